//! Codes of connectors: ends, types, and where they can be made.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "bad-buffer-length",
        title: "a connector's buffer cannot have that length",
        explain: "\
`dataport.outport.buffer.length` and `dataport.inport.buffer.length` (or `dataport.buffer.length` for both) say how many
samples wait at an end of the connector. That is a whole number from 1 to 65536; OpenRTM passes over anything else and
takes its own 8.

    rtsExt:name=\"dataport.inport.buffer.length\" rtsExt:value=\"0\"      wrong
    rtsExt:name=\"dataport.inport.buffer.length\" rtsExt:value=\"8\"      right

Write how many samples may wait, or leave it away for 64.",
    },
    Code {
        code: "bad-push-rate",
        title: "a periodic connector has no rate that it can send at",
        explain: "\
The subscription type `periodic` sends at a rate of its own: `dataport.publisher.push_rate` (or `dataport.push_rate`) in
hertz, else `rts:pushInterval` (`dataport.push_interval`) in seconds. OpenRTM refuses to connect without a rate, too.

    rtsExt:name=\"dataport.publisher.push_rate\" rtsExt:value=\"100.0\"      a sample each 10 ms

Write a rate above 0, or choose the subscription type `new`, which sends when there is something new.",
    },
    Code {
        code: "bad-skip-count",
        title: "the number of samples to pass over is none",
        explain: "\
With the push policy `skip` one sample is sent after each `dataport.publisher.skip_count` that are passed over: 0 sends
all, 1 each second one. OpenRTM passes over anything that is no whole number, and so sends all.

    rtsExt:name=\"dataport.publisher.skip_count\" rtsExt:value=\"1\"      each second sample

Write a whole number, 0 or more.",
    },
    Code {
        code: "bad-timeout",
        title: "a time-out of a connector's buffer is none",
        explain: "\
`dataport.outport.buffer.write.timeout` and its like say how long a write into a full buffer, or a read from an empty one,
may wait when its policy is `block`: seconds from 0 to 60. OpenRTM documents 0 as no time-out; here it is the longest
one, so that nothing waits for ever. A wait counts against the deadline of the callback that it happens in.

    rtsExt:name=\"dataport.inport.buffer.read.timeout\" rtsExt:value=\"-1\"       wrong
    rtsExt:name=\"dataport.inport.buffer.read.timeout\" rtsExt:value=\"0.5\"      right

Write seconds, or leave it away for 1.0.",
    },
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
        code: "no-transport",
        title: "no transport leads from one end of a connector to the other",
        explain: "\
A node that is reached by SSH alone (`rtsctl node add --ssh`) gets its commands through the session. Samples do not go
through it: a connector between such a node and another one would never carry any, and the system is refused.

    rtsctl.node of Sine0: arm, of Filter0: base        wrong, when arm is reached by SSH
    rtsctl.node of Sine0: arm, of Filter0: arm         right

Place both components on the same node (`rtsctl.node`), or install an agent that is reached without SSH. `rtsctl check`
knows the nodes of the home of whoever runs it.",
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
        code: "never-woken",
        title: "nothing wakes an event-driven component",
        explain: "\
An event-driven component runs when a sample arrives at one of its in-ports. A connector that pulls brings none: it fetches
when the component reads, and the component reads when it runs.

    rts:dataflowType=\"pull\"      wrong, when all connectors to the component do so
    rts:dataflowType=\"push\"      right

Let one of the connectors push, or make the execution context periodic. A component that wakes itself, from a thread of its
own, may be left as it is.",
    },
    Code {
        code: "interface-across-nodes",
        title: "a connector's interface type reaches no other node",
        explain: "\
`shared_memory` and `uds` join two processes of one node. Here the overlay or the profile puts the two components on
different nodes.

    rts:interfaceType=\"shared_memory\"      wrong, between two nodes
    rts:interfaceType=\"tcp\"                right
    rts:interfaceType=\"corba_cdr\"          right: the best that reaches

Place both on one node, or choose `tcp` or `corba_cdr`.",
    },
    Code {
        code: "unknown-policy",
        title: "a policy of a connector is none of those that are known",
        explain: "\
A connector's policies are words: `dataport.dataflow_type` is `push` or `pull`; `dataport.subscription_type` is `flush`,
`new`, `periodic`, `block` or `nonblock`; `dataport.publisher.push_policy` is `all`, `fifo`, `skip` or `new`;
`….buffer.write.full_policy` is `overwrite`, `do_nothing` or `block`; `….buffer.read.empty_policy` is `readback`,
`do_nothing` or `block`. OpenRTM logs another word and takes its default, which may lose samples or wait where nobody
meant it; here the connector is not made.

    rtsExt:name=\"dataport.publisher.push_policy\" rtsExt:value=\"newest\"      wrong
    rtsExt:name=\"dataport.publisher.push_policy\" rtsExt:value=\"new\"         right

Use a word that the help lists.",
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
        code: "unknown-property",
        title: "the name of a connector's property looks like a slip of the pen",
        explain: "\
Other programs have properties of their own, so that any name is passed on. This one is within two letters of a name that
is read here, and means nothing as it stands.

    rtsExt:name=\"dataport.buffer.lenght\" rtsExt:value=\"8\"      nothing reads it
    rtsExt:name=\"dataport.buffer.length\" rtsExt:value=\"8\"      right

Mend the name. docs/connectors.md lists those that are read.",
    },
    Code {
        code: "unknown-value",
        title: "a word is none of those that are known",
        explain: "\
Some attributes take one of few words: the interface type of a connector, the activity type of a component, the direction
of a location. What a port of the connector offers is known too. Another word is passed on as it
is, and probably means nothing to who reads it.

Use a word that the help lists.",
    },
];
