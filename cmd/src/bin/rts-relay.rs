//! The relay of a node that is reached by SSH. Everything it does is in `rts_relay`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use clap::Parser;
use rts_relay::Config;
use rtsctl::local::home::Home;
use rtsctl::local::nodes::Nodes;

/// Reaches one node by SSH for as long as commands need it, and some time more.
#[derive(Debug, Parser)]
#[command(name = "rts-relay", version)]
struct Args {
    /// Folder of sockets, state and logs.
    #[arg(long, env = "RTSCTL_HOME", value_name = "DIR")]
    home: PathBuf,
    /// Name of the node, which the home knows.
    #[arg(long)]
    node: String,
    /// Folders with modules, separated by colons, unless the node has some of its own [default: the folder of this program].
    #[arg(long, env = "RTSCTL_MODULE_PATH", value_name = "DIRS")]
    module_path: Option<String>,
}

impl Args {
    fn config(self) -> anyhow::Result<Config> {
        let program = std::env::current_exe().context("cannot find this program")?;
        let beside = program
            .parent()
            .unwrap_or(std::path::Path::new("/"))
            .to_owned();
        let home = Home::settle(Some(self.home))?;
        let nodes = Nodes::of(&home)?;
        let node = nodes.by_ssh().find(|node| node.name == self.node);
        let node = node.with_context(|| format!("node {} is not reached by SSH", self.node))?;
        let ssh = node.ssh.clone().context("it is not reached by SSH")?;
        let said = self.module_path.filter(|path| !path.is_empty());
        let said = said.map(|path| std::env::split_paths(&path).collect());
        let keep = ssh.keep_seconds.map_or(Config::KEEP, Duration::from_secs);
        Ok(Config {
            home: home.path().to_owned(),
            node: node.name.clone(),
            aliases: node.hosts().to_vec(),
            destination: ssh.destination,
            module_path: ssh
                .module_path
                .or(said)
                .unwrap_or_else(|| vec![beside.clone()]),
            programs: ssh.programs.unwrap_or(beside),
            keep: keep.min(Config::LONGEST),
        })
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    rtsctl::daemon::observe();
    let config = match args.config() {
        Ok(config) => config,
        Err(e) => {
            println!(
                "{}",
                serde_json::json!({ "ready": false, "error": format!("{e:#}") })
            );
            return ExitCode::FAILURE;
        }
    };
    match rts_relay::run(&config) {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
