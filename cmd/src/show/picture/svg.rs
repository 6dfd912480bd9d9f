//! A picture as SVG. All text is escaped; nothing is loaded from elsewhere.

use rts_schemas::system::PortKind;

use super::layout::{Area, CHARACTER, FONT, LINE, Layout, MARGIN, width};
use super::model::{Block, Model, Wire};

/// States, and their colours: fill and text. As the RT System Editor shows them.
const STATES: [(&str, &str, &str); 5] = [
    ("Created", "#ffffff", "#000000"),
    ("Inactive", "#2f6fdf", "#ffffff"),
    ("Active", "#90ee90", "#000000"),
    ("Error", "#d92626", "#ffffff"),
    ("Unknown", "#000000", "#ffffff"),
];
/// Half the side of a port's square.
const PORT: usize = 4;
/// How far below its components a backward connector goes.
const SWING: usize = 14;

/// The text of the file.
pub fn render(model: &Model, layout: &Layout) -> String {
    let (wide, high) = layout.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide}\" height=\"{high}\" viewBox=\"0 0 {wide} {high}\" \
         font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"{FONT}\">\n"
    );
    out.push_str(&format!("<title>system/{}</title>\n", escaped(&model.name)));
    out.push_str(&format!(
        "<rect width=\"{wide}\" height=\"{high}\" fill=\"#ffffff\"/>\n"
    ));
    let head = (MARGIN, MARGIN + LINE);
    out.push_str(&text(
        head,
        "start",
        "#000000",
        true,
        &format!("system/{}", model.name),
    ));
    for (name, area) in model.frames.iter().zip(&layout.frames) {
        out.push_str(&frame(name, *area));
    }
    for wire in &model.wires {
        out.push_str(&curve(wire, model, layout));
    }
    for (block, area) in model.blocks.iter().zip(&layout.blocks) {
        out.push_str(&component(block, *area));
    }
    out.push_str(&legend(MARGIN, high - MARGIN));
    out.push_str("</svg>\n");
    out
}

fn frame(name: &str, area: Area) -> String {
    let rect = rect(area, 8, "fill=\"#f6f6f6\" stroke=\"#999999\"");
    let at = (area.x + MARGIN / 2, area.y + LINE);
    rect + &text(at, "start", "#555555", false, &format!("node {name}"))
}

fn component(block: &Block, area: Area) -> String {
    let (fill, ink) = colours(&block.state);
    let dashes = if block.stand_in {
        " stroke-dasharray=\"6 3\""
    } else {
        ""
    };
    let mut out = format!(
        "<g><title>{}: {}, {}</title>\n",
        escaped(&block.name),
        escaped(&block.title()),
        escaped(&block.state)
    );
    let style = format!("fill=\"{fill}\" stroke=\"#333333\"{dashes}");
    out.push_str(&rect(area, 4, &style));
    let middle = area.x + area.width / 2;
    out.push_str(&text(
        (middle, area.y + LINE),
        "middle",
        ink,
        true,
        &block.name,
    ));
    out.push_str(&text(
        (middle, area.y + 2 * LINE),
        "middle",
        ink,
        false,
        &block.title(),
    ));
    for (at, name) in block.left.iter().enumerate() {
        let (x, y) = left(area, at);
        out.push_str(&square(x, y));
        out.push_str(&text((x + 2 * PORT, y + PORT), "start", ink, false, name));
    }
    for (at, name) in block.right.iter().enumerate() {
        let (x, y) = right(area, at);
        out.push_str(&square(x, y));
        out.push_str(&text((x - 2 * PORT, y + PORT), "end", ink, false, name));
    }
    out.push_str("</g>\n");
    out
}

fn curve(wire: &Wire, model: &Model, layout: &Layout) -> String {
    let (x1, y1) = right(layout.blocks[wire.from.0], wire.from.1);
    let (x2, y2) = left(layout.blocks[wire.to.0], wire.to.1);
    let path = if x2 > x1 {
        let pull = (x2 - x1) / 2;
        format!("C {} {y1}, {} {y2}, {x2} {y2}", x1 + pull, x2 - pull)
    } else {
        // A backward one swings out on both sides, and goes below its two components.
        let (from, to) = (layout.blocks[wire.from.0], layout.blocks[wire.to.0]);
        let low = (from.y + from.height).max(to.y + to.height) + SWING;
        let (right, left) = (x1 + 4 * SWING, x2.saturating_sub(4 * SWING));
        let middle = (x1 + x2) / 2;
        format!("C {right} {y1}, {right} {low}, {middle} {low} S {left} {y2}, {x2} {y2}")
    };
    let colour = match wire.state.as_str() {
        "Connected" => "#333333",
        "Connecting" => "#d98200",
        "Disconnected" => "#d92626",
        _ => "#888888",
    };
    let dashes = match wire.kind {
        PortKind::Data => "",
        PortKind::Service => " stroke-dasharray=\"2 3\"",
    };
    let (from, to) = (&model.blocks[wire.from.0], &model.blocks[wire.to.0]);
    let name = if wire.name.is_empty() {
        format!("{} to {}", from.name, to.name)
    } else {
        wire.name.clone()
    };
    format!(
        "<path d=\"M {x1} {y1} {path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"{dashes}>\
         <title>{}: {}</title></path>\n",
        escaped(&name),
        escaped(&wire.state)
    )
}

/// What the colours mean.
fn legend(x: usize, y: usize) -> String {
    let mut out = String::new();
    let mut x = x;
    for (state, fill, _) in STATES {
        let area = Area {
            x,
            y: y - FONT,
            width: FONT,
            height: FONT,
        };
        out.push_str(&rect(
            area,
            2,
            &format!("fill=\"{fill}\" stroke=\"#333333\""),
        ));
        x += FONT + CHARACTER;
        out.push_str(&text((x, y - 2), "start", "#555555", false, state));
        x += width(state) + 2 * CHARACTER;
    }
    out
}

/// Fill and text of a state.
fn colours(state: &str) -> (&'static str, &'static str) {
    let known = STATES.iter().find(|(name, ..)| *name == state);
    let (_, fill, ink) = known.unwrap_or(&STATES[4]);
    (fill, ink)
}

fn left(area: Area, port: usize) -> (usize, usize) {
    (area.x, area.y + (port + 3) * LINE - PORT / 2)
}

fn right(area: Area, port: usize) -> (usize, usize) {
    let (x, y) = left(area, port);
    (x + area.width, y)
}

fn square(x: usize, y: usize) -> String {
    let area = Area {
        x: x - PORT,
        y: y - PORT,
        width: 2 * PORT,
        height: 2 * PORT,
    };
    rect(area, 0, "fill=\"#ffffff\" stroke=\"#333333\"")
}

fn rect(area: Area, radius: usize, style: &str) -> String {
    let Area {
        x,
        y,
        width,
        height,
    } = area;
    let round = if radius > 0 {
        format!(" rx=\"{radius}\"")
    } else {
        String::new()
    };
    format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{round} {style}/>\n")
}

fn text(at: (usize, usize), anchor: &str, ink: &str, bold: bool, text: &str) -> String {
    let (x, y) = at;
    let weight = if bold { " font-weight=\"bold\"" } else { "" };
    format!(
        "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" fill=\"{ink}\"{weight}>{}</text>\n",
        escaped(text)
    )
}

/// Text that XML takes as it is.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
