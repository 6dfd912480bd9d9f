//! A copy of this process that is a child of its parent.
//!
//! By `clone3` itself, for the C library's `fork` can neither give the child to the parent (`CLONE_PARENT`) nor put it into a
//! control group from its first instruction (`CLONE_INTO_CGROUP`, which spares the move: that stops every fork and exit of the
//! machine for a moment) nor give a pidfd that is certainly its own. What `fork` does beside the call is to have the
//! kernel write the thread's new number where the C library keeps it, which is done here as well; its other
//! work is about locks of other threads, and there are none.

#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};

use libc::{c_int, c_long, c_ulong, c_ulonglong, pid_t};

/// Gives the address that `CLONE_CHILD_CLEARTID` was told of.
const PR_GET_TID_ADDRESS: c_int = 40;
/// `CLONE_INTO_CGROUP` does not fit into the type that libc gives it.
const CLONE_INTO_CGROUP: u64 = 0x2_0000_0000;
/// The child is the parent's child; its pidfd; its number for the C library, which is cleared when the thread ends.
const FLAGS: c_int =
    libc::CLONE_PARENT | libc::CLONE_PIDFD | libc::CLONE_CHILD_SETTID | libc::CLONE_CHILD_CLEARTID;

/// Arguments of `clone3`, up to the control group.
#[repr(C)]
#[derive(Default)]
struct CloneArgs {
    flags: u64,
    pidfd: u64,
    child_tid: u64,
    parent_tid: u64,
    exit_signal: u64,
    stack: u64,
    stack_size: u64,
    tls: u64,
    set_tid: u64,
    set_tid_size: u64,
    cgroup: u64,
}

/// On which side of the call one is.
pub enum Copy {
    /// In the copy.
    Own,
    /// In the one that was copied.
    Other {
        /// The copy's number.
        pid: u32,
        /// Its handle.
        pidfd: OwnedFd,
        /// It was born in the control group that was asked for.
        in_cgroup: bool,
    },
}

/// Makes copies.
pub struct Copier {
    /// Where the C library keeps this thread's number.
    tid: u64,
}

impl Copier {
    /// Refuses where it is not known how the C library must be told of a copy, and where there are other threads.
    pub fn new() -> io::Result<Self> {
        if std::fs::read_dir("/proc/self/task")?.count() != 1 {
            return Err(io::Error::other("this process has more than one thread"));
        }
        let mut tid: *mut pid_t = std::ptr::null_mut();
        // SAFETY: the kernel writes one pointer to the variable that is given.
        let known = unsafe { libc::prctl(PR_GET_TID_ADDRESS, &raw mut tid) };
        if known != 0 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: what the kernel holds there was given to it by the C library and is valid for the life of this thread, or
        // it is null.
        let here = unsafe { tid.as_ref() }.copied();
        if here != Some(rustix::thread::gettid().as_raw_nonzero().get()) {
            let text = "the C library does not keep its thread number where the kernel clears it";
            return Err(io::Error::new(io::ErrorKind::Unsupported, text));
        }
        Ok(Self {
            tid: tid.addr() as u64,
        })
    }

    /// Makes one, in a control group if one is given and that can be. Both go on from here.
    pub fn copy(&self, cgroup: Option<BorrowedFd<'_>>) -> io::Result<Copy> {
        if let Some(cgroup) = cgroup
            && let Ok(copy) = self.clone3(Some(cgroup))
        {
            return Ok(copy);
        }
        match self.clone3(None) {
            // Where a filter does not know the newer call.
            Err(e) if matches!(e.raw_os_error(), Some(libc::ENOSYS | libc::EPERM)) => self.clone(),
            other => other,
        }
    }

    fn clone3(&self, cgroup: Option<BorrowedFd<'_>>) -> io::Result<Copy> {
        let mut pidfd: RawFd = -1;
        let mut args = CloneArgs {
            flags: FLAGS as u64,
            pidfd: (&raw mut pidfd).addr() as u64,
            child_tid: self.tid,
            ..CloneArgs::default()
        };
        if let Some(cgroup) = cgroup {
            args.flags |= CLONE_INTO_CGROUP;
            args.cgroup = cgroup.as_raw_fd() as u64;
        }
        // SAFETY: without CLONE_VM the child has memory of its own and goes on upon a copy of this stack; there is no other
        // thread whose locks it could miss, as `new` has seen and nothing here starts one. The kernel reads `args` and
        // writes `pidfd` and, in the child, the thread number at `tid`, which is what the C library's fork asks of it.
        let pid = unsafe {
            libc::syscall(
                libc::SYS_clone3,
                &raw mut args,
                size_of::<CloneArgs>() as c_ulong,
            )
        };
        parted(pid, pidfd, cgroup.is_some())
    }

    fn clone(&self) -> io::Result<Copy> {
        // Elsewhere the arguments have another order.
        if !cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) {
            return Err(io::ErrorKind::Unsupported.into());
        }
        let mut pidfd: RawFd = -1;
        let flags = c_ulonglong::from((FLAGS | libc::SIGCHLD) as u32);
        // SAFETY: as for `clone3`. The last two arguments are the child's thread number and its storage, in one order or
        // the other; the storage is not looked at without CLONE_SETTLS.
        let pid = unsafe {
            libc::syscall(
                libc::SYS_clone,
                flags,
                0_u64,
                &raw mut pidfd,
                self.tid,
                self.tid,
            )
        };
        parted(pid, pidfd, false)
    }
}

fn parted(pid: c_long, pidfd: RawFd, in_cgroup: bool) -> io::Result<Copy> {
    match u32::try_from(pid) {
        Ok(0) => Ok(Copy::Own),
        Ok(pid) => Ok(Copy::Other {
            pid,
            // SAFETY: the kernel has just opened it for this process.
            pidfd: unsafe { OwnedFd::from_raw_fd(pidfd) },
            in_cgroup,
        }),
        Err(_) => Err(io::Error::last_os_error()),
    }
}
