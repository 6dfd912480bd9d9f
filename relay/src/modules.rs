//! Answers the agent over there which file has a type: the same search as that of a local agent, in folders of this machine.

use std::path::{Path, PathBuf};

use rts_agent::ModuleFinder;
use rts_agent_api::messages::ModuleFile;
use rts_bridge::Stream;
use rts_bridge::modules::{Answer, Offer, answer, asked};
use rts_ssh::machine_of;
use tokio::runtime::Handle;
use tokio::task::spawn_blocking;

/// The folders of this machine, and the machine for which modules must be made.
#[derive(Debug, Clone)]
pub(crate) struct Modules {
    finder: ModuleFinder,
    machine: String,
}

impl Modules {
    pub fn new(folders: &[PathBuf], machine: &str) -> Self {
        Self {
            // Modules are described over there.
            finder: ModuleFinder::new(folders, Path::new("/nonexistent")),
            machine: machine.to_owned(),
        }
    }

    /// Answers one question.
    pub async fn serve(self, stream: Stream) {
        let served = async {
            let (question, stream) = asked(stream).await?;
            let (reply, path) = self.find(question.type_name).await;
            let sent = answer(stream, reply, &path).await?;
            if sent > 0 {
                tracing::info!(bytes = sent, "sent module {}", path.display());
            }
            Ok::<_, rts_bridge::modules::ModuleError>(())
        };
        if let Err(e) = served.await {
            tracing::warn!("a question for a module was not answered: {e}");
        }
    }

    /// On another thread: a file system that hangs must hold up no sign of life.
    async fn find(self, type_name: String) -> (Answer, PathBuf) {
        let runtime = Handle::current();
        let found = spawn_blocking(move || runtime.block_on(self.find_here(&type_name)));
        found.await.unwrap_or_else(|e| {
            let error = e.to_string();
            (Answer::Fails { error }, PathBuf::new())
        })
    }

    async fn find_here(&self, type_name: &str) -> (Answer, PathBuf) {
        let nowhere = PathBuf::new();
        match self.finder.resolve(type_name).await {
            Ok(found) => match found.module {
                Some(module) => {
                    let path = PathBuf::from(&module.path);
                    (self.offer(&module, &path), path)
                }
                None => (
                    Answer::None {
                        searched: found.searched,
                    },
                    nowhere,
                ),
            },
            Err(e) => (
                Answer::Fails {
                    error: e.to_string(),
                },
                nowhere,
            ),
        }
    }

    fn offer(&self, module: &ModuleFile, path: &Path) -> Answer {
        let fails = |e: std::io::Error| Answer::Fails {
            error: format!("cannot read {}: {e}", path.display()),
        };
        match machine_of(path) {
            Ok(Some(made)) if made != self.machine => {
                let words = format!(
                    "{} (made for {made}, and the node is {})",
                    path.display(),
                    self.machine
                );
                return Answer::None {
                    searched: vec![words],
                };
            }
            Ok(_) => {}
            Err(e) => return fails(e),
        }
        match std::fs::metadata(path) {
            Ok(file) => Answer::File(Offer {
                name: path
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
                digest: module.digest.clone(),
                size: file.len(),
            }),
            Err(e) => fails(e),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_module_for_another_machine_is_not_offered() {
        let folder = tempfile::tempdir().unwrap();
        let modules = Modules::new(&[folder.path().to_owned()], "aarch64");
        assert!(
            matches!(modules.find("Sink".to_owned()).await.0, Answer::None { searched } if searched.len() == 2)
        );
        std::fs::copy(
            std::env::current_exe().unwrap(),
            folder.path().join("libsink.so"),
        )
        .unwrap();
        let other = Modules::new(&[folder.path().to_owned()], "vax");
        let Answer::None { searched } = other.find("Sink".to_owned()).await.0 else {
            panic!("a module of this machine was offered to a vax");
        };
        assert!(searched[0].contains("the node is vax"), "{searched:?}");
        let own = Modules::new(&[folder.path().to_owned()], std::env::consts::ARCH);
        assert!(
            matches!(own.find("Sink".to_owned()).await.0, Answer::File(offer) if offer.is_sound())
        );
    }
}
