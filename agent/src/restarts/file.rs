//! The file of what is remembered.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::component::Component;
use super::memory::Memory;

/// Name in the state folder.
const FILE: &str = "restarts.json";
/// Version of its format.
const VERSION: u32 = 1;
/// Largest file in bytes.
const MAX_FILE: u64 = 64 * 1024 * 1024;

/// Its contents.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Contents {
    version: u32,
    /// The boot in which it was written.
    boot_id: Option<String>,
    components: Vec<Component>,
}

/// The file of a state folder.
pub(super) fn path(state: &Path) -> PathBuf {
    state.join(FILE)
}

/// What was remembered. A damaged file is put aside, with a warning: what it held is lost, but nothing else. One that
/// cannot be read may hold what must not be forgotten: that is an error.
pub(super) fn load(path: &Path, boot_id: Option<&str>) -> io::Result<Memory> {
    let Some(text) = read(path)? else {
        return Ok(Memory::default());
    };
    Ok(match parse(&text) {
        Ok(contents) => {
            let rebooted = boot_id.is_none() || contents.boot_id.as_deref() != boot_id;
            Memory::of(contents.components, rebooted)
        }
        Err(why) => {
            put_aside(path, &why);
            Memory::default()
        }
    })
}

fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let file = match std::fs::File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    let mut text = Vec::new();
    file.take(MAX_FILE).read_to_end(&mut text)?;
    Ok(Some(text))
}

fn parse(text: &[u8]) -> Result<Contents, String> {
    let contents: Contents = serde_json::from_slice(text).map_err(|e| e.to_string())?;
    if contents.version != VERSION {
        let version = contents.version;
        return Err(format!(
            "it has format {version}, this agent knows {VERSION}"
        ));
    }
    Ok(contents)
}

fn put_aside(path: &Path, why: &str) {
    let mut name = path.as_os_str().to_owned();
    name.push(".damaged");
    let aside = PathBuf::from(name);
    let kept = match std::fs::rename(path, &aside) {
        Ok(()) => format!("it is kept as {}", aside.display()),
        Err(e) => format!("it cannot be put aside: {e}"),
    };
    tracing::warn!(
        "{} is damaged ({why}); restarts are counted anew, and {kept}",
        path.display()
    );
}

/// Replaces the file. Durable when it returns.
pub(super) fn save(
    path: &Path,
    boot_id: Option<&str>,
    components: Vec<Component>,
) -> io::Result<()> {
    let contents = Contents {
        version: VERSION,
        boot_id: boot_id.map(str::to_owned),
        components,
    };
    rts_host::files::replace_durably(path, &serde_json::to_vec_pretty(&contents)?)
}
