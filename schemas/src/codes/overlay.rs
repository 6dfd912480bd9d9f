//! Codes of deployment overlays.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "wrong-kind",
        title: "the file is not an overlay of the version that this program reads",
        explain: "\
Each overlay begins with the version of its format and its kind, so that a later format, or a file of another program, is
never taken for it.

    apiVersion: rtsctl.dev/v1
    kind: Deployment

Write these two lines. When the version is a later one, a later rtsctl reads it.",
    },
    Code {
        code: "missing-key",
        title: "a key that must be there is missing",
        explain: "\
An overlay has `apiVersion`, `kind` and `spec`, and each rule under `order` has the `component` that it is about. Without
them nobody can tell what was meant.

    order:
      shutDown:
        - { wait: 500ms }                      # who?
        - { component: Arm0, wait: 500ms }     # right

Add the key.",
    },
    Code {
        code: "execution-context-mismatch",
        title: "components of one execution context want to be run in different ways",
        explain: "\
An execution context runs all its components on one thread at one rate. Those that name the same one must want the same
kind and, where they say a rate, the same rate; who says none has that of the others.

    components:
      Filter0: { executionContext: { name: control, rate: 1000 } }
      Motor0: { executionContext: { name: control, rate: 50 } }      # which?

An editor writes a rate for each component. Say one for all of them: `executionContext: { name: control, rate: 1000 }`
under a glob or under `defaults`.",
    },
    Code {
        code: "execution-context-apart",
        title: "components of one execution context are in different processes",
        explain: "\
An execution context is a thread of one manager process, and runs components of that process only.

    components:
      Filter0: { manager: left, executionContext: { name: control } }
      Motor0: { manager: right, executionContext: { name: control } }

Give the components the same node and manager, or each its own execution context.",
    },
    Code {
        code: "unknown-key",
        title: "an overlay has no such key here",
        explain: "\
A key that nobody knows would be ignored, and what it was to say would not happen. So it is an error, mostly a slip of the
pen or a key at the wrong depth.

    spec:
      compnents: {}          # components
      components:
        Sine0:
          cpus: 2            # belongs under `resources`

Mend its spelling or its place: `rtsctl schema` lists all keys for editors, docs/overlay.md for people.",
    },
    Code {
        code: "unmatched-selector",
        title: "a host, type or glob fits nothing in the system",
        explain: "\
What an overlay says of a host, a type or a glob holds for the components that fit. Here none does, so that these lines do
nothing. An overlay that is laid over several systems may say more than each of them needs; then this warning can be
ignored. An instance name that is not there is an error (unknown-instance).

    hosts:
      robot2.local: arm      # the profile only names robot1.local
    components:
      \"Filter*\": { restart: never }

Mend the name, or remove the lines.",
    },
    Code {
        code: "not-carried-out",
        title: "the setting is kept, but this version does not act on it yet",
        explain: "\
Packages and limits of memory can be said, are checked and are stored with the system, but nothing acts on them in this
version: a module comes from the module folders of its node, and a process may have as much memory as its agent.

    types:
      Sine: { package: sine, version: \"1.2\" }
    components:
      Sine0: { resources: { memoryLimit: 256MiB } }

Nothing has to be mended. Do not rely on it: set limits where the agent is started, and put modules in its folders.",
    },
    Code {
        code: "empty-rule",
        title: "a rule of an order says nothing of its components",
        explain: "\
A rule under `order` names components and says who goes before or after them (`after`, `before`), how long to sleep
(`wait`), or which number they have (`sequence`). This one says none of it; `timing` and `timeout` alone only qualify
`after` and `before`.

    order:
      activation:
        - { component: Sine0, timing: async }                     # after whom?
        - { component: Sine0, after: Filter0, timing: async }     # right

Say it, or remove the rule.",
    },
    Code {
        code: "bad-recorded-data",
        title: "a stand-in cannot play what was recorded for it",
        explain: "\
Recorded data is played by an out-port of a stand-in, so the port must be there, must send, and its data type must be one
of BasicDataType.idl that the SDK knows: TimedBoolean, TimedOctet, TimedShort, TimedLong, TimedFloat, TimedDouble,
TimedString, and TimedOctetSeq, TimedShortSeq, TimedLongSeq, TimedFloatSeq, TimedDoubleSeq. Each value must be one of that
type; those of a sequence are lists. A component may play 1 MiB, and a port 10,000 values.

    components:
      Encoder0:                                # its port `angle` is an out-port of TimedLong
        standIn:
          when: missing
          data: { angle: [10, 20, 2.5] }       # 2.5 is no whole number

Mend the value or the name of the port. Where only the RTC Profile of its type says what the port is, name that with
`--rtc`.",
    },
    Code {
        code: "too-many-entries",
        title: "a part of an overlay is larger than its bound",
        explain: "\
A mapping or list may have 10,000 entries, a part 1,000 globs, and the rules of one order may make 100,000 pairs of
components: globs on both sides of a rule multiply. Beyond that an overlay is a mistake, or an attack.

    order:
      activation:
        - { component: \"*\", after: \"*\" }

Name what matters, or use narrower globs.",
    },
];
