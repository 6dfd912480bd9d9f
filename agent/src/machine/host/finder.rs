//! Finds the module file of a type in the module paths, its digest, and what it says of itself.

use std::collections::HashMap;
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_schemas::names::module_file_names;
use sha2::{Digest, Sha256};
use tokio::sync::Semaphore;

use super::describe::{DescribeError, describe};
use crate::events::lock;
use crate::folders::hex;

/// Most digests, and most descriptions, that are remembered.
const MAX_DIGESTS: usize = 4096;
/// Most modules that are described at once.
const MAX_DESCRIBING: usize = 4;

/// One version of a file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Version {
    path: PathBuf,
    file: (u64, u64),
    modified: (i64, i64),
    size: u64,
}

impl Version {
    fn of(path: &Path, metadata: &Metadata) -> Self {
        Self {
            path: path.to_owned(),
            file: (metadata.dev(), metadata.ino()),
            modified: (metadata.mtime(), metadata.mtime_nsec()),
            size: metadata.size(),
        }
    }
}

fn file(path: &Path, digest: String) -> ModuleFile {
    ModuleFile {
        path: path.display().to_string(),
        digest,
        description: None,
    }
}

/// Descriptions by digest and type name.
type Descriptions = HashMap<(String, String), Option<ModuleDescription>>;

/// Finds modules. Cheap to clone.
#[derive(Debug, Clone)]
pub struct ModuleFinder {
    folders: Arc<[PathBuf]>,
    digests: Arc<Mutex<HashMap<Version, String>>>,
    /// The manager program, which describes modules.
    program: Arc<Path>,
    describing: Arc<Semaphore>,
    /// By digest and type name; none for a module that cannot be described.
    descriptions: Arc<Mutex<Descriptions>>,
}

impl ModuleFinder {
    /// Searches these folders, in order. `program` is the manager program.
    pub fn new(folders: &[PathBuf], program: &Path) -> Self {
        let absolute = |folder: &PathBuf| std::path::absolute(folder).unwrap_or(folder.clone());
        Self {
            folders: folders.iter().map(absolute).collect(),
            digests: Arc::default(),
            program: program.into(),
            describing: Arc::new(Semaphore::new(MAX_DESCRIBING)),
            descriptions: Arc::default(),
        }
    }

    /// What a module says of itself; none when it says nothing.
    pub async fn describe(
        &self,
        module: &ModuleFile,
        type_name: &str,
    ) -> Option<ModuleDescription> {
        let key = (module.digest.clone(), type_name.to_owned());
        // It is never closed.
        let _permit = self.describing.acquire().await.ok()?;
        if let Some(known) = lock(&self.descriptions).get(&key) {
            return known.clone();
        }
        let description = match describe(&self.program, (&module.path).into(), type_name).await {
            Ok(description) => Some(description),
            Err(e) => {
                tracing::warn!("module {} says nothing of itself: {e}", module.path);
                if matches!(e, DescribeError::Run { .. }) {
                    return None;
                }
                None
            }
        };
        let mut descriptions = lock(&self.descriptions);
        if descriptions.len() >= MAX_DIGESTS {
            descriptions.clear();
        }
        descriptions.insert(key, description.clone());
        description
    }

    /// Where the module of a type is, or where it was looked for.
    pub async fn resolve(&self, type_name: &str) -> io::Result<ModuleResolution> {
        // A few looks at file names are shorter than to ask another thread for them; reading a file is not.
        if let Some(known) = self.known(type_name) {
            return Ok(known);
        }
        let (finder, name) = (self.clone(), type_name.to_owned());
        let found = tokio::task::spawn_blocking(move || finder.resolve_now(&name));
        found.await.map_err(io::Error::other).flatten()
    }

    /// A file as a module, with its digest.
    pub(super) async fn file(&self, path: PathBuf) -> io::Result<ModuleFile> {
        let finder = self.clone();
        let read = tokio::task::spawn_blocking(move || finder.file_now(&path));
        read.await.map_err(io::Error::other).flatten()
    }

    fn file_now(&self, path: &Path) -> io::Result<ModuleFile> {
        Ok(file(path, self.digest(path, &fs::metadata(path)?)?))
    }

    fn resolve_now(&self, type_name: &str) -> io::Result<ModuleResolution> {
        let (found, searched) = self.search(type_name);
        let module = match found {
            Some((path, metadata)) => Some(file(&path, self.digest(&path, &metadata)?)),
            None => None,
        };
        Ok(ModuleResolution {
            type_name: type_name.to_owned(),
            module,
            searched,
        })
    }

    /// The same for a file whose digest is known; none for any other.
    fn known(&self, type_name: &str) -> Option<ModuleResolution> {
        let (found, searched) = self.search(type_name);
        let (path, metadata) = found?;
        let digest = lock(&self.digests)
            .get(&Version::of(&path, &metadata))?
            .clone();
        Some(ModuleResolution {
            type_name: type_name.to_owned(),
            module: Some(file(&path, digest)),
            searched,
        })
    }

    /// The first file of a type, and what was looked for.
    fn search(&self, type_name: &str) -> (Option<(PathBuf, Metadata)>, Vec<String>) {
        let mut searched = Vec::new();
        for path in self.candidates(type_name) {
            searched.push(path.display().to_string());
            if let Ok(metadata) = fs::metadata(&path)
                && metadata.is_file()
            {
                return (Some((path, metadata)), searched);
            }
        }
        (None, searched)
    }

    fn candidates(&self, type_name: &str) -> impl Iterator<Item = PathBuf> {
        let names: Vec<String> = module_file_names(type_name)
            .into_iter()
            // A type name comes from a profile: it must not lead out of the module paths.
            .filter(|name| !name.contains(['/', '\0']))
            .collect();
        self.folders
            .iter()
            .flat_map(move |folder| names.clone().into_iter().map(|name| folder.join(name)))
    }

    fn digest(&self, path: &Path, metadata: &Metadata) -> io::Result<String> {
        let version = Version::of(path, metadata);
        if let Some(digest) = lock(&self.digests).get(&version) {
            return Ok(digest.clone());
        }
        let mut hash = Sha256::new();
        io::copy(&mut fs::File::open(path)?, &mut hash)?;
        let digest = hex(&hash.finalize());
        let mut digests = lock(&self.digests);
        if digests.len() >= MAX_DIGESTS {
            digests.clear();
        }
        digests.insert(version, digest.clone());
        Ok(digest)
    }
}
