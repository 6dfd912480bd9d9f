//! The functions behind a module's vtable. Nothing unwinds out of them.

#![allow(unsafe_code)]

use std::any::Any;
use std::cell::RefCell;
use std::ffi::c_void;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Once, OnceLock};

use crate::abi::{self, Host, Module, Text, return_code};
use crate::component::Component;
use crate::context::Context;
use crate::descriptor::{Declaration, describe};
use crate::sized::{self, Misfit};
use crate::waker::Wakers;
use crate::{ReturnCode, RtcError, RtcResult, text};

/// Makes this crate a module with one component type. The crate needs `crate-type = ["cdylib"]`.
#[macro_export]
macro_rules! export {
    ($component:ty) => {
        const _: () = {
            static MODULE: $crate::export::ModuleCell = $crate::export::ModuleCell::new();

            #[unsafe(no_mangle)]
            extern "C" fn rts_module_v1() -> *const $crate::abi::Module {
                MODULE.get::<$component>()
            }
        };
    };
}

/// Holds the descriptor of a module.
#[derive(Debug)]
pub struct ModuleCell(OnceLock<Shared>);

#[derive(Debug)]
struct Shared(&'static Module);

// SAFETY: the descriptor is never written after it was made; its pointers are to static memory.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}

impl ModuleCell {
    /// An empty cell.
    #[expect(
        clippy::new_without_default,
        reason = "only the macro uses it, in a static"
    )]
    pub const fn new() -> Self {
        Self(OnceLock::new())
    }

    /// The descriptor of `C`, made on the first call.
    pub fn get<C: Component>(&self) -> &'static Module {
        self.0
            .get_or_init(|| {
                remember_panics();
                Shared(describe::<C>())
            })
            .0
    }
}

/// A component with what is needed to call it.
struct Instance<C> {
    component: C,
    declaration: Declaration,
    /// As far as this SDK knows it; what the manager does not know is zero.
    host: Host,
    /// Ends after the component, whose drop may end threads that use it.
    wakers: Wakers,
}

/// Makes an instance.
///
/// # Safety
/// As [`Module::create`] says.
pub(crate) unsafe extern "C" fn create<C: Component>(
    host: *const Host,
    instance: *mut *mut c_void,
) -> i32 {
    if instance.is_null() {
        return return_code::BAD_PARAMETER;
    }
    // SAFETY: a manager passes a host that is as long as it says, and its functions hold for as long as the instance.
    let host = match unsafe { sized::read(host) } {
        Ok(host) => host,
        Err(Misfit::Null) => return return_code::BAD_PARAMETER,
        Err(_) => return return_code::UNSUPPORTED,
    };
    // SAFETY: they belong to the instance.
    let wakers = unsafe { Wakers::new(&host) };
    let made = guard(&host, &wakers, |_| {
        let mut declaration = Declaration::default();
        let component = C::declare(&mut declaration);
        if let Some(problem) = declaration.problem() {
            return Err(RtcError::error(format_args!(
                "the type {} is declared wrongly: {problem}",
                C::TYPE.name
            )));
        }
        Ok((component, declaration))
    });
    match made {
        Ok((component, declaration)) => {
            let made = Box::new(Instance {
                component,
                declaration,
                host,
                wakers,
            });
            // SAFETY: not null; the manager gave a place to write to.
            unsafe { *instance = Box::into_raw(made).cast() };
            return_code::OK
        }
        Err(code) => code,
    }
}

/// Frees an instance.
///
/// # Safety
/// As [`Module::destroy`] says.
pub(crate) unsafe extern "C" fn destroy<C: Component>(instance: *mut c_void) {
    if instance.is_null() {
        return;
    }
    // SAFETY: it came from `create` of the same type and is not used again.
    let instance = unsafe { Box::from_raw(instance.cast::<Instance<C>>()) };
    // There is nobody to tell of a panic in a destructor; the hook has printed it.
    let _ = catch(move || drop(instance));
}

/// Calls a callback.
///
/// # Safety
/// As [`Module::callback`] says.
pub(crate) unsafe extern "C" fn callback<C: Component>(
    instance: *mut c_void,
    callback: u32,
) -> i32 {
    if instance.is_null() {
        return return_code::BAD_PARAMETER;
    }
    // SAFETY: it came from `create` of the same type, and calls on one instance never overlap.
    let Instance {
        component,
        host,
        wakers,
        ..
    } = unsafe { &mut *instance.cast::<Instance<C>>() };
    let called = guard(host, wakers, |ctx| {
        dispatch(component, callback, ctx)?;
        Ok(ctx.is_default(callback))
    });
    match called {
        Ok(true) => return_code::NOT_IMPLEMENTED,
        called => code(called),
    }
}

/// Sets a parameter.
///
/// # Safety
/// As [`Module::configure`] says.
pub(crate) unsafe extern "C" fn configure<C: Component>(
    instance: *mut c_void,
    name: Text,
    value: Text,
) -> i32 {
    if instance.is_null() {
        return return_code::BAD_PARAMETER;
    }
    // SAFETY: it came from `create` of the same type, and calls on one instance never overlap.
    let Instance {
        declaration,
        host,
        wakers,
        ..
    } = unsafe { &*instance.cast::<Instance<C>>() };
    // SAFETY: the manager lends both texts for the time of the call.
    let (name, value) = unsafe { (text::read(name), text::read(value)) };
    code(guard(host, wakers, |_| {
        declaration
            .assign(&name, &value)
            .map_err(RtcError::bad_parameter)
    }))
}

fn dispatch<C: Component>(component: &mut C, callback: u32, ctx: &mut Context<'_>) -> RtcResult {
    match callback {
        abi::callback::ON_INITIALIZE => component.on_initialize(ctx),
        abi::callback::ON_FINALIZE => component.on_finalize(ctx),
        abi::callback::ON_STARTUP => component.on_startup(ctx),
        abi::callback::ON_SHUTDOWN => component.on_shutdown(ctx),
        abi::callback::ON_ACTIVATED => component.on_activated(ctx),
        abi::callback::ON_DEACTIVATED => component.on_deactivated(ctx),
        abi::callback::ON_ABORTING => component.on_aborting(ctx),
        abi::callback::ON_ERROR => component.on_error(ctx),
        abi::callback::ON_RESET => component.on_reset(ctx),
        abi::callback::ON_EXECUTE => component.on_execute(ctx),
        abi::callback::ON_STATE_UPDATE => component.on_state_update(ctx),
        abi::callback::ON_RATE_CHANGED => component.on_rate_changed(ctx),
        abi::callback::ON_CONFIGURED => component.on_configured(ctx),
        other => Err(RtcError::new(
            ReturnCode::Unsupported,
            format_args!("this module knows no callback {other}"),
        )),
    }
}

fn code<T>(result: Result<T, i32>) -> i32 {
    result.err().unwrap_or(return_code::OK)
}

/// Runs what the author wrote; an error or a panic becomes a reason for the manager and a return code.
fn guard<T>(
    host: &Host,
    wakers: &Wakers,
    run: impl FnOnce(&mut Context<'_>) -> RtcResult<T>,
) -> Result<T, i32> {
    let mut ctx = Context::new(host, wakers);
    match catch(|| run(&mut ctx)) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => {
            ctx.fail(error.reason());
            Err(error.code().number())
        }
        Err(panic) => {
            ctx.fail(&panic);
            Err(return_code::ERROR)
        }
    }
}

/// Runs `run`; a panic becomes `panicked at src/lib.rs:7:9: message`.
///
/// What a panic leaves behind in the component is the component's to judge: it goes to Error, and `on_reset` decides.
pub(crate) fn catch<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    LAST_PANIC.take();
    panic::catch_unwind(AssertUnwindSafe(run)).map_err(|payload| {
        let place = LAST_PANIC.take();
        let message = message(payload);
        match place {
            Some(place) => format!("panicked at {place}: {message}"),
            None => format!("panicked: {message}"),
        }
    })
}

fn message(payload: Box<dyn Any + Send>) -> String {
    if let Some(text) = payload.downcast_ref::<&str>() {
        return (*text).to_owned();
    }
    if let Some(text) = payload.downcast_ref::<String>() {
        return text.clone();
    }
    // Its destructor could panic again, outside of any catch.
    std::mem::forget(payload);
    "(no message)".to_owned()
}

thread_local! {
    static LAST_PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// A payload does not say where the panic was; only a hook sees that. The standard library, and so the hook, is the
/// module's own.
fn remember_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            let place = info.location().map(ToString::to_string);
            // Not at the end of a thread, where the cell is gone: a panic in a hook would abort.
            let _ = LAST_PANIC.try_with(|last| last.replace(place));
            before(info);
        }));
    });
}
