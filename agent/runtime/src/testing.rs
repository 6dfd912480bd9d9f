//! A manager for unit tests: drives a component through the same C ABI as a real one, without threads or time, and refuses
//! what that refuses. It applies a component's own checks of values, not its constraints.
//!
//! ```ignore
//! let mut host = TestHost::of::<Gain>()?;
//! host.configure("factor", "3")?;
//! host.activate()?;
//! host.send("in", &TimedDouble::now(2.0));
//! host.execute()?;
//! assert_eq!(host.take::<TimedDouble>("out")[0].data, 6.0);
//! ```

#![allow(unsafe_code)]

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::ffi::c_void;
use std::fmt;
use std::ptr;
use std::rc::Rc;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Instant, SystemTime};

use crate::abi::{self, Buffer, Host, Loan, Module, Text, callback, port_status, return_code};
use crate::export::ModuleCell;
use crate::sized;
use crate::types::DataType;
use crate::{Component, ReturnCode, text};

/// Samples that an in-port's queue holds; the oldest is dropped, as in a manager.
const QUEUE: usize = 64;
/// Written samples that are kept for [`TestHost::take`]; the oldest is dropped.
const WRITTEN: usize = 1024;
/// Longest sample, as in a manager.
const MAX_SAMPLE: usize = 64 * 1024 * 1024;
/// Most loans that are out at once, as in a manager.
const MAX_LOANS: usize = 64;

/// When the monotonic clock was first asked for.
static START: OnceLock<Instant> = OnceLock::new();

/// A call did not return OK.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The code.
    pub code: ReturnCode,
    /// What the component said before it; empty when nothing.
    pub reason: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.reason)
    }
}

impl std::error::Error for Failure {}

/// A component and what it did.
#[derive(Debug)]
pub struct TestHost {
    module: &'static Module,
    instance: *mut c_void,
    shared: Rc<Shared>,
    /// The component keeps a pointer to it.
    _host: Rc<Host>,
}

#[derive(Debug, Default)]
struct State {
    /// Of the in-ports: what was sent, and not read yet.
    queues: BTreeMap<u32, VecDeque<Sample>>,
    lent: BTreeMap<u32, Sample>,
    /// Of the out-ports.
    written: BTreeMap<u32, VecDeque<Sample>>,
    log: Vec<(u32, String)>,
    reason: String,
    /// Those that are out, by their token: port, length and memory.
    loans: BTreeMap<u64, (u32, usize, Vec<u64>)>,
    last_loan: u64,
    /// Directions and type ids of the ports.
    ports: Vec<(u32, String)>,
    rate: f64,
}

/// What the host's functions have.
#[derive(Debug, Default)]
struct Shared {
    state: RefCell<State>,
    is_event_driven: bool,
    /// Any thread counts.
    woken: AtomicU64,
}

#[derive(Debug)]
struct Sample {
    type_id: String,
    encoding: u32,
    data: Vec<u8>,
}

impl TestHost {
    /// Creates and initialises a component.
    pub fn of<C: Component>() -> Result<Self, Failure> {
        // One descriptor is leaked per call; in tests that is of no matter.
        let cell: &'static ModuleCell = Box::leak(Box::new(ModuleCell::new()));
        let mut host = Self::create(cell.get::<C>())?;
        host.callback(callback::ON_INITIALIZE)?;
        Ok(host)
    }

    /// Creates a component of a module, and calls nothing more.
    pub fn create(module: &'static Module) -> Result<Self, Failure> {
        let state = RefCell::new(State {
            // SAFETY: texts of a descriptor are static.
            ports: ports(module)
                .iter()
                .map(|port| (port.direction, unsafe { text::read(port.type_id) }))
                .collect(),
            rate: module.default_rate,
            ..State::default()
        });
        let shared = Rc::new(Shared {
            state,
            is_event_driven: module.execution_kind == abi::EXECUTION_EVENT_DRIVEN,
            woken: AtomicU64::new(0),
        });
        let host = Rc::new(Host {
            abi_version: abi::ABI_VERSION,
            size: size_of::<Host>() as u32,
            context: Rc::as_ptr(&shared).cast_mut().cast(),
            log,
            fail,
            now,
            rate,
            wake,
            write,
            read,
            is_new,
            loan,
            publish,
            discard,
        });
        let mut instance = ptr::null_mut();
        // SAFETY: the host lives in `Self` as long as the instance; `instance` can be written to.
        let code = unsafe { (module.create)(Rc::as_ptr(&host), &raw mut instance) };
        outcome(&shared.state, code)?;
        Ok(Self {
            module,
            instance,
            shared,
            _host: host,
        })
    }

    /// The descriptor.
    pub fn module(&self) -> &'static Module {
        self.module
    }

    /// Sets a parameter.
    pub fn configure(&mut self, name: &str, value: &str) -> Result<(), Failure> {
        // SAFETY: the instance is alive; the texts live until the call returns.
        let code =
            unsafe { (self.module.configure)(self.instance, text::lend(name), text::lend(value)) };
        outcome(&self.shared.state, code).map_err(|failure| Failure {
            reason: format!("parameter `{name}` = `{value}`: {}", failure.reason),
            ..failure
        })
    }

    /// Calls one of [`abi::callback`].
    pub fn callback(&mut self, callback: u32) -> Result<(), Failure> {
        if callback == callback::ON_ACTIVATED {
            self.shared.state.borrow_mut().queues.clear();
        }
        // SAFETY: the instance is alive.
        let code = unsafe { (self.module.callback)(self.instance, callback) };
        outcome(&self.shared.state, code)
    }

    /// Calls `on_activated`. What was sent before is forgotten, as in a manager.
    pub fn activate(&mut self) -> Result<(), Failure> {
        self.callback(callback::ON_ACTIVATED)
    }

    /// Calls `on_execute`.
    pub fn execute(&mut self) -> Result<(), Failure> {
        self.callback(callback::ON_EXECUTE)
    }

    /// Calls `on_deactivated`.
    pub fn deactivate(&mut self) -> Result<(), Failure> {
        self.callback(callback::ON_DEACTIVATED)
    }

    /// Puts a sample into an in-port's queue.
    ///
    /// # Panics
    /// When there is no such in-port, or the value cannot be encoded.
    pub fn send<T: DataType>(&mut self, port: &str, value: &T) {
        let mut data = Vec::new();
        value.encode(&mut data).expect("a value that CDR can hold");
        self.send_raw(port, T::TYPE_ID, &data);
    }

    /// Puts any bytes into an in-port's queue.
    ///
    /// # Panics
    /// When there is no such in-port.
    pub fn send_raw(&mut self, port: &str, type_id: &str, data: &[u8]) {
        let port = self.port(port, abi::PORT_IN);
        let sample = Sample {
            type_id: type_id.into(),
            encoding: abi::ENCODING_CDR_LE,
            data: data.into(),
        };
        let queues = &mut self.shared.state.borrow_mut().queues;
        push(queues, port, sample, QUEUE);
    }

    /// Takes what was written to an out-port.
    ///
    /// # Panics
    /// When there is no such out-port, or it has another type.
    pub fn take<T: DataType>(&mut self, port: &str) -> Vec<T> {
        let port = self.port(port, abi::PORT_OUT);
        let samples = self.shared.state.borrow_mut().written.remove(&port);
        let decode = |sample: Sample| {
            assert_eq!(sample.type_id, T::TYPE_ID, "type of the sample");
            T::decode(&sample.data).expect("a sample of this SDK")
        };
        samples
            .unwrap_or_default()
            .into_iter()
            .map(decode)
            .collect()
    }

    /// Takes how often the component asked for another cycle.
    pub fn take_woken(&mut self) -> u64 {
        self.shared.woken.swap(0, Ordering::Relaxed)
    }

    /// Takes the lines that were logged.
    pub fn take_log(&mut self) -> Vec<String> {
        let lines = std::mem::take(&mut self.shared.state.borrow_mut().log);
        lines.into_iter().map(|(_, line)| line).collect()
    }

    /// Names, directions and types of the ports, and the parameters with their defaults, one a line.
    pub fn describe(&self) -> String {
        let mut out = String::new();
        for port in ports(self.module) {
            // SAFETY: texts of a descriptor are static.
            let (name, type_id) = unsafe { (text::read(port.name), text::read(port.type_id)) };
            let direction = ["in", "out"][(port.direction == abi::PORT_OUT) as usize];
            out += &format!("{direction} {name} {type_id}\n");
        }
        for parameter in parameters(self.module) {
            // SAFETY: as above.
            let (name, default) =
                unsafe { (text::read(parameter.name), text::read(parameter.default)) };
            out += &format!("{name}={default}\n");
        }
        out
    }

    fn port(&self, name: &str, direction: u32) -> u32 {
        let found = ports(self.module).iter().position(|port| {
            // SAFETY: texts of a descriptor are static.
            port.direction == direction && unsafe { text::read(port.name) } == name
        });
        match found {
            Some(index) => index as u32,
            None => panic!(
                "no port `{name}` in this direction; the type has\n{}",
                self.describe()
            ),
        }
    }
}

impl Drop for TestHost {
    fn drop(&mut self) {
        // SAFETY: the instance is alive and not used again.
        unsafe { (self.module.destroy)(self.instance) }
    }
}

impl State {
    /// Whether there is a port with this number and direction.
    fn is(&self, port: u32, direction: u32) -> bool {
        let found = self.ports.get(port as usize);
        found.is_some_and(|(found, _)| *found == direction)
    }

    /// Keeps a sample that the component wrote.
    fn keep(&mut self, port: u32, data: Vec<u8>) -> i32 {
        let Some((abi::PORT_OUT, type_id)) = self.ports.get(port as usize) else {
            return port_status::PORT_INVALID_ARGS;
        };
        let sample = Sample {
            type_id: type_id.clone(),
            encoding: abi::ENCODING_CDR_LE,
            data,
        };
        push(&mut self.written, port, sample, WRITTEN);
        port_status::PORT_OK
    }
}

fn push(queues: &mut BTreeMap<u32, VecDeque<Sample>>, port: u32, sample: Sample, limit: usize) {
    let queue = queues.entry(port).or_default();
    if queue.len() == limit {
        queue.pop_front();
    }
    queue.push_back(sample);
}

fn ports(module: &'static Module) -> &'static [abi::Port] {
    // SAFETY: a descriptor's arrays are static; ours are never null, even when empty.
    unsafe { std::slice::from_raw_parts(module.ports, module.ports_len) }
}

fn parameters(module: &'static Module) -> &'static [abi::Parameter] {
    // SAFETY: as in `ports`.
    unsafe { std::slice::from_raw_parts(module.parameters, module.parameters_len) }
}

fn outcome(state: &RefCell<State>, code: i32) -> Result<(), Failure> {
    let reason = std::mem::take(&mut state.borrow_mut().reason);
    match code {
        return_code::OK | return_code::NOT_IMPLEMENTED => Ok(()),
        code => Err(Failure {
            code: ReturnCode::from_number(code),
            reason,
        }),
    }
}

/// # Safety
/// `context` must be that of the host made in [`TestHost::create`].
unsafe fn state<'a>(context: *mut c_void) -> &'a RefCell<State> {
    // SAFETY: it points into the `Rc` that the host's owner holds.
    unsafe { &(*context.cast::<Shared>()).state }
}

unsafe extern "C" fn log(context: *mut c_void, level: u32, message: Text) {
    // SAFETY: a component passes the host's context and a text that lives until the call returns.
    let (state, message) = unsafe { (state(context), text::read(message)) };
    state.borrow_mut().log.push((level, message));
}

unsafe extern "C" fn fail(context: *mut c_void, reason: Text) {
    // SAFETY: as in `log`.
    let (state, reason) = unsafe { (state(context), text::read(reason)) };
    state.borrow_mut().reason = reason;
}

unsafe extern "C" fn now(_context: *mut c_void, clock: u32) -> i64 {
    let since = match clock {
        abi::CLOCK_REALTIME => SystemTime::now()
            .duration_since(SystemTime::UNIX_EPOCH)
            .unwrap_or_default(),
        _ => START.get_or_init(Instant::now).elapsed(),
    };
    since.as_nanos() as i64
}

unsafe extern "C" fn rate(context: *mut c_void) -> f64 {
    // SAFETY: as in `log`.
    unsafe { state(context) }.borrow().rate
}

unsafe extern "C" fn wake(context: *mut c_void) -> i32 {
    // SAFETY: as in `log`, but by any thread: what is looked at does not change, or is atomic.
    let shared = unsafe { &*context.cast::<Shared>() };
    if !shared.is_event_driven {
        return return_code::PRECONDITION_NOT_MET;
    }
    shared.woken.fetch_add(1, Ordering::Relaxed);
    return_code::OK
}

unsafe extern "C" fn write(context: *mut c_void, port: u32, sample: *const Buffer) -> i32 {
    // SAFETY: a component passes the host's context, and a sample that is null or lives until the call returns.
    unsafe {
        let Ok(sample) = sized::read(sample) else {
            return port_status::PORT_INVALID_ARGS;
        };
        let data = Text {
            data: sample.data,
            len: sample.len,
        };
        let mut state = state(context).borrow_mut();
        let declared = state.ports.get(port as usize);
        let is_its_type =
            declared.is_some_and(|(_, it)| it.as_bytes() == text::bytes(sample.type_id));
        if !is_its_type || sample.encoding != abi::ENCODING_CDR_LE || sample.len > MAX_SAMPLE {
            return port_status::PORT_INVALID_ARGS;
        }
        state.keep(port, text::bytes(data).to_vec())
    }
}

unsafe extern "C" fn read(context: *mut c_void, port: u32, sample: *mut Buffer) -> i32 {
    // SAFETY: a component passes the host's context, and a place that is null or can be written to.
    let (mut state, is_usable) = unsafe {
        let is_usable = sized::size(sample.cast_const()).is_ok();
        (state(context).borrow_mut(), is_usable)
    };
    if !is_usable || !state.is(port, abi::PORT_IN) {
        return port_status::PORT_INVALID_ARGS;
    }
    let Some(next) = state.queues.get_mut(&port).and_then(VecDeque::pop_front) else {
        return port_status::PORT_BUFFER_EMPTY;
    };
    let buffer = Buffer {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Buffer>() as u32,
        type_id: text::lend(&next.type_id),
        encoding: next.encoding,
        reserved: 0,
        data: next.data.as_ptr(),
        len: next.data.len(),
    };
    // Moving a sample does not move its bytes.
    state.lent.insert(port, next);
    // SAFETY: as above.
    let filled = unsafe { sized::fill(sample, &buffer) };
    filled.map_or(port_status::PORT_INVALID_ARGS, |()| port_status::PORT_OK)
}

unsafe extern "C" fn is_new(context: *mut c_void, port: u32) -> i32 {
    // SAFETY: as in `log`.
    let state = unsafe { state(context) }.borrow();
    let queue = state.queues.get(&port);
    queue.is_some_and(|queue| !queue.is_empty()).into()
}

unsafe extern "C" fn loan(context: *mut c_void, port: u32, len: usize, loan: *mut Loan) -> i32 {
    // SAFETY: a component passes the host's context, and a place that is null or can be written to.
    let (mut state, is_usable) = unsafe {
        let is_usable = sized::size(loan.cast_const()).is_ok();
        (state(context).borrow_mut(), is_usable)
    };
    if !is_usable || !state.is(port, abi::PORT_OUT) || len > MAX_SAMPLE {
        return port_status::PORT_INVALID_ARGS;
    }
    if state.loans.len() == MAX_LOANS {
        return port_status::PORT_BUFFER_FULL;
    }
    state.last_loan += 1;
    let token = state.last_loan;
    let mut words = vec![0_u64; len.div_ceil(8)];
    let lent = Loan {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Loan>() as u32,
        token,
        data: words.as_mut_ptr().cast(),
        len,
    };
    state.loans.insert(token, (port, len, words));
    // SAFETY: as above.
    let filled = unsafe { sized::fill(loan, &lent) };
    filled.map_or(port_status::PORT_INVALID_ARGS, |()| port_status::PORT_OK)
}

unsafe extern "C" fn publish(context: *mut c_void, token: u64, len: usize) -> i32 {
    // SAFETY: as in `log`.
    let mut state = unsafe { state(context) }.borrow_mut();
    match state.loans.remove(&token) {
        Some((port, room, words)) if len <= room => {
            let bytes = words.into_iter().flat_map(u64::to_ne_bytes).take(len);
            state.keep(port, bytes.collect())
        }
        _ => port_status::PORT_INVALID_ARGS,
    }
}

unsafe extern "C" fn discard(context: *mut c_void, token: u64) {
    // SAFETY: as in `log`.
    unsafe { state(context) }.borrow_mut().loans.remove(&token);
}
