//! The rows as one SVG: a bar for each median on a logarithmic scale, a line from the minimum to the 95th percentile, and what was
//! published in 2011.

use crate::bench::scene::Scene;
use crate::bench::stats::Row;
use crate::bench::svg::{Svg, WIDTH};

/// Left and right of the plot.
const PLOT: (f64, f64) = (250.0, 800.0);
/// Where the first row begins.
const TOP: f64 = 78.0;
/// From one row to the next.
const STEP: f64 = 22.0;
/// Height of a bar.
const BAR: f64 = 12.0;
/// Left end of the axis, milliseconds.
const LEAST: f64 = 0.01;
/// What launching one component took in 2011, milliseconds, and how ("Table 3" of the paper).
const OF_2011: [(f64, &str); 3] = [(37.0, "agent"), (84.0, "process"), (178.0, "SSH")];

/// Colour of a row, by how it launches.
fn colour(row: &str) -> &'static str {
    match row.split('-').next() {
        Some("agent") => "#1f8a4c",
        Some("system") => "#2f7fd6",
        Some("ssh") => "#d98200",
        _ => "#8c959f",
    }
}

/// The text of the file.
pub fn render(rows: &[Row], scene: &Scene) -> String {
    let bottom = TOP + STEP * rows.len() as f64;
    let most = rows.iter().map(|row| row.p95).fold(1000.0, f64::max);
    let (first, last) = (LEAST.log10(), most.log10().ceil());
    let x = |ms: f64| {
        let share = (ms.max(LEAST).log10() - first) / (last - first);
        PLOT.0 + share * (PLOT.1 - PLOT.0)
    };
    let mut out = Svg::new(bottom + 66.0, "Time to launch a component");
    let title = "Time until a component is Active, milliseconds per component: median, and from minimum to 95th percentile";
    out.text((20.0, 24.0), "start", title);
    for power in (first as i32)..=(last as i32) {
        let ms = 10_f64.powi(power);
        out.line((x(ms), TOP - 6.0), (x(ms), bottom));
        out.text((x(ms), bottom + 16.0), "middle", &ms.to_string());
    }
    for (place, (ms, how)) in OF_2011.into_iter().enumerate() {
        let y = TOP - 40.0 + 13.0 * place as f64;
        let dashes = " stroke-width=\"1.4\" stroke-dasharray=\"5 4\"";
        let path = format!("M{:.1} {:.1}L{:.1} {bottom:.1}", x(ms), y + 3.0, x(ms));
        out.path("#d6336c", dashes, &path);
        out.text((x(ms) + 3.0, y), "start", &format!("2011: {how} {ms}"));
    }
    for (place, row) in rows.iter().enumerate() {
        let y = TOP + STEP * place as f64;
        let middle = y + BAR / 2.0;
        out.text((PLOT.0 - 8.0, middle + 4.0), "end", &row.row);
        let length = (x(row.median_ms_per_component) - PLOT.0).max(0.5);
        out.rectangle((PLOT.0, y), (length, BAR), colour(&row.row));
        let path = format!(
            "M{:.1} {middle:.1}L{:.1} {middle:.1}",
            x(row.min),
            x(row.p95)
        );
        out.path("#6e7781", " stroke-width=\"1.6\"", &path);
        let shown = format!("{:.2}", row.median_ms_per_component);
        let at = x(row.p95.max(row.median_ms_per_component)) + 5.0;
        out.text((at.min(WIDTH - 50.0), middle + 4.0), "start", &shown);
    }
    let scene = format!(
        "{}, {}, {} CPUs, Linux {}, {} build",
        scene.date, scene.machine, scene.cpus, scene.kernel, scene.build
    );
    out.text((20.0, bottom + 46.0), "start", &scene);
    out.finish()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn each_row_has_a_bar_and_longer_is_further_right() {
        let row = |name: &str, ms| Row::new(name, 1, vec![Duration::from_millis(ms)]);
        let rows = [row("agent-1-same", 1), row("ssh-loop-1", 1000)];
        let text = render(&rows, &Scene::begin("dev"));
        let lengths: Vec<f64> = text
            .lines()
            .filter(|line| line.contains("height=\"12.0\""))
            .filter_map(|line| {
                line.split("width=\"")
                    .nth(1)?
                    .split('"')
                    .next()?
                    .parse()
                    .ok()
            })
            .collect();
        let [short, long] = lengths[..] else {
            panic!("two bars, not {lengths:?}");
        };
        // One and a thousand milliseconds are two and five powers of ten above the left end.
        assert!((long / short - 2.5).abs() < 0.01, "{short} {long}");
        assert!(text.contains("2011: SSH 178") && text.ends_with("</svg>\n"));
    }
}
