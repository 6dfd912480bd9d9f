//! IDL files: what is accepted and refused here, is by `omniidl` of omniORB too.

// A failure here is a failed test; only the tests read files, the environment and start programs.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rts_schemas::diagnostic::{Report, render};
use rts_schemas::idl::{self, Found, Include, Kind, NoSources, Sources, Standard, read, standard};

const ACCEPTED: &str = include_str!("idl/accepted.txt");
const REFUSED: &str = include_str!("idl/refused.txt");
/// What `omniidl` accepts.
const STRICTER: &str = include_str!("idl/stricter.txt");

/// What `omniidl` refuses: it takes the complement of a signed number for an unsigned one, and the least number for the
/// negative of one that is too large.
const WIDER: [&str; 2] = [
    "const long x = ~5;",
    "const long long x = -9223372036854775808;",
];

fn text(case: &str) -> String {
    // `\\n` is a line that goes on.
    case.replace("\\\\n", "\\\n")
        .replace("\\n", "\n")
        .replace("'\n'", "'\\n'")
        + "\n"
}

/// Codes and texts.
fn cases(list: &'static str) -> Vec<(&'static str, String)> {
    let split = |line: &'static str| line.split_once('\t').map(|(code, case)| (code, text(case)));
    list.lines().map(|line| split(line).unwrap()).collect()
}

fn shown(report: &Report) -> String {
    let all: Vec<String> = report.findings.iter().map(render).collect();
    all.join("\n")
}

#[test]
fn what_is_right_is_accepted() {
    for case in ACCEPTED.lines().chain(WIDER).map(text) {
        let read = read("case.idl", case.as_bytes(), &NoSources);
        assert!(read.is_ok(), "{case}\n{}", shown(&read.unwrap_err()));
    }
}

#[test]
fn what_is_wrong_is_refused_and_explained() {
    let mut all = String::new();
    for (code, case) in cases(REFUSED).into_iter().chain(cases(STRICTER)) {
        let Err(report) = read("case.idl", case.as_bytes(), &NoSources) else {
            panic!("accepted: {case}");
        };
        assert_eq!(report.findings[0].code, code, "{case}\n{}", shown(&report));
        assert!(
            report.findings.iter().all(|finding| finding.help.is_some()),
            "{case}"
        );
        all += &format!("{}\n\n", shown(&report));
    }
    insta::assert_snapshot!(all);
}

/// True when `omniidl` is there; it must be where the corpus is.
fn has_omniidl() -> bool {
    let found = Command::new("omniidl")
        .arg("-V")
        .stdout(Stdio::null())
        .status();
    if found.is_ok_and(|status| status.success()) {
        return true;
    }
    let must = ["CI", "RTSCTL_CORPUS"]
        .iter()
        .any(|name| std::env::var_os(name).is_some());
    assert!(!must, "omniidl is missing: run `cargo xtask test packages`");
    println!("skipped: omniidl is not installed");
    false
}

/// Whether `omniidl` accepts files, and what it says.
fn omniidl(files: &[PathBuf], options: &[&str]) -> (bool, String) {
    // A back end of our own would be needed to say nothing; this one is there.
    let output = Command::new("omniidl")
        .arg("-bdump")
        .args(options)
        .args(files)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.success(), said)
}

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rts-schemas-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn put(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn omniidl_accepts_and_refuses_the_same() {
    if !has_omniidl() {
        return;
    }
    let folder = Folder::new("omniidl");
    let put = |(number, case): (usize, String)| folder.put(&format!("case{number}.idl"), &case);
    let mut right: Vec<PathBuf> = ACCEPTED.lines().map(text).enumerate().map(put).collect();
    let stricter = cases(STRICTER).into_iter().map(|(_, case)| case);
    right.extend(
        stricter
            .filter(|case| !case.contains("CORBA::"))
            .enumerate()
            .map(|(n, case)| put((n + 1000, case))),
    );
    let (accepted, said) = omniidl(&right, &[]);
    assert!(accepted, "{said}");
    for (number, (_, case)) in cases(REFUSED).into_iter().enumerate() {
        let file = put((number + 2000, case.clone()));
        // Without directives there is no need for a preprocessor, which is a process of its own.
        let options: &[&str] = if case.contains('#') || case.contains("/*") {
            &[]
        } else {
            &["-N"]
        };
        let (accepted, said) = omniidl(&[file], options);
        assert!(!accepted, "{case}\n{said}");
    }
    for case in WIDER.map(text) {
        assert!(
            !omniidl(&[folder.put("wider.idl", &case)], &["-N"]).0,
            "{case}"
        );
    }
}

/// A back end of omniidl that prints each definition and its repository id.
const IDS: &str = r#"
def tell(node):
    if hasattr(node, "declarators"):
        for each in node.declarators():
            tell(each)
    elif hasattr(node, "repoId") and not hasattr(node, "definitions"):
        print("::".join(node.scopedName()), node.repoId())
    for parts in ("definitions", "contents"):
        if hasattr(node, parts):
            for each in getattr(node, parts)():
                tell(each)
def run(tree, args):
    for each in tree.declarations():
        tell(each)
"#;

#[test]
fn repository_ids_are_those_of_omniidl() {
    if !has_omniidl() {
        return;
    }
    let texts = [
        "#pragma prefix \"lab.org\"\nmodule M { struct A { long x; }; };\nstruct B { long x; };\n",
        "module M {\n#pragma prefix \"lab.org\"\nstruct A { long x; }; module N { enum E { one }; }; };\nmodule M { struct B { long x; }; };\n",
        "#pragma prefix \"a\"\nmodule M { module N {\n#pragma prefix \"b\"\nconst long X = 1; };\nconst long Y = 1;\n#pragma prefix \"\"\ntypedef long T; };\nexception Z { };\n",
        "module M { interface I { struct S { long x; }; };\n#pragma prefix \"c\"\ninterface J { struct S { long x; }; }; };\n",
        "module M {\n#include \"inner.idl\"\nstruct A { long x; }; };\n",
        "#pragma prefix \"d\"\n#include \"inner.idl\"\nmodule M { struct A { long x; };\n#pragma ID A \"IDL:own:1.0\"\nstruct B { long x; };\n#pragma version B 3.1\n};\n",
    ];
    let folder = Folder::new("ids");
    let inner = "struct Plain { long x; };\n#pragma prefix \"in\"\nstruct Inner { long x; };\n";
    folder.put("inner.idl", inner);
    folder.put("ids.py", IDS);
    for (number, text) in texts.into_iter().enumerate() {
        let file = folder.put(&format!("ids{number}.idl"), text);
        let output = Command::new("omniidl")
            .args(["-bids", "-p"])
            .args([&folder.0, &file])
            .output()
            .unwrap();
        let mut told: Vec<String> = String::from_utf8_lossy(&output.stdout)
            .lines()
            .map(str::to_owned)
            .collect();
        let read = read(
            "ids.idl",
            text.as_bytes(),
            &Files(vec![("inner.idl", inner)]),
        )
        .unwrap();
        let mut ours: Vec<String> = read
            .unit
            .definitions
            .iter()
            .filter(|it| it.file == "ids.idl" || it.file == "inner.idl")
            .map(|it| format!("{} {}", it.name(), it.repository_id))
            .collect();
        told.sort();
        ours.sort();
        assert!(!told.is_empty(), "{output:?}");
        assert_eq!(ours, told, "{text}");
    }
}

/// Files of a folder and of those that are searched.
struct Folders(Vec<PathBuf>);

impl Sources for Folders {
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String> {
        let beside = Path::new(include.from).parent().map(Path::to_path_buf);
        let all = beside
            .into_iter()
            .filter(|_| !include.angled)
            .chain(self.0.iter().cloned());
        for path in all.map(|folder| folder.join(include.name)) {
            if let Ok(bytes) = std::fs::read(&path) {
                let path = path.to_string_lossy().into_owned();
                return Ok(Some(Found { path, bytes }));
            }
        }
        Ok(None)
    }
}

/// Files of real users that are refused, and the codes of all that is said of them.
const WRONG: [(&str, &[&str]); 2] = [
    // It relies on another file being read before it.
    ("/ColorTrack.idl", &["idl-unknown-name"]),
    // The same, and native types.
    (
        "/rmp400Struct.idl",
        &[
            "idl-not-supported",
            "idl-not-supported",
            "idl-not-supported",
            "idl-not-supported",
            "idl-unknown-name",
        ],
    ),
];

#[test]
fn files_of_real_users_are_read() {
    let Some(corpus) = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from) else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let sources = Folders(vec![corpus.join("gen/stubs")]);
    let mut open = vec![corpus.join("gen")];
    let mut count = 0;
    while let Some(folder) = open.pop() {
        for path in std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
        {
            if path.is_dir() {
                open.push(path);
                continue;
            }
            if path.extension().is_none_or(|extension| extension != "idl") {
                continue;
            }
            count += 1;
            let name = path.to_string_lossy().into_owned();
            let read = read(&name, &std::fs::read(&path).unwrap(), &sources);
            let known = WRONG.iter().find(|(wrong, _)| name.ends_with(wrong));
            let found = read.err().unwrap_or_default();
            let codes: Vec<&str> = found.findings.iter().map(|f| f.code.as_str()).collect();
            assert_eq!(
                codes,
                known.map_or(&[][..], |(_, codes)| codes),
                "{name}\n{}",
                shown(&found)
            );
        }
    }
    assert!(count >= 13, "{count} files");
}

/// Files by their names.
struct Files(Vec<(&'static str, &'static str)>);

impl Sources for Files {
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String> {
        if include.name == "secret.idl" {
            return Err("permission denied".to_owned());
        }
        let found = self.0.iter().find(|(name, _)| *name == include.name);
        Ok(found.map(|(name, text)| Found {
            path: (*name).to_owned(),
            bytes: text.as_bytes().to_vec(),
        }))
    }
}

const COMMON: &str = "#ifndef COMMON\n#define COMMON\n#pragma prefix \"common.org\"\n\
    module Common { struct Point { double x, y; }; const long COUNT = 3; };\n#endif\n";

#[test]
fn what_is_read_is_all_there() {
    let text = "#pragma prefix \"lab.org\"\n#include <common.idl>\n#include \"common.idl\"\nmodule Arm {\n\
        enum Mode { IDLE, BUSY };\n\
        struct Node; typedef sequence<Node> Nodes; struct Node { string<8> name; Nodes children; };\n\
        union Value switch (Mode) { case IDLE: case BUSY: long number; };\n\
        exception Refused { string why; };\n\
        typedef Common::Point Path[Common::COUNT][2];\n\
        interface Base { readonly attribute long count; };\n\
        interface Move : Base { oneway void stop(); boolean go(in Path way, inout Nodes all) raises (Refused); };\n\
        const Mode FIRST = BUSY; const unsigned long MASK = ~0 << 4 & 0xff; const string NAME = \"a\" \"b\";\n\
        #pragma version Move 2.1\n};\nmodule Arm { typedef Value Again; };\n";
    let read = read(
        "arm.idl",
        text.as_bytes(),
        &Files(vec![("common.idl", COMMON)]),
    )
    .unwrap();
    assert_eq!(read.findings.findings, []);
    insta::assert_debug_snapshot!(read.unit);
}

#[test]
fn definitions_are_found_by_id_and_name() {
    let text = "module RTC { struct TimedLong { long data; }; struct Twice { long x; }; };\n\
        module M { struct Twice { long x; }; };\n#pragma ID M::Twice \"LOCAL:twice\"\n";
    let unit = read("f.idl", text.as_bytes(), &NoSources).unwrap().unit;
    let found = |name| unit.find(name).map(|index| unit.definitions[index].name());
    for name in [
        "RTC::TimedLong",
        "::RTC::TimedLong",
        "TimedLong",
        "IDL:RTC/TimedLong:1.0",
    ] {
        assert_eq!(found(name).as_deref(), Some("RTC::TimedLong"), "{name}");
    }
    assert_eq!(found("LOCAL:twice").as_deref(), Some("M::Twice"));
    for name in ["Twice", "timedlong", "RTC", "", "IDL:M/Twice:1.0"] {
        assert_eq!(found(name), None, "{name}");
    }
}

#[test]
fn files_that_cannot_be_included_are_told() {
    let files = Files(vec![
        ("cycle.idl", "#include \"cycle.idl\"\nconst long x = 1;\n"),
        ("wrong.idl", "struct S { lng x; };\n"),
        ("open.idl", "module M {\n#if 1\n"),
        ("binary.idl", "\0\u{1}"),
    ]);
    let text = "#include \"secret.idl\"\n#include <missing.idl>\n#include other.idl\n#include \"wrong.idl\"\n\
        #include \"binary.idl\"\n#include \"open.idl\"\n};\n#include \"cycle.idl\"\n";
    insta::assert_snapshot!(shown(&read("f.idl", text.as_bytes(), &files).unwrap_err()));
}

#[test]
fn every_mistake_of_a_file_is_told() {
    let text = "module M {\n  struct Pose {\n    double x y;\n    dubble z;\n    long count\n  };\n\n  enum Mode { A, B, 3 };\n\
        \n  typedef sequence<Pose T;\n  const short LIMIT = 70000;\n\n  interface Move {\n    void go(Pose p);\n\
        \x20   long stop() raises (Nothing);\n    oneway long now();\n    attribute Pose;\n  };\n}\n\nstruct Last { M::Pose p; };\n";
    insta::assert_snapshot!(shown(
        &read("f.idl", text.as_bytes(), &NoSources).unwrap_err()
    ));
}

/// The codes of what is said of a text.
fn codes(text: &str) -> Vec<String> {
    let report = match read("f.idl", text.as_bytes(), &NoSources) {
        Ok(read) => read.findings,
        Err(report) => report,
    };
    report
        .findings
        .into_iter()
        .map(|finding| finding.code)
        .collect()
}

#[test]
fn what_is_too_much_is_refused() {
    let nested = |open: &str, inner: &str, close: &str| {
        format!("{}{inner}{}", open.repeat(10_000), close.repeat(10_000))
    };
    let numbered =
        |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let cases = [
        nested("module M { ", "", "};"),
        nested("struct S { ", "long x;", "} s;"),
        format!("const long x = {};", nested("(", "1", ")")),
        format!("typedef {} T;", nested("sequence<", "long", "> ")),
        format!("#if {}\n#endif\n", nested("(", "1", ")")),
        nested("#if 1\n", "", "#endif\n"),
        format!("#define A {}\n", "a ".repeat(5000)),
        format!(
            "{}const long x = A40;",
            numbered(40, &|n| format!("#define A{} A{n} A{n}\n", n + 1))
        ),
        format!(
            "#define A0\n{}const long x = 1; A4",
            numbered(4, &|n| format!(
                "#define A{} {}\n",
                n + 1,
                format!("A{n} ").repeat(900)
            ))
        ),
        format!(
            "struct A0 {{ long x; }};{}",
            numbered(100, &|n| format!("struct A{} {{ A{n} x; }};", n + 1))
        ),
        format!(
            "typedef long A0;{}",
            numbered(100, &|n| format!("typedef A{n} A{};", n + 1))
        ),
        format!(
            "struct A0 {{ long x; }};{}",
            numbered(40, &|n| format!("struct A{} {{ A{n} x, y; }};", n + 1))
        ),
        format!(
            "interface A0 {{}};{}",
            numbered(300, &|n| format!("interface A{} : A{n} {{}};", n + 1))
        ),
        "typedef long A[65536][65536];".to_owned(),
    ];
    for case in &cases {
        let codes = codes(case);
        let shown: String = case.chars().take(60).collect();
        assert!(
            codes.iter().any(|code| code == "idl-too-large"),
            "{shown}: {codes:?}"
        );
    }
    let members: Vec<String> = (0..20_000).map(|n| format!("a{n}")).collect();
    let dense = [
        format!("struct S {{ long {}; }};", members.join(",")),
        format!("enum E {{ {} }};", members.join(",")),
        format!(
            "module {} {{ {} }};",
            "M".repeat(5000),
            numbered(5000, &|n| format!("const long a{n} = 1;"))
        ),
    ];
    for case in &dense {
        let found = codes(case);
        assert!(found.iter().any(|code| code == "too-dense"), "{found:?}");
    }
    assert_eq!(codes(&"x".repeat((1 << 20) + 1)), ["too-large"]);
    let many = codes(&"long x;\n".repeat(1000));
    assert_eq!(
        (many.len(), many.last().map(String::as_str)),
        (101, Some("too-many-problems"))
    );
}

#[test]
fn the_types_of_openrtm_are_all_there() {
    let mut said = String::new();
    for (name, _) in Standard::files() {
        let text = format!("#include <rtm/idl/{name}>\n#include \"{name}\"\n");
        let read = read("f.idl", text.as_bytes(), &standard()).unwrap();
        assert_eq!(read.findings.findings, []);
        let own = read
            .unit
            .definitions
            .iter()
            .filter(|definition| definition.file.ends_with(name));
        let structs = own
            .filter(|definition| matches!(definition.kind, Kind::Struct(_)))
            .count();
        said += &format!("{name}: {structs} structs\n");
        if has_omniidl() {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("idl").join(name);
            let (accepted, said) = omniidl(&[path], &[]);
            assert!(accepted && said.is_empty(), "{said}");
        }
    }
    insta::assert_snapshot!(said, @r"
    BasicDataType.idl: 26 structs
    ExtendedDataTypes.idl: 56 structs
    InterfaceDataTypes.idl: 44 structs
    ");
}

/// An IDL file with everything that has a Rust type, and what is generated of it: a test of `rts-runtime` compiles it.
#[test]
fn generated_rust_is_what_is_compiled() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../agent/runtime/tests/generated");
    let text = std::fs::read(folder.join("lab.idl")).unwrap();
    let read =
        read("lab.idl", &text, &standard()).unwrap_or_else(|report| panic!("{}", shown(&report)));
    let code = idl::rust::generate(&read.unit, &["lab.idl"]);
    let left_out = code.left_out.iter();
    let left_out: Vec<String> = left_out
        .map(|left_out| {
            format!(
                "{}: {}",
                read.unit.definitions[left_out.definition].name(),
                left_out.reason
            )
        })
        .collect();
    insta::assert_debug_snapshot!(left_out);
    is_current(&folder.join("lab.rs"), &code.text);
}

/// The types of OpenRTM that the runtime has.
#[test]
fn generated_types_of_openrtm_are_those_of_the_runtime() {
    let include = |(name, _)| format!("#include <rtm/idl/{name}>\n");
    let text: String = Standard::files().map(include).collect();
    let read = read("openrtm.idl", text.as_bytes(), &standard()).unwrap();
    let files: Vec<String> = Standard::files()
        .map(|(name, _)| format!("rtm/idl/{name}"))
        .collect();
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let code = idl::rust::generate(&read.unit, &files);
    assert!(code.left_out.is_empty(), "{:?}", code.left_out);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../agent/runtime/src/types/openrtm.rs");
    is_current(&file, &code.text);
}

fn is_current(file: &Path, text: &str) {
    if std::fs::read_to_string(file).unwrap_or_default() != text {
        let new = file.with_extension("rs.new");
        std::fs::write(&new, text).unwrap();
        let (file, new) = (file.display(), new.display());
        panic!("{file} is no longer what is generated: look at {new}, and put it in its place");
    }
}
