//! The page of a server: HTML for the person who gives instructions, approves plans and watches runs.
//!
//! Every function is from the [`Hub`](crate::Hub) to HTML or from a form to the hub; the network is in `http`. The page works without
//! a script: each change is a form. `page.js` replaces the part of the page that changes ([`Sheet::fragment`]), moves the
//! slider, and sends the stop beside everything else.
//!
//! HTML is written with maud, which escapes every text when it compiles the template; [`Sheet::html`] makes hidden
//! characters visible in the whole document.

mod audit;
mod deed;
mod form;
mod goal;
mod listing;
mod picture;
mod plan;
mod proposal;
mod run;
mod session;
mod sheet;
mod shown;
mod start;
#[cfg(test)]
mod tests;

pub(crate) use audit::audit;
pub(crate) use deed::{Next, RunDeed, SessionDeed, act_on_run, act_on_session, begin_session};
pub(crate) use form::{Attempt, Fields};
pub(crate) use run::run;
pub(crate) use session::session;
pub(crate) use sheet::{Sheet, failed, stranger};
pub(crate) use shown::Look;
pub(crate) use start::start;

/// The script of the page.
pub(crate) const SCRIPT: &str = include_str!("page.js");

/// The style sheet of the page, with the rules of the pictures.
pub(crate) fn style() -> String {
    format!("{}\n{}", include_str!("page.css"), picture::stylesheet())
}

/// The icon of the page: two boxes and the step between them.
pub(crate) const ICON: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><rect width="32" height="32" rx="7" fill="#2f5fae"/><path d="M7 22h7v-6h7v-6h4" fill="none" stroke="#fff" stroke-width="3.2" stroke-linecap="round" stroke-linejoin="round"/></svg>"##;
