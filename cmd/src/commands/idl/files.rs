//! IDL files, and those that they include.

use std::io::Read;
use std::path::{Path, PathBuf};

use rts_schemas::idl::{self, Found, Include, SIZE_LIMIT, Sources};

/// Which files.
#[derive(Debug, clap::Args)]
pub(super) struct Files {
    /// IDL files; `-` is standard input
    #[arg(value_name = "FILE", required = true)]
    pub(super) files: Vec<PathBuf>,
    /// Where included ones are.
    #[command(flatten)]
    pub(super) folders: Folders,
}

/// Where included files are.
#[derive(Debug, Clone, clap::Args)]
pub struct Folders {
    /// Folder to look in for included files, after that of the file itself; those of OpenRTM-aist are always found (may
    /// be repeated)
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    include: Vec<PathBuf>,
}

impl Sources for Folders {
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String> {
        let beside = Path::new(include.from).parent().filter(|_| !include.angled);
        let folders = beside
            .into_iter()
            .chain(self.include.iter().map(PathBuf::as_path));
        for path in folders.map(|folder| folder.join(include.name)) {
            if let Some(bytes) = regular(&path)? {
                let path = path.to_string_lossy().into_owned();
                return Ok(Some(Found { path, bytes }));
            }
        }
        idl::standard().find(include)
    }
}

/// The bytes of a file, if it is one: what is none (a pipe, a device) may have no end.
fn regular(path: &Path) -> Result<Option<Vec<u8>>, String> {
    if !std::fs::metadata(path).is_ok_and(|found| found.is_file()) {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path);
    let read = file.and_then(|file| file.take(SIZE_LIMIT as u64 + 1).read_to_end(&mut bytes));
    read.map_err(|error| error.to_string())?;
    Ok(Some(bytes))
}
