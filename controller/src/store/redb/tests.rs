use std::collections::BTreeMap;

use redb::Database;

use super::*;
use crate::store::{NodeGeneration, SCHEMA_VERSION};

/// The error of an open, with the file's name taken out.
fn refused(path: &Path) -> String {
    let Err(error) = RedbStore::open(path, "u") else {
        panic!("it was opened");
    };
    error
        .to_string()
        .replace(&path.display().to_string(), "FILE")
}

#[test]
fn a_store_of_a_later_program_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.redb");
    let store = RedbStore::open(&path, "u").unwrap();
    let later = Change::put(META, rows::VERSION, &(SCHEMA_VERSION + 1)).unwrap();
    store.change(&[later]).unwrap();
    drop(store);
    insta::assert_snapshot!(refused(&path), @"FILE has schema version 4, and this program knows 3: upgrade rts-controller, or move the file away to start afresh");
}

#[test]
fn a_damaged_file_is_an_error_that_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.redb");
    std::fs::write(&path, b"this is no database").unwrap();
    insta::assert_snapshot!(refused(&path), @"the store FILE is damaged (Not a redb database: magic number mismatch); put a backup back with `rtsctl controller restore`, or, without one, end everything with `rtsctl down --purge` and apply the systems again");
}

#[test]
fn a_damaged_record_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.redb");
    let store = RedbStore::open(&path, "u").unwrap();
    store
        .change(&[Change::put(SYSTEMS, "hello", &7).unwrap()])
        .unwrap();
    let error = store.load().unwrap_err().to_string();
    assert!(error.contains("damaged (record hello: "), "{error}");
    store.write(&[Write::RemoveSystem("hello".into())]).unwrap();
    store.check().unwrap();
}

/// A file as version 1 of the program wrote it, row by row.
fn version_1(path: &Path) {
    let database = Database::create(path).unwrap();
    let transaction = database.begin_write().unwrap();
    let rows = [
        (META, "schemaVersion", "1"),
        (META, "clusterUid", r#""old-cluster""#),
        (META, "epoch", "3"),
        (META, "revisions", "2097152"),
        (
            SYSTEMS,
            "hello",
            r#"{"uid":"uid-hello","generation":4,"spec":{"name":"hello","fullId":"","components":[],"connectors":[],
                "orders":{}},"digests":{"A":"d"},"nodes":["local"],"created":"2026-01-01T00:00:00Z"}"#,
        ),
        (NODES, "local", r#"{"generation":9,"digest":"x"}"#),
    ];
    for (table, key, value) in rows {
        let mut table = transaction.open_table(table).unwrap();
        table.insert(key, value.as_bytes()).unwrap();
    }
    transaction.commit().unwrap();
}

#[test]
fn a_store_of_version_1_is_brought_up_to_date_and_its_copy_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("controller.redb");
    version_1(&path);
    let state = RedbStore::open(&path, "u").unwrap().load().unwrap();
    assert_eq!(
        (state.cluster_uid.as_str(), state.epoch),
        ("old-cluster", 3)
    );
    let hello = &state.systems["hello"];
    assert_eq!((hello.generation, hello.index), (4, 0));
    let local = NodeGeneration {
        epoch: 3,
        generation: 9,
        digest: "x".into(),
    };
    assert_eq!(state.nodes, BTreeMap::from([("local".to_owned(), local)]));
    assert_eq!(state.restored, None);
    let again = RedbStore::open(&path, "u").unwrap().load().unwrap();
    assert_eq!(again, state);

    let copy = folder.path().join("controller.redb.v1");
    let database = Database::open(&copy).unwrap();
    let transaction = database.begin_read().unwrap();
    let nodes = transaction.open_table(NODES).unwrap();
    let row = nodes.get("local").unwrap().unwrap();
    assert_eq!(row.value(), br#"{"generation":9,"digest":"x"}"#);
}

#[test]
fn a_step_that_fails_leaves_the_old_version() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("controller.redb");
    version_1(&path);
    let database = Database::open(&path).unwrap();
    let broken = Change {
        table: NODES,
        key: "robot".into(),
        value: Some(b"nonsense".to_vec()),
    };
    rows::write(&database, &[broken]).unwrap();
    drop(database);
    assert!(refused(&path).contains("record robot"));
    let database = Database::open(&path).unwrap();
    let transaction = database.begin_read().unwrap();
    let meta = transaction.open_table(META).unwrap();
    assert_eq!(rows::get::<u32>(&meta, rows::VERSION).unwrap(), Some(1));
}
