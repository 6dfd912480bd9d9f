//! The ledger and its fence.

use super::fence::Verdict;
use super::file::FILES;
use super::*;
use crate::fixtures::SlowDisk;
use rts_agent_api::messages::LedgerFence;
use rts_host::disk::FileDisk;
use rts_plan::desired::{NodeSpec, NodeSystem, SystemRef};
use rts_plan::place::digest;
use std::sync::Arc;

fn envelope(cluster: &str, epoch: u64, generation: u64, systems: &[&str]) -> NodeSpecEnvelope {
    let spec = NodeSpec {
        node: "local".to_owned(),
        systems: systems
            .iter()
            .map(|name| NodeSystem {
                system: SystemRef {
                    name: (*name).to_owned(),
                    uid: format!("uid-{name}"),
                },
                components: Vec::new(),
                connectors: Vec::new(),
                orders: Default::default(),
                elsewhere: Default::default(),
                generation: 0,
            })
            .collect(),
    };
    NodeSpecEnvelope {
        cluster_uid: cluster.to_owned(),
        epoch,
        generation,
        digest: digest(&spec),
        take_over: None,
        spec,
    }
}

fn judge(
    node: &str,
    held: Option<&NodeSpecEnvelope>,
    offered: &NodeSpecEnvelope,
) -> Result<Verdict, Problem> {
    fence::judge(node, held, &offered.clone().into())
}

fn code(held: &NodeSpecEnvelope, offered: &NodeSpecEnvelope) -> (u16, String) {
    let problem = judge("local", Some(held), offered).unwrap_err();
    (problem.status, problem.code)
}

#[test]
fn the_past_and_strangers_are_refused_each_with_its_own_code() {
    let held = envelope("a", 2, 7, &["hello"]);
    let refused = |offered: NodeSpecEnvelope| code(&held, &offered);
    assert_eq!(
        refused(envelope("a", 1, 9, &[])),
        (409, "stale-epoch".into())
    );
    assert_eq!(
        refused(envelope("a", 2, 6, &[])),
        (409, "stale-generation".into())
    );
    assert_eq!(
        refused(envelope("a", 2, 7, &[])),
        (409, "digest-mismatch".into())
    );
    assert_eq!(
        refused(envelope("b", 9, 9, &["hello"])),
        (409, "foreign-cluster".into())
    );
    assert_eq!(
        refused(envelope("b", 9, 9, &[])),
        (409, "foreign-cluster".into())
    );
}

#[test]
fn another_store_takes_over_only_the_very_ledger_that_it_names() {
    let held = envelope("a", 2, 7, &["hello"]);
    let judged = |change: fn(&mut LedgerFence), systems: &[&str]| {
        let mut meant = ledger_fence(&held);
        change(&mut meant);
        let mut offered = envelope("b", 1, 1, systems);
        offered.take_over = Some(meant);
        judge("local", Some(&held), &offered).map_err(|problem| (problem.status, problem.code))
    };
    let foreign = Err((409, "foreign-cluster".to_owned()));
    for systems in [&["hello"][..], &[]] {
        assert_eq!(judged(|_| {}, systems), Ok(Verdict::Newer));
        for change in [
            (|f: &mut LedgerFence| f.cluster_uid = "b".to_owned()) as fn(&mut LedgerFence),
            |f| f.epoch = 3,
            |f| f.generation = 6,
            |f| f.digest.replace_range(..1, "x"),
        ] {
            assert_eq!(judged(change, systems), foreign);
        }
    }
    // Who is of the same store has no ledger to take over: the past stays the past.
    let mut past = envelope("a", 2, 6, &["hello"]);
    past.take_over = Some(ledger_fence(&held));
    assert_eq!(code(&held, &past), (409, "stale-generation".into()));
    // One that is empty by now is not the one that was meant.
    let empty = envelope("a", 2, 8, &[]);
    let mut late = envelope("b", 1, 1, &["hello"]);
    late.take_over = Some(ledger_fence(&held));
    assert_eq!(code(&empty, &late), (409, "foreign-cluster".into()));
    let mut wrong = envelope("b", 1, 1, &["hello"]);
    wrong.take_over = Some(ledger_fence(&held));
    wrong.digest.replace_range(..1, "x");
    assert_eq!(code(&held, &wrong), (422, "digest-mismatch".into()));
}

#[test]
fn a_refusal_says_how_to_take_over() {
    let held = envelope("a", 2, 7, &["hello", "arm"]);
    let text = |take_over| {
        let mut offered = envelope("b", 1, 1, &["hello"]);
        offered.take_over = take_over;
        judge("local", Some(&held), &offered).unwrap_err().detail
    };
    insta::assert_snapshot!(text(None), @"node local belongs to cluster a, which runs hello, arm there; cluster b may not change it: `rtsctl controller adopt local` takes the node over and keeps everything running, `rtsctl controller take-over local` replaces what runs there");
    let stale = ledger_fence(&envelope("a", 2, 6, &["hello"]));
    insta::assert_snapshot!(text(Some(stale)), @"node local belongs to cluster a, which runs hello, arm there; cluster b may not change it: its ledger is another than the one to be taken over: look again; `rtsctl controller adopt local` takes the node over and keeps everything running, `rtsctl controller take-over local` replaces what runs there");
}

#[test]
fn what_is_newer_or_the_same_is_accepted() {
    let held = envelope("a", 2, 7, &["hello"]);
    let judged = |offered| judge("local", Some(&held), &offered).unwrap();
    assert_eq!(judged(envelope("a", 2, 7, &["hello"])), Verdict::Same);
    assert_eq!(judged(envelope("a", 2, 8, &["hello"])), Verdict::Newer);
    assert_eq!(judged(envelope("a", 3, 1, &[])), Verdict::Newer);
    let empty = envelope("a", 2, 7, &[]);
    let stranger = envelope("b", 1, 1, &["x"]);
    assert_eq!(
        judge("local", Some(&empty), &stranger).unwrap(),
        Verdict::Newer
    );
    assert_eq!(judge("local", None, &stranger).unwrap(), Verdict::Newer);
}

#[test]
fn a_wrong_digest_or_node_is_invalid() {
    let mut offered = envelope("a", 1, 1, &["hello"]);
    assert_eq!(
        judge("other", None, &offered).unwrap_err().code,
        "wrong-node"
    );
    offered.digest.replace_range(..1, "x");
    let problem = judge("local", None, &offered).unwrap_err();
    assert_eq!(
        (problem.status, problem.code.as_str()),
        (422, "digest-mismatch")
    );
}

/// Accepts a spec, and makes it durable.
async fn put(ledger: &mut Ledger, offered: Sealed) -> Result<NodeSpecReceipt, Problem> {
    let receipt = ledger.accept(offered).await?;
    ledger.saver().save().await?;
    Ok(receipt)
}

#[tokio::test]
async fn what_was_accepted_survives_a_restart_and_damage_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let load = || Ledger::load("local", folder.path(), Arc::new(FileDisk));
    let mut ledger = load().await.unwrap();
    assert!(ledger.held().is_none());
    let first = envelope("a", 1, 1, &["hello"]);
    assert!(
        put(&mut ledger, first.clone().into())
            .await
            .unwrap()
            .changed
    );
    assert!(
        !put(&mut ledger, first.clone().into())
            .await
            .unwrap()
            .changed
    );
    assert!(
        put(&mut ledger, envelope("a", 1, 0, &[]).into())
            .await
            .is_err()
    );

    let again = load().await.unwrap();
    assert_eq!(again.held(), Some(&first));

    let mut taken = envelope("b", 4, 2, &["hello"]);
    taken.take_over = Some(ledger_fence(&first));
    let mut ledger = again;
    assert!(
        put(&mut ledger, taken.clone().into())
            .await
            .unwrap()
            .changed
    );
    // Told again, since the answer was lost: it is so already.
    assert!(
        !put(&mut ledger, taken.clone().into())
            .await
            .unwrap()
            .changed
    );
    let again = load().await.unwrap();
    let kept = again.held().unwrap();
    assert_eq!(ledger_fence(kept), ledger_fence(&taken));
    assert_eq!(kept.take_over, None);
    assert!(
        put(&mut ledger, envelope("a", 9, 9, &[]).into())
            .await
            .is_err()
    );

    // The second was the newer one: without it, the first counts.
    let [path, newer] = FILES.map(|name| folder.path().join(name));
    std::fs::write(&newer, "{").unwrap();
    let again = load().await.unwrap();
    assert_eq!(again.held(), Some(&first));
    let text = std::fs::read_to_string(&path).unwrap();
    let damage = async |text: &str| {
        std::fs::write(&path, text).unwrap();
        std::fs::write(&newer, "{").unwrap();
        load().await.err().unwrap().to_string()
    };
    let error = damage(&text.replace("uid-hello", "uid-other")).await;
    assert!(error.contains("digest"), "{error}");
    let error = damage(&text.replace("\"epoch\": 1", "\"epoch\": 7")).await;
    assert!(error.contains("checksum"), "{error}");
    let error = damage(&text[..20]).await;
    assert!(error.contains("is damaged"), "{error}");
}

#[tokio::test]
async fn two_files_take_turns_and_what_is_torn_gives_way_to_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let load = || Ledger::load("local", folder.path(), Arc::new(FileDisk));
    let mut ledger = load().await.unwrap();
    let long: Vec<String> = (0..200).map(|n| format!("system{n}")).collect();
    let long: Vec<&str> = long.iter().map(String::as_str).collect();
    // Grown, then shorter again: nothing is left behind what is written.
    for (generation, systems) in [
        (1, &["a"][..]),
        (2, &long),
        (3, &long),
        (4, &["b"]),
        (5, &[]),
    ] {
        let spec = envelope("a", 1, generation, systems);
        put(&mut ledger, spec.clone().into()).await.unwrap();
        assert_eq!(ledger.saved(), Some(ledger_fence(&spec)));
        ledger = load().await.unwrap();
        assert_eq!(ledger.held(), Some(&spec));
    }
    let mut texts = FILES.map(|name| std::fs::read(folder.path().join(name)).unwrap());
    let generation = |text: &[u8]| file::parse(text).unwrap().1.envelope().generation;
    texts.sort_by_key(|text| generation(text));
    assert_eq!(texts.each_ref().map(|t| generation(t)), [4, 5]);
    let [old, new] = &texts;
    // Whatever part of the newer one did not come to the disk, what is read is one of the two, whole.
    for cut in (0..new.len()).step_by(997) {
        let torn = [&new[..cut], &old[cut..]].concat();
        let found = newest(&[&torn, old]).map(generation);
        assert!(matches!(found, Some(4 | 5)), "{cut}: {found:?}");
    }
    assert_eq!(newest(&[&new[..9], b""]), None);
}

#[tokio::test]
async fn what_takes_a_system_down_is_written_where_there_is_room_already() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = Ledger::load("local", folder.path(), Arc::new(FileDisk))
        .await
        .unwrap();
    let lengths = || {
        FILES.map(|name| std::fs::metadata(folder.path().join(name)).map_or(0, |file| file.len()))
    };
    let many: Vec<String> = (0..200).map(|n| format!("system{n}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let less = &many[1..];
    for (generation, systems) in [(1, &many[..1]), (2, &many[..]), (3, less), (4, &[])] {
        put(&mut ledger, envelope("a", 1, generation, systems).into())
            .await
            .unwrap();
        let now = lengths();
        assert_eq!(now[0], now[1], "{generation}");
        assert!(now[0] > 0 && (generation < 2 || now[0] > 16 * 1024));
    }
    // An agent of before knew one file only, or left the other one shorter.
    let (before, held) = (lengths(), ledger.held().cloned());
    for shorter in [None, Some(16 * 1024)] {
        let paths = FILES.map(|name| folder.path().join(name));
        let texts = paths.each_ref().map(|path| std::fs::read(path).unwrap());
        let older = usize::from(newest(&[&texts[0], &texts[1]]) == Some(&texts[0][..]));
        match shorter {
            None => std::fs::remove_file(&paths[older]).unwrap(),
            Some(length) => {
                let file = std::fs::File::options().write(true).open(&paths[older]);
                file.unwrap().set_len(length).unwrap();
            }
        }
        let again = Ledger::load("local", folder.path(), Arc::new(FileDisk)).await;
        assert_eq!(lengths(), before);
        assert_eq!(again.unwrap().held().cloned(), held);
    }
}

#[tokio::test]
async fn a_spec_counts_before_it_is_durable_unless_it_says_whom_the_node_obeys() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let (disk, mut begins, go) = SlowDisk::new(".json");
    let agent = crate::fixtures::agent_with(home.path(), disk.clone()).await;
    let offer = |epoch, generation| {
        let (agent, spec) = (agent.clone(), envelope("a", epoch, generation, &[]));
        tokio::spawn(async move { agent.offer_node_spec(spec.into()).await })
    };
    let held = async || {
        agent
            .ledger
            .lock()
            .await
            .fence()
            .map(|f| (f.epoch, f.generation))
    };
    let saved = async || {
        agent
            .ledger
            .lock()
            .await
            .saved()
            .map(|f| (f.epoch, f.generation))
    };
    // The first of all: nobody is told of it before it is durable.
    let first = offer(1, 1);
    assert_eq!(begins.recv().await, Some(()));
    assert!(!first.is_finished());
    go.send(()).unwrap();
    // The other file is made as long.
    assert_eq!(begins.recv().await, Some(()));
    go.send(()).unwrap();
    let first = first.await.unwrap().unwrap();
    assert!(first.await.unwrap().changed);
    // The next counts at once.
    let saving = offer(1, 2).await.unwrap().unwrap();
    assert_eq!(begins.recv().await, Some(()));
    assert_eq!((held().await, saved().await), (Some((1, 2)), Some((1, 1))));
    // Told again meanwhile, it is the same, and just as little durable.
    let again = offer(1, 2).await.unwrap().unwrap();
    let mut again = tokio::spawn(again);
    assert!(futures_util::FutureExt::now_or_never(&mut again).is_none());
    go.send(()).unwrap();
    assert!(saving.await.unwrap().changed);
    assert!(!again.await.unwrap().unwrap().changed);
    assert_eq!(saved().await, Some((1, 2)));
    // A raised epoch is durable first.
    let raised = offer(2, 1);
    assert_eq!(begins.recv().await, Some(()));
    assert!(!raised.is_finished());
    go.send(()).unwrap();
    assert!(raised.await.unwrap().unwrap().await.unwrap().changed);
    assert_eq!(held().await, Some((2, 1)));
}

#[tokio::test]
async fn a_write_goes_on_when_its_request_is_dropped_and_the_next_waits_for_it() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let (disk, mut begins, go) = SlowDisk::new(".json");
    let agent = crate::fixtures::agent_with(home.path(), disk.clone()).await;
    let first = agent.clone();
    let first =
        tokio::spawn(async move { first.put_node_spec(envelope("a", 1, 1, &[]).into()).await });
    assert_eq!(begins.recv().await, Some(()));
    first.abort();
    assert!(first.await.unwrap_err().is_cancelled());
    let second = agent.clone();
    let second =
        tokio::spawn(async move { second.put_node_spec(envelope("a", 1, 2, &[]).into()).await });
    for _ in 0..20 {
        tokio::task::yield_now().await;
    }
    assert!(begins.try_recv().is_err(), "the second waits");
    // The first spec in both files, and then the second.
    for _ in 0..2 {
        go.send(()).unwrap();
        assert_eq!(begins.recv().await, Some(()));
    }
    go.send(()).unwrap();
    assert!(second.await.unwrap().unwrap().changed);
    assert_eq!(agent.ledger.lock().await.fence().unwrap().generation, 2);
    let written = disk.written.lock().unwrap();
    let read = |text: &Vec<u8>| serde_json::from_slice::<Sealed>(text).unwrap();
    let generations: Vec<_> = written
        .iter()
        .map(|t| read(t).envelope().generation)
        .collect();
    assert_eq!(generations, [1, 1, 2]);
}

/// A spec as the version before wrote it: its policies have no `onHang`, and the empty orders of its system are missing.
const OLD: &str = r#"{"node":"local","systems":[{"system":{"name":"hello","uid":"1"},"components":[{"spec":{"instance":"A","type":"T","fullId":"","required":true,"ports":[],"configuration":{"active":null,"sets":{"default":{"text":"a  b \" c"}}},"executionContext":{"kind":"periodic","rate":1.0},"placement":{},"policy":{"onDisconnect":"keep","resetOnError":false,"restart":"never"}},"manager":"main","recreateHash":"h"}]}]}"#;

/// An envelope as the version before wrote it to its ledger.
fn old_envelope(spec: &str) -> String {
    use sha2::{Digest, Sha256};
    let digest = format!("{:x}", Sha256::digest(spec));
    format!(r#"{{"clusterUid":"a","epoch":1,"generation":3,"digest":"{digest}","spec":{spec}}}"#)
}

#[tokio::test]
async fn a_ledger_of_the_version_before_is_read_kept_as_it_was_and_names_the_same_parts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILES[0]);
    let load = || Ledger::load("local", folder.path(), Arc::new(FileDisk));
    let text = old_envelope(OLD);
    // A field that is new since then is written by nobody who reads it.
    let typed: NodeSpecEnvelope = serde_json::from_str(&text).unwrap();
    assert_ne!(digest(&typed.spec), typed.digest);
    std::fs::write(&path, &text).unwrap();
    let ledger = load().await.unwrap();
    let sealed = ledger.sealed().unwrap().clone();
    assert_eq!(sealed.envelope(), &typed);
    let parts = sealed.parts();
    assert_eq!(parts.len(), 1);

    // Offered by the controller of that version, it is the same; saved and read again, it is whole.
    let offered: Sealed = serde_json::from_str(&text).unwrap();
    let mut ledger = ledger;
    assert!(!put(&mut ledger, offered.clone()).await.unwrap().changed);
    let (number, sealed) = file::parse(text.as_bytes()).unwrap();
    ledger.files.save(number + 1, &sealed).await.unwrap();
    std::fs::remove_file(&path).unwrap();
    let again = load().await.unwrap();
    assert_eq!(again.sealed().unwrap().parts(), parts);

    // Written for people, as it was then.
    let pretty = |text: &str, indent: &str| text.replace("\":", &format!("\":\n{indent}"));
    std::fs::write(&path, pretty(&text, "  ")).unwrap();
    let again = load().await.unwrap();
    assert_eq!(again.sealed().unwrap().parts(), parts);
}

#[test]
fn a_field_that_this_version_does_not_know_is_refused_wherever_it_is() {
    for at in [
        r#"{"node""#,
        r#"{"system""#,
        r#"{"name""#,
        r#"{"spec":{"instance""#,
        r#"{"instance""#,
        r#"{"active""#,
        r#"{"kind""#,
        r#"{"onDisconnect""#,
    ] {
        assert!(OLD.contains(at), "{at}");
        let spec = OLD.replacen(at, &at.replacen('{', r#"{"new":1,"#, 1), 1);
        let error = serde_json::from_str::<Sealed>(&old_envelope(&spec)).unwrap_err();
        assert!(
            error.to_string().contains("unknown field `new`"),
            "{at}: {error}"
        );
    }
}
