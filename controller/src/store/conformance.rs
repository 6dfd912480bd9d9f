//! One suite for every implementation of [`Store`].

use std::sync::Arc;

use jiff::Timestamp;
use rts_schemas::system::{Orders, SystemSpec};

use super::{
    Backup, MemoryStore, NodeGeneration, OffLoop, RedbStore, Restored, State, Store, SystemRecord,
    Write,
};

fn record(name: &str, generation: u64) -> SystemRecord {
    SystemRecord {
        uid: format!("uid-{name}"),
        generation,
        index: 0,
        spec: Arc::new(SystemSpec {
            composites: Vec::new(),
            name: name.to_owned(),
            full_id: String::new(),
            components: Vec::new(),
            connectors: Vec::new(),
            orders: Orders::default(),
        }),
        digests: [("A".to_owned(), "d".to_owned())].into(),
        stand_ins: [("A0".to_owned(), Default::default())].into(),
        nodes: ["local".to_owned()].into(),
        created: Timestamp::UNIX_EPOCH,
        deleted: None,
        forgotten: [].into(),
        places: [("A0".to_owned(), "local".to_owned())].into(),
        left: [("A0".to_owned(), ["robot".to_owned()].into())].into(),
    }
}

fn put(name: &str, generation: u64) -> Write {
    Write::PutSystem(Arc::new(record(name, generation)))
}

/// `reopen` gives the store as the next start of the program finds it.
async fn conforms<S: Store>(mut reopen: impl FnMut(Option<S>) -> S) {
    let store = reopen(None);
    let fresh = store.load().await.unwrap();
    let numbers = (fresh.epoch, fresh.revisions, fresh.indexes);
    assert_eq!(numbers, (1, 0, 0));
    assert!(!fresh.cluster_uid.is_empty());
    assert!(fresh.systems.is_empty() && fresh.nodes.is_empty() && fresh.restored.is_none());

    store.write(vec![put("b", 1), put("a", 1)]).await.unwrap();
    store.write(vec![put("a", 2)]).await.unwrap();
    let node = NodeGeneration {
        epoch: 1,
        generation: 7,
        digest: "x".into(),
    };
    store
        .write(vec![Write::PutNode("local".into(), node.clone())])
        .await
        .unwrap();
    store.write(vec![Write::Revisions(100)]).await.unwrap();
    store.write(vec![Write::Revisions(50)]).await.unwrap();
    let indexed = |index| {
        let mut record = record("a", 2);
        record.index = index;
        [Write::Indexes(index), Write::PutSystem(Arc::new(record))]
    };
    store.write(indexed(9).into()).await.unwrap();
    store.write(indexed(8).into()).await.unwrap();

    let store = reopen(Some(store));
    let state = store.load().await.unwrap();
    assert_eq!(state.cluster_uid, fresh.cluster_uid);
    assert_eq!(state.revisions, 100, "never lowered");
    assert_eq!(state.nodes["local"], node);
    assert_eq!(state.systems.keys().collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(state.indexes, 9, "never lowered");
    assert_eq!(state.systems["a"].index, 8);

    let remove = Write::RemoveSystem("a".into());
    store
        .write(vec![remove.clone(), remove, Write::Epoch(4)])
        .await
        .unwrap();
    let store = reopen(Some(store));
    let state = store.load().await.unwrap();
    assert_eq!(state.systems.keys().collect::<Vec<_>>(), ["b"]);
    assert_eq!(state.epoch, 4);
}

/// What one store held comes back out of a backup of it, in a new store.
async fn comes_back<S: Store>(from: &S, mut to: impl FnMut(Option<S>) -> S) {
    let restored = Restored {
        said: ["hello".to_owned()].into(),
        at: Timestamp::UNIX_EPOCH,
        take_over: true,
        settled: ["local".to_owned()].into(),
    };
    let node = NodeGeneration {
        epoch: 1,
        generation: 7,
        digest: "x".into(),
    };
    let writes = [
        put("a", 3),
        put("b", 1),
        Write::PutNode("local".into(), node),
        Write::Revisions(100),
        Write::Indexes(12),
        Write::Restored(Some(restored)),
    ];
    from.write(writes.into()).await.unwrap();
    let held = from.load().await.unwrap();
    let document = Backup::of(&held, Timestamp::UNIX_EPOCH).unwrap();
    let document = serde_json::to_vec(&document).unwrap();
    let (_, read): (_, State) = Backup::read(&document).unwrap();
    assert_eq!(read, held);
    let store = to(None);
    store.write(read.writes()).await.unwrap();
    assert_eq!(to(Some(store)).load().await.unwrap(), held);
}

#[tokio::test]
async fn what_an_older_program_wrote_is_numbered_once() {
    let mut state = State::default();
    for (name, index) in [("a", 0), ("b", 7), ("c", 0)] {
        let mut record = record(name, 3);
        record.index = index;
        state.change(Write::PutSystem(Arc::new(record)));
    }
    let store = MemoryStore::holding(state.clone());
    store.write(state.number()).await.unwrap();
    assert_eq!(store.load().await.unwrap(), state);
    let indexes: Vec<u64> = state.systems.values().map(|r| r.index).collect();
    assert_eq!((indexes, state.indexes), (vec![8, 7, 9], 9));
    assert_eq!(state.number(), []);
}

#[tokio::test]
async fn memory_conforms() {
    let open = |old: Option<MemoryStore>| old.unwrap_or_else(|| MemoryStore::new("u"));
    conforms(open).await;
    comes_back(&MemoryStore::new("first"), open).await;
}

#[tokio::test]
async fn redb_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let open = |name: &str, old: Option<OffLoop>| {
        drop(old);
        let uid = uuid::Uuid::new_v4().to_string();
        OffLoop::new(RedbStore::open(&folder.path().join(name), &uid).unwrap())
    };
    conforms(|old| open("one.redb", old)).await;
    comes_back(&open("first.redb", None), |old| open("second.redb", old)).await;
}
