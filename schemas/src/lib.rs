//! What a system *is*: the models of profiles and overlays, their readers, and every check that needs no machine.
//!
//! No I/O happens here: text comes in, models and findings go out. Files are read by the programs.

pub mod canonical;
pub mod cdr;
pub mod check;
pub mod codes;
pub mod composite;
pub mod connector;
pub mod diagnostic;
pub mod docs;
pub mod form;
pub mod idl;
pub mod json_schema;
pub mod names;
pub mod overlay;
pub mod placement;
pub mod rtc_conf;
pub mod rtc_profile;
pub mod rts_profile;
pub mod span;
pub mod stand_in;
pub mod suggest;
pub mod system;
pub mod target;
pub mod xml;
pub mod yaml;
pub mod yaml_type;
