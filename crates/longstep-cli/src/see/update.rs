//! `longstep see --update`: a new look at the world of a session.

use anyhow::Result;
use longstep::perception::observation;
use longstep::session::{Event, ObserveError, Observed, Session};
use longstep_llm::{SessionFolder, load_domain};
use serde::Serialize;

use super::{LookReport, Source, UNCONFIRMED, is_yes, seen};
use crate::arguments::SeeArguments;
use crate::clock::clock;
use crate::failure::{Failure, NOT_VALID};
use crate::output::{self, print_line};
use crate::question::ask;
use crate::show;

/// A look, and its differences from the world of a session.
#[derive(Debug, Serialize)]
struct UpdateReport<'a> {
    #[serde(flatten)]
    look: &'a LookReport,
    changes: &'a [String],
    /// Entities of the look that the session does not have.
    unknown: &'a [String],
    /// Entities of the session that the look does not show; they stay as they were.
    not_seen: &'a [String],
    /// True if the session has the changes.
    stored: bool,
}

pub(super) fn run(arguments: &SeeArguments, source: &Source, named: &str) -> Result<u8> {
    let (mut folder, log) = SessionFolder::open(&crate::session::folder(named)?)?;
    let Some(Event::Begin { domain, .. }) = log.events().next() else {
        return Err(Failure::unreadable("the session has not begun").into());
    };
    let domain = load_domain(domain)?;
    let mut session = Session::resume(domain, &log, clock())?.session;
    let seen = seen(arguments, &session.domain().clone(), source)?;
    if !seen.report.contradictions.is_empty() {
        if arguments.json {
            report(&seen.report, &Observed::default(), &[], false)?;
        }
        return Ok(NOT_VALID);
    }
    let look = &seen.report.environment;
    let listed = |name: &String| look.assets.contains(name) || look.objects.contains(name);
    let own = session.world().environment();
    let all = own.assets.iter().chain(&own.objects);
    let not_seen: Vec<String> = all.filter(|name| !listed(name)).cloned().collect();
    let statements = observation(session.world(), look, seen.source);
    let observed = session.observed(&statements).map_err(unfit)?;
    if !arguments.json {
        show_changes(&observed, &not_seen);
    }
    let stored = seen.agreed && (arguments.yes || (!arguments.json && stores()?));
    if stored {
        folder.keep(&mut session)?;
    }
    if arguments.json {
        report(&seen.report, &observed, &not_seen, stored)?;
    } else if stored {
        print_line!("Stored in {}", folder.path().display());
    } else {
        show::hint("nothing is stored; confirm with `--yes`");
    }
    Ok(if stored { 0 } else { UNCONFIRMED })
}

fn report(look: &LookReport, observed: &Observed, not_seen: &[String], stored: bool) -> Result<()> {
    output::json(&UpdateReport {
        look,
        changes: &observed.changes,
        unknown: &observed.unknown,
        not_seen,
        stored,
    })
}

fn show_changes(observed: &Observed, not_seen: &[String]) {
    if observed.changes.is_empty() {
        print_line!("The world is as the session expects it")
    } else {
        show::list("Changed", &observed.changes)
    }
    show::list("Not in the session, and left out", &observed.unknown);
    show::list("Not seen, and left as it was", not_seen);
    output::blank();
}

fn stores() -> Result<bool> {
    let answer = ask("Store this in the session? yes or no", "no")?;
    Ok(answer.is_some_and(|answer| is_yes(&answer)))
}

fn unfit(error: ObserveError) -> Failure {
    let hint = match &error {
        ObserveError::Observation(_) => "begin a new session with the environment of this look",
        _ => "finish or cancel the instruction in `longstep chat --resume` first",
    };
    Failure::unreadable(error.to_string()).hint(hint)
}
