//! What the pictures of benchmarks share: an SVG of one size, light or dark by what the reader prefers.

use std::fmt::Write;

/// Width of every picture.
pub const WIDTH: f64 = 860.0;

/// A picture that is being drawn.
pub struct Svg {
    text: String,
}

impl Svg {
    /// An empty one of this height; `title` is for those who cannot see it.
    pub fn new(height: f64, title: &str) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
             font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"12\">\n\
             <style>.b{{fill:#ffffff}}.t{{fill:#24292f;stroke:#ffffff;stroke-width:3px;paint-order:stroke}}.g{{stroke:#d0d7de}}\
             @media(prefers-color-scheme:dark){{.b{{fill:#0d1117}}.t{{fill:#c9d1d9;stroke:#0d1117}}.g{{stroke:#30363d}}}}</style>\n\
             <title>{title}</title>\n\
             <rect class=\"b\" width=\"{WIDTH}\" height=\"{height}\"/>\n"
        );
        Self { text }
    }

    /// A thin line of the grid.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let _ = writeln!(
            self.text,
            "<path class=\"g\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    /// A path of a colour; `style` is further attributes.
    pub fn path(&mut self, colour: &str, style: &str, path: &str) {
        let _ = writeln!(
            self.text,
            "<path fill=\"none\" stroke=\"{colour}\"{style} d=\"{path}\"/>"
        );
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, at: (f64, f64), size: (f64, f64), colour: &str) {
        let _ = writeln!(
            self.text,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>",
            at.0, at.1, size.0, size.1
        );
    }

    /// A line of text; `anchor` is `start`, `middle` or `end`.
    pub fn text(&mut self, at: (f64, f64), anchor: &str, text: &str) {
        let _ = writeln!(
            self.text,
            "<text class=\"t\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{text}</text>",
            at.0, at.1
        );
    }

    /// The text of the file.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}
