//! A disk as one life of a program has it: the program may crash before, during and after each call.

use std::io;
use std::path::Path;

use futures_util::future::BoxFuture;
use rts_host::disk::Disk;

use super::SimDisk;
use crate::life::Life;

/// A disk in the hands of one life.
pub(super) struct Grip {
    pub disk: SimDisk,
    pub life: Life,
}

impl Grip {
    /// One call: some time, the effect, some time.
    fn call<'a, T: Send + 'a>(
        &'a self,
        effect: impl FnOnce(&SimDisk) -> io::Result<T> + Send + 'a,
    ) -> BoxFuture<'a, io::Result<T>> {
        Box::pin(self.life.call(async move {
            self.disk.delay().await;
            effect(&self.disk)
        }))
    }
}

impl Disk for Grip {
    fn read<'a>(&'a self, path: &'a Path, max: u64) -> BoxFuture<'a, io::Result<Option<Vec<u8>>>> {
        self.call(move |disk| {
            let max = usize::try_from(max).unwrap_or(usize::MAX);
            let files = disk.files();
            let bytes = files.read(path);
            Ok(bytes.map(|bytes| bytes.iter().take(max).copied().collect()))
        })
    }

    fn write<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(self.life.call(async move {
            self.disk.delay().await;
            let cut = self.disk.0.faults.between(0, bytes.len() as u64);
            let begun = bytes.iter().take(cut as usize).copied();
            let refused = self.disk.refuse(io::ErrorKind::StorageFull);
            self.disk.files().write(path, &begun.collect::<Vec<_>>());
            refused?;
            // A crash may come when some of it is written.
            self.life.pass().await;
            self.disk.delay().await;
            self.disk.files().write(path, &bytes);
            Ok(())
        }))
    }

    fn write_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(self.life.call(async move {
            self.disk.delay().await;
            let cut = self.disk.0.faults.between(0, bytes.len() as u64) as usize;
            let refused = self.disk.refuse(io::ErrorKind::StorageFull);
            self.disk.files().write_over(path, &bytes[..cut])?;
            refused?;
            // A crash may come when some of it is written.
            self.life.pass().await;
            self.disk.delay().await;
            self.disk.files().write_over(path, &bytes)
        }))
    }

    fn sync<'a>(&'a self, path: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        self.call(move |disk| {
            disk.refuse(io::ErrorKind::StorageFull)?;
            disk.files().sync(path)
        })
    }

    fn rename<'a>(&'a self, from: &'a Path, to: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        self.call(move |disk| {
            disk.refuse(io::ErrorKind::StorageFull)?;
            disk.files().rename(from, to)
        })
    }

    fn sync_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        self.call(move |disk| {
            disk.refuse(io::ErrorKind::StorageFull)?;
            disk.files().sync_folder(folder);
            Ok(())
        })
    }
}
