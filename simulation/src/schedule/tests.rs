use super::*;

#[test]
fn a_schedule_reads_well() {
    insta::assert_snapshot!(Schedule::of(Seed(3)).to_string());
}

#[test]
fn a_schedule_survives_json() {
    for seed in 0..50 {
        let schedule = Schedule::of(Seed(seed));
        let text = serde_json::to_string(&schedule).unwrap();
        let again: Schedule = serde_json::from_str(&text).unwrap();
        assert_eq!(again, schedule);
    }
}

#[test]
fn what_is_left_out_is_gone_and_the_rest_stays() {
    for seed in 0..50 {
        let schedule = Schedule::of(Seed(seed));
        let names = schedule.names();
        for name in &names {
            let less = schedule.without(&BTreeSet::from([name.clone()]));
            let mut rest = names.clone();
            rest.retain(|n| n != name);
            let kept_one = less.names() == names;
            let last = schedule
                .systems
                .iter()
                .any(|s| s.components.len() == 1 && s.components[0].instance == *name);
            assert!(less.names() == rest || (kept_one && last), "{seed} {name}");
        }
    }
}
