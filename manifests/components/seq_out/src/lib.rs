//! SeqOut: sends a rising pattern on ten ports, one of each basic type and its sequence.

use rts_runtime::types::{
    Time, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq, TimedLong, TimedLongSeq,
    TimedOctet, TimedOctetSeq, TimedShort, TimedShortSeq,
};
use rts_runtime::{Component, Context, Declaration, OutPort, RtcResult, TypeInfo};

/// Length of the sequences.
const LENGTH: u32 = 10;

struct SeqOut {
    octet: OutPort<TimedOctet>,
    short: OutPort<TimedShort>,
    long: OutPort<TimedLong>,
    float: OutPort<TimedFloat>,
    double: OutPort<TimedDouble>,
    octets: OutPort<TimedOctetSeq>,
    shorts: OutPort<TimedShortSeq>,
    longs: OutPort<TimedLongSeq>,
    floats: OutPort<TimedFloatSeq>,
    doubles: OutPort<TimedDoubleSeq>,
    count: u32,
}

impl Component for SeqOut {
    const TYPE: TypeInfo = TypeInfo {
        name: "SeqOut",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "sends a rising pattern of every basic type",
        rate: 10.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            octet: d.out_port("Octet"),
            short: d.out_port("Short"),
            long: d.out_port("Long"),
            float: d.out_port("Float"),
            double: d.out_port("Double"),
            octets: d.out_port("OctetSeq"),
            shorts: d.out_port("ShortSeq"),
            longs: d.out_port("LongSeq"),
            floats: d.out_port("FloatSeq"),
            doubles: d.out_port("DoubleSeq"),
            count: 0,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.count = 0;
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let n = self.count;
        self.count = n.wrapping_add(1);
        let tm = Time::now();
        // Integers wrap, each at its own width.
        macro_rules! one {
            ($port:ident, $sample:ident, $value:expr) => {
                self.$port.write(
                    ctx,
                    &$sample {
                        tm,
                        data: $value(n),
                    },
                )?
            };
        }
        macro_rules! many {
            ($port:ident, $sample:ident, $value:expr) => {{
                let data = (0..LENGTH).map(|i| $value(n.wrapping_add(i))).collect();
                self.$port.write(ctx, &$sample { tm, data })?;
            }};
        }
        one!(octet, TimedOctet, |n| n as u8);
        one!(short, TimedShort, |n| n as i16);
        one!(long, TimedLong, |n| n as i32);
        one!(float, TimedFloat, |n| n as f32 / 10.0);
        one!(double, TimedDouble, |n| f64::from(n) / 10.0);
        many!(octets, TimedOctetSeq, |n| n as u8);
        many!(shorts, TimedShortSeq, |n| n as i16);
        many!(longs, TimedLongSeq, |n| n as i32);
        many!(floats, TimedFloatSeq, |n| n as f32 / 10.0);
        many!(doubles, TimedDoubleSeq, |n| f64::from(n) / 10.0);
        Ok(())
    }
}

rts_runtime::export!(SeqOut);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn all_ten_ports_rise() {
        let mut host = TestHost::of::<SeqOut>().unwrap();
        host.activate().unwrap();
        for _ in 0..300 {
            host.execute().unwrap();
        }
        let octets: Vec<_> = host.take::<TimedOctet>("Octet");
        assert_eq!(
            octets[254..257].iter().map(|s| s.data).collect::<Vec<_>>(),
            [254, 255, 0]
        );
        assert_eq!(host.take::<TimedShort>("Short")[299].data, 299);
        assert_eq!(host.take::<TimedLong>("Long")[299].data, 299);
        assert_eq!(host.take::<TimedFloat>("Float")[5].data, 0.5);
        assert_eq!(host.take::<TimedDouble>("Double")[299].data, 29.9);
        assert_eq!(
            host.take::<TimedOctetSeq>("OctetSeq")[0].data,
            (0..10).collect::<Vec<_>>()
        );
        assert_eq!(host.take::<TimedShortSeq>("ShortSeq")[1].data[9], 10);
        assert_eq!(host.take::<TimedLongSeq>("LongSeq")[1].data[0], 1);
        assert_eq!(host.take::<TimedFloatSeq>("FloatSeq")[0].data[5], 0.5);
        assert_eq!(host.take::<TimedDoubleSeq>("DoubleSeq")[299].data.len(), 10);
    }
}
