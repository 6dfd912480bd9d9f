//! Modules that come from near, over the connection by which this machine is reached: kept in `modules/<sha256>/` of the
//! home, and sent but once.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::SystemTime;

use rts_agent_api::messages::{ModuleFile, ModuleResolution};
use rts_bridge::Opener;
use rts_bridge::modules::{Answer, Asked, ModuleError, Offer, ask};
use rts_host::error::chain;
use rts_host::files;
use tokio::sync::Mutex;

use super::finder::ModuleFinder;

/// Asks near for modules. Cheap to clone.
#[derive(Debug, Clone)]
pub(crate) struct Pull {
    folder: PathBuf,
    /// Set once the connection is there.
    near: Arc<OnceLock<Opener>>,
    /// One module is copied at a time.
    turn: Arc<Mutex<()>>,
}

/// Tells temporary files apart.
static NEXT: AtomicU64 = AtomicU64::new(0);

impl Pull {
    /// Keeps what comes in `modules` of a home.
    pub fn new(home: &Path) -> Self {
        Self {
            folder: home.join("modules"),
            near: Arc::default(),
            turn: Arc::default(),
        }
    }

    /// The connection is there.
    pub fn connected(&self, near: Opener) {
        // There is one connection in the life of this process.
        let _ = self.near.set(near);
    }

    /// Near's file of a type goes before what is installed here: whoever commands decides, as on a machine of his own.
    pub async fn resolve(
        &self,
        installed: &ModuleFinder,
        type_name: &str,
    ) -> io::Result<ModuleResolution> {
        let answer = self.ask(installed, type_name).await;
        let mut searched = match answer.map_err(|e| io::Error::other(chain(&e)))? {
            Ok(module) => {
                return Ok(ModuleResolution {
                    type_name: type_name.to_owned(),
                    searched: vec![module.path.clone()],
                    module: Some(module),
                });
            }
            Err(searched) => searched,
        };
        let mut found = installed.resolve(type_name).await?;
        if found.module.is_none() {
            searched.append(&mut found.searched);
            found.searched = searched;
        }
        Ok(found)
    }

    /// The module, or where near has looked for it.
    async fn ask(
        &self,
        finder: &ModuleFinder,
        type_name: &str,
    ) -> Result<Result<ModuleFile, Vec<String>>, ModuleError> {
        let near = self.near.get().ok_or(rts_bridge::Gone)?;
        let asked = ask(near, type_name).await?;
        let offer = match &asked.answer {
            Answer::File(offer) => offer.clone(),
            Answer::None { searched } => {
                let here = |path: &String| format!("{path} where rtsctl runs");
                return Ok(Err(searched.iter().map(here).collect()));
            }
            Answer::Fails { error } => return Err(ModuleError::Wrong(error.clone())),
        };
        let path = self.folder.join(&offer.digest).join(&offer.name);
        let _turn = self.turn.lock().await;
        if let Some(known) = kept(finder, &path, &offer).await {
            used(&path);
            asked.decline().await?;
            return Ok(Ok(known));
        }
        take(asked, &path).await?;
        tracing::info!(bytes = offer.size, "copied module {}", path.display());
        Ok(Ok(finder.file(path).await?))
    }
}

/// Its folder's time says when it was used last: what nobody has used for long is removed.
fn used(path: &Path) {
    let folder = path.parent().map(std::fs::File::open);
    if let Some(Ok(folder)) = folder {
        let _ = folder.set_modified(SystemTime::now());
    }
}

/// The module, if it is here and whole.
async fn kept(finder: &ModuleFinder, path: &Path, offer: &Offer) -> Option<ModuleFile> {
    let module = finder.file(path.to_owned()).await.ok()?;
    (module.digest == offer.digest).then_some(module)
}

/// Takes the bytes under another name first: half a module never has its place.
async fn take(asked: Asked, path: &Path) -> Result<(), ModuleError> {
    let folder = path.parent().unwrap_or(Path::new("/"));
    files::private_folder(folder)?;
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let new = folder.join(format!(".{}.{number}.new", std::process::id()));
    let taken = async {
        let mut file = tokio::fs::File::create_new(&new).await?;
        asked.take(&mut file).await?;
        file.sync_all().await?;
        Ok(tokio::fs::rename(&new, path).await?)
    };
    let taken = taken.await;
    if taken.is_err() {
        let _ = tokio::fs::remove_file(&new).await;
    }
    taken
}
