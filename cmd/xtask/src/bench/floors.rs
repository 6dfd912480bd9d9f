//! What no launcher can beat: opening the module and making the component; spawning the manager until it answers.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use rts_manager_api::client::Client;
use rts_manager_api::control::RequestBody;
use rts_runtime::abi;
use rts_runtime::abi::port_status::{
    PORT_BUFFER_EMPTY, PORT_BUFFER_FULL, PORT_INVALID_ARGS, PORT_OK,
};

/// A manager that takes longer than this is broken.
const PATIENCE: Duration = Duration::from_secs(10);

/// Opens `count` copies of a module and makes one component of each, in this process.
///
/// Copies, because the loader opens a file that it has open already in no time.
pub fn dlopen_and_create(module: &Path, folder: &Path, count: u32) -> Result<Duration> {
    let copies = (0..count)
        .map(|i| {
            let copy = folder.join(format!("floor{i}.so"));
            // A new inode each time: the loader compares device and inode.
            let _ = std::fs::remove_file(&copy);
            std::fs::copy(module, &copy)
                .with_context(|| format!("cannot copy {}", module.display()))?;
            Ok(copy)
        })
        .collect::<Result<Vec<_>>>()?;
    let host = abi::Host {
        abi_version: abi::ABI_VERSION,
        size: size_of::<abi::Host>() as u32,
        context: std::ptr::null_mut(),
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
    };
    let start = Instant::now();
    let made = copies
        .iter()
        .map(|copy| open_and_create(copy, &host))
        .collect::<Result<Vec<_>>>()?;
    let took = start.elapsed();
    for (library, module, instance) in made {
        // SAFETY: the instance was made by this module's `create` and is used nowhere else.
        unsafe { ((*module).destroy)(instance) };
        drop(library);
    }
    Ok(took)
}

type Made = (libloading::Library, *const abi::Module, *mut c_void);

fn open_and_create(file: &Path, host: &abi::Host) -> Result<Made> {
    // SAFETY: the module is built from this workspace; its initialisers do nothing.
    let library = unsafe { libloading::Library::new(file) }?;
    // SAFETY: `ENTRY` has the type `Entry` by the ABI's definition.
    let entry = unsafe { library.get::<abi::Entry>(abi::ENTRY.as_bytes()) }?;
    // SAFETY: the entry takes nothing and returns a descriptor that lives as long as the library.
    let module = unsafe { entry() };
    ensure!(!module.is_null(), "{} has no descriptor", file.display());
    let mut instance = std::ptr::null_mut();
    // SAFETY: `module` is valid, `host` outlives the instance, and `instance` is written on OK only.
    let code = unsafe { ((*module).create)(host, &mut instance) };
    ensure!(code == abi::return_code::OK, "create returned {code}");
    Ok((library, module, instance))
}

unsafe extern "C" fn log(_: *mut c_void, _: u32, _: abi::Text) {}
unsafe extern "C" fn fail(_: *mut c_void, _: abi::Text) {}
unsafe extern "C" fn now(_: *mut c_void, _: u32) -> i64 {
    0
}
unsafe extern "C" fn rate(_: *mut c_void) -> f64 {
    1.0
}
unsafe extern "C" fn wake(_: *mut c_void) -> i32 {
    abi::return_code::OK
}
unsafe extern "C" fn write(_: *mut c_void, _: u32, _: *const abi::Buffer) -> i32 {
    PORT_OK
}
unsafe extern "C" fn read(_: *mut c_void, _: u32, _: *mut abi::Buffer) -> i32 {
    PORT_BUFFER_EMPTY
}
unsafe extern "C" fn is_new(_: *mut c_void, _: u32) -> i32 {
    0
}
unsafe extern "C" fn loan(_: *mut c_void, _: u32, _: usize, _: *mut abi::Loan) -> i32 {
    PORT_BUFFER_FULL
}
unsafe extern "C" fn publish(_: *mut c_void, _: u64, _: usize) -> i32 {
    PORT_INVALID_ARGS
}
unsafe extern "C" fn discard(_: *mut c_void, _: u64) {}

/// Spawns `count` managers one after the other, each until its greeting is there, then stops them.
pub fn spawn_until_answer(manager: &Path, folder: &Path, count: u32) -> Result<Duration> {
    let folders = (0..count)
        .map(|i| {
            let run = folder.join(format!("floor{i}"));
            std::fs::create_dir_all(&run)?;
            Ok(run)
        })
        .collect::<Result<Vec<_>>>()?;
    let start = Instant::now();
    let spawned = folders
        .iter()
        .map(|run| spawn(manager, run))
        .collect::<Result<Vec<_>>>()?;
    let took = start.elapsed();
    for (mut child, mut client) in spawned {
        client.call(RequestBody::Shutdown, PATIENCE)?;
        child.wait()?;
    }
    Ok(took)
}

fn spawn(manager: &Path, run: &Path) -> Result<(std::process::Child, Client)> {
    let (ours, theirs) = UnixStream::pair()?;
    let child = Command::new(manager)
        .arg("--dir")
        .arg(run)
        .args(["--name", "floor", "--incarnation", "floor"])
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .with_context(|| format!("cannot start {}", manager.display()))?;
    Ok((child, Client::greet(ours, PATIENCE)?))
}
