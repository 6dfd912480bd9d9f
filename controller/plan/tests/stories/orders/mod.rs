//! Orders of a profile as stories in text: one for each rule.

mod conditions;
mod elsewhere;
mod going_down;
mod initialising;
mod optional;
mod preferences;
mod tell;
