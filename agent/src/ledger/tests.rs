//! The ledger and its fence.

use super::fence::{Verdict, judge};
use super::*;
use rts_agent_api::messages::LedgerFence;
use rts_plan::desired::{NodeSpec, NodeSystem, SystemRef};
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

#[tokio::test]
async fn what_was_accepted_survives_a_restart_and_damage_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let store = Arc::new(FileStore::new(folder.path()));
    let mut ledger = Ledger::load("local", store.clone()).unwrap();
    assert!(ledger.held().is_none());
    let first = envelope("a", 1, 1, &["hello"]);
    assert!(ledger.put(first.clone()).await.unwrap().changed);
    assert!(!ledger.put(first.clone()).await.unwrap().changed);
    assert!(ledger.put(envelope("a", 1, 0, &[])).await.is_err());

    let again = Ledger::load("local", store.clone()).unwrap();
    assert_eq!(again.held(), Some(&first));

    let mut taken = envelope("b", 4, 2, &["hello"]);
    taken.take_over = Some(ledger_fence(&first));
    let mut ledger = again;
    assert!(ledger.put(taken.clone()).await.unwrap().changed);
    // Told again, since the answer was lost: it is so already.
    assert!(!ledger.put(taken.clone()).await.unwrap().changed);
    let again = Ledger::load("local", store.clone()).unwrap();
    let kept = again.held().unwrap();
    assert_eq!(ledger_fence(kept), ledger_fence(&taken));
    assert_eq!(kept.take_over, None);
    assert!(ledger.put(envelope("a", 9, 9, &[])).await.is_err());

    let path = folder.path().join(FILE);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("uid-hello", "uid-other")).unwrap();
    let error = Ledger::load("local", store.clone()).err().unwrap();
    assert!(error.to_string().contains("digest"), "{error}");
    std::fs::write(&path, &text[..20]).unwrap();
    assert!(Ledger::load("local", store).is_err());
}

/// Saves one after the other, each when it is told to.
struct Slow {
    begun: tokio::sync::mpsc::UnboundedSender<u64>,
    go: std::sync::Mutex<std::sync::mpsc::Receiver<()>>,
    saved: std::sync::Mutex<Vec<u64>>,
}

impl Store for Slow {
    fn load(&self) -> Result<Option<NodeSpecEnvelope>, LedgerError> {
        Ok(None)
    }

    fn save(&self, envelope: &NodeSpecEnvelope) -> io::Result<()> {
        self.begun.send(envelope.generation).unwrap();
        self.go.lock().unwrap().recv().unwrap();
        self.saved.lock().unwrap().push(envelope.generation);
        Ok(())
    }
}

#[tokio::test]
async fn a_write_goes_on_when_its_request_is_dropped_and_the_next_waits_for_it() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let config = crate::Config {
        home: home.path().to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: Vec::new(),
        manager_program: "/nonexistent/rts-manager".into(),
        controller_socket: None,
        heal_after: None,
    };
    let folders = crate::folders::Folders::new(home.path(), "local").unwrap();
    let launcher = crate::launch::ProcessLauncher::new(&config.manager_program);
    let agent = crate::agent::Agent::new(config, folders, Arc::new(launcher)).unwrap();
    let agent = Arc::new(agent);
    let (begun, mut begins) = tokio::sync::mpsc::unbounded_channel();
    let (go, gone) = std::sync::mpsc::channel();
    let store = Arc::new(Slow {
        begun,
        go: std::sync::Mutex::new(gone),
        saved: Default::default(),
    });
    *agent.ledger.lock().await = Ledger::load("local", store.clone()).unwrap();

    let first = agent.clone();
    let first = tokio::spawn(async move { first.put_node_spec(envelope("a", 1, 1, &[])).await });
    assert_eq!(begins.recv().await, Some(1));
    first.abort();
    assert!(first.await.unwrap_err().is_cancelled());
    let second = agent.clone();
    let second = tokio::spawn(async move { second.put_node_spec(envelope("a", 1, 2, &[])).await });
    go.send(()).unwrap();
    assert_eq!(begins.recv().await, Some(2));
    go.send(()).unwrap();
    assert!(second.await.unwrap().unwrap().changed);
    assert_eq!(*store.saved.lock().unwrap(), [1, 2]);
    assert_eq!(agent.ledger.lock().await.fence().unwrap().generation, 2);
}
