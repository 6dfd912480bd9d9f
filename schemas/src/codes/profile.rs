//! Codes of RTS Profiles: the system, its components and its orders.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "bad-boolean",
        title: "an attribute is neither true nor false",
        explain: "\
`isRequired` decides whether a missing component makes the system unhealthy; from any other word nobody can tell.

Write `true` or `false` (`1` and `0` are read too).",
    },
    Code {
        code: "bad-component-id",
        title: "the id of a component does not say its type",
        explain: "\
The module that is loaded is found by the type, the fourth field of the id. Without it nothing can be started.

    RTC:AIST:example:ConsoleIn:1.0       RTC:vendor:category:type:version
    RTC:AIST.example.ConsoleIn:1.0       the older form, also read

Write the id as the component's RTC.xml has it.",
    },
    Code {
        code: "bad-name",
        title: "a name cannot be used",
        explain: "\
Names of instances, types and ports have 1 to 128 bytes, no `/` and no control character, since they become parts of
paths; an instance name has no dot in front. Any script may be used, and blanks inside.

Choose another name, and change it wherever it is referred to.",
    },
    Code {
        code: "bad-number",
        title: "a number is missing, malformed or out of its range",
        explain: "\
Rates are hertz from 0.001 to 1000000 (`1000.0`); sequences are whole numbers from 0; waiting times and time-outs are whole
milliseconds; push intervals are seconds; a location is in pixels. What has no effect on the system is only a warning.

    rts:rate=\"1 kHz\"       wrong
    rts:rate=\"1000.0\"      right",
    },
    Code {
        code: "bad-system-name",
        title: "a text cannot name a system",
        explain: "\
The name of a system is used in commands, paths and addresses: 1 to 63 of `a-z`, `0-9` and `-`, no hyphen at either end.
It comes from `--name`, else from the property `rtsctl.name` of the profile, else from its id.

Use the name that the help proposes.",
    },
    Code {
        code: "bad-timing",
        title: "the sending timing of a Preceding is not known",
        explain: "\
`SYNC` waits until the preceding components are in their state, `ASYNC` (or `NO_SYNC`) only until they were asked. Another
word would leave open what is waited for.

    <rts:Preceding rts:sendingTiming=\"SYNC\" rts:timeout=\"5000\">",
    },
    Code {
        code: "component-id-mismatch",
        title: "an instance is named with the id of another type",
        explain: "\
The end of a connector, and a condition of an order, name a component by its instance name and its id. Here the id is of
another type than the component of that name has. The name counts; after an instance was renamed or a component exchanged
by hand it may be the wrong one. Vendor, category and version are not compared.

    <rts:Components rts:instanceName=\"Sine0\" rts:id=\"RTC:AIST:example:Sine:1.0\" …>
    <rts:sourceDataPort rts:instanceName=\"Sine0\" rts:componentId=\"RTC:AIST:example:Filter:1.0\" …/>      wrong

Mend the id, or the name.",
    },
    Code {
        code: "composite-component",
        title: "a composite has no members, or is of a kind that is not known",
        explain: "\
A composite component stands for others: those of `PeriodicECShared` run on one execution context, those of
`PeriodicStateShared` share their state as well, and a `Grouping` is just a name for them. One of another kind is treated as
a plain component, and one without members stands for nothing.

    components:
      - instanceName: Arm0
        compositeType: PeriodicECShared
        participants:
          - participant: { instanceName: Motor0 }

List its members as `Participants`, or in its parameter `members`.",
    },
    Code {
        code: "composite-member-twice",
        title: "a component is a member of two composites",
        explain: "\
A component runs on one execution context and has one state, so it can follow one composite only.

    Arm0:  members: Motor0, Sensor0
    Hand0: members: Motor0            # whose?

Remove it from one of them. A composite may itself be a member of another one.",
    },
    Code {
        code: "composite-cycle",
        title: "a composite contains itself",
        explain: "\
A composite may have other composites as members, but not itself, not even by way of others: nobody could tell in which
order its members run.

    Arm0:  members: Hand0
    Hand0: members: Arm0

Remove one of them from the members of the other.",
    },
    Code {
        code: "composite-port",
        title: "a composite has no such port",
        explain: "\
A composite has no ports of its own. It exports ports of its members, which its parameter `exported_ports` lists as
`MEMBER.PORT`; a connector may name those as ports of the composite.

    exported_ports: Motor0.in, Sensor0.out

Add the port to the list, or let the connector name the member itself.",
    },
    Code {
        code: "duplicate-connector",
        title: "two connectors of a system have one name",
        explain: "\
Connectors are known by their names, which are made of their ends unless `rtsctl.name` says otherwise. Two with one name
cannot be told apart. Only a system that came over the API can have them: those of a file are numbered.

Give each its own name.",
    },
    Code {
        code: "duplicate-instance",
        title: "two components have one instance name",
        explain: "\
Connectors, orders, overlays and commands name components by their instance name. With two of one name nobody can tell
which is meant.

Give each its own name (`Motor0`, `Motor1`), and mend the connectors that mean the second one.",
    },
    Code {
        code: "duplicate-parameter",
        title: "a parameter stands twice in one set",
        explain: "\
One parameter has one value. In an RTS Profile the last one counts, in silence; that may be the wrong one.

Remove the others.",
    },
    Code {
        code: "duplicate-port",
        title: "a component declares two ports with one name",
        explain: "\
A component registers its ports by name, and refuses the second one. A data port and a service port share their names too.
In an RTS Profile the first counts.

Give each its own name, or remove the copy.",
    },
    Code {
        code: "empty-preceding",
        title: "a Preceding names no component",
        explain: "\
`rts:Preceding` waits for components, and none is named: it waits for nothing.

Add `rts:PrecedingComponents` with their instance names, or remove the element.",
    },
    Code {
        code: "empty-system",
        title: "the profile has no components",
        explain: "\
Such a profile is right and describes nothing. Editors write it for a new system; applied under the name of a running
system it would take all of that down.

Add components, or check that it is the right file.",
    },
    Code {
        code: "extra-execution-context",
        title: "a component has more than one execution context",
        explain: "\
A component runs in one context of its own; further ones belong to composites. The first is used, with its rate.

Remove the others if they mean nothing.",
    },
    Code {
        code: "instance-prefix",
        title: "a port has the name of another component before it",
        explain: "\
Editors write ports as `Instance.port`. Here the instance before the dot is another one than that of the component: one of
the two is wrong, and the system would be wired wrongly.

    rts:instanceName=\"Motor0\" rts:portName=\"Motor1.out\"     wrong
    rts:instanceName=\"Motor1\" rts:portName=\"Motor1.out\"     right",
    },
    Code {
        code: "missing-attribute",
        title: "an attribute that is needed is missing or empty",
        explain: "\
Without it the element does not say what it is: a component without instance name, a port without name, a condition
without sequence. What tools leave out and what can be done without is only a warning.

Add the attribute that the message names.",
    },
    Code {
        code: "missing-target",
        title: "a condition of an order has no target component",
        explain: "\
Each `rts:targets` says when one component is started, activated and so on. Without `rts:TargetComponent` it is a condition
of nobody.

    <rts:targets rts:sequence=\"1\">
        <rts:TargetComponent rts:id=\"0\" rts:instanceName=\"Motor0\" rts:componentId=\"…\"/>
    </rts:targets>",
    },
    Code {
        code: "no-system-name",
        title: "nothing names the system",
        explain: "\
The name comes from the third field of `RTSystem:vendor:name:version`. If the id has none, or one without any letter or
digit that a name may have, the file's name is taken; here that gives none either.

Name the system with `--name NAME`, or mend the id.",
    },
    Code {
        code: "unknown-configuration-set",
        title: "the active configuration set is not in the profile",
        explain: "\
A set that the component itself knows may still be meant; if it knows none of this name either, activating it fails and
the component keeps the values that it has.

Mend the name, or add the set.",
    },
    Code {
        code: "unknown-host",
        title: "a component belongs on a host that nobody knows",
        explain: "\
With `--node NAME`, all nodes and hosts are named. This component's place (what an overlay says, its `rtsctl.node`, the host
of its `pathUri`, or the host where it ran when the profile was saved) is none of them: it would be started on the local
node, or not at all. A host that an overlay gives a known node under `hosts` is known too, and the other way round.

Place it with an overlay, or name the host:

    spec:
      components:
        Camera0: { node: jetson }",
    },
    Code {
        code: "unknown-instance",
        title: "something refers to a component that is not there",
        explain: "\
A connector, a condition of an order, a Preceding or an overlay names an instance that the profile does not have. A
connector to nobody can never be made, and an order would wait for ever.

Mend the name (the help shows the nearest one), or add the component.",
    },
    Code {
        code: "unsupported-execution-kind",
        title: "the execution context does not run by itself",
        explain: "\
Components run periodically, at a rate, or when samples arrive (`EVENT_DRIVEN`). Any other, such as that of a simulator,
is taken for one that is driven from outside: the component is activated, and runs cycles when `rtsctl tick` asks for them.

Write `PERIODIC` and a rate if the component can run so.",
    },
    Code {
        code: "unknown-placement-key",
        title: "there is no such placement key",
        explain: "\
`rtsctl.…` properties of a component, and the keys of an overlay, say where the component runs and what happens when it
fails. This one is none of them, so nothing would come of it.

    rtsctl.isolate: true          # isolated

Mend the key. `rtsctl explain overlay.components` lists all of them.",
    },
    Code {
        code: "bad-placement-value",
        title: "a placement key does not take this value",
        explain: "\
Each placement key takes values of one kind: words, numbers, times with their unit, sizes with their unit.

    rtsctl.startTimeout: 10       # of what? write 10s

Write one of the values that the help names. `rtsctl explain overlay.components` lists keys and values.",
    },
];
