//! Codes of connectors: ends, types, and where they can be made.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "data-type-mismatch",
        title: "a connector joins ports of different data types",
        explain: "\
Samples are bytes: read as another type they are refused or, worse, mean something else. `RTC::TimedLong`, `TimedLong` and
`IDL:RTC/TimedLong:1.0` are one type; `Any`, or none, fits all. The type that a connector says must be that of its ports.

    Sine0.out    IDL:RTC/TimedDouble:1.0
    Print0.in    IDL:RTC/TimedLong:1.0       wrong: they cannot be connected

Connect ports of one type, or put a converter between them.",
    },
    Code {
        code: "direct-across-processes",
        title: "a connector of the type direct joins two processes",
        explain: "\
With `dataport.interface_type` = `direct` a sample is handed over as a variable, so that both ends must be in one process.
Here the overlay or the profile puts them into two: one is isolated, or they have different managers or nodes.

Give both the same `manager` and `node`, or choose the interface type `corba_cdr`, which joins any two processes.",
    },
    Code {
        code: "direction-mismatch",
        title: "a connector joins two out-ports or two in-ports",
        explain: "\
Data flows from an out-port to an in-port. Two of one direction have nothing to say to each other.

Mend one of the port names. Which end is called source does not matter (see `reversed-connector`).",
    },
    Code {
        code: "incompatible-dataflow-type",
        title: "a port does not offer the connector's dataflow type",
        explain: "\
`dataport.dataflow_type` of a port lists what it can do (`push,pull`). The connector wants another one, or both ports have
none in common: OpenRTM refuses to make such a connector.

Choose one that both offer: mostly `push`.",
    },
    Code {
        code: "incompatible-interface-type",
        title: "a port does not offer the connector's interface type",
        explain: "\
`dataport.interface_type` of a port lists how samples can reach it (`corba_cdr,direct`). The connector wants another one,
or both ports have none in common: OpenRTM refuses to make such a connector.

Choose one that both offer: mostly `corba_cdr`. `CORBA_Any` was its name before OpenRTM 1.0.",
    },
    Code {
        code: "incompatible-subscription-type",
        title: "a port does not offer the connector's subscription type",
        explain: "\
`dataport.subscription_type` of a port lists how it can send (`flush,new,periodic`; `Any` is all of them). The connector
wants another one, or both ports have none in common: OpenRTM refuses to make such a connector.

Choose one that both offer: `flush` sends at once, `new` from a buffer.",
    },
    Code {
        code: "duplicate-connector-id",
        title: "two connectors have one id",
        explain: "\
`rts:connectorId` is how editors and OpenRTM-aist tell connectors apart. Two with one id come from copying an element by
hand. This program goes by their ends and makes both; others may show or make only one.

Give each its own id.",
    },
    Code {
        code: "missing-end",
        title: "a connector has only one end",
        explain: "\
A connector joins two ports, and one of the two elements is missing.

    <rts:DataPortConnectors …>
        <rts:sourceDataPort rts:instanceName=\"Sine0\" rts:portName=\"Sine0.out\" …/>
        <rts:targetDataPort rts:instanceName=\"Print0\" rts:portName=\"Print0.in\" …/>
    </rts:DataPortConnectors>

Add it, or remove the connector.",
    },
    Code {
        code: "port-kind-mismatch",
        title: "a data connector ends at a service port, or the other way round",
        explain: "\
Data ports carry samples, service ports calls. `rts:DataPortConnectors` join the first, `rts:ServicePortConnectors` the
second.

Use the other kind of connector, or mend the port's name.",
    },
    Code {
        code: "repeated-connector",
        title: "two ports are connected more than once",
        explain: "\
Each connector carries each sample: with two of them everything arrives twice. Editors write such profiles when a system
was connected twice before it was saved.

Remove one of them.",
    },
    Code {
        code: "reversed-connector",
        title: "a connector is written from the in-port to the out-port",
        explain: "\
Choreonoid writes some connectors so. They are turned round, since the ports say which way data flows; other tools may
not do that.

Exchange source and target to silence the warning.",
    },
    Code {
        code: "self-connector",
        title: "a connector joins a port with itself",
        explain: "\
Both ends name the same port of the same component. Data flows from an out-port to an in-port, so no sample would ever
arrive; a service port would call itself. Mostly one end was meant to be another port.

    <rts:sourceDataPort rts:instanceName=\"Sine0\" rts:portName=\"Sine0.out\" …/>
    <rts:targetDataPort rts:instanceName=\"Sine0\" rts:portName=\"Sine0.out\" …/>      wrong

Mend one of the ends, or remove the connector. Two ports of one component may be connected.",
    },
    Code {
        code: "service-interface-mismatch",
        title: "a required interface has no fitting provided one",
        explain: "\
A service connector joins an interface that one side requires to one of the same type, and instance name, that the other
provides. With another type, or two sides that both require, no call can be made. The profile says so in the properties of
the connector, the RTC Profiles in `rtc:ServiceInterface`.

    Arm0.port.cmd.required.Arm::Commands.cmd = Gui0.port.cmd.provided.Arm::Commands.cmd      right

Mend the binding, or connect the ports that belong together.",
    },
    Code {
        code: "unknown-port",
        title: "a connector ends at a port that the component does not declare",
        explain: "\
The component is there, the port is not among those that the profile lists for it. Such a connector cannot be made.

    rts:portName=\"Sine0.ot\"      wrong
    rts:portName=\"Sine0.out\"     right: `Sine0.` before it may be left away

Mend the name, or declare the port with `rts:DataPorts` or `rts:ServicePorts`.",
    },
    Code {
        code: "unknown-value",
        title: "a word is none of those that are known",
        explain: "\
Some attributes take one of few words: the interface, dataflow and subscription type of a connector, the activity type of a
component, the direction of a location. What a port of the connector offers is known too. Another word is passed on as it
is, and probably means nothing to who reads it.

Use a word that the help lists.",
    },
];
