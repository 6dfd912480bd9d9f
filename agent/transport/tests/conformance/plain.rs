//! The frames of version 1 of the manager protocol: everything but the good-bye, and the time.

use std::os::unix::net::UnixStream;
use std::thread;

use rts_transport::{Ended, Parting, Sender, unix};

use crate::ends::{PATIENCE, end, next, sample};

const SIZES: [usize; 8] = [0, 1, 11, 12, 16_384, 16_385, 1 << 20, 3];

#[test]
fn samples_of_all_sizes_arrive_and_an_order_looks_like_a_loss() {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let mut sender = unix::plain_sender(ours).unwrap();
    let mut receiver = unix::plain_receiver(theirs).unwrap();
    let sending = thread::spawn(move || {
        for (sequence, size) in (1..).zip(SIZES) {
            sender
                .push_within(sample(sequence, size), PATIENCE)
                .unwrap();
        }
        sender.close(Parting::GoodBye);
        sender.linger();
        assert_eq!(sender.ended(), Some(Ended::Here));
    });
    for (sequence, size) in (1..).zip(SIZES) {
        let got = next(&mut receiver);
        let expected = sample(sequence, size).payload;
        assert_eq!((got.sequence, got.time), (sequence, 0));
        assert!(got.payload == expected, "sample {sequence}");
    }
    assert!(matches!(end(&mut receiver), (0, Ended::Lost(_))));
    sending.join().unwrap();
}
