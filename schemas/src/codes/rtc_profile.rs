//! Codes of RTC Profiles, and of an RTS Profile held against them.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "bad-interface-direction",
        title: "a service interface is neither provided nor required",
        explain: "\
`rtc:direction` of a `rtc:ServiceInterface` says who calls whom. From any other word nobody can tell, and no code can be
made for it.

Write `Provided` or `Required`.",
    },
    Code {
        code: "bad-port-type",
        title: "a data port is of no known kind",
        explain: "\
`rtc:portType` says which way data flows: `DataInPort`, `DataOutPort`, or `EventPort` for a state machine. `IN` and `OUT`
stand in old samples; they are understood here, but not by all tools.

Write the full word.",
    },
    Code {
        code: "bad-type-name",
        title: "a data or interface type is no name in an IDL file",
        explain: "\
Types are written with their modules, as in the IDL file that defines them: `RTC::TimedLong`, `Img::TimedCameraImage`.
With blanks, a single colon or other signs, no type can be found by it.

    RTC:TimedLong        wrong
    RTC::TimedLong       right",
    },
    Code {
        code: "no-rtc-profile",
        title: "there is no RTC Profile for the type of a component",
        explain: "\
With `--rtc` each component is held against the RTC Profile of its type, and none of the given files describes this one:
its package is missing, or the id in the RTS Profile has another type than the package. What the component has cannot be
checked, and on a robot that has only these packages it cannot be started.

Add the package's folder with another `--rtc`, or mend the id.",
    },
    Code {
        code: "rtc-execution-kind",
        title: "a component runs in another kind of context than it was made for",
        explain: "\
The RTC Profile says that the component is made for a periodic context, and the RTS Profile runs it in one of another kind,
or the other way round. `on_execute` is then called at other times than its author thought of, or never.

Use the kind of the RTC Profile, or check that the component can do with the other.",
    },
    Code {
        code: "rtc-name-mismatch",
        title: "the id and the name of an RTC Profile differ",
        explain: "\
The type stands in the fourth field of `rtc:id` and in `rtc:name` of `BasicInfo`. Modules are found by the name, RTS
Profiles refer to the id: a component with two names is not found by one of them.

Give both the same name.",
    },
    Code {
        code: "rtc-port-mismatch",
        title: "a port is otherwise than its RTC Profile says",
        explain: "\
The RTS Profile declares a port with another direction or data type than the RTC Profile of the component. The component
itself decides, so the RTS Profile is wrong, or it was saved with another version of the component.

Save the system again with the components as they are now, or check that you have the right RTC Profile. When the profile
is of another version than the component's id, this is only a warning.",
    },
    Code {
        code: "rtc-rate",
        title: "a component runs at another rate than it was made for",
        explain: "\
That is allowed and often wanted: the rate in the RTC Profile is only a default. It is a note, for those who wonder why a
controller behaves differently.",
    },
    Code {
        code: "rtc-unknown-parameter",
        title: "a component has no such parameter",
        explain: "\
The RTS Profile sets a parameter that the component's RTC Profile does not have. The component ignores it, so that what the
file says has no effect: mostly a slip of the pen, or the parameter was renamed.

Mend the name (the help lists those that there are), or remove it.",
    },
    Code {
        code: "rtc-unknown-port",
        title: "a component has no such port",
        explain: "\
The RTS Profile declares a port that the component's RTC Profile does not have: connectors to it cannot be made. Some
components add ports while they run, depending on their configuration; those are not in the RTC Profile.

Mend the name, or save the system again with the components as they are now. When the profile is of another version than
the component's id, this is only a warning.",
    },
];
