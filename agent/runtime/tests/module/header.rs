//! The C header is what the ABI's Rust source says, and a C and a C++ compiler lay it out in the same way.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fmt::Write;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::Command;

use rts_runtime::abi::{
    self, Buffer, Host, Loan, Module, Parameter, Port, Service, Text, callback,
};

const HEADER: &str = "include/rtsctl/rts_module.h";
/// Set, the header is written instead of compared.
const WRITE: &str = "RTSCTL_WRITE_HEADER";

const NAMES: [(&str, &str); 9] = [
    ("Text", "rts_text_t"),
    ("Buffer", "rts_buffer_t"),
    ("Loan", "rts_loan_t"),
    ("Port", "rts_port_t"),
    ("Service", "rts_service_t"),
    ("Parameter", "rts_parameter_t"),
    ("Module", "rts_module_t"),
    ("Host", "rts_host_t"),
    ("Entry", "rts_entry_t"),
];

const HEAD: &str = "\
/* The interface between rtsctl's managers and modules, version 1. docs/abi.md explains it.
 *
 * Made of agent/runtime/src/abi.rs; do not edit. C11 and C++11. */";

const HELPERS: &str = r#"
#if defined(__GNUC__)
#define RTS_EXPORT __attribute__((visibility("default")))
#else
#define RTS_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** The one function that a module exports. */
RTS_EXPORT const rts_module_t *rts_module_v1(void);

/** A text that ends with a zero, as the interface has it. */
static inline rts_text_t rts_text(const char *text) {
  rts_text_t lent;
  lent.data = (const uint8_t *)text;
  lent.len = strlen(text);
  return lent;
}

#ifdef __cplusplus
}
#endif

/** Whether a struct of the other side goes as far as a field: RTS_HAS(rts_host_t, host, publish). */
#define RTS_HAS(type, it, field) ((it)->size >= offsetof(type, field) + sizeof((it)->field))

#ifdef __cplusplus
#define RTS_STATIC_ASSERT(what) static_assert(what, #what)
#else
#define RTS_STATIC_ASSERT(what) _Static_assert(what, #what)
#endif

/* What both sides must agree on. */
#if UINTPTR_MAX == UINT64_MAX
"#;

macro_rules! layout {
    ($out:expr, $($type:ident $name:literal: $($field:ident)*;)*) => {$(
        writeln!($out, "RTS_STATIC_ASSERT(sizeof({}) == {});", $name, size_of::<$type>()).unwrap();
        $(
            let field = stringify!($field);
            let field = if field == "default" { "default_value" } else { field };
            let offset = offset_of!($type, $field);
            writeln!($out, "RTS_STATIC_ASSERT(offsetof({}, {field}) == {offset});", $name).unwrap();
        )*
    )*};
}

fn layout() -> String {
    let mut out = String::new();
    layout!(
        out,
        Text "rts_text_t": data len;
        Buffer "rts_buffer_t": abi_version size type_id encoding data len;
        Loan "rts_loan_t": abi_version size token data len;
        Port "rts_port_t": abi_version size name type_id direction;
        Service "rts_service_t": abi_version size port name interface_id polarity;
        Parameter "rts_parameter_t": abi_version size name default value_type unit constraint description;
        Module "rts_module_t": abi_version size type_name vendor category version description idl default_rate
            execution_kind activity_type max_instances actions ports ports_len parameters parameters_len services
            services_len create destroy callback configure;
        Host "rts_host_t": abi_version size context log fail now rate wake write read is_new loan publish discard;
    );
    out
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn header() -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: true,
        style: cbindgen::Style::Both,
        header: Some(HEAD.to_owned()),
        include_guard: Some("RTSCTL_RTS_MODULE_H".to_owned()),
        no_includes: true,
        sys_includes: ["stddef.h", "stdint.h", "string.h"]
            .map(str::to_owned)
            .into(),
        usize_is_size_t: true,
        documentation_style: cbindgen::DocumentationStyle::C99,
        line_length: 100,
        ..cbindgen::Config::default()
    };
    config.export.prefix = Some("RTS_".to_owned());
    config.export.renaming_overrides_prefixing = true;
    config.export.rename = NAMES
        .map(|(from, to)| (from.to_owned(), to.to_owned()))
        .into();
    config.export.include = NAMES.map(|(from, _)| from.to_owned()).into();
    let mut text = Vec::new();
    cbindgen::Builder::new()
        .with_src(folder().join("src/abi.rs"))
        .with_config(config)
        .generate()
        .expect("the source is Rust")
        .write(&mut text);
    let text = String::from_utf8(text).expect("UTF-8");
    let text = links(&text);
    // A name that C keeps for itself.
    let text = text.replace("rts_text_t default_;", "rts_text_t default_value;");
    let text = text.replace("rts_text_t default;", "rts_text_t default_value;");
    let end = text.rfind("#endif").expect("an include guard");
    format!(
        "{}{HELPERS}{}#endif\n\n{}",
        &text[..end],
        layout(),
        &text[end..]
    )
}

/// Links of the Rust documentation, as C has their names.
fn links(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in text.split("[`").enumerate() {
        let is_constant = part.starts_with(|c: char| c.is_ascii_uppercase())
            && part.chars().nth(1).is_some_and(|c| c.is_ascii_uppercase());
        let member = NAMES.iter().find_map(|(rust, c)| {
            let rest = part.strip_prefix(rust)?;
            Some(format!(
                "{c}{}",
                rest.strip_prefix("::")
                    .map_or(rest.to_owned(), |rest| format!(".{rest}"))
            ))
        });
        match member {
            Some(member) if index > 0 => out += &member,
            _ if index > 0 && is_constant => out += &format!("RTS_{part}"),
            _ => out += part,
        }
    }
    out.replace("`]", "").replace('`', "")
}

#[test]
fn the_c_header_is_what_the_rust_source_says() {
    let made = header();
    let path = folder().join(HEADER);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    assert!(
        made == kept,
        "{} is not up to date: {WRITE}=1 cargo test -p rts-runtime --test module header",
        path.display()
    );
    for name in ["ON_CONFIGURED 12", "PORT_CONNECTION_LOST 12", "ALL_ACTIONS"] {
        assert!(made.contains(&format!("#define RTS_{name}")), "{name}");
    }
    assert_eq!(abi::ALL_ACTIONS, (1 << callback::CALLBACKS) - 1);
}

#[test]
fn compilers_of_c_and_of_cpp_accept_the_header_with_all_warnings() {
    let folder = tempfile::tempdir().unwrap();
    for (language, standard) in [("c", "-std=c11"), ("c++", "-std=c++11")] {
        let source = folder.path().join("it.c");
        std::fs::write(&source, "#include <rtsctl/rts_module.h>\n").unwrap();
        let done = compile(&source, language, standard);
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
    }
}

fn compile(source: &Path, language: &str, standard: &str) -> std::process::Output {
    Command::new("cc")
        .args([
            "-x",
            language,
            standard,
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
        ])
        .args(["-fsyntax-only", "-I"])
        .arg(folder().join("include"))
        .arg(source)
        .output()
        .expect("a compiler")
}
