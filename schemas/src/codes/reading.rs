//! Codes of reading any file: encoding, XML, YAML.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "bad-encoding",
        title: "the bytes are no text in the encoding that the file declares",
        explain: "\
The XML declaration (or UTF-8, without one) says how bytes become letters, and some byte of the file means nothing then.
What it stood for cannot be guessed.

Save the file as UTF-8 and declare `encoding=\"UTF-8\"`; UTF-16, Shift_JIS and EUC-JP are read too when they are declared.",
    },
    Code {
        code: "dtd-refused",
        title: "a document type declaration is not read",
        explain: "\
`<!DOCTYPE …>` can define entities that grow to any size or read other files. Profiles have no use for it.

Remove the declaration. If the file uses entities of it (`&name;`), write their text in their place.",
    },
    Code {
        code: "empty-file",
        title: "the file has nothing in it",
        explain: "\
There is neither an XML element nor a YAML key. An editor that died while it was saving leaves such files.

Take the file from a backup, or save it again. An RTS Profile starts with `<rts:RtsProfile …>` or `rtsProfile:`, an overlay
with `apiVersion: rtsctl.dev/v1`.",
    },
    Code {
        code: "encoding-mismatch",
        title: "the file is in another encoding than it declares",
        explain: "\
Windows editors declare UTF-8 and write cp932 (Shift_JIS). Such a file is read as cp932, so that nothing is lost; other
tools refuse it or show wrong letters.

Save the file as UTF-8 and declare `encoding=\"UTF-8\"`.",
    },
    Code {
        code: "malformed-xml",
        title: "the file is not well-formed XML",
        explain: "\
A tag is not closed, an attribute has no quotes, a prefix is not declared, or the file ends too early. Nothing after the
place can be trusted, so nothing of the file is used.

    <rts:Components rts:instanceName=Sine0/>       wrong: quotes are missing
    <rts:Components rts:instanceName=\"Sine0\"/>     right

The help names the innermost element that is still open: often the mistake is just behind its start.",
    },
    Code {
        code: "malformed-yaml",
        title: "the file is not well-formed YAML",
        explain: "\
Brackets or quotes are not closed, the indentation does not fit, a key stands twice in one mapping, or there is more than
one document. Nothing of the file is used.

    components:
      - instanceName: Sine0
        instanceName: Sine1      wrong: one key, two values

Indent with blanks, never with tabs, and put texts with `: ` or ` #` in quotes.",
    },
    Code {
        code: "repeated-element",
        title: "an element that may stand once stands twice",
        explain: "\
The schema has room for one, so the first one counts and the others mean nothing, whatever the editor showed.

Remove the others, or put what they say into the first.",
    },
    Code {
        code: "stray-text",
        title: "text stands between elements",
        explain: "\
Profiles say everything in attributes and a few elements made for text. Text between other elements is read by nobody: a
note, the rest of an edit, or a tag that lost its brackets. It is kept when the file is written again.

    <rts:Components …>
        TODO: the left one                  wrong
        <!-- TODO: the left one -->         right

Remove it, or make it a comment.",
    },
    Code {
        code: "too-deep",
        title: "elements lie in each other too deeply",
        explain: "\
A profile needs fewer than ten levels. A file that has far more is something else, or was made to harm its reader.

Check that it is the right file.",
    },
    Code {
        code: "too-dense",
        title: "the file has more elements or values than a file of its size can have",
        explain: "\
What is read takes memory, and an element that says nothing takes as much as one that says something. A file of nearly
nothing but empty elements, values or aliases would cost hundreds of times its size, so it is not read to its end. Files
that describe a system are far from this.

Check that it is the right file.",
    },
    Code {
        code: "too-large",
        title: "the file is larger than any profile",
        explain: "\
The largest profile in public has 90 kB. A file beyond the limit is not read, since it is probably something else.

Check that it is the right file.",
    },
    Code {
        code: "too-long",
        title: "the name of a namespace is too long",
        explain: "\
Namespaces are short addresses such as `http://www.openrtp.org/namespaces/rts`. A very long one is no profile's.

Check that it is the right file.",
    },
    Code {
        code: "too-many-attributes",
        title: "an element has too many attributes",
        explain: "\
No element of a profile has more than about twenty. A file with hundreds on one element is something else.

Check that it is the right file.",
    },
    Code {
        code: "too-many-problems",
        title: "there are more problems than are shown",
        explain: "\
So many findings in one file mostly have one cause: a wrong file, a wrong version, a search-and-replace that went wrong.

Mend the first ones and check again.",
    },
    Code {
        code: "unknown-attribute",
        title: "an attribute is not known where it stands",
        explain: "\
It is in a namespace of the profile, or in none, but no schema has it on this element: nothing reads it. It is kept when the
file is written again.

    <rts:Components rts:isRequird=\"false\" …>      wrong: the component is required
    <rts:Components rts:isRequired=\"false\" …>     right

Mend the name, or remove the attribute. What is your own belongs in a namespace of your own.",
    },
    Code {
        code: "unknown-element",
        title: "an element or key is not known where it stands",
        explain: "\
It is in a namespace of the profile, but no schema has it there: nothing reads it, and what is in it has no effect. It is
kept when the file is written again.

    <rts:Component rts:instanceName=\"Sine0\"/>      wrong in version 0.2: the system loses a component
    <rts:Components rts:instanceName=\"Sine0\"/>     right

Mend the name, or remove the element. What is your own belongs in a namespace of your own, in YAML under a key with `x-`.",
    },
    Code {
        code: "unprefixed-attribute",
        title: "an attribute does not have the prefix of its namespace",
        explain: "\
Each attribute of a profile belongs to a namespace and has its prefix; a default namespace (`xmlns=\"…\"`) holds for elements
only. Files that were written by hand often leave the prefix away, or use that of the extension where the schema has the
other. It is read all the same, but other tools find nothing there. Told once for each element.

    <rts:Components instanceName=\"Sine0\" …>           read, but not as the schema has it
    <rts:Components rts:instanceName=\"Sine0\" …>       right

Write the prefix. `rtsctl convert` and `rtsctl fmt` keep the attribute as it is.",
    },
    Code {
        code: "unknown-version",
        title: "the version is none of the schema's",
        explain: "\
RTS Profiles have the versions 0.1 and 0.2, RTC Profiles 0.1, 0.2 and 0.3. The file is read all the same, as the version
that its elements look like; other tools may refuse it.

Write the version that your editor writes, mostly `0.2`.",
    },
    Code {
        code: "wrong-namespace",
        title: "the root element is in another namespace",
        explain: "\
The prefix is free, but it must stand for the namespace of the profile. Usually the declaration was mistyped, or it was
lost when the file was edited.

Declare `xmlns:rts=\"http://www.openrtp.org/namespaces/rts\"` (for an RTC Profile
`xmlns:rtc=\"http://www.openrtp.org/namespaces/rtc\"`) on the root element.",
    },
    Code {
        code: "wrong-root",
        title: "the file is another kind of document",
        explain: "\
The first element or key says what a file is: `rts:RtsProfile` describes a system, `rtc:RtcProfile` a component,
`kind: Deployment` is an overlay. The help says what the file seems to be.

    rtsctl check system.xml -f lab.yaml        the profile first, then overlays
    rtsctl check RTC.xml                       an RTC Profile alone",
    },
    Code {
        code: "wrong-shape",
        title: "a list, mapping or plain value stands where another is needed",
        explain: "\
In YAML the shape of a value follows from its key, and this one has another: a list where one value belongs, or a plain
value where a mapping does. It is not read.

    components: Sine0            wrong
    components:                  right
      - instanceName: Sine0",
    },
    Code {
        code: "unreadable-file",
        title: "a file cannot be read",
        explain: "\
The file is not there, is a folder, or may not be read by you. Nothing was checked in it; what is said of the other files
holds all the same. It stands in JSON and SARIF, so that a report of a check that could not be made is not taken for a good
one; the exit code is 3.

Mend the name, or the rights of the file.",
    },
];
