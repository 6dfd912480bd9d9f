//! The simulation as a program of its own, as [`ProgramSimulator`](rts_controller::simulator::ProgramSimulator) starts it: the
//! scenario is the first line of the input, the answer is all of the output.

use std::io::{self, BufRead, Read, Write};
use std::thread;

use rts_controller::simulate::{STACK, quietly};
use rts_controller::simulator::{HURRY, MAX_SCENARIO, Scenario, Stop};

use super::UserSimulator;

/// Bytes of a word after the scenario.
const MAX_WORD: u64 = 64;

/// Reads a scenario, plays it through, and writes what came of it. Ends the process when the input ends before: then nobody
/// waits.
///
/// # Errors
/// The scenario cannot be read or understood, or nobody reads the answer.
pub fn answer(mut input: impl BufRead + Send + 'static, mut output: impl Write) -> io::Result<()> {
    let scenario = read(&mut input)?;
    let stop = scenario.stop.clone();
    thread::Builder::new().spawn(move || listen(input, &stop))?;
    let play = move || serde_json::to_vec(&quietly(&UserSimulator, &scenario));
    let played = thread::Builder::new().stack_size(STACK).spawn(play)?;
    let answer = played.join();
    let answer = answer.map_err(|_| io::Error::other("the simulation panicked"))??;
    output.write_all(&answer)?;
    output.flush()
}

fn read(input: &mut impl BufRead) -> io::Result<Scenario> {
    let mut line = Vec::new();
    input.take(MAX_SCENARIO).read_until(b'\n', &mut line)?;
    Ok(serde_json::from_slice(&line)?)
}

/// Hears what is said meanwhile.
fn listen(mut input: impl BufRead, stop: &Stop) {
    let mut word = String::new();
    loop {
        word.clear();
        match input.by_ref().take(MAX_WORD).read_line(&mut word) {
            // Whoever asked has gone: there is nothing to put in order.
            Ok(0) | Err(_) => std::process::exit(0),
            Ok(_) if word.trim_end() == HURRY => stop.hurry(),
            Ok(_) => {}
        }
    }
}
