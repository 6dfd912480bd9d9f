//! `rtsctl node add`.

use std::ffi::OsString;
use std::path::PathBuf;

use rts_ssh::{Destination, HostKeys};
use serde::Deserialize;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::HomeLock;
use crate::local::nodes::{NodeSetup, Nodes, SshNode};
use crate::local::relays;
use crate::local::up::{Wish, ensure};
use crate::session::Session;

/// Longest manifest in bytes.
const MAX_FILE: u64 = 1024 * 1024;

/// Add a node that is reached by SSH alone
///
/// Programs are copied there once, by digest, and an agent runs there for as long as a command needs it: there is no daemon, and
/// between commands nothing there is healed. Components go on. `ssh`, its settings and its agent are the user's own; nobody is
/// asked for a password.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Whom to reach
    #[arg(
        long,
        value_name = "[USER@]HOST[:PORT]",
        required_unless_present = "file"
    )]
    ssh: Option<Destination>,
    /// A manifest of kind Node instead (`-` is standard input)
    #[arg(short, long, value_name = "FILE", conflicts_with = "ssh")]
    file: Option<PathBuf>,
    /// Name of the node [default: the host's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// A host of profiles that means this node; may be repeated
    #[arg(long = "alias", value_name = "HOST")]
    aliases: Vec<String>,
    /// TCP port
    #[arg(long, value_name = "PORT", requires = "ssh")]
    port: Option<u16>,
    /// Private key; no other one is offered then
    #[arg(long, value_name = "FILE", requires = "ssh")]
    identity: Option<PathBuf>,
    /// Settings of `ssh` instead of the user's
    #[arg(long, value_name = "FILE", requires = "ssh")]
    ssh_config: Option<PathBuf>,
    /// Take a host key that is not known, and remember it; one that has changed is refused all the same
    #[arg(long, requires = "ssh")]
    accept_new: bool,
    /// Folders of this machine that are searched for the node's modules, separated by colons [env: RTSCTL_MODULE_PATH]
    /// [default: that of the programs]
    #[arg(long, value_name = "DIRS", env = "RTSCTL_MODULE_PATH", hide_env = true)]
    module_path: Option<OsString>,
    /// Folder of this machine with rts-agent and rts-manager for the node's machine [default: that of rtsctl]
    #[arg(long, value_name = "DIR")]
    programs: Option<PathBuf>,
    /// Seconds for which the session is kept when no command needs it [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    keep: Option<u64>,
}

/// A manifest of a node.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Manifest {
    api_version: String,
    kind: String,
    metadata: Name,
    spec: Spec,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Name {
    name: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Spec {
    transport: String,
    ssh: Destination,
    #[serde(default)]
    aliases: Vec<String>,
    #[serde(default)]
    module_path: Option<Vec<PathBuf>>,
    #[serde(default)]
    programs: Option<PathBuf>,
    #[serde(default)]
    keep_seconds: Option<u64>,
}

/// Reaches it, and remembers it then.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let node = match &args.file {
        Some(file) => of_manifest(args, &read(file)?)?,
        None => of_flags(args)?,
    };
    let name = &node.name;
    let before = Nodes::known(&session.home)?.named(name).cloned();
    if let Some(before) = &before {
        same_machine(before, &node)?;
        // What is said now is tried, not what a session of before was opened with.
        relays::stop(&session.home, name);
    }
    let wish = Wish {
        module_path: None,
        nodes: vec![node.clone()],
    };
    if let Err(e) = ensure(session, wish).await {
        let _lock = HomeLock::take(&session.home)?;
        Nodes::take_back(&session.home, &node, before.as_ref())?;
        return Err(e);
    }
    let destination = node.ssh.as_ref().map(|ssh| ssh.destination.to_string());
    let destination = destination.unwrap_or_default();
    session.out.result(&format!(
        "node/{name} added: reached by SSH ({destination})"
    ))?;
    Ok(Exit::Ok)
}

/// A name means one machine: what runs on another one would be lost sight of.
fn same_machine(before: &NodeSetup, now: &NodeSetup) -> Result<(), CliError> {
    let account = |node: &NodeSetup| {
        let destination = node.ssh.as_ref().map(|ssh| &ssh.destination);
        destination.map(|d| (d.host.clone(), d.user.clone(), d.port, d.config.clone()))
    };
    let name = &now.name;
    match &before.ssh {
        None => Err(CliError::usage_help(
            format!("there is a node {name} already, an agent of this machine"),
            "say another name with --name",
        )),
        Some(ssh) if account(before) != account(now) => Err(CliError::usage_help(
            format!(
                "there is a node {name} already, reached by SSH ({})",
                ssh.destination
            ),
            format!("`rtsctl node remove {name}` first, or say another name with --name"),
        )),
        Some(_) => Ok(()),
    }
}

fn of_flags(args: &Args) -> Result<NodeSetup, CliError> {
    let mut destination = args.ssh.clone().ok_or_else(|| usage("--ssh is missing"))?;
    destination.port = args.port.or(destination.port);
    destination.identity = args.identity.clone().map(absolute).or(destination.identity);
    destination.config = args.ssh_config.clone().map(absolute).or(destination.config);
    if args.accept_new {
        destination.host_keys = HostKeys::AcceptNew;
    }
    let name = match &args.name {
        Some(name) => name.clone(),
        None => node_name(&destination.host),
    };
    let path = args.module_path.as_ref().filter(|path| !path.is_empty());
    sound(NodeSetup {
        name,
        aliases: Some(args.aliases.clone()),
        ssh: Some(SshNode {
            destination,
            module_path: path.map(|path| std::env::split_paths(path).map(absolute).collect()),
            programs: args.programs.clone().map(absolute),
            keep_seconds: args.keep,
        }),
    })
}

fn of_manifest(args: &Args, text: &str) -> Result<NodeSetup, CliError> {
    let manifest: Manifest =
        serde_yaml::from_str(text).map_err(|e| usage(&format!("the manifest is no Node: {e}")))?;
    if manifest.api_version != "rtsctl.dev/v1" || manifest.kind != "Node" {
        return Err(usage("the manifest is not of kind Node of rtsctl.dev/v1"));
    }
    if manifest.spec.transport != "ssh" {
        let text = format!(
            "the transport {:?} is not known: `ssh` is",
            manifest.spec.transport
        );
        return Err(usage(&text));
    }
    manifest.spec.ssh.check().map_err(|e| usage(&e))?;
    let mut aliases = manifest.spec.aliases;
    aliases.extend(args.aliases.iter().cloned());
    sound(NodeSetup {
        name: args.name.clone().unwrap_or(manifest.metadata.name),
        aliases: Some(aliases),
        ssh: Some(SshNode {
            destination: manifest.spec.ssh,
            module_path: manifest
                .spec
                .module_path
                .map(|path| path.into_iter().map(absolute).collect()),
            programs: manifest.spec.programs.map(absolute),
            keep_seconds: args
                .keep
                .or(manifest.spec.keep_seconds.map(|keep| keep.clamp(1, 86_400))),
        }),
    })
}

/// A name that the controller takes, and hosts that can be hosts.
fn sound(node: NodeSetup) -> Result<NodeSetup, CliError> {
    let words = format!("{}={}", node.name, node.hosts().join(","));
    words.parse::<NodeSetup>().map_err(|e| usage(&e))?;
    if !rts_schemas::names::is_dns_label(&node.name) {
        return Err(usage(&format!(
            "{:?} is no name of a node: 1 to 63 of a-z, 0-9 and -; say another one with --name",
            node.name
        )));
    }
    Ok(node)
}

/// A node's name from that of a host: the first part, as a DNS label.
fn node_name(host: &str) -> String {
    let first = match host.parse::<std::net::IpAddr>() {
        Ok(_) => host,
        Err(_) => host.split('.').next().unwrap_or(host),
    };
    let label = first
        .to_ascii_lowercase()
        .replace(|c: char| !c.is_ascii_alphanumeric(), "-");
    label.trim_matches('-').chars().take(63).collect()
}

fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

fn usage(text: &str) -> CliError {
    CliError::usage_help(text.to_owned(), "`rtsctl node add --help` shows how")
}

fn read(file: &PathBuf) -> Result<String, CliError> {
    use std::io::Read;
    let mut text = String::new();
    let read = match file.as_os_str() == "-" {
        true => std::io::stdin().take(MAX_FILE).read_to_string(&mut text),
        false => {
            std::fs::File::open(file).and_then(|file| file.take(MAX_FILE).read_to_string(&mut text))
        }
    };
    match read {
        Ok(_) => Ok(text),
        Err(e) => Err(usage(&format!("cannot read {}: {e}", file.display()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_gives_its_node_a_name() {
        for (host, name) in [
            ("robot1.local", "robot1"),
            ("10.0.0.5", "10-0-0-5"),
            ("Arm_2", "arm-2"),
        ] {
            assert_eq!(node_name(host), name);
        }
    }

    #[test]
    fn the_schema_knows_what_is_read() {
        let schema = include_str!("../../../../docs/schema/node.json");
        let schema: serde_json::Value = serde_json::from_str(schema).unwrap();
        let spec = &schema["properties"]["spec"]["properties"];
        let keys = |of: &serde_json::Value| {
            let keys = of.as_object().unwrap().keys().cloned();
            keys.collect::<std::collections::BTreeSet<_>>()
        };
        // What it does not know is refused with a list of what it does.
        let unknown = |place: &str| {
            let text = format!("apiVersion: x\nkind: Node\nmetadata: {{name: a}}\nspec: {place}\n");
            serde_yaml::from_str::<Manifest>(&text)
                .unwrap_err()
                .to_string()
        };
        for (place, known) in [
            ("{nonsense: 1}", keys(spec)),
            ("{ssh: {nonsense: 1}}", keys(&spec["ssh"]["properties"])),
        ] {
            let error = unknown(place);
            let (_, listed) = error.split_once("expected one of").unwrap_or(("", &error));
            for key in &known {
                assert!(listed.contains(&format!("`{key}`")), "{key}: {error}");
            }
            assert_eq!(listed.matches('`').count(), 2 * known.len(), "{error}");
        }
    }

    #[test]
    fn a_manifest_says_what_flags_say() {
        use clap::Parser;
        #[derive(Parser)]
        struct Line {
            #[command(flatten)]
            args: Args,
        }
        let parse = |words: &[&str]| Line::parse_from([&["x"], words].concat()).args;
        let flags = [
            "--ssh",
            "me@robot:2222",
            "--name",
            "arm",
            "--alias",
            "robot1",
            "--programs",
            "/p",
            "--keep",
            "5",
        ];
        let by_flags = of_flags(&parse(&flags)).unwrap();
        let text = "apiVersion: rtsctl.dev/v1\nkind: Node\nmetadata: {name: arm}\nspec:\n  transport: ssh\n  ssh: {user: me, host: robot, port: 2222}\n  aliases: [robot1]\n  programs: /p\n  keepSeconds: 5\n";
        let args = parse(&["-f", "node.yaml"]);
        assert_eq!(of_manifest(&args, text).unwrap(), by_flags);
        for wrong in [
            text.replace("Node", "Pod"),
            text.replace("transport: ssh", "transport: carrier-pigeon"),
            text.replace("host: robot", "host: -x"),
        ] {
            assert_eq!(of_manifest(&args, &wrong).unwrap_err().exit().code(), 2);
        }
    }
}
