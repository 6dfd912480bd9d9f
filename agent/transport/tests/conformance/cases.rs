//! Both ends in one process.

use std::thread;
use std::time::{Duration, Instant};

use rts_transport::{Ended, Kind, MAX_SAMPLE, Parting, Payload, Question, Refused, Sample};

use crate::ends::{PATIENCE, assert_is, end, end_of_sender, fill, next, pair, sample};

const SIZES: [usize; 16] = [
    0,
    1,
    8,
    23,
    24,
    25,
    1000,
    16_384,
    16_385,
    65_511,
    65_512,
    65_536,
    1 << 20,
    (1 << 20) + 1,
    4 << 20,
    3,
];

pub fn samples_of_all_sizes_arrive_whole_and_in_order(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    let sending = thread::spawn(move || {
        for round in 0..3 {
            for (at, size) in (1..).zip(SIZES) {
                sender
                    .push_within(sample(round * 100 + at, size), PATIENCE)
                    .unwrap();
            }
        }
        sender.close(Parting::GoodBye);
    });
    for round in 0..3 {
        for (at, size) in (1..).zip(SIZES) {
            assert_is(&next(&mut *receiver), round * 100 + at, size);
        }
    }
    assert_eq!(end(&mut *receiver), (0, Ended::GoodBye));
    sending.join().unwrap();
}

pub fn a_full_connection_says_so_and_goes_on_when_there_is_room(kind: Kind) {
    for size in [100, 10_000, 300_000] {
        let (mut sender, mut receiver) = pair(kind);
        let taken = fill(&mut *sender, size);
        assert!(taken > 0);
        for sequence in 1..=taken {
            assert_is(&next(&mut *receiver), sequence, size);
        }
        assert_eq!(receiver.try_take(), Ok(None));
        sender.push(sample(taken + 1, size)).unwrap();
        assert_is(&next(&mut *receiver), taken + 1, size);
    }
}

/// Not less, and on the slowest machine not so much more that it could be another time.
#[track_caller]
fn as_long_as(asked: Duration, begin: Instant) {
    let waited = begin.elapsed();
    assert!(waited >= asked, "{waited:?} instead of {asked:?}");
    assert!(waited < asked * 100, "{waited:?} instead of {asked:?}");
}

pub fn who_asks_for_room_waits_for_it_and_not_longer_than_asked(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    let mut taken = fill(&mut *sender, 2000);
    // A kernel may still find some room in its buffers.
    let asked = Duration::from_millis(30);
    let refused = loop {
        let begin = Instant::now();
        match sender.push_within(sample(taken + 1, 2000), asked) {
            Ok(()) => taken += 1,
            Err(refused) => {
                as_long_as(asked, begin);
                break refused;
            }
        }
    };
    assert_eq!(refused, Refused::Full(sample(taken + 1, 2000)));
    let sending = thread::spawn(move || {
        let pushed = sender.push_within(sample(taken + 1, 2000), PATIENCE);
        (pushed, sender)
    });
    thread::sleep(Duration::from_millis(20));
    for sequence in 1..=taken + 1 {
        assert_is(&next(&mut *receiver), sequence, 2000);
    }
    assert_eq!(sending.join().unwrap().0, Ok(()));
}

pub fn a_sample_that_nobody_takes_is_refused_by_its_size(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    let huge = Sample {
        sequence: 1,
        time: 0,
        payload: Payload::from(vec![0; MAX_SAMPLE + 1]),
    };
    assert_eq!(sender.push(huge), Err(Refused::TooLarge(MAX_SAMPLE + 1)));
    sender.push(sample(2, 10)).unwrap();
    assert_is(&next(&mut *receiver), 2, 10);
}

pub fn who_waits_for_a_sample_waits_no_longer_than_asked(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    assert_eq!(receiver.try_take(), Ok(None));
    assert_eq!(receiver.take(Duration::ZERO), Ok(None));
    for asked in [20, 70] {
        let asked = Duration::from_millis(asked);
        let begin = Instant::now();
        assert_eq!(receiver.take(asked), Ok(None));
        as_long_as(asked, begin);
    }
    assert_eq!(sender.ended(), None);
    let taking = thread::spawn(move || receiver.take(Duration::MAX));
    thread::sleep(Duration::from_millis(120));
    sender.push(sample(1, 10)).unwrap();
    // It sleeps as one does who has waited for long, and has to be woken.
    let begin = Instant::now();
    while !taking.is_finished() {
        assert!(begin.elapsed() < PATIENCE / 2, "it was not woken");
        thread::sleep(Duration::from_millis(1));
    }
    let taken = taking.join().unwrap().unwrap();
    assert_is(&taken.unwrap(), 1, 10);
}

pub fn what_was_pushed_before_a_good_bye_arrives(kind: Kind) {
    for size in [10, 3 << 20] {
        let (mut sender, mut receiver) = pair(kind);
        // The rest of a large one, and the good-bye, wait for room when this thread has gone on.
        sender.push(sample(1, size)).unwrap();
        sender.close(Parting::GoodBye);
        let refused = sender.push(sample(2, size));
        assert_eq!(refused, Err(Refused::Ended(Ended::Here)));
        assert_is(&next(&mut *receiver), 1, size);
        assert_eq!(end(&mut *receiver), (0, Ended::GoodBye));
        assert_eq!(end(&mut *receiver), (0, Ended::GoodBye));
        assert_eq!(sender.ended(), Some(Ended::Here));
    }
}

pub fn the_end_of_the_receiver_is_what_the_sender_is_told(kind: Kind) {
    for (parting, lost) in [(Parting::GoodBye, false), (Parting::Loss, true)] {
        let is = |ended: Ended| match lost {
            true => assert!(matches!(ended, Ended::Lost(_)), "{ended:?}"),
            false => assert_eq!(ended, Ended::GoodBye),
        };
        let (mut sender, mut receiver) = pair(kind);
        receiver.close(parting);
        assert_eq!(end(&mut *receiver).1, Ended::Here);
        is(end_of_sender(&mut *sender));
        let Err(Refused::Ended(ended)) = sender.push(sample(1, 10)) else {
            panic!("it has ended");
        };
        is(ended);
        // With samples under way that nobody reads, and a sender that only pushes.
        let (mut sender, mut receiver) = pair(kind);
        let taken = fill(&mut *sender, 100_000);
        receiver.close(parting);
        let ended = match sender.push_within(sample(taken + 1, 100_000), PATIENCE) {
            Err(Refused::Ended(ended)) => ended,
            // The rest of one was waiting, and is what was noticed.
            _ => end_of_sender(&mut *sender),
        };
        is(ended);
    }
}

pub fn an_end_that_is_dropped_is_a_loss(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    sender.push(sample(1, 10)).unwrap();
    drop(sender);
    assert_is(&next(&mut *receiver), 1, 10);
    assert!(matches!(end(&mut *receiver), (0, Ended::Lost(_))));
    let (mut sender, receiver) = pair(kind);
    drop(receiver);
    assert!(matches!(end_of_sender(&mut *sender), Ended::Lost(_)));
}

pub fn one_that_is_closed_here_says_so_whatever_comes_after(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    sender.push(sample(1, 10)).unwrap();
    receiver.close(Parting::GoodBye);
    // The first counts.
    receiver.close(Parting::Loss);
    assert_eq!(receiver.try_take(), Err(Ended::Here));
    assert_eq!(end_of_sender(&mut *sender), Ended::GoodBye);
    sender.close(Parting::Loss);
    assert_eq!(sender.ended(), Some(Ended::GoodBye));
}

pub fn a_close_wakes_a_receiver_that_waits(kind: Kind) {
    for parting in [Parting::GoodBye, Parting::Loss] {
        for pause in [0, 20, 120] {
            let (sender, mut receiver) = pair(kind);
            let handle = receiver.handle();
            let taking = thread::spawn(move || receiver.take(Duration::MAX));
            thread::sleep(Duration::from_millis(pause));
            handle.close(parting);
            assert_eq!(taking.join().unwrap(), Err(Ended::Here));
            drop(sender);
        }
    }
}

pub fn a_close_wakes_a_sender_that_waits(kind: Kind) {
    for parting in [Parting::GoodBye, Parting::Loss] {
        for size in [1000, 1 << 20] {
            let (mut sender, receiver) = pair(kind);
            let handle = sender.handle();
            let sending = thread::spawn(move || {
                for sequence in 1.. {
                    if let Err(refused) = sender.push_within(sample(sequence, size), Duration::MAX)
                    {
                        return refused;
                    }
                }
                unreachable!()
            });
            thread::sleep(Duration::from_millis(60));
            handle.close(parting);
            assert_eq!(sending.join().unwrap(), Refused::Ended(Ended::Here));
            drop(receiver);
        }
    }
}

pub fn many_connectors_work_at_once(kind: Kind) {
    let threads = (0..24_u64).map(|connector| {
        let (mut sender, mut receiver) = pair(kind);
        let size = move |sequence: u64| ((sequence * 37 + connector * 101) % 5000) as usize;
        let sending = thread::spawn(move || {
            for sequence in 1..=200 {
                let sample = sample(sequence, size(sequence));
                sender.push_within(sample, PATIENCE).unwrap();
            }
            sender.close(Parting::GoodBye);
        });
        let taking = thread::spawn(move || {
            for sequence in 1..=200 {
                assert_is(&next(&mut *receiver), sequence, size(sequence));
            }
            assert_eq!(end(&mut *receiver), (0, Ended::GoodBye));
        });
        [sending, taking]
    });
    for thread in threads.collect::<Vec<_>>().into_iter().flatten() {
        thread.join().unwrap();
    }
}

pub fn one_payload_goes_to_several_readers_of_which_none_holds_up_another(kind: Kind) {
    let mut connectors: Vec<_> = (0..3).map(|_| pair(kind)).collect();
    let mut stalled = connectors.pop().unwrap();
    fill(&mut *stalled.0, 10_000);
    for sequence in 1..=40 {
        let sample = sample(sequence, 10_000);
        for (sender, _) in &mut connectors {
            sender.push(sample.clone()).unwrap();
        }
        for (_, receiver) in &mut connectors {
            let got = next(&mut **receiver);
            assert_is(&got, sequence, 10_000);
            let is_shared = got.payload.as_ptr() == sample.payload.as_ptr();
            assert_eq!(is_shared, kind == Kind::InProcess);
        }
    }
    assert_eq!(stalled.0.ended(), None);
}

pub fn samples_are_handed_on_until_the_end(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    let handing = thread::spawn(move || {
        let mut got = Vec::new();
        let ended = receiver.hand_on(&mut |sample| {
            got.push(sample.sequence);
            true
        });
        (got, ended)
    });
    for sequence in 1..=5 {
        sender.push_within(sample(sequence, 10), PATIENCE).unwrap();
    }
    sender.close(Parting::GoodBye);
    assert_eq!(
        handing.join().unwrap(),
        (vec![1, 2, 3, 4, 5], Ended::GoodBye)
    );
    let (mut sender, mut receiver) = pair(kind);
    sender.push(sample(1, 10)).unwrap();
    assert_eq!(receiver.hand_on(&mut |_| false), Ended::Here);
}

pub fn a_sender_hears_what_its_reader_asks_for(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    let handle = receiver.handle();
    assert_eq!(sender.asked(), None);
    for fetch in [Question::First, Question::More] {
        assert!(handle.ask(fetch));
        let begin = Instant::now();
        let asked = loop {
            match sender.asked() {
                Some(asked) => break asked,
                None => assert!(begin.elapsed() < PATIENCE),
            }
        };
        assert_eq!((asked, sender.asked()), (fetch, None));
        sender.push(sample(1, 10)).unwrap();
        assert_is(&next(&mut *receiver), 1, 10);
    }
    assert!(!sender.handle().ask(Question::First), "it is no reader");
    assert!(!handle.has_gone() && !sender.handle().has_gone());
    // However often it asks, and it is told of the end behind that.
    for _ in 0..100 {
        handle.ask(Question::More);
    }
    receiver.close(Parting::GoodBye);
    assert!(!handle.ask(Question::More));
    assert_eq!(end_of_sender(&mut *sender), Ended::GoodBye);
    assert!(sender.handle().has_gone());
}

pub fn who_lingers_waits_for_the_good_bye(kind: Kind) {
    let (mut sender, mut receiver) = pair(kind);
    sender.push(sample(1, 3 << 20)).unwrap();
    let taking = thread::spawn(move || {
        thread::sleep(Duration::from_millis(20));
        let samples = end(&mut *receiver);
        (samples, receiver)
    });
    sender.close(Parting::GoodBye);
    sender.linger();
    // Nobody would send it any more.
    drop(sender);
    assert_eq!(taking.join().unwrap().0, (1, Ended::GoodBye));
    // Who stalls is not waited for.
    let (mut sender, _receiver) = pair(kind);
    sender.push(sample(1, 4 << 20)).unwrap();
    sender.close(Parting::GoodBye);
    sender.linger();
}
