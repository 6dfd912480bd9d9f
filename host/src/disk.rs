//! Small files that must survive, over the calls of a file system. A simulation passes its own disk, which loses what was
//! never made durable.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use futures_util::future::BoxFuture;

use crate::files::{self, beside, folder_of};

/// What a file system does. Nothing is durable before [`Disk::sync`], or [`Disk::sync_folder`] for a name.
pub trait Disk: Send + Sync + 'static {
    /// At most `max` bytes of a file from its begin on; none when there is no such file.
    fn read<'a>(&'a self, path: &'a Path, max: u64) -> BoxFuture<'a, io::Result<Option<Vec<u8>>>>;
    /// Makes or empties a file, mode 0600, and writes it. A crash later may leave any part of it.
    fn write<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>>;
    /// Makes the contents of a file durable.
    fn sync<'a>(&'a self, path: &'a Path) -> BoxFuture<'a, io::Result<()>>;
    /// Gives a file another name in the same folder, in the place of whatever has it.
    fn rename<'a>(&'a self, from: &'a Path, to: &'a Path) -> BoxFuture<'a, io::Result<()>>;
    /// Makes the names in a folder durable.
    fn sync_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>>;
    /// Writes over the begin of a file that is there, and leaves what is behind. A crash later may leave any part of it; when it
    /// fails, the file is no longer than it was.
    fn write_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>>;

    /// Replaces a file as a whole: whoever reads it finds the old or the new contents, also after a crash. Durable when
    /// it ends well. Only one at a time may replace a file.
    fn replace<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            let new = beside(path)?;
            self.write(&new, bytes).await?;
            self.sync(&new).await?;
            self.rename(&new, path).await?;
            self.sync_folder(folder_of(path)).await
        })
    }

    /// Writes over the begin of a file that is there. Durable when it ends well, and that with the one flush that this
    /// takes; a crash before may leave a mixture of the old and the new contents.
    fn save_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            self.write_over(path, bytes).await?;
            self.sync(path).await
        })
    }
}

/// See [`Disk::replace`].
pub async fn replace_durably(disk: &dyn Disk, path: &Path, bytes: Vec<u8>) -> io::Result<()> {
    disk.replace(path, bytes).await
}

/// The file system of this machine, off the event loop.
#[derive(Debug, Clone, Copy, Default)]
pub struct FileDisk;

async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> io::Result<T> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(io::Error::other).flatten()
}

impl Disk for FileDisk {
    fn read<'a>(&'a self, path: &'a Path, max: u64) -> BoxFuture<'a, io::Result<Option<Vec<u8>>>> {
        let path = path.to_owned();
        Box::pin(blocking(move || read(&path, max)))
    }

    fn write<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        let path = path.to_owned();
        Box::pin(blocking(move || write(&path, &bytes)))
    }

    fn sync<'a>(&'a self, path: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        let path = path.to_owned();
        Box::pin(blocking(move || File::open(path)?.sync_all()))
    }

    fn rename<'a>(&'a self, from: &'a Path, to: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        let (from, to): (PathBuf, PathBuf) = (from.to_owned(), to.to_owned());
        Box::pin(blocking(move || std::fs::rename(from, to)))
    }

    fn sync_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        self.sync(folder)
    }

    fn write_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        let path = path.to_owned();
        Box::pin(blocking(move || write_over(&path, &bytes).map(drop)))
    }

    // One call to a thread that may block, where the steps one by one are as many.
    fn replace<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        let path = path.to_owned();
        Box::pin(blocking(move || files::replace_durably(&path, &bytes)))
    }

    fn save_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        let path = path.to_owned();
        Box::pin(blocking(move || write_over(&path, &bytes)?.sync_data()))
    }
}

fn read(path: &Path, max: u64) -> io::Result<Option<Vec<u8>>> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    let mut bytes = Vec::new();
    file.take(max).read_to_end(&mut bytes)?;
    Ok(Some(bytes))
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut options = OpenOptions::new();
    let mut file = options
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(path)?;
    file.write_all(bytes)
}

/// The file is not emptied: where its length stays, nothing but its bytes has to be flushed.
fn write_over(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    let before = file.metadata()?.len();
    if let Err(e) = file.write_all(bytes) {
        // What did not fit must not lie behind what is written there next.
        let _ = file.set_len(before);
        return Err(e);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        assert_eq!(FileDisk.read(&path, 10).await.unwrap(), None);
        let replace = async |text: &str| replace_durably(&FileDisk, &path, text.into()).await;
        replace("a longer first text").await.unwrap();
        replace("short").await.unwrap();
        assert_eq!(FileDisk.read(&path, 3).await.unwrap().unwrap(), b"sho");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let nowhere = folder.path().join("none/x.json");
        assert!(replace_durably(&FileDisk, &nowhere, vec![1]).await.is_err());
    }

    #[tokio::test]
    async fn a_file_is_written_over_in_its_place_and_is_never_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        assert!(FileDisk.save_over(&path, vec![1]).await.is_err());
        std::fs::write(&path, "the old text").unwrap();
        FileDisk.save_over(&path, "THE NEW".into()).await.unwrap();
        FileDisk.write_over(&path, "A".into()).await.unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"AHE NEW text");
    }
}
