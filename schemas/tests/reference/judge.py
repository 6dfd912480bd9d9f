"""For each line KIND, ORIGINAL, OURS: KIND, equal | refused (also the original) | WRONG, and why."""
import io
import re
import sys
import time
import warnings
from pathlib import Path

warnings.simplefilter("ignore")
import yaml
from lxml import etree
from rtsprofile.rts_profile import RtsProfile

XSD = Path(sys.argv[1])
VENDOR = "OpenRTM__OpenRTP-aist__"


def schema(*names):
    """One schema of several files, whose imports lead to each other under other names."""
    class Resolver(etree.Resolver):
        def resolve(self, url, public, context):
            wanted = Path(url).name
            for name in names:
                if name.endswith(wanted):
                    return self.resolve_filename(str(XSD / (VENDOR + name)), context)
            return None

    parser = etree.XMLParser()
    parser.resolvers.add(Resolver())
    targets = {"RtsProfile.xsd": "rts", "RtsProfile_ext.xsd": "rts_ext", "basic.xsd": "rtc",
               "doc.xsd": "rtc_doc", "Profile_ext.xsd": "rtc_ext"}
    lines = []
    for name in names:
        end = next(end for end in targets if name.endswith(end))
        if name.endswith("RtsProfile_ext.xsd"):
            end = "RtsProfile_ext.xsd"
        uri = "http://www.openrtp.org/namespaces/" + targets[end]
        lines.append(f'<xsd:import namespace="{uri}" schemaLocation="{name}"/>')
    text = ('<xsd:schema xmlns:xsd="http://www.w3.org/2001/XMLSchema">' + "".join(lines) + "</xsd:schema>")
    return etree.XMLSchema(etree.parse(io.StringIO(text), parser))


SCHEMAS = {}


def schema_of(kind, version):
    key = (kind, version)
    if key not in SCHEMAS:
        names = {
            ("rts-xsd", "0.1"): ("V1RtsProfile.xsd", "V1RtsProfile_ext.xsd"),
            ("rtc-xsd", "0.1"): ("V1RtcProfile_basic.xsd", "V1RtcProfile_doc.xsd", "V1RtcProfile_ext.xsd"),
            ("rtc-xsd", "0.2"): ("V2RtcProfile_basic.xsd", "V2RtcProfile_doc.xsd", "RtcProfile_ext.xsd"),
            ("rtc-xsd", "0.3"): ("RtcProfile_basic.xsd", "RtcProfile_doc.xsd", "RtcProfile_ext.xsd"),
        }.get(key, ("RtsProfile.xsd", "RtsProfile_ext.xsd"))
        SCHEMAS[key] = schema(*names)
    return SCHEMAS[key]


def valid(kind, path):
    tree = etree.parse(path)
    version = next((v for k, v in tree.getroot().attrib.items() if k.endswith("}version")), "0.2")
    known = {"rts-xsd": ("0.1", "0.2"), "rtc-xsd": ("0.1", "0.2", "0.3")}[kind]
    schema_of(kind, version if version in known else "0.2").assertValid(tree)
    return None


def text_of(path):
    data = Path(path).read_bytes()
    declared = re.match(rb"\s*<\?xml[^>]*encoding=[\"']([^\"']+)", data)
    try:
        return data.decode(declared.group(1).decode() if declared else "utf-8-sig").lstrip("\ufeff")
    except (UnicodeDecodeError, LookupError):
        return data.decode("cp932")


def library(kind, path):
    text = text_of(path)
    if kind == "xml":
        # The library reads text, whatever encoding it declares.
        return dump(RtsProfile(xml_spec=re.sub(r"^\s*<\?xml.*?\?>", "", text)))
    return dump(RtsProfile(yaml_spec=text))


def plain(value):
    """Values as texts: the library makes numbers of some when it reads YAML."""
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else str(value)


def without_visible(value):
    if isinstance(value, dict):
        return {k: without_visible(v) for k, v in value.items() if k != "rtsExt::visible"}
    if isinstance(value, list):
        return [without_visible(v) for v in value]
    return value


def dump(profile):
    said = profile._to_dict()["rtsProfile"]
    said["creationDate"], said["updateDate"] = str(profile.creation_date), str(profile.update_date)
    return plain(said)


import rtsprofile.rts_profile as library_module

# The library cannot say dates with a time zone in YAML; content is compared by what it read.
library_module.date_to_dict = lambda date: date


def answer(kind, original, ours):
    first, second = {
        "rts-xml": ("xml", "xml"),
        "rts-yaml-of-xml": ("xml", "yaml"),
        "rts-yaml": ("yaml", "yaml"),
    }.get(kind, (None, None))
    read = (lambda which, path: valid(kind, path)) if first is None else library
    try:
        expected = read(first, original)
    except Exception as error:
        return "refused", type(error).__name__
    if second == "yaml" and "rtsExt::versionUpLogs" in Path(ours).read_text("utf-8"):
        # It takes a text for a list there, and fails whatever is written.
        return "refused", "the library reads no version-up logs in YAML"
    try:
        found = read(second, ours)
    except Exception as error:
        return "WRONG", f"{original}: {type(error).__name__} {error}"
    if first != second:
        # Of a date in YAML it reads neither milliseconds nor the time zone.
        for key in ("creationDate", "updateDate"):
            expected[key] = expected[key][:19]
        # What is not said to be visible is so in XML, and is not in YAML.
        expected, found = without_visible(expected), without_visible(found)
    if found != expected:
        return "WRONG", f"{original}: " + difference(expected, found)
    return "equal", ""


def difference(a, b, at=""):
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted(set(a) | set(b)):
            if a.get(key) != b.get(key):
                return difference(a.get(key), b.get(key), f"{at}.{key}")
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for index, (x, y) in enumerate(zip(a, b)):
            if x != y:
                return difference(x, y, f"{at}[{index}]")
    return f"{at}: {a!r} became {b!r}"[:300]


for line in sys.stdin:
    kind, original, ours = line.rstrip("\n").split("\t")
    verdict, why = answer(kind, original, ours)
    why = str(why).replace("\n", " ")
    print(kind, verdict, why, sep="\t")
