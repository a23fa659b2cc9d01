//! The processes of this machine, as far as Linux shows them in `/proc`. On other systems nothing is known.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// A moment at which a process began. No two processes with the same number have the same one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Moment {
    /// The identifier of the boot.
    boot: String,
    /// The time since then, in ticks of the clock.
    ticks: u64,
}

/// The state of a process.
#[derive(Debug, PartialEq)]
struct State {
    has_ended: bool,
    parent: u32,
    group: u32,
    ticks: u64,
}

/// Returns the moment at which a process began; none if that is not known.
pub(crate) fn begun(process: u32) -> Option<Moment> {
    let ticks = state(process)?.ticks;
    Some(Moment { boot: boot()?, ticks })
}

/// Returns the processes of a group that run, without one process and its children. The group has the number of its first process,
/// which began at this moment.
pub(crate) fn in_group(group: u32, started: &Moment, without: Option<u32>) -> Vec<u32> {
    if boot().as_ref() != Some(&started.boot) {
        return Vec::new();
    }
    // The number of a process is given again only after its group is gone.
    if state(group).is_some_and(|first| first.ticks != started.ticks) {
        return Vec::new();
    }
    let is_left_out = |process: u32, state: &State| without.is_some_and(|own| [process, state.parent].contains(&own));
    let mut found = all();
    found.retain(|process| {
        let state = state(*process);
        state.is_some_and(|own| own.group == group && !own.has_ended && !is_left_out(*process, &own))
    });
    found
}

/// Returns the processes of this user that have opened a file.
pub(crate) fn holding(path: &Path) -> Vec<u32> {
    let Ok(path) = path.canonicalize() else {
        return Vec::new();
    };
    let holds = |process: &u32| {
        let files = fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten();
        let mut targets = files.filter_map(|file| fs::read_link(file.ok()?.path()).ok());
        targets.any(|target| target == path)
    };
    all().into_iter().filter(holds).collect()
}

fn all() -> Vec<u32> {
    let entries = fs::read_dir("/proc").into_iter().flatten();
    let number = |entry: std::io::Result<fs::DirEntry>| entry.ok()?.file_name().to_str()?.parse().ok();
    let mut numbers: Vec<u32> = entries.filter_map(number).collect();
    numbers.sort_unstable();
    numbers
}

fn boot() -> Option<String> {
    let text = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    Some(text.trim().to_owned())
}

fn state(process: u32) -> Option<State> {
    parsed(&fs::read_to_string(format!("/proc/{process}/stat")).ok()?)
}

/// Reads a line of `/proc/N/stat`: the name in it may hold spaces and parentheses.
fn parsed(line: &str) -> Option<State> {
    let (_, rest) = line.rsplit_once(')')?;
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let number = |index: usize| fields.get(index)?.parse::<u64>().ok();
    Some(State {
        has_ended: matches!(*fields.first()?, "Z" | "X" | "x"),
        parent: u32::try_from(number(1)?).ok()?,
        group: u32::try_from(number(2)?).ok()?,
        ticks: number(19)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn process_state_is_read_for_any_program_name() {
        let line = "42 (a) b (c)) S 7 40 40 0 -1 4194560 1 0 0 0 0 0 0 0 20 0 1 0 12345 0 0";
        let expected = State {
            has_ended: false,
            parent: 7,
            group: 40,
            ticks: 12345,
        };
        assert_eq!(parsed(line), Some(expected));
        assert_eq!(parsed("42 (sh) S"), None);
        assert_eq!(parsed(""), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_is_in_its_group() {
        let own = std::process::id();
        let group = state(own).unwrap().group;
        let first = begun(group).unwrap_or_else(|| begun(own).unwrap());
        assert!(in_group(group, &first, None).contains(&own));
        assert!(!in_group(group, &first, Some(own)).contains(&own));
        let other = Moment {
            boot: "other".to_owned(),
            ..first
        };
        assert!(in_group(group, &other, None).is_empty());
    }
}
