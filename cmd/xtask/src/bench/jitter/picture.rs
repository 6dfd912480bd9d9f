//! The histograms as one SVG: how many cycles began how late, both axes logarithmic. Light and dark by what the reader prefers.

use std::fmt::Write;

use super::RATE;
use super::series::Row;
use crate::bench::svg::Svg;

const HEIGHT: f64 = 440.0;
/// Of the plot: left, top, right, bottom.
const PLOT: (f64, f64, f64, f64) = (70.0, 64.0, 840.0, 350.0);
/// One for each series; a floor has that of its component, dashed.
const COLOURS: [&str; 4] = ["#1f8a4c", "#2f7fd6", "#d98200", "#d6336c"];
/// The latest of the left edge, in nanoseconds.
const FIRST: u64 = 256;

/// What is drawn: the powers of two of its axis, and the highest count.
struct Scale {
    first: u32,
    last: u32,
    most: f64,
}

impl Scale {
    fn of(rows: &[Row]) -> Self {
        let buckets = || rows.iter().flat_map(|row| &row.jitter.buckets);
        let last = buckets().map(|(below, _)| *below).max();
        let most = buckets().map(|(_, count)| *count).max();
        Self {
            first: FIRST.ilog2(),
            last: last.unwrap_or(1 << 20).max(1 << 20).ilog2(),
            most: 10_f64.powf((most.unwrap_or(10).max(10) as f64).log10().ceil()),
        }
    }

    /// Where a lateness is, by its power of two.
    fn x(&self, power: f64) -> f64 {
        let share = (power - f64::from(self.first)) / f64::from(self.last - self.first);
        PLOT.0 + share.clamp(0.0, 1.0) * (PLOT.2 - PLOT.0)
    }

    /// Where a count is; none and one are not the same.
    fn y(&self, count: f64) -> f64 {
        let floor = 0.5_f64.log10();
        let share = (count.max(0.5).log10() - floor) / (self.most.log10() - floor);
        PLOT.3 - share * (PLOT.3 - PLOT.1)
    }
}

/// The text of the file.
pub fn render(rows: &[Row], seconds: u64) -> String {
    let scale = Scale::of(rows);
    let mut out = Svg::new(HEIGHT, &format!("Jitter of a component of {RATE} Hz"));
    let title = format!(
        "How late the cycles of a component of {RATE} Hz begin, {seconds} s each; dashed: a thread that only sleeps"
    );
    out.text((PLOT.0, 24.0), "start", &title);
    out.text((PLOT.0, 48.0), "start", "cycles");
    axes(&mut out, &scale);
    let mut names: Vec<&str> = rows.iter().map(|row| row.series.as_str()).collect();
    names.dedup();
    for row in rows {
        let place = names.iter().position(|name| *name == row.series);
        let colour = COLOURS[place.unwrap_or_default() % COLOURS.len()];
        let dashes = match row.of {
            "floor" => " stroke-width=\"1.2\" stroke-dasharray=\"5 4\"",
            _ => " stroke-width=\"2.4\"",
        };
        out.path(colour, dashes, &outline(row, &scale));
    }
    legend(&mut out, rows, &names);
    out.finish()
}

fn axes(out: &mut Svg, scale: &Scale) {
    let (left, top, right, bottom) = PLOT;
    for (nanoseconds, name) in [
        (1e3, "1 µs"),
        (1e4, "10 µs"),
        (1e5, "100 µs"),
        (1e6, "1 ms"),
        (1e7, "10 ms"),
        (1e8, "100 ms"),
        (1e9, "1 s"),
    ] {
        let power = f64::log2(nanoseconds);
        if power <= f64::from(scale.last) {
            let x = scale.x(power);
            out.line((x, top), (x, bottom));
            out.text((x, bottom + 18.0), "middle", name);
        }
    }
    let mut count = 1.0;
    while count <= scale.most {
        let y = scale.y(count);
        out.line((left, y), (right, y));
        out.text((left - 8.0, y + 4.0), "end", &count.to_string());
        count *= 10.0;
    }
    out.line((left, bottom), (right, bottom));
    out.line((left, top), (left, bottom));
}

/// Steps: each bucket from half of its end to its end.
fn outline(row: &Row, scale: &Scale) -> String {
    let mut path = format!("M{:.1} {:.1}", PLOT.0, PLOT.3);
    for power in scale.first..scale.last {
        let below = 1_u64 << (power + 1);
        let buckets = row.jitter.buckets.iter();
        // What is left of the plot is in its first step.
        let here =
            buckets.filter(|(end, _)| *end == below || (power == scale.first && *end < below));
        let count: u64 = here.map(|(_, count)| count).sum();
        let y = match count {
            0 => PLOT.3,
            some => scale.y(some as f64),
        };
        let (from, to) = (scale.x(power.into()), scale.x(f64::from(power) + 1.0));
        let _ = write!(path, "L{from:.1} {y:.1}L{to:.1} {y:.1}");
    }
    let _ = write!(path, "L{:.1} {:.1}", PLOT.2, PLOT.3);
    path
}

fn legend(out: &mut Svg, rows: &[Row], names: &[&str]) {
    let share = (PLOT.2 - PLOT.0) / COLOURS.len() as f64;
    for (place, name) in names.iter().enumerate() {
        let x = PLOT.0 + share * place as f64;
        let colour = COLOURS[place % COLOURS.len()];
        out.rectangle((x, 388.0), (14.0, 14.0), colour);
        out.text((x + 20.0, 400.0), "start", name);
        let row = rows.iter().find(|row| row.series == *name);
        if let Some(row) = row {
            let (median, max) = (short(row.jitter.median), short(row.jitter.max));
            let said = format!("median {median}, max {max}");
            out.text((x + 20.0, 420.0), "start", &said);
        }
    }
}

fn short(nanoseconds: u64) -> String {
    match nanoseconds {
        0..1_000_000 => format!("{:.0} µs", nanoseconds as f64 / 1e3),
        _ => format!("{:.1} ms", nanoseconds as f64 / 1e6),
    }
}
