//! The frame of every page: head, navigation, the stop, and the part that changes.

use longstep_core::visible;
use maud::{DOCTYPE, Markup, html};

use super::form::problem;
use crate::id::RunId;
use crate::problem::Problem;

/// A page before it is written.
pub(crate) struct Sheet {
    /// The title.
    pub(super) title: String,
    /// The path of the page.
    pub(super) path: String,
    /// The part that changes.
    pub(super) live: Markup,
    /// What the page follows on the live stream: a query such as `?run=ID`; none for a page that does not change.
    pub(super) follows: Option<String>,
    /// The run that the stop of this page stops; none for all robots.
    pub(super) stops: Option<Stops>,
    /// True while a robot may move.
    pub(super) is_going: bool,
    /// True if the page changes by itself soon: without a script it is loaded again.
    pub(super) is_waiting: bool,
}

/// The run that a page stops.
pub(super) struct Stops {
    pub(super) run: RunId,
    pub(super) robot: String,
}

impl Sheet {
    /// Creates a page that follows nothing.
    pub(super) fn new(title: impl Into<String>, path: impl Into<String>, live: Markup) -> Self {
        Self {
            title: title.into(),
            path: path.into(),
            live,
            follows: None,
            stops: None,
            is_going: false,
            is_waiting: false,
        }
    }

    /// Writes the part that changes.
    pub(crate) fn fragment(&self) -> String {
        visible::block(&self.main().into_string()).into_owned()
    }

    /// Writes the whole page.
    pub(crate) fn html(&self) -> String {
        let follows = self.follows.as_deref();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title, self.is_waiting))
                body data-follows=[follows] {
                    a.skip href="#live" { "Skip to the content" }
                    (navigation(&self.path))
                    (self.main())
                    (keys())
                    (self.stop())
                }
            }
        };
        visible::block(&page.into_string()).into_owned()
    }

    fn main(&self) -> Markup {
        let going = if self.is_going { "true" } else { "false" };
        html! {
            main #live tabindex="-1" data-title=(self.title) data-going=(going) { (self.live) }
        }
    }

    /// Writes the stop, which is never replaced, so that a press is never lost.
    fn stop(&self) -> Markup {
        let (to, at_once, label) = match &self.stops {
            Some(stops) => (
                format!("/runs/{}/stop", stops.run),
                format!("/api/runs/{}/stop", stops.run),
                format!("Stop {}", stops.robot),
            ),
            None => ("/stop".to_owned(), "/api/stop".to_owned(), "Stop all robots".to_owned()),
        };
        html! {
            aside #stop aria-label="Stop" {
                p #stopped role="alert" {}
                form method="post" action=(to) data-stop=(at_once) {
                    button.stop type="submit" aria-describedby="stop-keys" { (label) }
                }
                p #stop-keys { "or hold Esc" }
            }
        }
    }
}

fn head(title: &str, is_waiting: bool) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="color-scheme" content="light dark";
            title { (title) " · Longstep" }
            link rel="icon" href="/page/icon.svg" type="image/svg+xml";
            link rel="stylesheet" href="/page/page.css";
            script src="/page/page.js" defer {}
            @if is_waiting { noscript { meta http-equiv="refresh" content="3"; } }
        }
    }
}

fn navigation(path: &str) -> Markup {
    let current = |own: &str| (own == path).then_some("page");
    html! {
        header.top {
            a.brand href="/" aria-current=[current("/")] { "Longstep" }
            nav aria-label="Pages" {
                a href="/" aria-current=[current("/")] { "Start" }
                a href="/audit" aria-current=[current("/audit")] { "Audit log" }
            }
            p #link role="status" {}
        }
    }
}

/// Describes the keys. Single letters do nothing until they are switched on, for people who dictate.
fn keys() -> Markup {
    html! {
        footer.keys {
            details {
                summary { "Keys, and the limits of the stop" }
                dl {
                    dt { kbd { "Esc" } " held for a second" } dd { "stop, as the red button does" }
                    dt { kbd { "←" } " " kbd { "→" } } dd { "the step before and after, in the picture of the scene" }
                    dt { kbd { "/" } } dd { "go to the field for the instruction" }
                    dt { kbd { "Enter" } " in a field" } dd { "send it; with " kbd { "Shift" } " a new line" }
                    dt { kbd { "Tab" } " " kbd { "Enter" } } dd { "everything else" }
                }
                p { label { input #letters type="checkbox" checked; " Use " kbd { "/" } " as a key of this page" } }
                p {
                    "The stop is a request to the program that drives the robot. It does not replace the robot's own "
                    "emergency stop: keep that one within reach."
                }
            }
        }
    }
}

/// The page for a browser that has not shown the token.
pub(crate) fn stranger() -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head("Open the link", false))
            body {
                main #live.narrow {
                    h1 { "Open the link that the server printed" }
                    p {
                        "This server lets only those in who have its token. " code { "longstep serve" }
                        " prints a link with the token when it begins: open that link in this browser, once."
                    }
                    p { "You came from that link? " a href="/" { "Go on" } "." }
                    p.hint { "A program sends the header " code { "Authorization: Bearer TOKEN" } "." }
                }
            }
        }
    };
    page.into_string()
}

/// The page for a request that failed as a whole.
pub(crate) fn failed(reason: &Problem) -> Sheet {
    let live = html! {
        h1 { "This did not work" }
        (problem(reason))
        p { a href="/" { "Back to the start" } }
    };
    Sheet::new("Not done", "", live)
}
