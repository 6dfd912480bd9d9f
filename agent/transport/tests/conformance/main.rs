//! What every transport must do, required of each.

#![allow(clippy::unwrap_used)]

mod cases;
mod child;
mod ends;
mod hostile;
mod hostile_memory;
mod leaks;
mod plain;
mod processes;

/// Tests of these functions, which get the transport.
macro_rules! tests {
    ($kind:ident: $($module:ident::$case:ident,)*) => {
        $(#[test]
        fn $case() {
            crate::$module::$case(rts_transport::Kind::$kind);
        })*
    };
}

macro_rules! everywhere {
    ($kind:ident) => {
        tests! { $kind:
            cases::samples_of_all_sizes_arrive_whole_and_in_order,
            cases::a_full_connection_says_so_and_goes_on_when_there_is_room,
            cases::who_asks_for_room_waits_for_it_and_not_longer_than_asked,
            cases::a_sample_that_nobody_takes_is_refused_by_its_size,
            cases::who_waits_for_a_sample_waits_no_longer_than_asked,
            cases::what_was_pushed_before_a_good_bye_arrives,
            cases::the_end_of_the_receiver_is_what_the_sender_is_told,
            cases::an_end_that_is_dropped_is_a_loss,
            cases::one_that_is_closed_here_says_so_whatever_comes_after,
            cases::a_close_wakes_a_receiver_that_waits,
            cases::a_close_wakes_a_sender_that_waits,
            cases::many_connectors_work_at_once,
            cases::one_payload_goes_to_several_readers_of_which_none_holds_up_another,
            cases::samples_are_handed_on_until_the_end,
            cases::a_sender_hears_what_its_reader_asks_for,
            cases::who_lingers_waits_for_the_good_bye,
            leaks::no_descriptor_no_mapping_and_no_thread_is_left,
        }
    };
}

macro_rules! between_processes {
    ($kind:ident) => {
        tests! { $kind:
            processes::another_process_gets_what_is_sent_and_answers,
            processes::a_killed_sender_is_a_loss,
            processes::a_killed_receiver_is_a_loss,
            hostile::a_receiver_that_sends_nothing_any_more_is_a_loss,
        }
    };
}

macro_rules! over_sockets {
    ($kind:ident) => {
        tests! { $kind:
            hostile::a_sender_that_sends_nothing_any_more_is_a_loss,
            hostile::what_is_no_frame_is_refused,
            hostile::a_cut_sample_is_a_loss,
            hostile::a_sample_that_trickles_is_waited_for_no_longer_than_asked,
        }
    };
}

mod inproc {
    everywhere!(InProcess);
}

mod shm {
    everywhere!(SharedMemory);
    between_processes!(SharedMemory);
}

mod unix {
    everywhere!(Unix);
    between_processes!(Unix);
    over_sockets!(Unix);
}

mod tcp {
    everywhere!(Tcp);
    between_processes!(Tcp);
    over_sockets!(Tcp);
}
