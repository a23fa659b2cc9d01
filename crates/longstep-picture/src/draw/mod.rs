//! Drawing: SVG elements, colours, and widths of texts.

pub(crate) mod canvas;
#[cfg(test)]
pub(crate) mod inspect;
pub(crate) mod text;
pub(crate) mod theme;

pub use canvas::SvgOptions;
pub use theme::stylesheet;
