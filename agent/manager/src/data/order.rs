//! Samples with the most significant byte first, where `dataport.serializer.cdr.endian` asks for it. Components write and
//! read the least significant one first; the manager turns the bytes on their way out of a process, and back on their way in.

use bytes::BytesMut;
use rts_manager_api::control::Failure;
use rts_schemas::cdr::{self, Endian};
use rts_schemas::idl::{self, Type, Unit};

use super::{BIG_ENDIAN, LITTLE_ENDIAN, Payload, Sample};
use crate::failure::invalid;

/// The types of OpenRTM-aist, which a module need not bring along.
const STANDARD: &str = "#include <rtm/idl/BasicDataType.idl>\n\
                        #include <rtm/idl/ExtendedDataTypes.idl>\n\
                        #include <rtm/idl/InterfaceDataTypes.idl>\n";

/// The type of a connector, by which bytes are turned.
#[derive(Debug)]
pub struct Turn {
    unit: Unit,
    r#type: Type,
}

/// The name of the encoding, as the protocol shows it.
pub fn encoding(endian: Endian) -> &'static str {
    match endian {
        Endian::Little => LITTLE_ENDIAN,
        Endian::Big => BIG_ENDIAN,
    }
}

/// What turns the samples of a connector; none when they stay as they are. `idl` is what the module of `port` says.
pub fn turn(
    endian: Endian,
    port: &str,
    data_type: &str,
    idl: &str,
) -> Result<Option<Turn>, Failure> {
    if endian == Endian::Little {
        return Ok(None);
    }
    // One that has types of its own with these names brings all of its types along.
    let texts = [format!("{STANDARD}{idl}"), idl.to_owned()];
    let found = texts.iter().find_map(|text| {
        let read = idl::read("module.idl", text.as_bytes(), &idl::standard()).ok()?;
        let index = read.unit.find(data_type)?;
        Some(Turn {
            unit: read.unit,
            r#type: Type::Named(index),
        })
    });
    found.map(Some).ok_or_else(|| {
        invalid(format!(
            "`dataport.serializer.cdr.endian` is big, which needs the IDL of {data_type}: the module of {port} does not \
             bring it along; let it do so, or choose little"
        ))
    })
}

impl Turn {
    /// To the order of the way, or back; none when the bytes are no value of the type.
    pub fn turned(&self, mut sample: Sample, from: Endian) -> Option<Sample> {
        let mut bytes = BytesMut::from(&sample.payload[..]);
        cdr::swap(&self.unit, &self.r#type, &mut bytes, from).ok()?;
        sample.payload = Payload::from(bytes);
        Some(sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDL: &str = "module Own { struct Pair { unsigned short a; unsigned long b; }; };";

    #[test]
    fn samples_of_known_types_are_turned_and_turned_back() {
        for (data_type, little, big) in [
            (
                "IDL:Own/Pair:1.0",
                &[1, 0, 0, 0, 2, 0, 0, 0][..],
                &[0, 1, 0, 0, 0, 0, 0, 2][..],
            ),
            (
                "IDL:RTC/TimedShort:1.0",
                &[1, 0, 0, 0, 2, 0, 0, 0, 3, 0],
                &[0, 0, 0, 1, 0, 0, 0, 2, 0, 3],
            ),
        ] {
            let turn = turn(Endian::Big, "A.out", data_type, IDL).unwrap().unwrap();
            let sample = |bytes: &[u8]| Sample {
                sequence: 1,
                time: 2,
                payload: Payload::copy_from_slice(bytes),
            };
            let turned = turn.turned(sample(little), Endian::Little).unwrap();
            assert_eq!(turned, sample(big));
            let back = turn.turned(turned, Endian::Big).unwrap();
            assert_eq!(back, sample(little));
            assert_eq!(turn.turned(sample(&big[1..]), Endian::Big), None);
        }
    }

    #[test]
    fn a_type_without_idl_is_refused_unless_its_bytes_stay() {
        let unknown = "IDL:Img/Camera:1.0";
        assert!(
            turn(Endian::Little, "A.out", unknown, "")
                .unwrap()
                .is_none()
        );
        let refusal = turn(Endian::Big, "A.out", unknown, IDL).unwrap_err();
        assert!(
            refusal
                .message
                .contains("needs the IDL of IDL:Img/Camera:1.0")
        );
    }
}
