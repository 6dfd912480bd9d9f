//! Files that a file names: read by who has them.

/// Most bytes of all files that one set-up names.
const BYTES: usize = 16 << 20;

/// Most files that one set-up names.
const FILES: usize = 1000;

/// How many folders above a file's own the files that it names are looked for.
const UP: usize = 4;

/// What gives files by their path.
pub trait Sources {
    /// The bytes of a file; `None` if there is no such file.
    ///
    /// # Errors
    /// Why a file that is there cannot be read.
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>, String>;
}

/// A reader within bounds.
pub(super) struct Bounded<'a> {
    sources: &'a dyn Sources,
    bytes: usize,
    files: usize,
}

impl<'a> Bounded<'a> {
    pub(super) fn new(sources: &'a dyn Sources) -> Self {
        Self {
            sources,
            bytes: 0,
            files: 0,
        }
    }

    /// A file that another one names, with the path where it was found: in the folder of that file, or in one above it,
    /// because OpenRTM-aist looks from where it was started.
    pub(super) fn find(
        &mut self,
        from: &str,
        path: &str,
    ) -> Result<Option<(String, Vec<u8>)>, String> {
        for path in candidates(from, path) {
            if self.files == FILES {
                return Err(format!("more than {FILES} files are named"));
            }
            if let Some(bytes) = self.sources.read(&path)? {
                self.files += 1;
                self.bytes += bytes.len();
                if self.bytes > BYTES {
                    return Err(format!(
                        "the files that are named have more than {BYTES} bytes"
                    ));
                }
                return Ok(Some((path, bytes)));
            }
        }
        Ok(None)
    }
}

fn candidates(from: &str, path: &str) -> Vec<String> {
    let is_drive = path.as_bytes().get(1) == Some(&b':');
    if path.starts_with('/') || is_drive {
        return vec![path.to_owned()];
    }
    let mut folder = from
        .rsplit_once('/')
        .map_or("", |(folder, _)| folder)
        .to_owned();
    let is_absolute = from.starts_with('/');
    let mut all = Vec::new();
    for _ in 0..=UP {
        all.push(match folder.as_str() {
            "" if is_absolute => format!("/{path}"),
            "" => path.to_owned(),
            folder => format!("{folder}/{path}"),
        });
        if folder.is_empty() && is_absolute {
            break;
        }
        folder = match folder.rsplit_once('/') {
            _ if folder.is_empty() || folder == "." => "..".to_owned(),
            _ if folder == ".." || folder.ends_with("/..") => format!("{folder}/.."),
            Some((above, _)) => above.to_owned(),
            None => String::new(),
        };
    }
    all
}

#[cfg(test)]
mod tests {
    use super::candidates;

    #[test]
    fn files_are_looked_for_from_the_folder_upwards() {
        assert_eq!(
            candidates("a/conf/rtc.conf", "conf/x.conf"),
            [
                "a/conf/conf/x.conf",
                "a/conf/x.conf",
                "conf/x.conf",
                "../conf/x.conf",
                "../../conf/x.conf"
            ]
        );
        assert_eq!(candidates("rtc.conf", "x")[..2], ["x", "../x"]);
        assert_eq!(candidates("./rtc.conf", "x")[..2], ["./x", "../x"]);
        assert_eq!(candidates("/rtc.conf", "x"), ["/x"]);
        assert_eq!(candidates("a/rtc.conf", "/etc/x"), ["/etc/x"]);
        assert_eq!(candidates("a/rtc.conf", "C:/x"), ["C:/x"]);
    }
}
