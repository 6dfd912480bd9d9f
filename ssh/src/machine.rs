//! For which machine a program is made, as its ELF header says.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes of the header up to and with `e_machine`.
const HEADER: usize = 20;

/// The machine of a program or module by the name that `uname -m` has for it, where that is known; none for what is no ELF
/// file.
pub fn machine_of(path: &Path) -> std::io::Result<Option<&'static str>> {
    let mut header = Vec::new();
    File::open(path)?
        .take(HEADER as u64)
        .read_to_end(&mut header)?;
    Ok(parse(&header))
}

fn parse(header: &[u8]) -> Option<&'static str> {
    let header: &[u8; HEADER] = header.try_into().ok()?;
    let rest = header.strip_prefix(b"\x7fELF")?;
    let bytes = [header[18], header[19]];
    let machine = match rest[1] {
        1 => u16::from_le_bytes(bytes),
        2 => u16::from_be_bytes(bytes),
        _ => return None,
    };
    // ELF specification, e_machine.
    match machine {
        3 => Some("i686"),
        40 => Some("arm"),
        62 => Some("x86_64"),
        183 => Some("aarch64"),
        243 => Some("riscv64"),
        _ => None,
    }
}

/// The name of [`machine_of`] for what `uname -m` says and the bits of the programs there.
pub(crate) fn common_name(machine: &str, bits: Option<u32>) -> String {
    let small = bits == Some(32);
    match machine {
        "x86_64" | "amd64" if small => "i686".to_owned(),
        "aarch64" | "arm64" if small => "arm".to_owned(),
        "amd64" => "x86_64".to_owned(),
        "arm64" => "aarch64".to_owned(),
        "i386" | "i486" | "i586" => "i686".to_owned(),
        arm if arm.starts_with("armv") => "arm".to_owned(),
        other => other.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_tells_the_machine() {
        let mut header = [0; HEADER];
        header[..6].copy_from_slice(b"\x7fELF\x02\x01");
        header[18] = 183;
        assert_eq!(parse(&header), Some("aarch64"));
        (header[5], header[18], header[19]) = (2, 0, 62);
        assert_eq!(parse(&header), Some("x86_64"));
        assert_eq!(parse(b"#!/bin/sh\n"), None);
        assert_eq!(parse(&header[..19]), None);
    }

    #[test]
    fn this_test_is_of_this_machine() {
        let own = std::env::current_exe().unwrap();
        assert_eq!(machine_of(&own).unwrap(), Some(std::env::consts::ARCH));
    }

    #[test]
    fn machines_have_one_name() {
        for (machine, bits, name) in [
            ("amd64", None, "x86_64"),
            ("armv7l", Some(32), "arm"),
            ("aarch64", Some(64), "aarch64"),
            ("aarch64", Some(32), "arm"),
            ("mips", None, "mips"),
        ] {
            assert_eq!(common_name(machine, bits), name);
        }
    }
}
