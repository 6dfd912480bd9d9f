//! One suite for every implementation of [`Store`].

use jiff::Timestamp;
use rts_schemas::system::{Orders, SystemSpec};

use super::{MemoryStore, NodeGeneration, RedbStore, Store, SystemRecord};

fn record(name: &str, generation: u64) -> SystemRecord {
    SystemRecord {
        uid: format!("uid-{name}"),
        generation,
        spec: SystemSpec {
            name: name.to_owned(),
            full_id: String::new(),
            components: Vec::new(),
            connectors: Vec::new(),
            orders: Orders::default(),
        },
        digests: [("A".to_owned(), "d".to_owned())].into(),
        nodes: ["local".to_owned()].into(),
        created: Timestamp::UNIX_EPOCH,
        deleted: None,
    }
}

/// `reopen` gives the store as the next start of the program finds it.
fn conforms<S: Store>(mut reopen: impl FnMut(Option<S>) -> S) {
    let store = reopen(None);
    let fresh = store.load().unwrap();
    assert_eq!((fresh.epoch, fresh.revisions), (1, 0));
    assert!(!fresh.cluster_uid.is_empty());
    assert!(fresh.systems.is_empty() && fresh.nodes.is_empty());

    store.put_system(&record("b", 1)).unwrap();
    store.put_system(&record("a", 1)).unwrap();
    store.put_system(&record("a", 2)).unwrap();
    let node = NodeGeneration {
        generation: 7,
        digest: "x".into(),
    };
    store.put_node("local", &node).unwrap();
    store.reserve_revisions(100).unwrap();
    store.reserve_revisions(50).unwrap();

    let store = reopen(Some(store));
    let state = store.load().unwrap();
    assert_eq!(state.cluster_uid, fresh.cluster_uid);
    assert_eq!(state.revisions, 100, "never lowered");
    assert_eq!(state.nodes["local"], node);
    assert_eq!(state.systems.keys().collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(state.systems["a"], record("a", 2));

    store.remove_system("a").unwrap();
    store.remove_system("a").unwrap();
    let store = reopen(Some(store));
    assert_eq!(
        store.load().unwrap().systems.keys().collect::<Vec<_>>(),
        ["b"]
    );
}

#[test]
fn memory_conforms() {
    conforms(|old| old.unwrap_or_else(|| MemoryStore::new("u")));
}

#[test]
fn redb_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("controller.redb");
    conforms(|old| {
        drop(old);
        RedbStore::open(&path, &uuid::Uuid::new_v4().to_string()).unwrap()
    });
}
