//! The other process: this program again, with one end of the connection as its standard input.

use std::os::fd::{AsFd, OwnedFd};
use std::process::{Child, Command, Stdio};

use rts_transport::{Kind, Parting};

use crate::ends::{PATIENCE, fill, next, sample};
use crate::leaks;

const ROLE: &str = "RTS_TRANSPORT_ROLE";
const KIND: &str = "RTS_TRANSPORT_KIND";

/// Starts it in a role.
pub fn start(role: &str, kind: Kind, socket: Option<OwnedFd>) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "child::play", "--ignored", "--nocapture"])
        .env(ROLE, role)
        .env(KIND, kind.name())
        .stdin(socket.map_or_else(Stdio::null, Stdio::from))
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
#[ignore = "played in processes that other tests start"]
fn play() {
    // Without a role somebody runs all ignored tests.
    let (Ok(role), Ok(kind)) = (std::env::var(ROLE), std::env::var(KIND)) else {
        return;
    };
    let kind: Kind = kind.parse().unwrap();
    let socket = || std::io::stdin().as_fd().try_clone_to_owned().unwrap();
    match role.as_str() {
        "take all" => take_all(kind, socket()),
        "take one" => {
            let mut receiver = kind.receiver(socket()).unwrap();
            next(&mut *receiver);
            // Until it is killed.
            std::thread::sleep(PATIENCE);
        }
        "send until full" => {
            let mut sender = kind.sender(socket()).unwrap();
            fill(&mut *sender, 1000);
            std::thread::sleep(PATIENCE);
        }
        "send one" => {
            let mut sender = kind.sender(socket()).unwrap();
            sender.push(sample(1, 10)).unwrap();
            std::thread::sleep(PATIENCE);
        }
        "leak" => leaks::measure(kind),
        other => panic!("{other}"),
    }
}

/// Takes all samples, and says good-bye when they are right.
fn take_all(kind: Kind, socket: OwnedFd) {
    let mut receiver = kind.receiver(socket).unwrap();
    for (sequence, size) in crate::processes::samples() {
        crate::ends::assert_is(&next(&mut *receiver), sequence, size);
    }
    receiver.close(Parting::GoodBye);
}
