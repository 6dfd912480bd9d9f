//! The throw-away stack: a home of its own in the folder for temporary files.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::local::home::Home;
use crate::local::nodes::NodeSetup;
use crate::local::{LocalError, up};
use crate::output::Output;
use crate::session::Session;

/// Longest path of the folder above the home, in bytes: sockets lie deep below it.
const LONGEST: usize = 24;

/// A stack that nobody else knows of.
#[derive(Debug)]
pub struct Stack {
    /// Its home, and its controller.
    pub session: Session,
    /// Its nodes; the first one takes what no host means.
    pub nodes: Vec<NodeSetup>,
}

impl Stack {
    /// Makes its folder; nothing runs yet.
    pub fn make(nodes: Vec<NodeSetup>, out: Output) -> Result<Self, CliError> {
        let above = above();
        let folder = tempfile::Builder::new()
            .prefix("rts-smoke-")
            .tempdir_in(&above)
            .map_err(LocalError::file("make a folder in", above))?;
        // It goes when the stack has ended, and not before.
        let home = Home::settle(Some(folder.keep()))?;
        Ok(Self {
            session: Session {
                home,
                controller: None,
                out,
                local: Default::default(),
                answered: Default::default(),
            },
            nodes,
        })
    }

    /// Its folder.
    pub fn home(&self) -> &Home {
        &self.session.home
    }

    /// Starts the controller and the agents, and waits until they know each other.
    pub async fn start(&self) -> Result<(), CliError> {
        let wish = up::Wish {
            module_path: None,
            nodes: self.nodes.clone(),
        };
        up::ensure(&self.session, wish).await?;
        Ok(())
    }
}

/// `$TMPDIR` where it is short enough.
fn above() -> PathBuf {
    let named = std::env::temp_dir();
    let short = named.is_absolute() && named.as_os_str().len() <= LONGEST;
    if short {
        named
    } else {
        Path::new("/tmp").to_owned()
    }
}
