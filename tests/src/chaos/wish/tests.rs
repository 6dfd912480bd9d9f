use super::*;

fn drawn() -> (Wish, Draw) {
    let mut draw = Draw::new(3, 1);
    (Wish::draw("s", &mut draw), draw)
}

#[test]
fn a_change_of_configuration_touches_nobody() {
    let (wish, mut draw) = drawn();
    let next = wish.changed(Change::Configuration, &mut draw);
    assert_eq!(next.serial, 2);
    assert_ne!(wish.xml(), next.xml());
    assert!(touched(Some(&wish), Some(&next)).is_empty());
    assert!(rewired(Some(&wish), Some(&next)).is_empty());
    assert_eq!(wish.changed(Change::Nothing, &mut draw), wish);
}

#[test]
fn a_move_touches_the_one_that_moves_and_its_connectors() {
    let (wish, _) = drawn();
    let mut next = wish.clone();
    next.parts[1].manager = "z".to_owned();
    let touched = touched(Some(&wish), Some(&next));
    assert_eq!(touched.into_iter().collect::<Vec<_>>(), ["sp1"]);
    let rewired = rewired(Some(&wish), Some(&next));
    assert_eq!(rewired.len(), 1, "{rewired:?}");
    assert!(rewired.iter().all(|name| name.ends_with("sp1.in")));
}

#[test]
fn an_end_touches_all() {
    let (wish, _) = drawn();
    assert_eq!(touched(Some(&wish), None).len(), wish.parts.len());
    assert_eq!(rewired(None, Some(&wish)).len(), wish.connectors().len());
}

#[test]
fn whatever_changes_everything_that_can_be_fed_is_fed() {
    let mut draw = Draw::new(11, 0);
    let mut wish = Wish::draw("s", &mut draw);
    let changes = [
        Change::Connector,
        Change::Manager,
        Change::More,
        Change::Less,
    ];
    for _ in 0..200 {
        let change = *draw.pick(&changes).unwrap();
        wish = wish.changed(change, &mut draw);
        let fed = wish
            .parts
            .iter()
            .filter(|p| p.kind.input().is_some())
            .count();
        assert_eq!(wish.connectors().len(), fed, "{wish:#?}");
    }
}
