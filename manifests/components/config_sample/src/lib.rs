//! ConfigSample: the parameters of OpenRTM's example; logs each change.

use rts_runtime::{Component, Config, Context, Declaration, ParameterValue, RtcResult, TypeInfo};

struct ConfigSample {
    int_param0: Watched<i32>,
    int_param1: Watched<i32>,
    double_param0: Watched<f64>,
    double_param1: Watched<f64>,
    str_param0: Watched<String>,
    str_param1: Watched<String>,
    vector_param0: Watched<Vec<f64>>,
}

/// A parameter and what it was when it was last looked at.
struct Watched<T> {
    name: &'static str,
    value: Config<T>,
    seen: String,
}

impl<T: ParameterValue> Watched<T> {
    fn new(d: &mut Declaration, name: &'static str, default: T) -> Self {
        let value = d.parameter(name, default);
        let seen = value.with(T::text);
        Self { name, value, seen }
    }

    fn look(&mut self, ctx: &Context<'_>) {
        if !self.value.changed() {
            return;
        }
        let now = self.value.with(T::text);
        let before = std::mem::replace(&mut self.seen, now);
        if before != self.seen {
            ctx.info(format_args!("{}: {before} -> {}", self.name, self.seen));
        }
    }
}

impl Component for ConfigSample {
    const TYPE: TypeInfo = TypeInfo {
        name: "ConfigSample",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "logs changes of its configuration",
        rate: 10.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            int_param0: Watched::new(d, "int_param0", 0),
            int_param1: Watched::new(d, "int_param1", 1),
            double_param0: Watched::new(d, "double_param0", 0.11),
            double_param1: Watched::new(d, "double_param1", 9.9),
            str_param0: Watched::new(d, "str_param0", "hoge".into()),
            str_param1: Watched::new(d, "str_param1", "dara".into()),
            vector_param0: Watched::new(d, "vector_param0", vec![0.0, 1.0, 2.0, 3.0, 4.0]),
        }
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.int_param0.look(ctx);
        self.int_param1.look(ctx);
        self.double_param0.look(ctx);
        self.double_param1.look(ctx);
        self.str_param0.look(ctx);
        self.str_param1.look(ctx);
        self.vector_param0.look(ctx);
        Ok(())
    }
}

rts_runtime::export!(ConfigSample);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn it_declares_what_openrtm_does() {
        let host = TestHost::of::<ConfigSample>().unwrap();
        assert_eq!(
            host.describe(),
            "int_param0=0\nint_param1=1\ndouble_param0=0.11\ndouble_param1=9.9\nstr_param0=hoge\nstr_param1=dara\n\
             vector_param0=0.0,1.0,2.0,3.0,4.0\n"
        );
    }

    #[test]
    fn only_real_changes_are_logged() {
        let mut host = TestHost::of::<ConfigSample>().unwrap();
        host.configure("int_param0", "0").unwrap();
        host.configure("str_param1", "foo").unwrap();
        host.configure("vector_param0", "1, 2").unwrap();
        host.execute().unwrap();
        host.execute().unwrap();
        assert_eq!(
            host.take_log(),
            [
                "str_param1: dara -> foo",
                "vector_param0: 0.0,1.0,2.0,3.0,4.0 -> 1.0,2.0"
            ]
        );
    }
}
