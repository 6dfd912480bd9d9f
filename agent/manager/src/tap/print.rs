//! Looking at an out-port.

use std::io;
use std::sync::Arc;

use rts_manager_api::frame::FrameError;
use rts_manager_api::tap::{END, TapEnd, TapSample};
use rustix::event::PollFlags;
use rustix::io::Errno;
use rustix::net::{SendFlags, send};

use super::{Client, LOOK};
use crate::data::tap::{Tap, Taps};

/// Sends what the port writes until the client goes, or the component.
pub(super) fn print(
    mut client: Client<'_>,
    data_type: String,
    taps: &Arc<Taps>,
) -> Result<(), FrameError> {
    let tap = Arc::new(Tap::new()?);
    let _tapped = taps.add(&tap);
    client.accept(data_type)?;
    let mut taken = 0;
    loop {
        while let Some((seen, missed)) = tap.take() {
            let sample = TapSample {
                length: seen.payload.len(),
                time: seen.time,
                missed,
            };
            if !(write(&client, &sample.head())? && write(&client, &seen.payload)?) {
                return Ok(());
            }
            taken += 1;
        }
        if let failure @ Some(_) = client.gone() {
            if write(&client, &END)? {
                client.end(&TapEnd {
                    taken,
                    failure,
                    ..TapEnd::default()
                })?;
            }
            return Ok(());
        }
        let seen = client.wait(PollFlags::IN, Some(&tap.filled()), LOOK)?;
        tap.awake();
        // It sends nothing: what can be read is its end.
        if !seen.is_empty() {
            return Ok(());
        }
    }
}

/// Sends bytes to a client that may not read for a long time; false when it has gone. The tap misses samples meanwhile.
fn write(client: &Client<'_>, bytes: &[u8]) -> io::Result<bool> {
    let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
    let mut rest = bytes;
    while !rest.is_empty() {
        match send(client.stream, rest, flags) {
            Ok(sent) => rest = &rest[sent..],
            Err(Errno::AGAIN) => {
                let events = client.wait(PollFlags::OUT | PollFlags::IN, None, LOOK)?;
                if events.intersects(PollFlags::IN | PollFlags::HUP | PollFlags::ERR) {
                    return Ok(false);
                }
            }
            Err(Errno::INTR) => {}
            Err(Errno::PIPE | Errno::CONNRESET) => return Ok(false),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(true)
}
