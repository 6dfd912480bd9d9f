//! The trait that a component implements.

use crate::abi::{self, callback};
use crate::{Context, Declaration, RtcResult};

/// What a component type says of itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TypeInfo {
    /// Type name (`ConsoleIn`), as in the profile's component id.
    pub name: &'static str,
    /// Vendor.
    pub vendor: &'static str,
    /// Category.
    pub category: &'static str,
    /// Version (`1.2.0`).
    pub version: &'static str,
    /// One line for people.
    pub description: &'static str,
    /// Rate of the periodic execution context in Hz when nothing else is said.
    pub rate: f64,
}

/// Which execution context a component wants when nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExecutionKind {
    /// A cycle at a fixed rate.
    #[default]
    Periodic,
    /// A cycle when a sample arrives, or when the component asks for one.
    EventDriven,
    /// A cycle when somebody asks for one.
    External,
}

impl ExecutionKind {
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Periodic => abi::EXECUTION_PERIODIC,
            Self::EventDriven => abi::EXECUTION_EVENT_DRIVEN,
            Self::External => abi::EXECUTION_EXTERNAL,
        }
    }

    /// The activity type that goes with it.
    pub(crate) fn activity(self) -> u32 {
        match self {
            Self::Periodic => abi::ACTIVITY_PERIODIC,
            Self::EventDriven => abi::ACTIVITY_EVENT_DRIVEN,
            Self::External => abi::ACTIVITY_SPORADIC,
        }
    }
}

/// A component (`RTObject`): [`TYPE`](Self::TYPE), [`declare`](Self::declare), and the callbacks that it needs.
///
/// Callbacks never overlap. What they must not do is block: a cycle that sleeps holds back every component of its
/// execution context. An `Err` or a panic in `on_execute` sends the component to Error; the reason is shown to the
/// user. The callbacks are those of `ComponentAction` and `DataFlowComponentAction` (OMG RTC 1.0, 5.2.2.4, 5.3.1.2).
pub trait Component: Send + Sized + 'static {
    /// Name, version, default rate.
    const TYPE: TypeInfo;

    /// The execution context that it wants.
    const EXECUTION: ExecutionKind = ExecutionKind::Periodic;

    /// Most instances in one process; 0 for any number.
    const MAX_INSTANCES: u32 = 0;

    /// Declares the ports and parameters and makes a component that holds them.
    ///
    /// It runs once to describe the type and once for each instance, so it must declare the same each time and touch
    /// nothing outside: open files and devices in `on_initialize` or `on_activated`.
    fn declare(d: &mut Declaration) -> Self;

    /// The instance was created and configured. An error undoes the creation.
    fn on_initialize(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_INITIALIZE);
        Ok(())
    }

    /// The instance is about to be deleted.
    fn on_finalize(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_FINALIZE);
        Ok(())
    }

    /// The execution context starts.
    fn on_startup(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_STARTUP);
        Ok(())
    }

    /// The execution context stops.
    fn on_shutdown(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_SHUTDOWN);
        Ok(())
    }

    /// Inactive to Active. An error leads to Error.
    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_ACTIVATED);
        Ok(())
    }

    /// Active to Inactive.
    fn on_deactivated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_DEACTIVATED);
        Ok(())
    }

    /// Active to Error: bring the hardware to a safe state.
    fn on_aborting(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_ABORTING);
        Ok(())
    }

    /// Once a cycle while in Error.
    fn on_error(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_ERROR);
        Ok(())
    }

    /// Error to Inactive. An error keeps it in Error.
    fn on_reset(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_RESET);
        Ok(())
    }

    /// Once a cycle while Active.
    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_EXECUTE);
        Ok(())
    }

    /// After each `on_execute`.
    fn on_state_update(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_STATE_UPDATE);
        Ok(())
    }

    /// The rate of the execution context was changed.
    fn on_rate_changed(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_RATE_CHANGED);
        Ok(())
    }

    /// Parameters were set while it lives: all values of one update, before the next `on_execute`. An error leads to Error.
    fn on_configured(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.not_implemented(callback::ON_CONFIGURED);
        Ok(())
    }
}
