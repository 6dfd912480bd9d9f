//! Codes of `rtc.conf` files, and of profiles that are converted.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "conf-not-text",
        title: "a configuration file is no text",
        explain: "\
A configuration file of OpenRTM-aist is text: UTF-8 with or without a byte order mark, Shift_JIS or EUC-JP. This file
has zero bytes, or bytes that mean nothing in any of them. Often another kind of file has the ending `.conf`.

Name the right file, or save it as UTF-8.",
    },
    Code {
        code: "conf-no-separator",
        title: "there is no `:` in a line of a configuration file",
        explain: "\
A line is `key: value` or `key=value`. Where there is neither, OpenRTM-aist ends the key at the first blank, so that

    conf.__widget__.gain, text

sets the key `conf.__widget__.gain,`, which nobody reads. Write

    conf.__widget__.gain: text",
    },
    Code {
        code: "conf-repeated-key",
        title: "a key is given twice in one configuration file",
        explain: "\
The last value counts, and the earlier one is lost without a word: of

    manager.components.precreate: Motor
    manager.components.precreate: Sensor

only Sensor is made. Write one list, `Motor, Sensor`, or take a line away.",
    },
    Code {
        code: "conf-dangling-continuation",
        title: "the last line of a configuration file is to go on",
        explain: "\
A `\\` at the end of a line joins the next line to it. When the file ends there, OpenRTM-aist drops the line altogether.
It is read here. Take the `\\` away.",
    },
    Code {
        code: "conf-bad-value",
        title: "a value of a configuration file is not of its kind",
        explain: "\
A switch is neither YES nor NO, a rate is no number of cycles in a second, or a value has a control character, which
comes of a backslash before f: `conf\\file` is read as an escape. The value is left out, or read as far as it goes.

Write `YES` or `NO`, a number such as `1000.0`, and `/` or `\\\\` in paths.",
    },
    Code {
        code: "conf-bad-item",
        title: "an item of a list of components or connections cannot be understood",
        explain: "\
OpenRTM-aist logs an error, leaves the item out and goes on, so that a part of the system is missing. The forms are

    manager.components.precreate: Motor, Motor?instance_name=Left&conf.default.gain=2, RTC:AIST:example:Motor:1.0
    manager.components.preconnect: A0.out?port=B0.in&dataflow_type=push, A0.out:C0.in(interface_type=direct)

A name of a component has no `/`, no control character and no dot at its start. `rtsctl convert --force` leaves the
item out.",
    },
    Code {
        code: "conf-unknown-key",
        title: "OpenRTM-aist has no such key",
        explain: "\
The key has no effect. If it is near a key that there is, it is probably misspelt:

    manager.component.precreate: Motor      # manager.components.precreate

Other programs may read keys of their own from the file. They are not carried over into a profile.",
    },
    Code {
        code: "conf-manager-name",
        title: "a manager gets another name than its file says",
        explain: "\
Each `rtc.conf` is a manager process, named by `manager.instance_name`, `manager.name` or the file. A name has 1 to 63
letters, digits, `-`, `_` and `.`, and the managers of a system differ by it. Two files that say
`manager.name: manager` are two managers, and the second is named after its file.

Give each file a `manager.instance_name` of its own.",
    },
    Code {
        code: "conf-unknown-instance",
        title: "a name stands for no component that is made",
        explain: "\
A connection, an activation or a configuration file is for a component that no `manager.components.precreate` makes.
What is said of it is left out. Components are numbered by type from 0, and one with a name of its own takes a number
too:

    manager.components.precreate: Motor, Motor?instance_name=Left, Motor    # Motor0, Left, Motor2

If another manager makes it, name that manager's `rtc.conf` too: `rtsctl convert rtc_cpp.conf rtc_py.conf`.",
    },
    Code {
        code: "conf-several-files",
        title: "`config_file` names several files",
        explain: "\
OpenRTM-aist takes the whole value for the name of one file, which is not there, and goes on without it. Here the
first of the files that is there is read. Name one file.",
    },
    Code {
        code: "conf-file-missing",
        title: "a configuration file of a component is not there",
        explain: "\
OpenRTM-aist starts the component with its own values and says nothing. It looks from the folder where it was started;
here the folder of the `rtc.conf` is tried, then up to four folders above it. Put the file there, or mend the path.",
    },
    Code {
        code: "conf-duplicate-instance",
        title: "two components have the same name",
        explain: "\
In one process the second is not made. In two processes, each of which counts from 0, both are made and the second
takes the other's place at the name server. In a system a name stands for one component:

    manager.components.precreate: Motor?instance_name=RightMotor

`rtsctl convert --force` leaves the second one out.",
    },
    Code {
        code: "conf-no-component",
        title: "no component is made",
        explain: "\
A system consists of components, which `manager.components.precreate` lists. Files of RT-Components that are programs
of their own often have no such line: the program makes the component. Add

    manager.components.precreate: TYPE

A file of `conf.` keys configures one component: an `rtc.conf` names it (`CATEGORY.INSTANCE.config_file: FILE`), and is what
`rtsctl convert` reads.",
    },
    Code {
        code: "conf-not-activated",
        title: "components stay Inactive in OpenRTM-aist",
        explain: "\
OpenRTM-aist activates what `manager.components.preactivation` lists, and leaves the rest to a person. `rtsctl apply`
activates every component of a system; `rtsctl deactivate` stops one again.",
    },
    Code {
        code: "conf-not-carried",
        title: "keys that a profile has no place for",
        explain: "\
They say how the manager works (log, network, name server, modules), not what the system is. Modules are found by the
type of their component where the agent looks; logs are those of `rtsctl logs`.",
    },
    Code {
        code: "conf-unknown-type",
        title: "nothing says which version of whose component it is",
        explain: "\
`rtc.conf` names a type alone. In a profile a component has an id, `RTC:vendor:category:type:version`; what is not
known is written as `unknown` and `1.0.0`. With `rtsctl convert --rtc DIR` it comes from the RTC Profiles (`RTC.xml`)
in that folder, with the ports and their data types.",
    },
    Code {
        code: "conf-other-category",
        title: "configuration is given under a category that is not the component's",
        explain: "\
The key of a component's configuration begins with its category: `Motor.Driver0.config_file`. If its RTC Profile says
another category, OpenRTM-aist does not read it. It is read here. Write the category that the RTC Profile says.",
    },
    Code {
        code: "conf-unknown-port",
        title: "a connection ends at a port that the RTC Profile does not have",
        explain: "\
The name is misspelt, or the RTC Profile is of another version of the component. OpenRTM-aist leaves such a connection
out without a word. The port is written into the profile as it is named.",
    },
    Code {
        code: "conf-open-connector",
        title: "a port is connected with something outside",
        explain: "\
`RTMtoROS0.out?interface_type=ros&ros.topic=x` has no `port=`: it is connected with a topic of ROS. A profile says
connections between two components; this one is left out.",
    },
    Code {
        code: "version-cannot-say",
        title: "the wanted version of the schema has no place for this",
        explain: "\
Profiles of version 0.1 have no groups, no order but StartUp and no constraints; RTC Profiles of 0.3 have no
Parameters, those of 0.2 no event ports. `rtsctl convert` refuses to lose it; with `--force` it is left out, and each
thing is named in a warning.

In an RTS Profile 0.1 the source of a connector, the order of connectors and the ids of contexts are kept in properties
`rtsctl.v02.…`, and are there again in version 0.2.",
    },
    Code {
        code: "comments-left-out",
        title: "comments are not in the YAML that is written",
        explain: "\
YAML profiles keep every value and every unknown element, but no comments and no processing instructions. Keep the old
file, or write the comments into the YAML by hand. XML keeps them: those of a YAML file too, each before the element that
it stood before.",
    },
];
