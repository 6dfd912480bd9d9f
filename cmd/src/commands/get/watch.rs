//! `--watch`: what there is, then what changes, for as long as the user likes; also while the controller is away.

use jiff::Timestamp;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::Kind;
use serde_json::Value;

use super::{FormatArgs, Selection, not_there};
use crate::commands::while_read;
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::{Change, Memory, News, Watching};
use crate::session::Session;
use crate::show::stream::Stream;

/// Prints the objects, unless only changes are wanted, then a line for each change, until Ctrl-C.
pub async fn watch(
    controller: &Controller,
    selection: &Selection<'_>,
    only_changes: bool,
    format: &FormatArgs,
    session: &Session,
) -> Result<Exit, CliError> {
    let kind = selection.kind;
    let printer = Printer {
        kind,
        selection,
        stream: Stream::new(kind, format, session.out.stdout_color()),
        session,
    };
    let watching = Watching::new(controller, kind, None);
    while_read(printer.run(watching, only_changes), session).await
}

struct Printer<'a> {
    kind: Kind,
    selection: &'a Selection<'a>,
    stream: Stream,
    session: &'a Session,
}

impl Printer<'_> {
    async fn run(
        mut self,
        mut watching: Watching<Value>,
        only_changes: bool,
    ) -> Result<Exit, CliError> {
        let mut memory = Memory::of(self.kind);
        let mut begun = false;
        let out = self.session.out;
        loop {
            let news = watching.next().await;
            match news.map_err(failed(self.kind))? {
                News::Silent(e) if !begun => return Err(failed(self.kind)(e)),
                News::Silent(e) => out.say(&format!("rtsctl: {e}; trying again until Ctrl-C")),
                News::Back => out.say("rtsctl: the controller answers again"),
                News::All(list) => {
                    let again = std::mem::replace(&mut begun, true);
                    let (changes, gap) = memory.list(list.items);
                    if again && gap {
                        out.warn("some events may be missing: the controller began a new log, or forgot old ones");
                    }
                    if !again
                        && self
                            .selection
                            .lacks(changes.iter().map(|(_, object)| object))
                    {
                        let known = changes.iter().map(|(_, object)| object);
                        return Err(not_there(self.selection, known));
                    }
                    let hide = only_changes && !again;
                    self.print(if hide { Vec::new() } else { changes })?;
                }
                News::Change(what, object) => {
                    if memory.change(what, &object) {
                        self.print(vec![(what, object)])?;
                    }
                }
            }
        }
    }

    fn print(&mut self, mut changes: Vec<Change>) -> Result<(), CliError> {
        changes.retain(|(_, object)| self.selection.takes(object));
        let text = self.stream.text(&changes, Timestamp::now())?;
        self.session.out.result(&text)
    }
}

fn failed(kind: Kind) -> impl FnOnce(rts_controller_api::ClientError) -> CliError {
    CliError::request(format!("watch {}", kind.plural()))
}
