//! The file of what is remembered.

use std::io;
use std::path::{Path, PathBuf};

use rts_host::disk::{Disk, replace_durably};
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
pub(super) async fn load(
    disk: &dyn Disk,
    path: &Path,
    boot_id: Option<&str>,
) -> io::Result<Memory> {
    let Some(text) = disk.read(path, MAX_FILE).await? else {
        return Ok(Memory::default());
    };
    Ok(match parse(&text) {
        Ok(contents) => {
            let rebooted = boot_id.is_none() || contents.boot_id.as_deref() != boot_id;
            Memory::of(contents.components, rebooted)
        }
        Err(why) => {
            put_aside(disk, path, &why).await;
            Memory::default()
        }
    })
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

async fn put_aside(disk: &dyn Disk, path: &Path, why: &str) {
    let mut name = path.as_os_str().to_owned();
    name.push(".damaged");
    let aside = PathBuf::from(name);
    let kept = match disk.rename(path, &aside).await {
        Ok(()) => format!("it is kept as {}", aside.display()),
        Err(e) => format!("it cannot be put aside: {e}"),
    };
    tracing::warn!(
        "{} is damaged ({why}); restarts are counted anew, and {kept}",
        path.display()
    );
}

/// Replaces the file. Durable when it returns.
pub(super) async fn save(
    disk: &dyn Disk,
    path: &Path,
    boot_id: Option<&str>,
    components: Vec<Component>,
) -> io::Result<()> {
    let contents = Contents {
        version: VERSION,
        boot_id: boot_id.map(str::to_owned),
        components,
    };
    replace_durably(disk, path, serde_json::to_vec_pretty(&contents)?).await
}
