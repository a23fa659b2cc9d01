//! Capabilities and size of the terminal.

use std::io::IsTerminal;

/// Columns and lines where they are not known.
const USUAL: (usize, usize) = (80, 24);

#[expect(clippy::disallowed_methods, reason = "asks only, and prints nothing")]
fn shows_results() -> bool {
    std::io::stdout().is_terminal()
}

/// Returns true if a person reads what goes to stderr.
#[expect(clippy::disallowed_methods, reason = "asks only, and prints nothing")]
pub(crate) fn shows_remarks() -> bool {
    std::io::stderr().is_terminal()
}

/// Returns false if lines cannot be drawn again: stderr is no terminal, or a dumb one.
pub(crate) fn can_redraw() -> bool {
    let is_dumb = std::env::var("TERM").is_ok_and(|terminal| terminal == "dumb");
    shows_remarks() && !is_dumb
}

/// Returns true if a board of several lines can be drawn below what is printed.
pub(crate) fn can_draw_board() -> bool {
    can_redraw() && shows_results()
}

/// Returns true if the results may have characters for lines: the locale is one of UTF-8, and the terminal is not a dumb one.
pub(crate) fn draws_lines() -> bool {
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    if variable("TERM").is_some_and(|terminal| terminal == "dumb") {
        return false;
    }
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
    match locale.map(|locale| locale.to_ascii_lowercase()) {
        Some(locale) => locale.contains("utf-8") || locale.contains("utf8"),
        // Windows has no locale in its environment, and its terminals have these characters.
        None => cfg!(windows),
    }
}

/// The columns of the terminal that shows the results; none where they go to a pipe or a file.
pub(crate) fn columns() -> Option<usize> {
    (shows_results() && shows_remarks()).then(|| terminal_size().0)
}

/// The columns and lines of the terminal.
#[cfg(unix)]
#[expect(clippy::disallowed_methods, reason = "asks only, and prints nothing")]
pub(crate) fn terminal_size() -> (usize, usize) {
    let size = rustix::termios::tcgetwinsize(std::io::stderr()).ok();
    let known = size.filter(|size| size.ws_col > 0 && size.ws_row > 0);
    known.map_or(USUAL, |size| (size.ws_col.into(), size.ws_row.into()))
}

/// The columns and lines of a usual terminal.
#[cfg(not(unix))]
pub(crate) fn terminal_size() -> (usize, usize) {
    USUAL
}
