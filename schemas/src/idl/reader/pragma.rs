//! Repository ids that pragmas give.

use super::super::names::{ScopedName, What};
use super::super::preprocessor::Pragma;
use super::super::token::At;
use super::{Prefix, Reader};

impl Reader<'_> {
    /// Does what a pragma says, here.
    pub(super) fn pragma(&mut self, pragma: Pragma, at: At) {
        match pragma {
            Pragma::Prefix(_) if self.open > 0 => {
                let message =
                    "a prefix stands within a struct, a union, an exception or an interface";
                let help = "write it before the definition: it holds for what comes behind it in its module or file";
                self.error("idl-bad-directive", at, message, help);
            }
            Pragma::Prefix(prefix) => {
                self.charge(prefix.len(), at);
                self.prefix = self.prefix_here(prefix);
            }
            Pragma::Id { name, id } => self.set_id(&name, at, |_| id),
            Pragma::Version { name, version } => self.set_id(&name, at, |old| {
                let stem = old.rsplit_once(':').map_or(old, |(stem, _)| stem);
                format!("{stem}:{version}")
            }),
        }
    }

    /// A prefix that begins in this scope; names of the scopes around it are not part of ids, as in omniORB.
    pub(super) fn prefix_here(&self, text: String) -> Prefix {
        let outer = self.path(self.scope).len();
        Prefix { text, outer }
    }

    fn set_id(&mut self, name: &str, at: At, id: impl FnOnce(&str) -> String) {
        let absolute = name.starts_with("::");
        let parts = name.strip_prefix("::").unwrap_or(name).split("::");
        let name = ScopedName {
            absolute,
            parts: parts
                .map(|part| part.strip_prefix('_').unwrap_or(part).to_owned())
                .collect(),
            at,
        };
        let index = match self.resolve(&name) {
            Some(What::Definition(index)) => index,
            // A module has an id too, which nobody asks for.
            Some(What::Module(_)) | None => return,
            Some(_) => {
                let message = format!("`{}` has no repository id", name.shown());
                self.error(
                    "idl-wrong-name",
                    at,
                    message,
                    "name a type, a constant, an exception or an interface",
                );
                return;
            }
        };
        let old = &self.definitions[index].repository_id;
        let id = id(old);
        if self.facts[index].has_id && *old != id {
            let message = format!(
                "the repository id of `{}` was set to `{old}` already",
                name.shown()
            );
            self.error(
                "idl-name-taken",
                at,
                message,
                "leave one of the two pragmas out",
            );
            return;
        }
        self.facts[index].has_id = true;
        self.charge(id.len(), at);
        self.definitions[index].repository_id = id;
    }
}
