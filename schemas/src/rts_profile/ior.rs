//! The host and port inside a stringified CORBA object reference: a placement hint, never dialled.
//!
//! Source: CORBA 3.3 part 2, 7.6.2 (IOR) and 9.7.2 (IIOP profile), in CDR encapsulation.

/// Where the process of an object ran when the profile was saved.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Endpoint {
    /// Host name or address.
    pub host: String,
    /// TCP port.
    pub port: u16,
}

/// Longest reference that is looked at, in hex digits. Real ones have about 400.
const LONGEST: usize = 64 * 1024;

/// The address of the first IIOP profile of `IOR:…`; `None` for anything else.
pub fn endpoint(ior: &str) -> Option<Endpoint> {
    let hex = ior.trim().strip_prefix("IOR:")?;
    if hex.len() > LONGEST {
        return None;
    }
    let bytes = unhex(hex)?;
    let mut cdr = Cdr::encapsulation(&bytes)?;
    cdr.bytes()?; // type id, a string
    let profiles = cdr.u32()?;
    for _ in 0..profiles.min(16) {
        let tag = cdr.u32()?;
        let body = cdr.bytes()?;
        // 0 = TAG_INTERNET_IOP
        if tag == 0 {
            return iiop(body);
        }
    }
    None
}

fn iiop(body: &[u8]) -> Option<Endpoint> {
    let mut cdr = Cdr::encapsulation(body)?;
    cdr.u8()?; // major version
    cdr.u8()?; // minor version
    let host = cdr.bytes()?;
    let host = host.strip_suffix(&[0]).unwrap_or(host);
    let host = std::str::from_utf8(host).ok()?;
    let plain = !host.is_empty()
        && host.len() <= 255
        && host
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_' | ':' | '%'));
    plain.then_some(())?;
    Some(Endpoint {
        host: host.to_owned(),
        port: cdr.u16()?,
    })
}

fn unhex(hex: &str) -> Option<Vec<u8>> {
    let digit = |c: u8| (c as char).to_digit(16);
    hex.as_bytes()
        .chunks(2)
        .map(|pair| match pair {
            [high, low] => u8::try_from(digit(*high)? * 16 + digit(*low)?).ok(),
            _ => None,
        })
        .collect()
}

/// A cursor over CDR: numbers are aligned to their size from the start of the encapsulation.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> Cdr<'a> {
    fn encapsulation(bytes: &'a [u8]) -> Option<Self> {
        let little = *bytes.first()? & 1 == 1;
        Some(Self {
            bytes,
            at: 1,
            little,
        })
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let piece = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(piece)
    }

    fn u8(&mut self) -> Option<u8> {
        self.take(1).map(|b| b[0])
    }

    fn u16(&mut self) -> Option<u16> {
        self.at = self.at.next_multiple_of(2);
        let bytes = self.take(2)?.try_into().ok()?;
        Some(if self.little {
            u16::from_le_bytes(bytes)
        } else {
            u16::from_be_bytes(bytes)
        })
    }

    fn u32(&mut self) -> Option<u32> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.take(4)?.try_into().ok()?;
        Some(if self.little {
            u32::from_le_bytes(bytes)
        } else {
            u32::from_be_bytes(bytes)
        })
    }

    /// A sequence of octets or a string: its length, then its bytes.
    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.u32()?).ok()?;
        self.take(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REAL: &str = "IOR:010000003500000049444c3a6f70656e72746d2e616973742e676f2e6a702f4f70656e52544d2f44617461466c6f77436f6d706f6e656e743a312e3000000000010000000000000064000000010102000e0000003135302e32392e39392e31303600f4e90e000000fe05c5165700002070000000000000000200000000000000080000000100000000545441010000001c00000001000000010001000100000001000105090101000100000009010100";

    #[test]
    fn a_real_reference() {
        let found = endpoint(REAL).unwrap();
        assert_eq!((found.host.as_str(), found.port), ("150.29.99.106", 59892));
    }

    #[test]
    fn a_cut_reference_is_none() {
        // Past the port the profile may miss its object key; before it nothing may be made up.
        for end in 0..REAL.len() {
            if let Some(found) = endpoint(&REAL[..end]) {
                assert_eq!(found.port, 59892);
            }
        }
        assert_eq!(endpoint("IOR:"), None);
        assert_eq!(endpoint("IOR:01ffffff"), None);
        assert_eq!(endpoint("corbaloc::x"), None);
    }
}
