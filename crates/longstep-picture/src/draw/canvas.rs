//! Elements of an SVG, with every text escaped.

use std::fmt::Write as _;

use longstep_core::visible;

use super::text::Font;
use super::theme::{self, Paint};

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Area {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Area {
    pub(crate) fn right(self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(self) -> f64 {
        self.y + self.height
    }
}

/// A line of text with its baseline.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) text: String,
    pub(crate) font: Font,
    pub(crate) paint: Paint,
}

/// Options of a picture: its width in pixels, from which the height follows, its title, and the start of its ids.
///
/// ```
/// use longstep_picture::SvgOptions;
/// let options = SvgOptions::new(360.0).with_prefix("step-3").with_title("After step 3").without_style();
/// assert_ne!(options, SvgOptions::new(360.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SvgOptions {
    pub(crate) width: f64,
    /// The start of all ids; none for one that follows from the content.
    prefix: Option<String>,
    pub(crate) title: String,
    style: bool,
}

/// The least and the greatest width of a picture in pixels.
const WIDTHS: (f64, f64) = (120.0, 8_000.0);

impl SvgOptions {
    /// Creates options for a width in pixels, between 120 and 8,000.
    pub fn new(width: f64) -> Self {
        let width = if width.is_finite() { width } else { WIDTHS.0 };
        Self {
            width: width.clamp(WIDTHS.0, WIDTHS.1).floor(),
            prefix: None,
            title: String::new(),
            style: true,
        }
    }

    /// Sets the start of all ids, which otherwise follows from the content, so that different pictures fit on one page.
    /// Characters other than ASCII letters, digits, `-` and `_` are left out.
    #[must_use]
    pub fn with_prefix(mut self, prefix: &str) -> Self {
        let is_plain = |c: &char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        self.prefix = Some(prefix.chars().filter(is_plain).collect());
        self
    }

    /// Sets the title, for readers who do not see the picture.
    #[must_use]
    pub fn with_title(mut self, title: &str) -> Self {
        title.clone_into(&mut self.title);
        self
    }

    /// Leaves out the stylesheet, for a page that has [`stylesheet`](super::stylesheet) once.
    #[must_use]
    pub fn without_style(mut self) -> Self {
        self.style = false;
        self
    }
}

/// Returns a number that different texts hardly share (FNV-1a).
fn digest(texts: [&str; 3]) -> u32 {
    let bytes = texts.iter().flat_map(|text| text.bytes());
    bytes.fold(0x811c_9dc5, |digest, byte| {
        (digest ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    })
}

/// An SVG that is written.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    body: String,
}

impl Canvas {
    /// Returns the whole picture with its frame. A drawing that is wider than the picture is scaled down.
    pub(crate) fn finish(self, options: &SvgOptions, drawn: (f64, f64), title: &str, description: &str) -> String {
        let mut out = String::with_capacity(self.body.len() + 4_096);
        let scale = options.width / drawn.0;
        let (width, height) = (number(drawn.0), number(drawn.1.ceil()));
        let of_content = || format!("longstep-{:08x}", digest([title, description, self.body.as_str()]));
        let prefix = options.prefix.clone().unwrap_or_else(of_content);
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" id=\"{prefix}\" class=\"ls-picture\" role=\"img\" \
             aria-labelledby=\"{prefix}-title {prefix}-desc\" width=\"{}\" height=\"{}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{}\">",
            number(options.width),
            number((drawn.1.ceil() * scale).ceil()),
            theme::FONTS
        );
        let _ = write!(out, "<title id=\"{prefix}-title\">{}</title>", escaped(title));
        let _ = write!(out, "<desc id=\"{prefix}-desc\">{}</desc>", escaped(description));
        if options.style {
            let _ = write!(out, "<style>{}</style>", theme::stylesheet());
        }
        let _ = write!(
            out,
            "<rect width=\"{width}\" height=\"{height}\"{}/>",
            theme::PAPER.attributes()
        );
        out.push_str(&self.body);
        out.push_str("</svg>\n");
        out
    }

    /// Begins a group with data for scripts: names with their values.
    pub(crate) fn begin(&mut self, class: &str, data: &[(&str, &str)]) {
        let _ = write!(self.body, "<g class=\"{class}\"");
        for (name, value) in data {
            let _ = write!(self.body, " data-{name}=\"{}\"", escaped(value));
        }
        self.body.push('>');
    }

    pub(crate) fn end(&mut self) {
        self.body.push_str("</g>");
    }

    /// Adds the text that a pointer over the group shows.
    pub(crate) fn title(&mut self, text: &str) {
        let _ = write!(self.body, "<title>{}</title>", escaped(text));
    }

    pub(crate) fn rect(&mut self, area: Area, radius: f64, paint: Paint) {
        let _ = write!(
            self.body,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"{}\"{}/>",
            number(area.x),
            number(area.y),
            number(area.width),
            number(area.height),
            number(radius),
            paint.attributes()
        );
    }

    pub(crate) fn circle(&mut self, (x, y): (f64, f64), radius: f64, paint: Paint) {
        let _ = write!(
            self.body,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\"{}/>",
            number(x),
            number(y),
            number(radius),
            paint.attributes()
        );
    }

    /// Adds a path of straight lines through the points, moved by an offset.
    pub(crate) fn line(&mut self, points: &[(f64, f64)], (x, y): (f64, f64), paint: Paint) {
        let mut path = String::new();
        for (index, (dx, dy)) in points.iter().enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{} {}", number(x + dx), number(y + dy));
        }
        let _ = write!(self.body, "<path d=\"{path}\"{}/>", paint.attributes());
    }

    /// Adds a line of text. It must fit: it is not shortened.
    pub(crate) fn text(&mut self, line: &Line) {
        let Line {
            x,
            y,
            text,
            font,
            paint,
        } = line;
        let weight = if font.bold { " font-weight=\"600\"" } else { "" };
        let _ = write!(
            self.body,
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\"{weight}{}>{}</text>",
            number(*x),
            number(*y),
            number(font.size),
            paint.attributes(),
            escaped(text)
        );
    }
}

/// Escapes a text for XML, with hidden and control characters made visible.
fn escaped(text: &str) -> String {
    let shown = visible::line(text);
    let mut escaped = String::with_capacity(shown.len() + 8);
    for character in shown.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Writes a coordinate with at most one decimal place.
fn number(value: f64) -> String {
    let tenths = (value * 10.0).round() / 10.0;
    format!("{tenths}")
}
