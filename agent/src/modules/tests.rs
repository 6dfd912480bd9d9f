//! Finding and describing modules.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::machine::Host;

/// The modules in some folders, of a node in a home of its own.
async fn modules(folders: &[PathBuf], program: &Path) -> Modules {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let config = crate::Config {
        home: home.path().to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: folders.to_owned(),
        manager_program: program.to_owned(),
        controller_socket: None,
        heal_after: None,
        idle_managers: None,
    };
    Modules::new(Arc::new(Host::take(&config, None).await.unwrap()))
}

async fn finder(folders: &[PathBuf]) -> Modules {
    modules(folders, Path::new("/nonexistent/rts-manager")).await
}

#[tokio::test]
async fn the_first_file_in_the_order_of_paths_and_names_wins() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let modules = finder(&[a.path().to_owned(), b.path().to_owned()]).await;
    let none = modules.resolve("ConsoleIn").await.unwrap();
    assert_eq!((none.module, none.searched.len()), (None, 4));
    let error = modules.find("ConsoleIn", None).await.unwrap_err();
    assert!(error.to_string().contains("libconsole_in.so"), "{error}");

    fs::write(b.path().join("libconsole_in.so"), "b").unwrap();
    let found = modules.find("ConsoleIn", None).await.unwrap();
    assert_eq!(
        found.path,
        b.path().join("libconsole_in.so").display().to_string()
    );
    fs::write(a.path().join("ConsoleIn.so"), "a").unwrap();
    let found = modules.find("ConsoleIn", None).await.unwrap();
    assert_eq!(
        found.path,
        a.path().join("ConsoleIn.so").display().to_string()
    );
    assert_eq!(
        found.digest,
        "ca978112ca1bbdcafac231b39a23dc4da786eff8147c4e72b9807785afee48bb"
    );
}

#[tokio::test]
async fn a_changed_file_has_a_new_digest_and_is_refused_when_pinned() {
    let folder = tempfile::tempdir().unwrap();
    let modules = finder(&[folder.path().to_owned()]).await;
    let path = folder.path().join("libsink.so");
    fs::write(&path, "one").unwrap();
    let first = modules.find("Sink", None).await.unwrap();
    assert!(modules.find("Sink", Some(&first.digest)).await.is_ok());
    fs::write(&path, "other").unwrap();
    let error = modules.find("Sink", Some(&first.digest)).await.unwrap_err();
    assert!(matches!(error, ModuleError::Changed { .. }));
    assert!(error.to_string().contains("apply it again"), "{error}");
}

#[tokio::test]
async fn a_type_name_does_not_lead_out_of_the_module_paths() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    fs::write(folder.path().join("evil.so"), "x").unwrap();
    let modules = finder(&[folder.path().join("in")]).await;
    assert_eq!(modules.resolve("../evil").await.unwrap().module, None);
}

#[tokio::test]
async fn a_module_is_described_once_by_a_process_of_its_own() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("describe");
    let asked = folder.path().join("asked");
    // Says what it was asked, and answers for one type alone.
    let script = format!(
        r#"#!/bin/sh
echo "$*" >> '{}'
[ "$4" = Sine ] || exit 1
echo '{{"typeName":"Sine","vendor":"","category":"","version":"","description":"","path":"","ports":[{{"name":"out","direction":"out","dataType":"IDL:RTC/TimedDouble:1.0"}}],"parameters":{{"gain":"1"}}}}'
"#,
        asked.display()
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o700)).unwrap();
    let modules = modules(&[folder.path().to_owned()], &program).await;
    fs::write(folder.path().join("libsine.so"), "s").unwrap();
    fs::write(folder.path().join("libbad.so"), "b").unwrap();
    for _ in 0..2 {
        let sine = modules.resolve_described("Sine").await.unwrap();
        let description = sine.module.unwrap().description.unwrap();
        assert_eq!(description.parameters["gain"], "1");
        assert_eq!(description.ports[0].name, "out");
        let bad = modules.resolve_described("Bad").await.unwrap();
        assert_eq!(bad.module.unwrap().description, None);
    }
    let asked = fs::read_to_string(asked).unwrap();
    assert_eq!(asked.lines().count(), 2, "{asked}");
    let line = format!(
        "--describe {}/libsine.so --type Sine\n",
        folder.path().display()
    );
    assert!(asked.starts_with(&line), "{asked}");
}
