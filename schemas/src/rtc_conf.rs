//! `rtc.conf` of OpenRTM-aist, and the configuration files of components that it names: read with the place of everything,
//! and turned into an RTS Profile and an overlay.
//!
//! A line is `key: value`; `\` at its end continues it, `#` or `!` at its start makes it a comment. What OpenRTM-aist does
//! with an odd file is done here too, and said.

mod component;
mod convert;
mod decode;
mod entries;
mod item;
mod keys;
mod list;
mod manager;
mod overlay;
mod setup;
mod sources;

pub use component::{ComponentConf, Named, Set};
pub use convert::{Converted, Options, convert};
pub use decode::SIZE_LIMIT;
pub(crate) use decode::text;
pub use entries::{Conf, Entry, read};
pub use item::{Port, Preconnect, Precreate};
pub use manager::{ComponentFile, ManagerConf};
pub use setup::{Component, Manager, Setup, load};
pub use sources::Sources;

use crate::names;

/// A name for a system whose `rtc.conf` lies there: the stem of the file, or its folder's name if the file is called as
/// most are (`rtc.conf`, `conf/rtc_cpp.conf`).
pub fn system_name(path: &str) -> Option<String> {
    let stem = names::file_stem(path)?;
    let rest = stem
        .strip_prefix("rtc")
        .or_else(|| stem.strip_prefix("RTC"));
    let usual = rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()));
    if !usual {
        return names::dns_label(stem);
    }
    let mut folders = path.rsplit('/').skip(1);
    let folder =
        folders.find(|folder| !matches!(*folder, "conf" | "." | "..") && !folder.is_empty());
    folder.and_then(names::dns_label)
}

#[cfg(test)]
mod tests {
    use super::system_name;

    #[test]
    fn systems_are_named_after_their_file_or_folder() {
        let name = |path| system_name(path);
        assert_eq!(name("/home/x/Crawler/rtc.conf").as_deref(), Some("crawler"));
        assert_eq!(
            name("/home/x/nao_joy/conf/rtc_py.conf").as_deref(),
            Some("nao-joy")
        );
        assert_eq!(name("lab.conf").as_deref(), Some("lab"));
        assert_eq!(name("rtc.conf"), None);
        assert_eq!(name("x/rtcdemo.conf").as_deref(), Some("rtcdemo"));
    }
}
