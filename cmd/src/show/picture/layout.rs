//! Where everything goes: components in columns along the flow of data, each node a band of its own, so that a connector
//! leads from left to right wherever the flow has no circle.

use std::collections::BTreeSet;

use unicode_width::UnicodeWidthStr;

use super::model::{Block, Model};

/// Width of a character; the font is a fixed-width one of [`FONT`].
pub const CHARACTER: usize = 7;
/// Size of the font.
pub const FONT: usize = 12;
/// Height of a line of text, and of a port.
pub const LINE: usize = 18;
/// Space around the picture and inside frames.
pub const MARGIN: usize = 20;
/// Space between columns, for the wires.
const GAP: usize = 90;
/// Space between two blocks of a column.
const BETWEEN: usize = 24;
/// Rounds of untangling.
const ROUNDS: usize = 8;

/// A rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Area {
    /// Left.
    pub x: usize,
    /// Top.
    pub y: usize,
    /// Width.
    pub width: usize,
    /// Height.
    pub height: usize,
}

/// Where everything goes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Layout {
    /// Of each frame.
    pub frames: Vec<Area>,
    /// Of each block.
    pub blocks: Vec<Area>,
    /// The whole picture.
    pub size: (usize, usize),
}

/// The places of a model's parts. The same model always gives the same.
pub fn of(model: &Model) -> Layout {
    let columns = ordered(model, columns(model));
    let mut layout = Layout {
        blocks: model.blocks.iter().map(size).collect(),
        ..Layout::default()
    };
    let mut right = 2 * MARGIN;
    for column in &columns {
        let width = column.iter().map(|ix| layout.blocks[*ix].width).max();
        for ix in column {
            layout.blocks[*ix].x = right;
        }
        right += width.unwrap_or_default() + GAP;
    }
    let right = right.saturating_sub(GAP).max(14 * MARGIN) + MARGIN;
    let mut top = MARGIN + 2 * LINE;
    for frame in 0..model.frames.len() {
        let height = stack(model, &columns, frame, top, &mut layout);
        layout.frames.push(Area {
            x: MARGIN,
            y: top,
            width: right - MARGIN,
            height,
        });
        top += height + MARGIN;
    }
    // Below it, what the colours mean.
    layout.size = (right + MARGIN, top + LINE + MARGIN);
    layout
}

/// Puts the blocks of one frame below each other, each column in the middle; gives the height of the frame.
fn stack(
    model: &Model,
    columns: &[Vec<usize>],
    frame: usize,
    top: usize,
    layout: &mut Layout,
) -> usize {
    let own = |column: &Vec<usize>| -> Vec<usize> {
        let own = column.iter().filter(|ix| model.blocks[**ix].frame == frame);
        own.copied().collect()
    };
    let height = |column: &[usize], layout: &Layout| -> usize {
        let blocks = column.iter().map(|ix| layout.blocks[*ix].height + BETWEEN);
        blocks.sum::<usize>().saturating_sub(BETWEEN)
    };
    let columns: Vec<Vec<usize>> = columns.iter().map(own).collect();
    let heights = columns.iter().map(|column| height(column, layout));
    let tallest = heights.max().unwrap_or_default();
    for column in &columns {
        let mut y = top + LINE + MARGIN + (tallest - height(column, layout)) / 2;
        for ix in column {
            layout.blocks[*ix].y = y;
            y += layout.blocks[*ix].height + BETWEEN;
        }
    }
    LINE + 2 * MARGIN + tallest
}

/// Width of a text.
pub fn width(text: &str) -> usize {
    text.width() * CHARACTER
}

fn size(block: &Block) -> Area {
    let widest = |ports: &[String]| {
        ports
            .iter()
            .map(|port| width(port))
            .max()
            .unwrap_or_default()
    };
    let title = width(&block.name).max(width(&block.title()));
    let ports = widest(&block.left) + widest(&block.right) + 4 * CHARACTER;
    Area {
        width: title.max(ports) + 4 * CHARACTER,
        height: (2 + block.left.len().max(block.right.len())) * LINE + LINE,
        ..Area::default()
    }
}

/// Column of each block: right of all that it gets something from, circles aside.
fn columns(model: &Model) -> Vec<Vec<usize>> {
    let count = model.blocks.len();
    let mut to: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); count];
    for wire in &model.wires {
        if wire.from.0 != wire.to.0 {
            to[wire.from.0].insert(wire.to.0);
        }
    }
    let order = without_circles(&mut to);
    let mut rank = vec![0; count];
    for ix in order {
        for next in &to[ix] {
            rank[*next] = rank[*next].max(rank[ix] + 1);
        }
    }
    let tied: BTreeSet<usize> = model
        .wires
        .iter()
        .flat_map(|w| [w.from.0, w.to.0])
        .collect();
    let width = rank.iter().max().map_or(1, |last| last + 1);
    // What has no wires is spread out, at least to a square.
    let loose = count - tied.len();
    let width = width.max((1..).find(|side| side * side >= loose).unwrap_or(1));
    let mut columns = vec![Vec::new(); width];
    let mut next = 0;
    for ix in 0..count {
        if tied.contains(&ix) {
            columns[rank[ix]].push(ix);
        } else {
            columns[next % width].push(ix);
            next += 1;
        }
    }
    columns
}

/// Takes away the edges that close circles; gives an order in which all others lead forward.
fn without_circles(to: &mut [BTreeSet<usize>]) -> Vec<usize> {
    let targets: BTreeSet<usize> = to.iter().flatten().copied().collect();
    let sources = (0..to.len()).filter(|ix| !targets.contains(ix));
    let starts: Vec<usize> = sources.chain(0..to.len()).collect();
    let mut state = vec![Walk::New; to.len()];
    let mut order = Vec::new();
    for start in starts {
        // An own stack: systems may be long chains.
        let mut path = vec![start];
        while let Some(&ix) = path.last() {
            if state[ix] == Walk::New {
                state[ix] = Walk::Open;
                to[ix].retain(|next| state[*next] != Walk::Open);
            }
            match to[ix]
                .iter()
                .copied()
                .find(|next| state[*next] == Walk::New)
            {
                Some(next) => path.push(next),
                None => {
                    if state[ix] == Walk::Open {
                        state[ix] = Walk::Done;
                        order.push(ix);
                    }
                    path.pop();
                }
            }
        }
    }
    order.reverse();
    order
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Walk {
    New,
    Open,
    Done,
}

/// Sorts each column so that wires cross less: by frame, then by the middle of the neighbours.
fn ordered(model: &Model, mut columns: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut place = vec![0; model.blocks.len()];
    let mark = |column: &[usize], place: &mut Vec<usize>| {
        for (at, ix) in column.iter().enumerate() {
            place[*ix] = at;
        }
    };
    for column in &mut columns {
        column.sort_by_key(|ix| (model.blocks[*ix].frame, *ix));
        mark(column, &mut place);
    }
    for round in 0..ROUNDS {
        let forward = round % 2 == 0;
        let mut turns: Vec<usize> = (0..columns.len()).collect();
        if !forward {
            turns.reverse();
        }
        for at in turns {
            let middle = |ix: usize| middle(model, &place, ix, forward);
            columns[at].sort_by_cached_key(|ix| (model.blocks[*ix].frame, middle(*ix)));
            mark(&columns[at], &mut place);
        }
    }
    columns
}

/// The mean place of what a block is connected to on one side, in hundredths; its own place when that is nothing.
fn middle(model: &Model, place: &[usize], ix: usize, forward: bool) -> usize {
    let ends = model.wires.iter().filter_map(|wire| {
        let (own, other) = if forward {
            (wire.to, wire.from)
        } else {
            (wire.from, wire.to)
        };
        (own.0 == ix).then_some(place[other.0] * 100 + other.1)
    });
    let ends: Vec<usize> = ends.collect();
    match ends.len() {
        0 => place[ix] * 100,
        count => ends.iter().sum::<usize>() / count,
    }
}
