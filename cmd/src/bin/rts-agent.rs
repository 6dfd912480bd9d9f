//! The agent of a node.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use rts_agent::Config;

/// Runs the components of one node: starts managers, carries out plans, and says what really runs.
#[derive(Debug, Parser)]
#[command(name = "rts-agent", version)]
struct Args {
    /// Folder of sockets, state and logs.
    #[arg(long, env = "RTSCTL_HOME", value_name = "DIR")]
    home: PathBuf,
    /// Name of this node.
    #[arg(long, default_value = Config::LOCAL_NODE)]
    node: String,
    /// Further host name by which profiles may mean this node; may be repeated.
    #[arg(long = "alias", value_name = "NAME")]
    aliases: Vec<String>,
    /// Folders with modules, separated by colons [default: the folder of this program].
    #[arg(long, env = "RTSCTL_MODULE_PATH", value_name = "DIRS")]
    module_path: Option<String>,
    /// Manager program [default: rts-manager beside this program].
    #[arg(long, value_name = "FILE")]
    manager_program: Option<PathBuf>,
    /// Socket of the controller [default: run/controller.sock in the home].
    #[arg(long, value_name = "SOCKET", conflicts_with = "no_controller")]
    controller: Option<PathBuf>,
    /// Run without a controller.
    #[arg(long)]
    no_controller: bool,
    /// Manager processes that are kept ready for the next start, 0 to 2.
    #[arg(
        long,
        env = "RTSCTL_IDLE_MANAGERS",
        value_name = "N",
        default_value_t = Config::MOST_IDLE,
        value_parser = clap::value_parser!(u8).range(..=i64::from(Config::MOST_IDLE))
    )]
    idle_managers: u8,
    /// Spawn each manager anew instead of forking it from one that is warm: then each has an address space laid out by chance of its own.
    #[arg(long, env = "RTSCTL_NO_ZYGOTE", value_parser = clap::builder::FalseyValueParser::new())]
    no_zygote: bool,
    /// Serve whoever started this program over its standard input and output, until they are closed: for nodes that are
    /// reached by SSH alone.
    #[arg(long, conflicts_with_all = ["controller", "no_controller"])]
    stdio: bool,
}

impl Args {
    fn config(self, program: &Path) -> Config {
        let beside = program.parent().unwrap_or(Path::new("."));
        let controller = self
            .controller
            .unwrap_or_else(|| self.home.join("run/controller.sock"));
        let module_path = match self.module_path.filter(|path| !path.is_empty()) {
            Some(path) => std::env::split_paths(&path).collect(),
            None => vec![beside.to_owned()],
        };
        Config {
            home: self.home,
            node: self.node,
            aliases: self.aliases,
            module_path,
            manager_program: self
                .manager_program
                .unwrap_or_else(|| beside.join("rts-manager")),
            controller_socket: (!self.no_controller).then_some(controller),
            heal_after: Some(Config::HEAL_AFTER),
            idle_managers: (!self.no_zygote).then_some(self.idle_managers),
        }
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    rtsctl::daemon::observe();
    let outcome = std::env::current_exe()
        .map_err(anyhow::Error::from)
        .and_then(|program| match args.stdio {
            true => Ok(rts_agent::run_stdio(args.config(&program))?),
            false => Ok(rts_agent::run(args.config(&program))?),
        });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            tracing::error!("{e:#}");
            ExitCode::FAILURE
        }
    }
}
