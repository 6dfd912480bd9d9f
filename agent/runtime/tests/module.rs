//! The exported function and the vtable behind it, as a manager uses them.

#![allow(unsafe_code)]

#[path = "module/header.rs"]
mod header;
#[path = "module/test_host.rs"]
mod test_host;

use std::ptr;
use std::sync::Mutex;
use std::thread::{self, JoinHandle};

use rts_runtime::abi::{self, Entry, Host, Module, callback};
use rts_runtime::sized::Sized32 as _;
use rts_runtime::testing::TestHost;
use rts_runtime::types::{DataType, TimedDouble, TimedLong};
use rts_runtime::{
    Component, Config, Context, Declaration, ExecutionKind, InPort, OutPort, ReturnCode, RtcError,
    RtcResult, TypeInfo, Waker,
};

struct Echo {
    input: InPort<TimedLong>,
    output: OutPort<TimedLong>,
    offset: Config<i32>,
}

impl Component for Echo {
    const TYPE: TypeInfo = TypeInfo {
        name: "Echo",
        vendor: "test",
        category: "test",
        version: "1.2.3",
        description: "sends back what it gets",
        rate: 50.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
            offset: d.parameter("offset", 0),
        }
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.info(format_args!("offset {}", self.offset.get()));
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(mut sample) = self.input.read(ctx)? {
            if sample.data == 13 {
                panic!("13 brings bad luck");
            }
            sample.data += self.offset.get();
            self.output.write(ctx, &sample)?;
        }
        Ok(())
    }

    fn on_reset(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        Err(RtcError::precondition("the motor is hot"))
    }
}

rts_runtime::export!(Echo);

unsafe extern "C" {
    fn rts_module_v1() -> *const Module;
}

fn module() -> &'static Module {
    let entry: Entry = rts_module_v1;
    // SAFETY: the exported function of this very file; its descriptor is static.
    unsafe { &*entry() }
}

#[test]
fn the_descriptor_says_what_was_declared() {
    let module = module();
    assert_eq!(module.abi_version, abi::ABI_VERSION);
    assert_eq!(module.size as usize, size_of::<Module>());
    assert_eq!(module.default_rate, 50.0);
    // SAFETY: as in `module`.
    let again = unsafe { rts_module_v1() };
    assert!(ptr::eq(module, again), "one descriptor for all calls");
    assert_eq!(
        TestHost::create(module).unwrap().describe(),
        "in in IDL:RTC/TimedLong:1.0\nout out IDL:RTC/TimedLong:1.0\noffset=0\n"
    );
}

#[test]
fn samples_parameters_and_lines_cross_the_boundary() {
    let mut host = TestHost::create(module()).unwrap();
    host.configure("offset", "100").unwrap();
    for number in 0..callback::CALLBACKS {
        if number != callback::ON_RESET {
            host.callback(number).unwrap();
        }
    }
    host.send("in", &TimedLong::now(1));
    host.send("in", &TimedLong::now(2));
    host.execute().unwrap();
    let out: Vec<_> = host.take::<TimedLong>("out");
    assert_eq!(out.iter().map(|s| s.data).collect::<Vec<_>>(), [101, 102]);
    assert_eq!(host.take_log(), ["offset 100"]);
}

#[test]
fn instances_share_nothing() {
    let mut one = TestHost::create(module()).unwrap();
    let mut two = TestHost::create(module()).unwrap();
    one.configure("offset", "1").unwrap();
    for host in [&mut one, &mut two] {
        host.send("in", &TimedLong::now(0));
        host.execute().unwrap();
    }
    assert_eq!(one.take::<TimedLong>("out")[0].data, 1);
    assert_eq!(two.take::<TimedLong>("out")[0].data, 0);
}

#[test]
fn a_panic_is_an_error_with_its_message_and_the_instance_lives_on() {
    let mut host = TestHost::create(module()).unwrap();
    host.send("in", &TimedLong::now(13));
    let failure = host.execute().unwrap_err();
    assert_eq!(failure.code, ReturnCode::Error);
    let (place, message) = failure.reason.rsplit_once(": ").unwrap();
    assert_eq!(message, "13 brings bad luck");
    assert!(
        place.starts_with("panicked at ") && place.contains("module.rs:"),
        "{place}"
    );
    host.send("in", &TimedLong::now(7));
    host.execute().unwrap();
    assert_eq!(host.take::<TimedLong>("out")[0].data, 7);
}

#[test]
fn failures_carry_code_and_reason() {
    let mut host = TestHost::create(module()).unwrap();
    let failures = [
        host.callback(callback::ON_RESET).unwrap_err(),
        host.callback(99).unwrap_err(),
        host.configure("offset", "1.5").unwrap_err(),
        host.configure("speed", "1").unwrap_err(),
    ];
    let text: Vec<_> = failures.iter().map(ToString::to_string).collect();
    assert_eq!(
        text,
        [
            "PRECONDITION_NOT_MET: the motor is hot",
            "UNSUPPORTED: this module knows no callback 99",
            "BAD_PARAMETER: parameter `offset` = `1.5`: expected a 32-bit integer",
            "BAD_PARAMETER: parameter `speed` = `1`: there is no such parameter; the type has offset",
        ]
    );
}

#[test]
fn a_sample_of_another_type_or_length_is_refused() {
    let mut host = TestHost::create(module()).unwrap();
    host.send_raw("in", TimedDouble::TYPE_ID, &[0; 16]);
    assert_eq!(
        host.execute().unwrap_err().to_string(),
        "BAD_PARAMETER: in-port `in`: the sample is a IDL:RTC/TimedDouble:1.0 in encoding 1, expected \
         IDL:RTC/TimedLong:1.0 in encoding 1"
    );
    host.send_raw("in", TimedLong::TYPE_ID, &[0; 11]);
    assert_eq!(
        host.execute().unwrap_err().to_string(),
        "BAD_PARAMETER: in-port `in`: the sample is no IDL:RTC/TimedLong:1.0: the bytes cannot be decoded: unexpected \
         end of input"
    );
}

#[test]
fn a_host_of_another_version_is_refused_before_it_is_used() {
    #[repr(align(8))]
    struct Head(#[allow(dead_code)] [u32; 2]); // The module reads it.
    let prefix = Head([abi::ABI_VERSION + 1, size_of::<Host>() as u32]);
    let short = Head([abi::ABI_VERSION, Host::V1_SIZE as u32 - 8]);
    let mut instance = ptr::null_mut();
    for host in [&prefix, &short] {
        // SAFETY: of an unknown version only the first two fields are read.
        let code = unsafe { (module().create)(ptr::from_ref(host).cast(), &raw mut instance) };
        assert_eq!(code, abi::return_code::UNSUPPORTED);
        assert!(instance.is_null());
    }
    // SAFETY: null pointers are refused.
    unsafe {
        assert_eq!(
            (module().create)(ptr::null(), &raw mut instance),
            abi::return_code::BAD_PARAMETER
        );
        assert_eq!(
            (module().callback)(ptr::null_mut(), 0),
            abi::return_code::BAD_PARAMETER
        );
        (module().destroy)(ptr::null_mut());
    }
}

struct Broken<const HOW: u8>;

impl<const HOW: u8> Component for Broken<HOW> {
    const TYPE: TypeInfo = TypeInfo {
        name: "Broken",
        ..Echo::TYPE
    };

    fn declare(d: &mut Declaration) -> Self {
        let _: InPort<TimedLong> = d.in_port("a");
        match HOW {
            0 => drop(d.out_port::<TimedLong>("a")),
            _ => panic!("no declaration"),
        }
        Self
    }
}

#[test]
fn a_wrong_declaration_fails_at_create_with_the_reason() {
    let twice = TestHost::of::<Broken<0>>().unwrap_err();
    assert_eq!(
        twice.reason,
        "the type Broken is declared wrongly: the port `a` is declared twice"
    );
    let panic = TestHost::of::<Broken<1>>().unwrap_err();
    assert!(panic.reason.ends_with(": no declaration"), "{panic}");
}

/// Wakes itself by a thread that its drop ends, and lends its waker to whoever wants it.
struct Threaded {
    thread: Option<JoinHandle<RtcResult>>,
}

static LENT: Mutex<Option<Waker>> = Mutex::new(None);
static AT_DROP: Mutex<Option<RtcResult>> = Mutex::new(None);

impl Component for Threaded {
    const TYPE: TypeInfo = TypeInfo {
        name: "Threaded",
        ..Echo::TYPE
    };
    const EXECUTION: ExecutionKind = ExecutionKind::EventDriven;

    fn declare(_: &mut Declaration) -> Self {
        Self { thread: None }
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let waker = ctx.waker();
        *LENT.lock().expect("nobody panics") = Some(waker.clone());
        self.thread = Some(thread::spawn(move || (0..3).try_for_each(|_| waker.wake())));
        Ok(())
    }
}

impl Drop for Threaded {
    fn drop(&mut self) {
        let ended = self
            .thread
            .take()
            .map(|thread| thread.join().expect("nobody panics"));
        let waker = LENT.lock().expect("nobody panics").clone();
        *AT_DROP.lock().expect("nobody panics") =
            ended.and_then(|ended| Some(ended.and(waker?.wake())));
    }
}

#[test]
fn any_thread_wakes_a_component_until_it_has_ended() {
    let mut host = TestHost::of::<Threaded>().unwrap();
    host.activate().unwrap();
    let lent = LENT.lock().unwrap().clone().unwrap();
    lent.wake().unwrap();
    let woken = loop {
        match host.take_woken() {
            0 => thread::yield_now(),
            some => break some,
        }
    };
    assert!((1..=4).contains(&woken), "{woken}");
    drop(host);
    let at_drop = AT_DROP.lock().unwrap().take().unwrap();
    assert!(
        at_drop.is_ok(),
        "it still is when it is dropped: {at_drop:?}"
    );
    let late = lent.wake().unwrap_err();
    assert_eq!(late.code(), ReturnCode::PreconditionNotMet);
    assert_eq!(late.reason(), "the component cannot be woken: it has ended");
}
