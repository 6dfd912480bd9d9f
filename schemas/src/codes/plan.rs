//! Codes that the planner finds.

use super::Code;

pub(super) const CODES: &[Code] = &[Code {
    code: "order-cycle",
    title: "written orders wait for each other in a circle",
    explain: "\
`Preceding` and the sequence numbers of StartUp, Activation and the other orders are always obeyed. Here each member waits
for another member, so that none can ever go first. All members are named, and the help lists the lines that make the
circle.

    Sine0 waits for Filter0, Filter0 for Printer0, Printer0 for Sine0

Remove one of the conditions. The flow of data needs no order: connectors in a circle are no problem.",
}];
