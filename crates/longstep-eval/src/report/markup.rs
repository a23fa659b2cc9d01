//! The HTML frame of a page, and its building blocks.

use longstep_core::visible;

/// The style sheet of all pages.
const STYLE: &str = include_str!("page.css");

/// The script that opens attempts on top of the page. Without it, links lead to them further down.
const SCRIPT: &str = include_str!("page.js");

/// The parts of a page.
#[derive(Debug)]
pub(crate) struct Page {
    /// Plain text.
    pub(crate) title: String,
    /// The line below the title, as plain text.
    pub(crate) about: String,
    /// HTML.
    pub(crate) body: String,
}

/// The complete file.
pub(crate) fn whole(page: &Page) -> String {
    let title = escaped(&page.title);
    let about = escaped(&page.about);
    let body = &page.body;
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<header><h1>{title}</h1><p>{about}</p></header>\n<main>\n{body}</main>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )
}

/// Escapes text for HTML, between tags and in quoted attributes. Invisible characters become visible escapes.
pub(crate) fn escaped(text: &str) -> String {
    let mut markup = String::with_capacity(text.len());
    for letter in visible::block(text).chars() {
        match letter {
            '&' => markup.push_str("&amp;"),
            '<' => markup.push_str("&lt;"),
            '>' => markup.push_str("&gt;"),
            '"' => markup.push_str("&quot;"),
            '\'' => markup.push_str("&#39;"),
            other => markup.push(other),
        }
    }
    markup
}

/// A section of a page with its heading; empty if the body is empty.
pub(super) fn section(id: &str, heading: &str, body: &str) -> String {
    if body.is_empty() {
        String::new()
    } else {
        format!("<section id=\"{id}\"><h2>{heading}</h2>\n{body}</section>\n")
    }
}

/// A wide table in a box of its own, which scrolls instead of the page. It is reachable, and scrollable, with the
/// keyboard.
pub(super) fn scrolling(name: &str, table: &str) -> String {
    format!("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{name}\">{table}</div>\n")
}
