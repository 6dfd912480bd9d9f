use super::*;

fn read<T: Scalar>(text: &str) -> Option<String> {
    T::parse(text).map(|value| value.spelled())
}

fn refused<T: Scalar>(texts: &[&str]) {
    for text in texts {
        assert_eq!(read::<T>(text), None, "{text}");
    }
}

#[test]
fn times_have_a_unit_and_bounds() {
    let ms = |text| Time::parse(text).map(|time| time.0);
    let read = [
        "100ms", "500ms", "10s", "5m", "1h30m", "24h", "1.5s", "1 min",
    ]
    .map(ms);
    let expected = [
        100, 500, 10_000, 300_000, 5_400_000, 86_400_000, 1500, 60_000,
    ];
    assert_eq!(read, expected.map(Some));
    refused::<Time>(&[
        "",
        "10",
        "99ms",
        "0s",
        "-10s",
        "24h1ms",
        "1d",
        "1y",
        "ten",
        "99999999999999h",
    ]);
}

#[test]
fn times_and_sizes_are_spelled_in_their_unit() {
    let spelled = [100, 1500, 90_000, 600_000, 3_600_000, 0].map(spelled_time);
    assert_eq!(spelled, ["100ms", "1500ms", "90s", "10m", "1h", "0ms"]);
    let spelled = [1 << 20, 3 << 29, 1 << 50, 1_500_000].map(|b| MemoryLimit(b).spelled());
    assert_eq!(spelled, ["1MiB", "1536MiB", "1024TiB", "1500000B"]);
}

#[test]
fn sizes_have_a_unit_and_bounds() {
    let bytes = |text| MemoryLimit::parse(text).map(|limit| limit.0);
    let read = ["256MiB", "256Mi", "1.5 GiB", "2GB", "1500000B", "1PiB"].map(bytes);
    let expected = [
        256 << 20,
        256 << 20,
        3 << 29,
        2_000_000_000,
        1_500_000,
        1 << 50,
    ];
    assert_eq!(read, expected.map(Some));
    refused::<MemoryLimit>(&[
        "", "256", "MiB", "1023KiB", "1025TiB", "-1GiB", "1 XiB", "NaN MiB", "1e30GiB",
    ]);
}

#[test]
fn processors_are_listed_in_order() {
    let listed = ["2-3", "5, 2 - 3", "3,2,1", "0", "0-3,2-7,9", "7-7"].map(read::<Cpus>);
    let expected = ["2-3", "2-3,5", "1-3", "0", "0-7,9", "7"];
    assert_eq!(listed, expected.map(|text| Some(text.to_owned())));
    refused::<Cpus>(&[
        "", ",", "3-2", "1-", "-1", "+1", "1024", "0-1024", "all", "1;2",
    ]);
}

#[test]
fn numbers_are_whole_and_have_bounds() {
    assert_eq!(
        ["1", "1000"].map(read::<RestartLimit>).map(|r| r.is_some()),
        [true; 2]
    );
    refused::<RestartLimit>(&["", "0", "1001", "-1", "1.5", "many", "99999999999"]);
    assert_eq!(
        ["1", "99"].map(read::<Priority>).map(|r| r.is_some()),
        [true; 2]
    );
    refused::<Priority>(&["", "0", "100", "-1", "1.5", "high"]);
}

#[test]
fn words_are_read_in_any_case() {
    let words = ["repair", "Ignore", "ADOPT"].map(|word| DriftPolicy::parse(word).unwrap());
    let expected = [DriftPolicy::Repair, DriftPolicy::Ignore, DriftPolicy::Adopt];
    assert_eq!(words, expected);
    let refused = DriftPolicy::fault("drift", "keep");
    assert_eq!(refused.message, "`keep` is not a value of `drift`");
    let help = "expected: `repair`, `ignore` or `adopt`";
    assert_eq!(refused.help.as_deref(), Some(help));
    let restart = ["OnFailure", "on-failure"].map(read::<RestartPolicy>);
    assert_eq!(restart, [(); 2].map(|()| Some("on-failure".to_owned())));
    let stand_in = ["true", "Missing", "0"].map(read::<StandIn>);
    assert_eq!(
        stand_in,
        ["always", "missing", "never"].map(|word| Some(word.to_owned()))
    );
}

#[test]
fn packages_and_versions_are_plain() {
    for name in ["sine", "openrtm.org/sine_source", "@lab/arm-1.2", "ros+x"] {
        assert_eq!(
            read::<PackageName>(name).is_some(),
            !name.starts_with('@'),
            "{name}"
        );
    }
    refused::<PackageName>(&["", "a b", "../x", "a\nb", "ü"]);
    for version in [
        "1.2",
        "1.0",
        "2",
        "2.0.0-RELEASE",
        "1.2.0-rc.1+5",
        ">=1.2, <2",
        "> 1.0,<=1.9.9",
        "^1",
        "~1.2",
        "=1.2.3",
        "1.*",
        "*",
    ] {
        assert_eq!(read::<VersionRange>(version).as_deref(), Some(version));
    }
    refused::<VersionRange>(&[
        "",
        "abc",
        "1.2;",
        "$(x)",
        "latest",
        "1.2.3.4",
        "2:1.0~rc1",
        ">=",
        "1.2,",
        ",",
        "=>1",
        "v1",
        "-1",
    ]);
}
