use std::os::unix::fs::PermissionsExt;

use super::*;
use crate::exit::Exit;
use crate::show::plan::samples::result;

fn request() -> ApplyRequest {
    let text = include_bytes!("../../../manifests/hello/system.xml");
    let loaded = rts_schemas::rts_profile::load("hello.xml", text, None, &[]);
    ApplyRequest {
        targets: vec!["Sine0".to_owned()],
        ..ApplyRequest::of(loaded.unwrap().0)
    }
}

fn saved() -> SavedPlan {
    SavedPlan::of(&request(), &result())
}

fn refused(bytes: &[u8]) -> String {
    let error = SavedPlan::read("x.plan", bytes).unwrap_err();
    assert_eq!(error.exit(), Exit::Invalid);
    format!("{}; {}", error.line(), error.help().unwrap())
}

#[test]
fn what_is_written_is_read_again_and_asks_for_no_change_since() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.plan");
    for _ in 0..2 {
        saved().write(&path).unwrap();
    }
    let mode = std::fs::metadata(&path).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let read = SavedPlan::read("a.plan", &std::fs::read(&path).unwrap());
    let read = read.unwrap().unwrap();
    assert_eq!(read, saved());
    assert_eq!(read.result(), result());
    let expect = Expect {
        index: Some(3),
        digest: Some(result().digest),
        no_restart: false,
        max_stand_ins: None,
    };
    assert_eq!(
        read.request(),
        ApplyRequest {
            expect,
            ..request()
        }
    );
}

#[test]
fn what_is_no_plan_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("system.xml");
    let said = |path: &Path| {
        let error = saved().write(path).unwrap_err();
        assert_eq!(error.exit(), Exit::Usage);
        error.line()
    };
    for text in ["<xml/>", "{\"kind\": \"List\"}", "{"] {
        std::fs::write(&path, text).unwrap();
        assert!(said(&path).ends_with("exists and is no saved plan: it is not replaced"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
    assert!(said(folder.path()).contains("is no ordinary file"));
    assert!(said(Path::new("/dev/null")).contains("is no ordinary file"));
    assert!(said(Path::new("-")).contains("not on standard output"));
    assert!(said(&folder.path().join("none/a.plan")).contains("No such file"));
    // As `mktemp` makes it.
    std::fs::write(&path, "").unwrap();
    saved().write(&path).unwrap();
}

#[test]
fn a_damaged_plan_is_told_from_a_system() {
    let whole = serde_json::to_vec(&saved()).unwrap();
    for part in [100, 1000, whole.len() - 1] {
        let said = refused(&whole[..part]);
        assert!(said.contains("it is cut off or damaged"), "{said}");
    }
    let text = String::from_utf8(whole).unwrap();
    let newer = text.replace("rtsctl.dev/v1", "rtsctl.dev/v2");
    insta::assert_snapshot!("newer", refused(newer.as_bytes()));
    let strange = text.replace("\"index\":", "\"indices\":");
    assert!(refused(strange.as_bytes()).contains("it is damaged, or of another version"));
    let printed = serde_json::to_vec(&result().plan).unwrap();
    insta::assert_snapshot!("printed", refused(&printed));
}

#[test]
fn a_plan_that_was_edited_is_refused_and_one_laid_out_anew_is_not() {
    let whole = serde_json::to_value(saved()).unwrap();
    let laid_out = format!("{whole:#}");
    let read = SavedPlan::read("x.plan", laid_out.as_bytes());
    assert_eq!(read.unwrap().unwrap(), saved());
    let edits: [fn(&mut Value); 6] = [
        |v| v["metadata"]["name"] = json!("other"),
        |v| v["index"] = json!(4),
        |v| v["plan"]["steps"] = json!([]),
        |v| v["plan"]["steps"][0]["reason"] = json!("other"),
        |v| v["request"]["spec"]["components"][0]["type"] = json!("Other"),
        |v| v["checksum"] = json!(""),
    ];
    for edit in edits {
        let mut edited = whole.clone();
        edit(&mut edited);
        assert_ne!(edited, whole);
        insta::allow_duplicates! {
            insta::assert_snapshot!("edited", refused(edited.to_string().as_bytes()));
        }
    }
    let mut old = whole;
    old.as_object_mut().unwrap().remove("checksum");
    let said = refused(old.to_string().as_bytes());
    assert!(said.contains("missing field `checksum`"), "{said}");
}

#[test]
fn other_files_are_none_of_its_business() {
    for other in [
        "",
        "<a/>",
        "rtsprofile: {}",
        "{",
        "{rtsProfile: {}}",
        "{\"kind\":\"Deployment\"}",
    ] {
        assert_eq!(
            SavedPlan::read("x", other.as_bytes()).unwrap(),
            None,
            "{other}"
        );
    }
}

#[test]
fn a_saved_plan_is_applied_as_it_is() {
    use crate::cli::{Color, Globals};
    use crate::input::{InputArgs, Source};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.plan");
    saved().write(&path).unwrap();
    let out = crate::output::Output::new(&Globals {
        home: None,
        controller: None,
        color: Color::Never,
        verbose: 0,
        quiet: true,
    });
    let of = |overlays: &[&str], name: Option<&str>, targets: &[&str]| {
        let overlays = overlays.iter().map(|f| folder.path().join(f)).collect();
        let targets = targets.iter().map(|t| (*t).to_owned()).collect();
        InputArgs::of(path.clone(), overlays, name.map(str::to_owned), targets)
    };
    let source = of(&[], None, &[]).load_any(&out).unwrap();
    assert!(matches!(source, Source::Saved(plan) if *plan == saved()));
    for (args, option) in [
        (of(&["lab.yaml"], None, &[]), "-f"),
        (of(&[], Some("other"), &[]), "--name"),
        (of(&[], None, &["Sine0"]), "--target"),
    ] {
        let error = args.load_any(&out).unwrap_err();
        assert_eq!(error.exit(), Exit::Usage);
        assert!(error.line().contains(option), "{}", error.line());
    }
    let error = of(&[], None, &[]).load(&out).unwrap_err();
    assert_eq!(error.exit(), Exit::Usage);
}
