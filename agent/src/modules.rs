//! Finds the module file of a type in the module paths, and its digest.

use std::collections::HashMap;
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rts_agent_api::messages::{ModuleFile, ModuleResolution};
use rts_schemas::names::module_file_names;
use sha2::{Digest, Sha256};

use crate::events::lock;
use crate::folders::hex;

/// Most digests that are remembered.
const MAX_DIGESTS: usize = 4096;

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

/// One version of a file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Version {
    path: PathBuf,
    inode: u64,
    modified: (i64, i64),
    size: u64,
}

/// Finds modules. Cheap to clone.
#[derive(Debug, Clone)]
pub(crate) struct Modules {
    folders: Arc<[PathBuf]>,
    digests: Arc<Mutex<HashMap<Version, String>>>,
}

impl Modules {
    /// Searches these folders, in order.
    pub fn new(folders: &[PathBuf]) -> Self {
        let absolute = |folder: &PathBuf| std::path::absolute(folder).unwrap_or(folder.clone());
        Self {
            folders: folders.iter().map(absolute).collect(),
            digests: Arc::default(),
        }
    }

    /// Where the module of a type is, or where it was looked for.
    pub async fn resolve(&self, type_name: &str) -> Result<ModuleResolution, ModuleError> {
        let (finder, name) = (self.clone(), type_name.to_owned());
        tokio::task::spawn_blocking(move || finder.resolve_now(&name))
            .await
            .map_err(io::Error::other)
            .flatten()
            .map_err(|e| ModuleError::Unreadable {
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

    fn resolve_now(&self, type_name: &str) -> io::Result<ModuleResolution> {
        let mut searched = Vec::new();
        for path in self.candidates(type_name) {
            searched.push(path.display().to_string());
            match fs::metadata(&path) {
                Ok(metadata) if metadata.is_file() => {
                    return Ok(ModuleResolution {
                        type_name: type_name.to_owned(),
                        module: Some(ModuleFile {
                            digest: self.digest(&path, &metadata)?,
                            path: path.display().to_string(),
                        }),
                        searched,
                    });
                }
                _ => {}
            }
        }
        Ok(ModuleResolution {
            type_name: type_name.to_owned(),
            module: None,
            searched,
        })
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
        let version = Version {
            path: path.to_owned(),
            inode: metadata.ino(),
            modified: (metadata.mtime(), metadata.mtime_nsec()),
            size: metadata.size(),
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_first_file_in_the_order_of_paths_and_names_wins() {
        let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let modules = Modules::new(&[a.path().to_owned(), b.path().to_owned()]);
        let none = modules.resolve("ConsoleIn").await.unwrap();
        assert_eq!((none.module, none.searched.len()), (None, 4));
        let error = modules.find("ConsoleIn", None).await.unwrap_err();
        assert!(error.to_string().contains("libconsole_in.so"), "{error}");

        fs::write(b.path().join("libconsole_in.so"), "b").unwrap();
        let found = modules.find("ConsoleIn", None).await.unwrap();
        assert_eq!(
            found.path,
            b.path().join("libconsole_in.so").display().to_string()
        );
        fs::write(a.path().join("ConsoleIn.so"), "a").unwrap();
        let found = modules.find("ConsoleIn", None).await.unwrap();
        assert_eq!(
            found.path,
            a.path().join("ConsoleIn.so").display().to_string()
        );
        assert_eq!(
            found.digest,
            "ca978112ca1bbdcafac231b39a23dc4da786eff8147c4e72b9807785afee48bb"
        );
    }

    #[tokio::test]
    async fn a_changed_file_has_a_new_digest_and_is_refused_when_pinned() {
        let folder = tempfile::tempdir().unwrap();
        let modules = Modules::new(&[folder.path().to_owned()]);
        let path = folder.path().join("libsink.so");
        fs::write(&path, "one").unwrap();
        let first = modules.find("Sink", None).await.unwrap();
        assert!(modules.find("Sink", Some(&first.digest)).await.is_ok());
        fs::write(&path, "other").unwrap();
        let error = modules.find("Sink", Some(&first.digest)).await.unwrap_err();
        assert!(matches!(error, ModuleError::Changed { .. }));
        assert!(error.to_string().contains("apply it again"), "{error}");
    }

    #[tokio::test]
    async fn a_type_name_does_not_lead_out_of_the_module_paths() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("in")).unwrap();
        fs::write(folder.path().join("evil.so"), "x").unwrap();
        let modules = Modules::new(&[folder.path().join("in")]);
        assert_eq!(modules.resolve("../evil").await.unwrap().module, None);
    }
}
