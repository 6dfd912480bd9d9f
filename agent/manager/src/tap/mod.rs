//! Taps: connections that look at a port, or write to one, for as long as they last. Neither is a connector: the inventory
//! has them in a list of their own, which nobody plans.

mod inject;
mod print;

use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, Weak};
use std::time::{Duration, Instant};

use rts_manager_api::control::{Failure, TapInfo};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::net::Timed;
use rts_manager_api::speaks;
use rts_manager_api::tap::{MAX_SAMPLE, TapEnd, TapHello, TapOpened, TapReply, TapWay};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::component::Component;
use crate::failure::{conflict, invalid, not_found};
use crate::manager::Manager;
use crate::sync::lock;

/// Whatever a port carries can be looked at.
const _: () = assert!(MAX_SAMPLE == rts_transport::MAX_SAMPLE);
/// Taps of one manager that may exist at once.
const MOST: usize = 64;
/// Time for an answer to leave.
const SENDING: Duration = Duration::from_secs(2);
/// Between two looks whether the component is still there.
const LOOK: Duration = Duration::from_millis(500);

/// The taps that there are.
#[derive(Debug, Default)]
pub struct List(Mutex<Entries>);

#[derive(Debug, Default)]
struct Entries {
    next: u64,
    taps: Vec<(u64, TapInfo)>,
}

/// A tap in the list, until it is dropped.
#[derive(Debug)]
struct Entry<'a> {
    list: &'a List,
    number: u64,
}

impl Drop for Entry<'_> {
    fn drop(&mut self) {
        let mut entries = lock(&self.list.0);
        entries.taps.retain(|(number, _)| *number != self.number);
    }
}

impl List {
    /// What the inventory shows.
    pub fn infos(&self) -> Vec<TapInfo> {
        let entries = lock(&self.0);
        entries.taps.iter().map(|(_, info)| info.clone()).collect()
    }

    fn enter(&self, info: TapInfo) -> Result<Entry<'_>, Failure> {
        let mut entries = lock(&self.0);
        if entries.taps.len() >= MOST {
            let message = format!(
                "{MOST} ports of this manager are looked at or written to; end one of them"
            );
            return Err(conflict(message));
        }
        let number = entries.next;
        entries.next += 1;
        entries.taps.push((number, info));
        Ok(Entry { list: self, number })
    }
}

/// Serves a tap until it ends.
pub fn serve(stream: &UnixStream, hello: &TapHello, manager: &Manager) -> Result<(), FrameError> {
    let begun = begin(hello, manager);
    let (component, entry) = match begun {
        Ok(begun) => begun,
        Err(failure) => return refuse(stream, failure),
    };
    let client = Client {
        stream,
        stays: Arc::downgrade(&component),
        opened: TapOpened {
            incarnation: component.identity.incarnation.clone(),
            data_type: String::new(),
        },
    };
    let served = match &hello.way {
        TapWay::Print => match component.out_port(&hello.port) {
            Ok(port) => {
                let (taps, data_type) = (Arc::clone(&port.taps), port.data_type.clone());
                // A component that is deleted meanwhile is not held here.
                drop(component);
                print::print(client, data_type, &taps)
            }
            Err(failure) => refuse(stream, failure),
        },
        TapWay::Inject {
            data_type,
            wait_ms,
            linger_ms,
        } => match component.in_port(&hello.port) {
            Ok(port) if port.data_type == *data_type => {
                let port = Arc::clone(port);
                drop(component);
                let wait = Duration::from_millis(*wait_ms);
                let linger = Duration::from_millis(*linger_ms);
                inject::inject(client, &port, wait, linger)
            }
            Ok(port) => {
                let (instance, name) = (&hello.instance, &hello.port);
                let takes = &port.data_type;
                let message = format!("{instance}.{name} takes {takes}, not {data_type}");
                refuse(stream, invalid(message))
            }
            Err(failure) => refuse(stream, failure),
        },
    };
    drop(entry);
    served
}

fn begin<'a>(
    hello: &TapHello,
    manager: &'a Manager,
) -> Result<(Arc<Component>, Entry<'a>), Failure> {
    speaks(hello.version).map_err(|e| invalid(e.to_string()))?;
    let component = manager.component(&hello.instance)?;
    let way = match hello.way {
        TapWay::Print => "print",
        TapWay::Inject { .. } => "inject",
    };
    let entry = manager.taps.enter(TapInfo {
        port: format!("{}.{}", hello.instance, hello.port),
        way: way.to_owned(),
    })?;
    Ok((component, entry))
}

fn refuse(stream: &UnixStream, failure: Failure) -> Result<(), FrameError> {
    let reply = TapReply {
        result: Err(failure),
    };
    frame::write_answer(&mut Timed::new(stream, Instant::now() + SENDING), &reply)
}

/// Who is at the other end of a tap, and the component that it is about.
struct Client<'a> {
    stream: &'a UnixStream,
    stays: Weak<Component>,
    opened: TapOpened,
}

impl Client<'_> {
    /// Tells that the tap is there.
    fn accept(&mut self, data_type: String) -> Result<(), FrameError> {
        self.opened.data_type = data_type;
        let reply = TapReply {
            result: Ok(self.opened.clone()),
        };
        self.send(&reply)
    }

    /// Tells how it ended.
    fn end(&self, end: &TapEnd) -> Result<(), FrameError> {
        self.send(end)
    }

    fn send<T: serde::Serialize>(&self, message: &T) -> Result<(), FrameError> {
        let until = Instant::now() + SENDING;
        frame::write_answer(&mut Timed::new(self.stream, until), message)
    }

    /// Why there is nothing to look at any more, when there is not.
    fn gone(&self) -> Option<Failure> {
        let Some(component) = self.stays.upgrade() else {
            return Some(not_found("the component was deleted"));
        };
        component.check_stays().err()
    }

    /// Waits until something can be read from the client, or `also` is ready; at most so long. What became of both.
    fn wait(
        &self,
        events: PollFlags,
        also: Option<&dyn AsFd>,
        time: Duration,
    ) -> io::Result<PollFlags> {
        let mut fds = vec![PollFd::new(self.stream, events)];
        fds.extend(also.map(|fd| PollFd::from_borrowed_fd(fd.as_fd(), PollFlags::IN)));
        let timeout = Timespec {
            tv_sec: time.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: time.subsec_nanos().into(),
        };
        match poll(&mut fds, Some(&timeout)) {
            Ok(_) => Ok(fds[0].revents()),
            Err(Errno::INTR) => Ok(PollFlags::empty()),
            Err(error) => Err(error.into()),
        }
    }
}
