//! `rtsctl manager`: the manager service for people.

mod create;
mod place;

use rts_agent_api::messages::{Factory, ModuleRequest};
use rts_controller_api::objects::Kind;

use super::get::{Format, FormatArgs, Selection, show};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;
use crate::show::table::Table;

/// Work with manager processes by hand: load modules, create and delete components
///
/// What is made by hand belongs to no system and is shown as drift.
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    List(ListArgs),
    /// Load the module of a type into a manager; started when it is not there
    Load(LoadArgs),
    /// Unload the module of a type from a manager
    Unload(LoadArgs),
    Factories(FactoriesArgs),
    Create(create::Args),
    Delete(DeleteArgs),
}

/// Show the managers; the same as `rtsctl get managers`
#[derive(Debug, clap::Args)]
pub struct ListArgs {
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// The module of a type in a manager
#[derive(Debug, clap::Args)]
pub struct LoadArgs {
    /// Manager, as `rtsctl get managers` names it
    manager: String,
    /// Type name of the component (`ConsoleOut`)
    #[arg(value_name = "TYPE")]
    type_name: String,
    /// Node [default: where the manager is]
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
}

/// Show the modules that a manager has opened
#[derive(Debug, clap::Args)]
pub struct FactoriesArgs {
    /// Manager, as `rtsctl get managers` names it
    manager: String,
    /// Node [default: where the manager is]
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// Delete a component that was created by hand
#[derive(Debug, clap::Args)]
pub struct DeleteArgs {
    /// Instance name
    instance: String,
    /// Manager [default: where the component is]
    #[arg(long, value_name = "MANAGER")]
    manager: Option<String>,
    /// Node [default: where the component is]
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
}

/// Runs one of the verbs.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::List(args) => {
            let controller = session.connect().await?;
            show(
                &controller,
                &Selection::of(Kind::Manager, None),
                &args.format,
                session,
            )
            .await
        }
        Command::Load(args) => load(args, session).await,
        Command::Unload(args) => unload(args, session).await,
        Command::Factories(args) => factories(args, session).await,
        Command::Create(args) => create::run(args, session).await,
        Command::Delete(args) => delete(args, session).await,
    }
}

async fn load(args: LoadArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let place = place::manager(&controller, &args.manager, args.node.as_deref()).await?;
    let request = ModuleRequest {
        type_name: args.type_name,
    };
    let factory = controller
        .load_module(&place.node, &place.manager, &request)
        .await;
    let what = format!("load {} into manager/{}", request.type_name, place.manager);
    let factory = factory.map_err(CliError::request(what))?;
    if !place.runs {
        let (manager, node) = (&place.manager, &place.node);
        let text = format!("rtsctl: manager/{manager} did not run: started it on node/{node}");
        session.out.say(&text);
    }
    let (
        manager,
        Factory {
            type_name,
            version,
            path,
            ..
        },
    ) = (place.manager, factory);
    session.out.result(&format!(
        "manager/{manager} loaded {type_name} {version} from {path}"
    ))?;
    Ok(Exit::Ok)
}

async fn unload(args: LoadArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let place = place::manager(&controller, &args.manager, args.node.as_deref()).await?;
    let (manager, type_name) = (&place.manager, &args.type_name);
    let unloaded = controller
        .unload_module(&place.node, manager, type_name)
        .await;
    unloaded.map_err(CliError::request(format!(
        "unload {type_name} from manager/{manager}"
    )))?;
    session
        .out
        .result(&format!("manager/{manager} unloaded {type_name}"))?;
    Ok(Exit::Ok)
}

async fn factories(args: FactoriesArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let place = place::manager(&controller, &args.manager, args.node.as_deref()).await?;
    let factories = controller.factories(&place.node, &place.manager).await;
    let what = format!("list the modules of manager/{}", place.manager);
    let factories = factories.map_err(CliError::request(what))?;
    let wide = args.format.output == Format::Wide;
    let text = match args.format.output {
        Format::Json => format!("{:#}", serde_json::json!(factories)),
        Format::Yaml => serde_yaml::to_string(&factories).map_err(std::io::Error::other)?,
        Format::Name => factories
            .iter()
            .map(|f| format!("module/{}\n", f.type_name))
            .collect(),
        Format::Table | Format::Wide => {
            table(&factories, wide).render(!args.format.no_headers, session.out.stdout_color())
        }
    };
    session.out.result(&text)?;
    Ok(Exit::Ok)
}

fn table(factories: &[Factory], wide: bool) -> Table {
    let mut headers = vec!["TYPE", "VENDOR", "CATEGORY", "VERSION", "PORTS"];
    if wide {
        headers.extend(["PARAMETERS", "PATH"]);
    }
    let mut table = Table::new(&headers);
    for factory in factories {
        let mut cells = vec![
            factory.type_name.clone(),
            factory.vendor.clone(),
            factory.category.clone(),
            factory.version.clone(),
            ports(factory, wide),
        ];
        if wide {
            let parameters = factory
                .parameters
                .iter()
                .map(|(key, value)| format!("{key}={value}"));
            cells.extend([
                parameters.collect::<Vec<_>>().join(","),
                factory.path.clone(),
            ]);
        }
        table.row(cells);
    }
    table
}

/// `name:direction`, and the type in wide tables.
fn ports(factory: &Factory, wide: bool) -> String {
    let short = |port: &String| port.splitn(3, ':').take(2).collect::<Vec<_>>().join(":");
    let shown = |port: &String| if wide { port.clone() } else { short(port) };
    factory
        .ports
        .iter()
        .map(shown)
        .collect::<Vec<_>>()
        .join(",")
}

async fn delete(args: DeleteArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let (node, instance) = (args.node.as_deref(), &args.instance);
    let place = match &args.manager {
        Some(manager) => place::manager(&controller, manager, node).await?,
        None => place::component(&controller, instance, node).await?,
    };
    let deleted = controller
        .delete_component(&place.node, &place.manager, instance)
        .await;
    deleted.map_err(CliError::request(format!("delete component/{instance}")))?;
    session
        .out
        .result(&format!("component/{instance} deleted"))?;
    Ok(Exit::Ok)
}
