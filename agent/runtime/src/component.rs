//! The trait that a component implements.

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

/// A component (`RTObject`): [`TYPE`](Self::TYPE), [`declare`](Self::declare), and the callbacks that it needs.
///
/// Callbacks never overlap. What they must not do is block: a cycle that sleeps holds back every component of its
/// execution context. An `Err` or a panic in `on_execute` sends the component to Error; the reason is shown to the
/// user. The callbacks are those of `ComponentAction` and `DataFlowComponentAction` (OMG RTC 1.0, 5.2.2.4, 5.3.1.2).
pub trait Component: Send + Sized + 'static {
    /// Name, version, default rate.
    const TYPE: TypeInfo;

    /// Declares the ports and parameters and makes a component that holds them.
    ///
    /// It runs once to describe the type and once for each instance, so it must declare the same each time and touch
    /// nothing outside: open files and devices in `on_initialize` or `on_activated`.
    fn declare(d: &mut Declaration) -> Self;

    /// The instance was created and configured. An error undoes the creation.
    fn on_initialize(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// The instance is about to be deleted.
    fn on_finalize(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// The execution context starts.
    fn on_startup(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// The execution context stops.
    fn on_shutdown(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Inactive to Active. An error leads to Error.
    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Active to Inactive.
    fn on_deactivated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Active to Error: bring the hardware to a safe state.
    fn on_aborting(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Once a cycle while in Error.
    fn on_error(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Error to Inactive. An error keeps it in Error.
    fn on_reset(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// Once a cycle while Active.
    fn on_execute(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// After each `on_execute`.
    fn on_state_update(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }

    /// The rate of the execution context was changed.
    fn on_rate_changed(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Ok(())
    }
}
