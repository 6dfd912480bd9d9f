//! What is done with profiles without any daemon: `fmt`, and `explain` of fields.

use std::os::unix::fs::PermissionsExt;

use super::*;

/// Made by hand: a comment before and after the root, tabs, DOS line ends, quotes of both kinds, an unknown element.
const BY_HAND: &str = "<!-- Made by hand. -->\r
<r:RtsProfile xmlns:r='http://www.openrtp.org/namespaces/rts' r:id='RTSystem:a:b:1' r:version=\"0.2\">\r
\t<r:Components r:instanceName='A0' r:id=\"RTC:v:c:A:1\"   r:pathUri = 'localhost/A0.rtc'/> <!-- the first -->\r
\t<r:Components r:instanceName='B0'\r
\t\tr:id='RTC:v:c:B:1'><r:DataPorts r:name='in'/><mine xmlns='urn:mine'>kept</mine></r:Components>\r
</r:RtsProfile>\r
<!-- The end. -->";

impl Edge {
    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.folder.path().join(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.folder.path().join(name)).unwrap()
    }
}

#[test]
fn a_profile_is_printed_in_canonical_form() {
    let edge = Edge::new();
    edge.write("a.xml", BY_HAND.as_bytes());
    let (code, stdout, stderr) = edge.run(&["fmt", "a.xml"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    insta::assert_snapshot!(stdout);
    assert_eq!(edge.read("a.xml"), BY_HAND.as_bytes());
    edge.write("b.xml", stdout.as_bytes());
    assert_eq!(edge.run(&["fmt", "b.xml"]).1, stdout);
    let out = edge.run(&["fmt", "a.xml", "--out", "c.xml"]);
    assert_eq!(out, (0, String::new(), String::new()));
    assert_eq!(edge.read("c.xml"), stdout.as_bytes());
    assert!(!edge.home().exists(), "formatting made the home");
}

/// No program may write them, and some do; a terminal would obey some of them.
#[test]
fn control_characters_are_printed_as_they_are_written() {
    let edge = Edge::new();
    let odd = "<rts:RtsProfile xmlns:rts='http://www.openrtp.org/namespaces/rts' rts:id='a\0b\u{1b}[0m'>\n \
        <rts:Components rts:instanceName='A0'/>\0\n <rts:Components/></rts:RtsProfile>";
    edge.write("a.xml", odd.as_bytes());
    let (code, stdout, stderr) = edge.run(&["fmt", "a.xml"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("a\0b\u{1b}[0m") && stdout.contains("/>\0"),
        "{stdout}"
    );
    edge.write("b.xml", stdout.as_bytes());
    assert_eq!(edge.run(&["fmt", "b.xml"]).1, stdout);
    assert_eq!(edge.run(&["fmt", "-w", "a.xml"]).0, 0);
    assert_eq!(edge.read("a.xml"), stdout.as_bytes());
    assert_eq!(edge.run(&["convert", "b.xml", "--to", "xml"]).1, stdout);
}

#[test]
fn a_file_is_replaced_as_a_whole_and_its_other_names_keep_the_old_text() {
    let edge = Edge::new();
    edge.write("a.xml", BY_HAND.as_bytes());
    let path = |name: &str| edge.folder.path().join(name);
    std::fs::hard_link(path("a.xml"), path("hard.xml")).unwrap();
    std::os::unix::fs::symlink("a.xml", path("soft.xml")).unwrap();
    assert_eq!(edge.run(&["fmt", "-w", "soft.xml"]).0, 0);
    assert!(path("soft.xml").is_symlink());
    assert_ne!(edge.read("a.xml"), BY_HAND.as_bytes());
    assert_eq!(edge.read("soft.xml"), edge.read("a.xml"));
    assert_eq!(edge.read("hard.xml"), BY_HAND.as_bytes());
}

#[test]
fn explain_takes_roots_and_goes_through_free_names() {
    let edge = Edge::new();
    let first = edge.run(&["explain", "rtsProfile.components"]);
    assert_eq!(first, edge.run(&["explain", "system.components"]));
    assert_eq!(first.0, 0);
    let (code, stdout, _) = edge.run(&["explain", "overlay.spec.hosts"]);
    assert_eq!(code, 0);
    insta::assert_snapshot!(stdout, @r#"
    KIND:    Deployment overlay
    FIELD:   overlay.spec.hosts <map[string]string>
    KEYS:    any name, as in overlay.spec.hosts.NAME

    DESCRIPTION:
        Node for each host that the profile names (host of `pathUri`, else of the
        IOR).
    "#);
    let (code, stdout, _) = edge.run(&["explain", "overlay.spec.components.Motor0.node"]);
    let field = "FIELD:   overlay.spec.components.Motor0.node <string>\n";
    assert!(code == 0 && stdout.contains(field), "{stdout}");
}

#[test]
fn check_and_diff_change_nothing_and_write_changes_what_must_be() {
    let edge = Edge::new();
    edge.write("a.xml", BY_HAND.as_bytes());
    let good = edge.run(&["fmt", "a.xml"]).1;
    edge.write("good.xml", good.as_bytes());
    let checked = edge.run(&["fmt", "--check", "good.xml", "a.xml"]);
    assert_eq!(checked, (1, "a.xml\n".to_owned(), String::new()));
    assert_eq!(edge.run(&["fmt", "--check", "good.xml"]).0, 0);
    let (code, diff, _) = edge.run(&["fmt", "--diff", "good.xml", "a.xml"]);
    assert_eq!(code, 0);
    insta::assert_snapshot!(diff);
    assert_eq!(edge.read("a.xml"), BY_HAND.as_bytes());
    let path = edge.folder.path().join("a.xml");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("a.xml", edge.folder.path().join("link.xml")).unwrap();
    let written = edge.run(&["fmt", "-w", "good.xml", "link.xml"]);
    assert_eq!(written, (0, "link.xml\n".to_owned(), String::new()));
    assert_eq!(edge.read("a.xml"), good.as_bytes());
    assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    assert!(edge.folder.path().join("link.xml").is_symlink());
    assert_eq!(edge.run(&["fmt", "--check", "a.xml"]).0, 0);
}

#[test]
fn what_would_lose_something_is_left_as_it_is() {
    let edge = Edge::new();
    let yaml = include_str!("../../../manifests/hello/system.yaml");
    let lab = include_str!("../../../manifests/hello/lab.yaml");
    edge.write("system.yaml", format!("{yaml}# the end\n").as_bytes());
    edge.write("lab.yaml", lab.as_bytes());
    edge.write("broken.xml", b"<a>");
    edge.write("two.yaml", b"rtsProfile: {id: x}\nmore: 1\n");
    edge.write("a.xml", BY_HAND.as_bytes());
    let files = [
        "system.yaml",
        "lab.yaml",
        "broken.xml",
        "two.yaml",
        "none.xml",
        "a.xml",
    ];
    let mut args = vec!["fmt", "--write"];
    args.extend(files);
    let (code, stdout, stderr) = edge.run(&args);
    // The good one is formatted all the same.
    assert_eq!((code, stdout.as_str()), (3, "a.xml\n"));
    insta::assert_snapshot!(stderr);
    assert_eq!(edge.read("lab.yaml"), lab.as_bytes());
    assert!(edge.read("system.yaml").ends_with(b"# the end\n"));
    for (args, said) in [
        (&["fmt", "a.xml", "b.xml"][..], "several files"),
        (&["fmt", "-w", "-"], "standard input"),
    ] {
        let (code, _, stderr) = edge.run(args);
        assert!(code == 2 && stderr.contains(said), "{args:?}: {stderr}");
    }
}

#[test]
fn other_encodings_become_utf_8() {
    let edge = Edge::new();
    // "系" in Shift_JIS.
    let head = b"<?xml version='1.0' encoding='Shift_JIS'?><r:RtsProfile xmlns:r='http://www.openrtp.org/namespaces/rts' r:abstract='";
    let bytes = [&head[..], b"\x8c\x6e", b"'/>"].concat();
    edge.write("sjis.xml", &bytes);
    let (code, stdout, stderr) = edge.run(&["fmt", "sjis.xml"]);
    assert_eq!(
        (code, stderr.as_str()),
        (0, "sjis.xml: Shift_JIS becomes UTF-8\n")
    );
    assert!(
        stdout.contains("encoding=\"UTF-8\"") && stdout.contains("系"),
        "{stdout}"
    );
}

#[test]
fn yaml_is_formatted_by_the_order_of_the_schema() {
    let edge = Edge::new();
    let yaml = "---\nrtsProfile:\n  components: [{instanceName: A0, id: 'RTC:v:c:A:1', more: [1, 2]}]\n  version: 0.2\n  id: RTSystem:a:b:1\n";
    edge.write("a.yaml", yaml.as_bytes());
    let (code, stdout, _) = edge.run(&["fmt", "a.yaml"]);
    assert_eq!(code, 0);
    insta::assert_snapshot!(stdout, @r#"
    rtsProfile:
      id: "RTSystem:a:b:1"
      version: "0.2"
      components:
        - id: "RTC:v:c:A:1"
          instanceName: A0
          more:
            - "1"
            - "2"
    "#);
}

#[test]
fn fields_are_explained() {
    let edge = Edge::new();
    let mut all = String::new();
    for args in [
        &["explain", "system.components.dataPorts"][..],
        &["explain", "system.components.dataPorts.name"],
        &["explain", "component.basicInfo.componentType"],
        &["explain", "system.activation", "--recursive"],
        &[
            "explain",
            "system.components",
            "--profile-version",
            "0.1",
            "--recursive",
        ],
        &[
            "explain",
            "component.configurationSet.configuration.constraint.unit.propertyIsBetween",
            "-o",
            "json",
        ],
    ] {
        let (code, stdout, stderr) = edge.run(args);
        assert_eq!((code, stderr.as_str()), (0, ""), "{args:?}");
        all.push_str(&format!("$ rtsctl {}\n{stdout}\n", args.join(" ")));
    }
    insta::assert_snapshot!(all);
    assert!(!edge.home().exists(), "explaining made the home");
}

#[test]
fn a_field_that_is_not_there_is_2_and_a_file_comes_first() {
    let edge = Edge::new();
    let mut all = String::new();
    for path in ["system.component", "system.xml", "component.basicinfo.nam"] {
        let (code, stdout, stderr) = edge.run(&["explain", path]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{path}");
        all.push_str(&stderr);
    }
    insta::assert_snapshot!(all);
    // A plan needs a controller.
    edge.write(
        "system.xml",
        include_bytes!("../../../manifests/hello/system.xml"),
    );
    assert_eq!(edge.run(&["explain", "system.xml"]).0, 4);
    assert_eq!(edge.run(&["explain-plan", "system"]).0, 3);
}
