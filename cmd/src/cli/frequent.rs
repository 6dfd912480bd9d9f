//! A short way to the arguments of the verbs that are used all the time: to describe all verbs to the parser takes longer
//! than the rest of a start. What is not read here, help and mistakes included, is read by the whole, so that nobody sees
//! a difference.

use std::ffi::OsString;

use clap::{Parser, Subcommand};

use super::{Cli, Command, Globals, apply, diff, get, teardown};

/// The command line with these verbs alone.
#[derive(Debug, Parser)]
#[command(name = "rtsctl")]
struct Frequent {
    #[command(flatten)]
    globals: Globals,
    #[command(subcommand)]
    verb: Verb,
}

/// Only the one that is named is described.
#[derive(Debug, Subcommand)]
#[command(defer = true)]
enum Verb {
    Apply(apply::Args),
    Diff(diff::Args),
    Get(get::Args),
    #[command(alias = "delete")]
    Teardown(teardown::Args),
}

/// Their names, and those of aliases.
const NAMES: [&str; 5] = ["apply", "diff", "get", "teardown", "delete"];

/// Reads the arguments of a frequent verb; none when that is no such, or they are to be read by the whole.
pub(super) fn read(arguments: impl Iterator<Item = OsString>) -> Option<Cli> {
    let arguments: Vec<OsString> = arguments.collect();
    // Options of every verb may stand before it, their values too.
    let named = |word: &OsString| NAMES.iter().any(|name| word.as_os_str() == *name);
    if !arguments.iter().any(named) {
        return None;
    }
    let Frequent { globals, verb } = Frequent::try_parse_from(arguments).ok()?;
    let command = match verb {
        Verb::Apply(args) => Command::Apply(args),
        Verb::Diff(args) => Command::Diff(args),
        Verb::Get(args) => Command::Get(args),
        Verb::Teardown(args) => Command::Teardown(args),
    };
    Some(Cli { globals, command })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_words(line: &str) -> Option<Cli> {
        read(line.split_whitespace().map(OsString::from))
    }

    /// What is read the short way is what the whole reads.
    #[test]
    fn the_short_way_reads_the_same() {
        for line in [
            "rtsctl apply a.xml -f b.yaml --timeout 5s --stand-ins --no-restart",
            "rtsctl --home apply -q apply --timings a.xml",
            "rtsctl apply --dry-run -o json a.xml",
            "rtsctl diff a.xml",
            "rtsctl get components -o wide -w",
            "rtsctl get --controller /s nodes local",
            "rtsctl teardown --yes --forget-node n1 --forget-node n2 ten",
            "rtsctl delete ten -y -vv",
        ] {
            let short = read_words(line).unwrap_or_else(|| panic!("not read: {line}"));
            let whole = Cli::try_parse_from(line.split_whitespace());
            let whole = whole.unwrap_or_else(|e| panic!("{line}: {e}"));
            assert_eq!(format!("{short:?}"), format!("{whole:?}"), "{line}");
        }
    }

    #[test]
    fn help_mistakes_and_other_verbs_are_for_the_whole() {
        for line in [
            "rtsctl",
            "rtsctl up",
            "rtsctl help apply",
            "rtsctl apply --help",
            "rtsctl apply",
            "rtsctl apply a.xml --no-such-option",
            "rtsctl describe apply",
            "rtsctl --version apply",
        ] {
            assert!(read_words(line).is_none(), "{line}");
        }
    }
}
