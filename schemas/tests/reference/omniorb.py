"""omniORB reads and writes values of the types in IDL files.

Arguments: IDL files. Input: lines of TYPE (::RTC::TimedLong), a value as JSON, and its bytes with the least significant
byte first, and with the most significant one first, as hex digits. Output: TYPE, the bytes that omniORB writes of the
value in both orders, and the value as it reads it; or TYPE, `refused` and why.
"""
import base64
import json
import math
import os
import subprocess
import sys
import tempfile

import _omniidl
import omniORB
from omniORB import CORBA
from omniidl import idlast, idltype

PLAIN = {
    idltype.tk_short, idltype.tk_long, idltype.tk_ushort, idltype.tk_ulong, idltype.tk_float, idltype.tk_double,
    idltype.tk_boolean, idltype.tk_char, idltype.tk_octet, idltype.tk_longlong, idltype.tk_ulonglong, idltype.tk_wchar,
    idltype.tk_longdouble, idltype.tk_any,
}
made = {}


def named(declaration):
    """The descriptor of a struct, a union or an enum."""
    known = declaration.repoId()
    if known not in made:
        # omniORB finds a type within itself by its id.
        made[known] = (omniORB.tcInternal.tv__indirect, [known])
        made[known] = {
            idlast.Struct: struct, idlast.Union: union, idlast.Enum: enum,
        }[type(declaration)](declaration)
        omniORB.registerType(known, made[known], None)
    return made[known]


def struct(it):
    fields = []
    for member in it.members():
        for declarator in member.declarators():
            fields += [declarator.identifier(), described(member.memberType(), declarator.sizes())]
    known = omniORB.createUnknownStruct(it.repoId(), fields[::2])
    return (idltype.tk_struct, known, it.repoId(), it.identifier(), *fields)


def enum(it):
    names = tuple(omniORB.EnumItem(name.identifier(), number) for number, name in enumerate(it.enumerators()))
    omniORB.Enum(it.repoId(), names)
    return (idltype.tk_enum, it.repoId(), it.identifier(), names)


def union(it):
    switch = described(it.switchType(), [])
    members, default = [], -1
    for case in it.cases():
        content = described(case.caseType(), case.declarator().sizes())
        for label in case.labels():
            value = label.value()
            if label.default():
                default = len(members)
            if label.labelKind() == idltype.tk_enum:
                items = named(it.switchType().unalias().decl())[3]
                value = next(item for item in items if item._n == value.identifier())
            elif label.labelKind() == idltype.tk_boolean:
                value = bool(value)
            members.append((value, case.declarator().identifier(), content))
    known = omniORB.createUnknownUnion(it.repoId(), default, members)
    by_label = {member[0]: member for number, member in enumerate(members) if number != default}
    chosen = members[default] if default >= 0 else None
    return (idltype.tk_union, known, it.repoId(), it.identifier(), switch, default, tuple(members), chosen, by_label)


def described(it, sizes):
    """The descriptor of a type as it is used."""
    if sizes:
        return (idltype.tk_array, described(it, sizes[1:]), sizes[0])
    kind = it.kind()
    if kind in PLAIN:
        return kind
    if kind in (idltype.tk_string, idltype.tk_wstring):
        return (kind, it.bound())
    if kind == idltype.tk_sequence:
        return (kind, described(it.seqType(), []), it.bound())
    if kind == idltype.tk_alias:
        return described(it.decl().alias().aliasType(), it.decl().sizes())
    return named(it.decl().fullDecl())


def shown(it, value):
    """A value as our JSON has it."""
    kind = it[0] if isinstance(it, tuple) else it
    if kind == omniORB.tcInternal.tv__indirect:
        return shown(made[it[1][0]], value)
    if kind in (idltype.tk_float, idltype.tk_double) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if kind == idltype.tk_boolean:
        return bool(value)
    if kind == idltype.tk_string:
        # omniORB hands the bytes on as ISO 8859-1.
        return value.encode("latin-1").decode("utf-8")
    if kind == idltype.tk_enum:
        return value._n
    if kind in (idltype.tk_sequence, idltype.tk_array):
        return [shown(it[1], element) for element in value]
    if kind == idltype.tk_struct:
        return {name: shown(content, getattr(value, name)) for name, content in zip(it[4::2], it[5::2])}
    if kind == idltype.tk_union:
        member = it[8].get(value._d, it[7])
        content = {} if member is None else {member[1]: shown(member[2], value._v)}
        return {"$discriminator": shown(it[4], value._d), **content}
    return value


def given(it, value):
    """The value that our JSON says."""
    kind = it[0] if isinstance(it, tuple) else it
    if kind == omniORB.tcInternal.tv__indirect:
        return given(made[it[1][0]], value)
    if kind in (idltype.tk_float, idltype.tk_double):
        return float(value)
    if kind in (idltype.tk_longlong, idltype.tk_ulonglong):
        return int(value)
    if kind == idltype.tk_string:
        return value.encode("utf-8").decode("latin-1")
    if kind == idltype.tk_enum:
        return next(item for item in it[3] if item._n == value)
    if kind in (idltype.tk_sequence, idltype.tk_array):
        if isinstance(value, dict):
            return base64.b64decode(value["$base64"])
        elements = [given(it[1], element) for element in value]
        if it[1] == idltype.tk_octet:
            return bytes(elements)
        return "".join(elements) if it[1] == idltype.tk_char else elements
    if kind == idltype.tk_struct:
        return it[1](*(given(content, value[name]) for name, content in zip(it[4::2], it[5::2])))
    if kind == idltype.tk_union:
        chooses = given(it[4], value["$discriminator"])
        member = it[8].get(chooses, it[7])
        return it[1](chooses, None if member is None else given(member[2], value[member[1]]))
    return value


def read(path):
    """The declarations of a file, after its preprocessor."""
    omnicpp = os.path.join(os.path.dirname(sys.executable), "omnicpp")
    text = subprocess.run([omnicpp, "-D__OMNIIDL__", path], stdout=subprocess.PIPE, check=True).stdout
    with tempfile.NamedTemporaryFile() as file:
        file.write(text)
        file.flush()
        tree = _omniidl.compile(file.name, path)
    if tree is None:
        sys.exit(f"omniidl refuses {path}")


def declared(name):
    found = idlast.findDecl(name.strip(":").split("::"))
    if isinstance(found, idlast.Declarator):
        return described(found.alias().aliasType(), found.sizes())
    return named(found)


def wide(it):
    """Whether there may be a wchar in it: omniORB for Python cannot read those that it writes."""
    return it == idltype.tk_wchar or isinstance(it, tuple) and any(wide(part) for part in it)


def answer(name, value, *written):
    content = declared(name)
    code = omniORB.tcInternal.createTypeCode(content)
    ours = [omniORB.cdrMarshal(code, given(content, json.loads(value)), order).hex() for order in (1, 0)]
    values = [
        json.dumps(shown(content, omniORB.cdrUnmarshal(code, bytes.fromhex(digits), order)))
        for digits, order in zip(written, (1, 0)) if not wide(content)
    ] or [value]
    assert values[0] == values[-1], values
    return [name, *ours, values[0]]


CORBA.ORB_init(["judge", "-ORBtraceLevel", "0"])
for path in sys.argv[1:]:
    read(path)
for line in sys.stdin:
    name, *question = line.rstrip("\n").split("\t")
    try:
        print("\t".join(answer(name, *question)))
    except (CORBA.SystemException, AssertionError, SystemError, ValueError) as error:
        print(f"{name}\trefused\t{error}")
