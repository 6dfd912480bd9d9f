//! An instance of a component: the only place that calls into a module, or into what stands in for one.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ptr;
use std::sync::Arc;
use std::time::Instant;

use rts_runtime::abi::return_code;

use super::host::Host;
use super::lifecycle::callback_name;
use super::{Busy, Component};
use crate::module::{Code, Functions};
use crate::stand_in::StandIn;
use crate::sync::lock;
use crate::text::{lend, one_line};

/// An instance. Stays on the thread that made it; freed on drop.
pub struct Instance {
    body: Body,
    component: Arc<Component>,
    /// Callbacks that it implements, as far as is known, a bit each.
    actions: u32,
}

enum Body {
    Library(Made),
    StandIn(StandIn),
}

/// What a module made.
struct Made {
    functions: Functions,
    pointer: *mut c_void,
    host: Host,
}

/// A call that did not return OK.
#[derive(Debug, PartialEq, Eq)]
pub struct CallFailed {
    /// Return code.
    pub code: i32,
    /// For people, the call named.
    pub message: String,
}

impl Instance {
    /// Makes an instance.
    pub fn create(component: &Arc<Component>) -> Result<Self, CallFailed> {
        let body = match &component.module.code {
            Code::Library(functions) => Body::Library(make(component, *functions)?),
            Code::StandIn(shape) => Body::StandIn(StandIn::new(shape)),
        };
        Ok(Self {
            body,
            component: Arc::clone(component),
            actions: component.module.actions,
        })
    }

    /// Calls a callback, if the component has it.
    pub fn callback(&mut self, number: u32) -> Result<(), CallFailed> {
        if self.actions & 1 << number == 0 {
            return Ok(());
        }
        let name = callback_name(number);
        self.component.in_ports().for_each(|port| port.begin());
        let made = match &mut self.body {
            Body::Library(made) => made,
            Body::StandIn(stand_in) => {
                let component = &self.component;
                let called = during(component, name, || stand_in.callback(component, number));
                return called.map_err(|why| CallFailed {
                    code: return_code::ERROR,
                    message: format!("{name}: {why}"),
                });
            }
        };
        let code = during(&self.component, name, || {
            // SAFETY: the instance was made by this module, lives, and is used by this thread alone.
            unsafe { (made.functions.callback)(made.pointer, number) }
        });
        if code == return_code::NOT_IMPLEMENTED {
            self.actions &= !(1 << number);
            return Ok(());
        }
        check(name, code, &made.host)
    }

    /// Sets a parameter. To a stand-in it means nothing.
    pub fn configure(&mut self, name: &str, value: &str) -> Result<(), CallFailed> {
        let Body::Library(made) = &mut self.body else {
            return Ok(());
        };
        let code = during(&self.component, "configure", || {
            // SAFETY: as for callbacks; both texts live during the call.
            unsafe { (made.functions.configure)(made.pointer, lend(name), lend(value)) }
        });
        check(&format!("parameter `{name}` = `{value}`"), code, &made.host)
    }
}

/// Lets a module make an instance.
fn make(component: &Arc<Component>, functions: Functions) -> Result<Made, CallFailed> {
    let host = Host::new(component);
    let mut pointer = ptr::null_mut();
    let code = during(component, "create", || {
        // SAFETY: the host lives as long as the instance; `pointer` may be written.
        unsafe { (functions.create)(host.as_abi(), &raw mut pointer) }
    });
    check("create", code, &host)?;
    if pointer.is_null() {
        return Err(CallFailed {
            code: return_code::ERROR,
            message: "create returned RTC_OK without an instance".to_owned(),
        });
    }
    Ok(Made {
        functions,
        pointer,
        host,
    })
}

impl Drop for Instance {
    fn drop(&mut self) {
        let Body::Library(made) = &self.body else {
            return;
        };
        during(&self.component, "destroy", || {
            // SAFETY: the instance was made by this module and is not used again.
            unsafe { (made.functions.destroy)(made.pointer) }
        });
    }
}

/// Makes a call visible while it lasts, so that one that hangs can be named.
fn during<T>(component: &Component, call: &'static str, f: impl FnOnce() -> T) -> T {
    let since = Instant::now();
    *lock(&component.busy) = Some(Busy { call, since });
    let result = f();
    *lock(&component.busy) = None;
    result
}

fn check(what: &str, code: i32, host: &Host) -> Result<(), CallFailed> {
    let reason = host.take_failure();
    if code == return_code::OK {
        return Ok(());
    }
    let message = match reason {
        Some(reason) => format!("{what}: {reason}"),
        None => format!("{what} returned {}", code_name(code)),
    };
    // From here it goes to logs, events and terminals.
    let message = one_line(&message);
    Err(CallFailed { code, message })
}

fn code_name(code: i32) -> String {
    match code {
        return_code::ERROR => "RTC_ERROR".to_owned(),
        return_code::BAD_PARAMETER => "BAD_PARAMETER".to_owned(),
        return_code::UNSUPPORTED => "UNSUPPORTED".to_owned(),
        return_code::OUT_OF_RESOURCES => "OUT_OF_RESOURCES".to_owned(),
        return_code::PRECONDITION_NOT_MET => "PRECONDITION_NOT_MET".to_owned(),
        other => format!("the unknown code {other}"),
    }
}
