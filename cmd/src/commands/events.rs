//! `rtsctl events`.

use rts_controller_api::objects::Kind;

use super::describe::kind_of;
use super::get::{FormatArgs, Selection, show, singular, watch};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Show what happened, oldest first
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print what happened, then what happens, until Ctrl-C; `-o json` gives JSON Lines of {type, object}
    #[arg(short, long)]
    watch: bool,
    /// Only about one object
    #[arg(long = "for", value_name = "KIND/NAME")]
    about: Option<String>,
    /// Only of one system
    #[arg(long, value_name = "NAME")]
    system: Option<String>,
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints the events.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let about = args.about.as_deref().map(object).transpose()?;
    let controller = session.connect().await?;
    let selection = Selection {
        system: args.system.as_deref(),
        about: about.as_deref(),
        ..Selection::of(Kind::Event, None)
    };
    if args.watch {
        return watch(&controller, &selection, false, &args.format, session).await;
    }
    show(&controller, &selection, &args.format, session).await
}

/// An object as events name it: `comp/Sine0` is `component/Sine0`.
fn object(text: &str) -> Result<String, CliError> {
    let Some((kind, name)) = text.split_once('/') else {
        return Err(CliError::usage_help(
            format!("{text:?} names no object"),
            "write KIND/NAME, as in `rtsctl events --for component/Sine0`",
        ));
    };
    Ok(format!("{}/{name}", singular(kind_of(kind)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_named_as_everywhere() {
        assert_eq!(object("comp/Sine0").unwrap(), "component/Sine0");
        assert_eq!(object("managers/a.main").unwrap(), "manager/a.main");
        assert_eq!(object("Sine0").unwrap_err().exit().code(), 2);
        assert_eq!(object("robot/R2").unwrap_err().exit().code(), 2);
    }
}
