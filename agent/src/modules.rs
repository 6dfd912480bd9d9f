//! The modules of the node: where they are, and which of them may be used.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use rts_agent_api::messages::{ModuleFile, ModuleResolution};
use rts_http::problem::Problem;

use crate::machine::Machine;

/// Most types that are resolved at once.
const MAX_TYPES: usize = 10_000;

/// A module that cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ModuleError {
    /// No file.
    #[error("no module of type {type_name} was found; looked for {}; put it there or set RTSCTL_MODULE_PATH", searched.join(", "))]
    NotFound {
        /// Type name.
        type_name: String,
        /// Files that were looked for.
        searched: Vec<String>,
    },
    /// Another file than the one that was pinned.
    #[error(
        "module file {path} changed since the system was applied (SHA-256 {found}, expected {expected}); apply it again"
    )]
    Changed {
        /// The file.
        path: String,
        /// Its digest.
        found: String,
        /// The digest that was pinned.
        expected: String,
    },
    /// The file cannot be read.
    #[error("cannot read the module of type {type_name}: {reason}")]
    Unreadable {
        /// Type name.
        type_name: String,
        /// Why.
        reason: String,
    },
}

/// Finds modules.
#[derive(Clone)]
pub(crate) struct Modules(Arc<dyn Machine>);

impl Modules {
    /// Those of a machine.
    pub fn new(machine: Arc<dyn Machine>) -> Self {
        Self(machine)
    }

    /// Where the module of a type is, and what it says of itself.
    async fn resolve_described(&self, type_name: &str) -> Result<ModuleResolution, ModuleError> {
        let mut resolution = self.resolve(type_name).await?;
        if let Some(module) = &mut resolution.module {
            module.description = self.0.describe(module, type_name).await;
        }
        Ok(resolution)
    }

    /// Where the modules of types are, and what they say of themselves.
    pub async fn resolve_all(&self, types: &[String]) -> Result<Vec<ModuleResolution>, Problem> {
        if types.len() > MAX_TYPES {
            let detail = format!("at most {MAX_TYPES} types at once");
            return Err(Problem::invalid("too-many", detail));
        }
        let found = types.iter().map(|type_name| async {
            let resolution = self.resolve_described(type_name).await;
            resolution.map_err(|e| Problem::internal(e.to_string()))
        });
        futures_util::future::try_join_all(found).await
    }

    /// Where the module of a type is, or where it was looked for.
    async fn resolve(&self, type_name: &str) -> Result<ModuleResolution, ModuleError> {
        let found = self.0.resolve(type_name).await;
        found.map_err(|e| ModuleError::Unreadable {
            type_name: type_name.to_owned(),
            reason: e.to_string(),
        })
    }

    /// The module of a type; with a pinned digest it must have that one.
    pub async fn find(
        &self,
        type_name: &str,
        pinned: Option<&str>,
    ) -> Result<ModuleFile, ModuleError> {
        let resolution = self.resolve(type_name).await?;
        let Some(module) = resolution.module else {
            return Err(ModuleError::NotFound {
                type_name: type_name.to_owned(),
                searched: resolution.searched,
            });
        };
        match pinned {
            Some(expected) if expected != module.digest => Err(ModuleError::Changed {
                path: module.path,
                found: module.digest,
                expected: expected.to_owned(),
            }),
            _ => Ok(module),
        }
    }
}
