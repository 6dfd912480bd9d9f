//! The help of every verb, and the reference made of it.

use std::path::Path;

use clap::CommandFactory;
use rtsctl::cli::Cli;

/// Every verb's `--help` in one text, so that a change is seen.
#[test]
fn help_is_as_reviewed() {
    let mut text = String::new();
    help("rtsctl", &mut Cli::command(), &mut text);
    insta::assert_snapshot!(text);
}

fn help(path: &str, command: &mut clap::Command, text: &mut String) {
    let long = command.render_long_help().to_string();
    text.push_str(&format!("$ {path} --help\n{long}\n"));
    let names: Vec<_> = command
        .get_subcommands()
        .filter(|sub| !sub.is_hide_set() && sub.get_name() != "help")
        .map(|sub| sub.get_name().to_owned())
        .collect();
    for name in names {
        if let Some(sub) = command.find_subcommand_mut(&name) {
            help(&format!("{path} {name}"), sub, text);
        }
    }
}

#[test]
fn arguments_are_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn the_reference_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/cli.md");
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    let wanted = rtsctl::commands::docs::markdown();
    assert!(
        stored == wanted,
        "docs/cli.md is not what the program says: run `cargo run -p rtsctl -- docs > docs/cli.md`"
    );
}
