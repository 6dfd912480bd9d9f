//! What a component is built on: the Rust SDK and the C ABI of modules.
//!
//! A component is a type that implements [`Component`]; [`export!`] makes its crate a module that a manager can load.
//!
//! ```
//! use rts_runtime::{Component, Config, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};
//! use rts_runtime::types::TimedDouble;
//!
//! struct Gain {
//!     input: InPort<TimedDouble>,
//!     output: OutPort<TimedDouble>,
//!     factor: Config<f64>,
//! }
//!
//! impl Component for Gain {
//!     const TYPE: TypeInfo = TypeInfo {
//!         name: "Gain",
//!         vendor: "me",
//!         category: "example",
//!         version: "0.1.0",
//!         description: "multiplies by a factor",
//!         rate: 100.0,
//!     };
//!
//!     fn declare(d: &mut Declaration) -> Self {
//!         Self {
//!             input: d.in_port("in"),
//!             output: d.out_port("out"),
//!             factor: d.parameter("factor", 2.0),
//!         }
//!     }
//!
//!     fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
//!         while let Some(mut sample) = self.input.read(ctx)? {
//!             sample.data *= self.factor.get();
//!             self.output.write(ctx, &sample)?;
//!         }
//!         Ok(())
//!     }
//! }
//! rts_runtime::export!(Gain);
//! ```

pub mod abi;
mod component;
mod configuration;
mod context;
mod descriptor;
mod error;
#[doc(hidden)]
pub mod export;
mod loan;
mod port_status;
mod ports;
pub mod sized;
pub mod testing;
mod text;
pub mod types;
mod waker;

pub use component::{Component, ExecutionKind, TypeInfo};
pub use configuration::{Config, ParameterError, ParameterValue};
pub use context::{Context, Level};
pub use descriptor::Declaration;
pub use error::{ReturnCode, RtcError, RtcResult};
pub use loan::Loan;
pub use port_status::PortStatus;
pub use ports::{InPort, OutPort};
pub use waker::Waker;
/// Types that are generated from IDL name it so.
extern crate self as rts_runtime;

/// For types that are generated from IDL.
#[doc(hidden)]
pub use serde;

/// Keeps the guide's first example compiling.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/components.md")]
struct Guide;
