//! Pictures of small systems, and what must hold for any.

use super::layout::{self, Area};
use super::model::{self, Block, Model, Wire};
use super::svg;
use proptest::prelude::*;
use rts_schemas::rts_profile;
use rts_schemas::system::PortKind;

fn hello() -> Model {
    let file = include_bytes!("../../../../manifests/hello/system.xml");
    let spec = rts_profile::load("hello.xml", file, None, &[]).unwrap().0;
    let mut model = model::of(&spec, &[], &[]);
    for (block, state) in model.blocks.iter_mut().zip(["Active", "Inactive", "Error"]) {
        state.clone_into(&mut block.state);
    }
    model
}

#[test]
fn a_picture_is_as_reviewed() {
    let model = hello();
    insta::assert_snapshot!(svg::render(&model, &layout::of(&model)));
}

#[test]
fn text_is_escaped() {
    let mut model = hello();
    "<script>&\"\u{1}".clone_into(&mut model.blocks[0].name);
    model.frames[0] = "a<b".to_owned();
    let picture = svg::render(&model, &layout::of(&model));
    assert!(picture.contains(">&lt;script&gt;&amp;&quot;\u{fffd}</text>"));
    assert!(picture.contains("node a&lt;b"));
    assert!(!picture.contains("<script>"));
}

#[test]
fn data_flows_from_left_to_right() {
    let model = hello();
    let layout = layout::of(&model);
    for wire in &model.wires {
        let (from, to) = (layout.blocks[wire.from.0], layout.blocks[wire.to.0]);
        assert!(from.x + from.width < to.x, "{}", wire.name);
    }
}

fn models() -> impl Strategy<Value = Model> {
    let counts = (1..4usize, 1..12usize);
    counts.prop_flat_map(|(frames, blocks)| {
        let ends = (0..blocks, 0..blocks);
        let wires = proptest::collection::vec(ends, 0..20);
        let placed = proptest::collection::vec(0..frames, blocks);
        (placed, wires).prop_map(move |(placed, ends)| {
            let block = |(ix, frame): (usize, usize)| Block {
                name: format!("C{ix}"),
                type_name: "T".to_owned(),
                state: "Active".to_owned(),
                stand_in: ix % 2 == 0,
                frame,
                left: vec!["in".to_owned()],
                right: vec!["out".to_owned()],
            };
            let wire = |(from, to): (usize, usize)| Wire {
                name: format!("{from}-{to}"),
                kind: PortKind::Data,
                state: "Connected".to_owned(),
                from: (from, 0),
                to: (to, 0),
            };
            Model {
                name: "s".to_owned(),
                frames: (0..frames).map(|n| format!("n{n}")).collect(),
                blocks: placed.into_iter().enumerate().map(block).collect(),
                wires: ends.into_iter().map(wire).collect(),
            }
        })
    })
}

fn overlap(a: Area, b: Area) -> bool {
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height
}

fn within(inner: Area, outer: Area) -> bool {
    inner.x >= outer.x
        && inner.y >= outer.y
        && inner.x + inner.width <= outer.x + outer.width
        && inner.y + inner.height <= outer.y + outer.height
}

proptest! {
    #[test]
    fn no_two_components_overlap_and_each_is_in_its_frame(model in models()) {
        let layout = layout::of(&model);
        for (ix, area) in layout.blocks.iter().enumerate() {
            prop_assert!(within(*area, layout.frames[model.blocks[ix].frame]));
            for other in &layout.blocks[..ix] {
                prop_assert!(!overlap(*area, *other));
            }
        }
        for (ix, area) in layout.frames.iter().enumerate() {
            prop_assert!(area.x + area.width <= layout.size.0);
            prop_assert!(area.y + area.height <= layout.size.1);
            for other in &layout.frames[..ix] {
                prop_assert!(!overlap(*area, *other));
            }
        }
        prop_assert_eq!(svg::render(&model, &layout), svg::render(&model, &layout::of(&model)));
    }
}
