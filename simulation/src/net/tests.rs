use std::sync::atomic::{AtomicU32, Ordering};

use tokio::time::{Instant, timeout};

use super::ask::Serve;
use super::*;
use crate::life::Life;

const LONG: Duration = Duration::from_secs(30);

fn lives() -> (Life, Life) {
    (Life::new("controller", 1), Life::new("local", 1))
}

fn serve(of: &Life, work: impl Fn() -> u32 + Clone + Send + 'static) -> Serve<u32> {
    let of = of.clone();
    Box::new(move || {
        let work = work.clone();
        (!of.is_over()).then(|| (of.clone(), Box::pin(async move { work() }) as _))
    })
}

#[tokio::test(start_paused = true)]
async fn a_request_is_answered_within_moments() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    let begin = Instant::now();
    let answer = net.ask(&controller, "local", serve(&agent, || 7)).await;
    assert_eq!(answer, Ok(7));
    let took = begin.elapsed();
    assert!(
        took >= Duration::from_millis(1) && took <= Duration::from_millis(8),
        "{took:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_dead_program_resets_and_a_dark_host_is_silent() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    agent.end();
    let answer = net.ask(&controller, "local", serve(&agent, || 7)).await;
    assert_eq!(answer, Err(Reset));
    net.dark("local", true);
    let answer = net.ask(&controller, "local", serve(&agent, || 7));
    assert!(timeout(LONG, answer).await.is_err());
}

#[tokio::test(start_paused = true)]
async fn a_cut_is_of_one_direction_and_ends() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    let done = Arc::new(AtomicU32::new(0));
    let ask = || {
        let done = Arc::clone(&done);
        let work = serve(&agent, move || done.fetch_add(1, Ordering::SeqCst));
        timeout(LONG, net.ask(&controller, "local", work))
    };
    net.cut("local", "controller");
    assert!(ask().await.is_err());
    assert_eq!(done.load(Ordering::SeqCst), 1);
    net.cut("controller", "local");
    assert!(ask().await.is_err());
    assert_eq!(done.load(Ordering::SeqCst), 1);
    net.mend("controller", "local");
    net.mend("local", "controller");
    assert_eq!(ask().await.unwrap(), Ok(1));
}

#[tokio::test(start_paused = true)]
async fn weather_loses_and_doubles() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    net.weather(Weather {
        lost: 0,
        doubled: 1000,
        delay: Duration::ZERO,
    });
    let done = Arc::new(AtomicU32::new(0));
    let count = Arc::clone(&done);
    let work = serve(&agent, move || count.fetch_add(1, Ordering::SeqCst));
    assert!(net.ask(&controller, "local", work).await.is_ok());
    sleep(LONG).await;
    assert_eq!(done.load(Ordering::SeqCst), 2);
    net.weather(Weather {
        lost: 1000,
        ..Weather::default()
    });
    let answer = net.ask(&controller, "local", serve(&agent, || 7));
    assert!(timeout(LONG, answer).await.is_err());
}

#[tokio::test(start_paused = true)]
async fn a_line_keeps_its_order_and_tells_a_crash() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    net.weather(Weather {
        lost: 300,
        doubled: 0,
        delay: Duration::from_millis(50),
    });
    let (mut teller, mut line) = line(&net, &agent, &controller);
    for n in 0..20 {
        assert!(teller.say(n));
    }
    for n in 0..20 {
        assert_eq!(line.next().await, Some(Ok(n)));
    }
    agent.end();
    assert_eq!(line.next().await, Some(Err(Reset)));
}

#[tokio::test(start_paused = true)]
async fn nothing_comes_over_a_line_that_is_cut() {
    let (net, (controller, agent)) = (Net::new(Seed(1)), lives());
    let (mut teller, mut line) = line(&net, &agent, &controller);
    net.cut("local", "controller");
    assert!(teller.say(1));
    assert!(timeout(LONG, line.next()).await.is_err());
    net.mend("local", "controller");
    // What was cut off stays so, or comes late.
    let late = timeout(LONG, line.next()).await;
    assert!(late.is_err() || line.resumes);
}
