use std::path::PathBuf;

use rts_host::disk::replace_durably;
use tokio::time::timeout;

use super::*;

const OLD: &[u8] = b"the old contents of the file";
const NEW: &[u8] = b"the new ones, which are longer than those before";
const LONG: Duration = Duration::from_secs(60);

fn path() -> PathBuf {
    PathBuf::from("/state/node1/ledger.json")
}

/// Crashes at this passage, with a loss of power or without; the end of the call, if it came to one, and what is read
/// then.
async fn crash(
    seed: u64,
    calls: u64,
    power: bool,
    replace: impl AsyncFn(&dyn Disk) -> io::Result<()>,
) -> (Option<io::Result<()>>, Option<Vec<u8>>) {
    let disk = SimDisk::new("node1", Seed(seed));
    let first = disk.grip(Life::new("node1", 1));
    replace_durably(&*first, &path(), OLD.to_vec())
        .await
        .unwrap();
    let life = Life::new("node1", 2);
    life.burn(calls);
    let grip = disk.grip(life.clone());
    let ended = timeout(LONG, replace(&*grip)).await.ok();
    assert_eq!(life.is_over(), ended.is_none());
    if power {
        disk.lose_power();
    }
    let third = disk.grip(Life::new("node1", 3));
    let read = third.read(&path(), 1 << 20).await.unwrap();
    assert_eq!(disk.contents(&path()), read);
    (ended, read)
}

/// Passages of one replacement: two of each call, and one in the middle of the write.
const PASSAGES: u64 = 9;

#[tokio::test(start_paused = true)]
async fn a_durable_replacement_survives_a_crash_anywhere() {
    let (mut olds, mut news) = (0, 0);
    for seed in 0..50 {
        for (calls, power) in (1..=PASSAGES + 1).flat_map(|calls| [(calls, false), (calls, true)]) {
            let replace =
                async |disk: &dyn Disk| replace_durably(disk, &path(), NEW.to_vec()).await;
            let (ended, read) = crash(seed, calls, power, replace).await;
            assert_eq!(ended.is_some(), calls > PASSAGES, "at {calls}");
            let read = read.unwrap();
            let text = String::from_utf8_lossy(&read).into_owned();
            assert!(read == OLD || read == NEW, "{seed} {calls} {power}: {text}");
            if matches!(ended, Some(Ok(()))) {
                assert_eq!(read, NEW, "it was acknowledged");
            }
            olds += u32::from(read == OLD);
            news += u32::from(read == NEW);
        }
    }
    assert!(olds > 100 && news > 100, "{olds} {news}");
}

/// Both kinds of harm, over many seeds: (torn, gone although acknowledged).
async fn harm(replace: impl AsyncFn(&dyn Disk) -> io::Result<()>) -> (u32, u32) {
    let (mut torn, mut gone) = (0, 0);
    for seed in 0..100 {
        let (ended, read) = crash(seed, 100, true, &replace).await;
        assert!(matches!(ended, Some(Ok(()))));
        let read = read.unwrap_or_default();
        torn += u32::from(read != OLD && read != NEW);
        gone += u32::from(read == OLD);
    }
    (torn, gone)
}

#[tokio::test(start_paused = true)]
async fn a_sync_that_is_left_out_is_noticed() {
    let new = PathBuf::from("/state/node1/new");
    let folder = PathBuf::from("/state/node1");
    let (torn, gone) = harm(async |disk| {
        disk.write(&new, NEW.to_vec()).await?;
        disk.rename(&new, &path()).await?;
        disk.sync_folder(&folder).await
    })
    .await;
    assert!(torn > 50 && gone == 0, "{torn} {gone}");
    let (torn, gone) = harm(async |disk| {
        disk.write(&new, NEW.to_vec()).await?;
        disk.sync(&new).await?;
        disk.rename(&new, &path()).await
    })
    .await;
    assert!(torn == 0 && gone > 20, "{torn} {gone}");
    let (torn, _) = harm(async |disk| {
        disk.write(&path(), NEW.to_vec()).await?;
        disk.sync_folder(&folder).await
    })
    .await;
    assert!(torn > 20, "{torn}");
}

#[tokio::test(start_paused = true)]
async fn a_program_that_crashes_loses_nothing_that_the_kernel_has() {
    let disk = SimDisk::new("node1", Seed(1));
    let life = Life::new("node1", 1);
    let grip = disk.grip(life.clone());
    grip.write(&path(), NEW.to_vec()).await.unwrap();
    life.end();
    assert_eq!(disk.contents(&path()).as_deref(), Some(NEW));
    assert!(timeout(LONG, grip.read(&path(), 9)).await.is_err());
    // In the middle of a write it leaves a part.
    let life = Life::new("node1", 2);
    life.burn(2);
    let grip = disk.grip(life);
    let long = vec![b'x'; 10_000];
    assert!(timeout(LONG, grip.write(&path(), long)).await.is_err());
    let left = disk.contents(&path()).unwrap();
    assert!(left.len() < 10_000 && left.iter().all(|b| *b == b'x'));
}

#[tokio::test(start_paused = true)]
async fn it_fails_and_is_slow_while_it_shall() {
    let disk = SimDisk::new("node1", Seed(7));
    let grip = disk.grip(Life::new("node1", 1));
    let replace = async || replace_durably(&*grip, &path(), OLD.to_vec()).await;
    replace().await.unwrap();
    disk.fail_writes(true);
    for _ in 0..9 {
        assert!(replace().await.is_err());
        assert!(grip.sync(&path()).await.is_err());
        assert!(grip.sync_folder(Path::new("/state")).await.is_err());
        assert!(grip.rename(&path(), Path::new("/y")).await.is_err());
    }
    assert_eq!(grip.read(&path(), 3).await.unwrap().unwrap(), b"the");
    disk.fail_writes(false);
    let time = async || {
        let begin = tokio::time::Instant::now();
        replace().await.unwrap();
        begin.elapsed()
    };
    assert!(time().await < Duration::from_millis(20));
    disk.slow(Some(Duration::from_secs(5)));
    assert!(time().await > Duration::from_secs(1));
    disk.slow(None);
    assert!(time().await < Duration::from_millis(20));
}
