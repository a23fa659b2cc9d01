//! A run that is cut off at any byte and taken up again is the run that was not cut off.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use longstep::domain::{self, Domain};
use longstep::session::{Settings, Strategy};
use longstep_eval::folder::{self, FolderError, Plan, RunFolder, VERSION};
use longstep_eval::run::Lines;
use longstep_eval::suite::{self, Files, Suite};
use longstep_eval::{Alone, Campaign, Choice, Queue, Recorded, Source, Turn, kept_text, lengths, read_kept, units};

const DESK: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "on_something(<desk>)"}}"#;

const CASES: &str = "
[[case]]
id = 'pen'
scene = 'desk'
says = 'The pen belongs on the shelf.'
goal = 'put(pen, shelf)'
[[case]]
id = 'chain'
scene = 'desk'
steps = [{ says = 'Shelve the cup.', goal = 'put(cup, shelf)' }, { says = 'Put the cup back on the desk.', goal = 'put(cup, desk)' }]
[[case]]
id = 'comb'
scene = 'desk'
says = 'Put the comb on the shelf.'
expect = 'question'
";

/// Two trials. In the second one another thing than the pen is spoken of, and the chain's first two replies are no replies.
const REPLIES: &str = r#"[
    {"case": "pen", "reply": {"goal": "put(pen, shelf)", "left_out": [], "question": ""}},
    {"case": "chain", "round": 0, "reply": {"goal": "put(cup, shelf)", "left_out": [], "question": ""}},
    {"case": "chain", "round": 1, "reply": {"goal": "put(cup, desk)", "left_out": [], "question": ""}},
    {"case": "comb", "reply": {"goal": "", "left_out": [], "question": "Which comb?"}},
    {"case": "pen", "trial": 2, "reply": {"goal": "put(cup, shelf)", "left_out": [], "question": ""}},
    {"case": "chain", "trial": 2, "round": 0, "reply": "no idea"},
    {"case": "chain", "trial": 2, "round": 1, "reply": "no idea at all"},
    {"case": "chain", "trial": 2, "round": 2, "reply": {"goal": "put(cup, shelf)", "left_out": [], "question": ""}},
    {"case": "chain", "trial": 2, "round": 3, "reply": {"goal": "put(cup, desk)", "left_out": [], "question": ""}},
    {"case": "comb", "trial": 2, "reply": {"goal": "put(cup, shelf)", "left_out": [], "question": ""}}
]"#;

fn suite() -> (Arc<Domain>, Suite) {
    let domain = domain::shipped("household").unwrap().unwrap();
    let files = Files {
        folder: "mine/".to_owned(),
        suite: "name = 'mine'\nabout = 'A desk.'\ndomain = 'household'".to_owned(),
        cases: [("cases.toml".to_owned(), CASES.to_owned())].into(),
        scenes: [("desk".to_owned(), DESK.to_owned())].into(),
    };
    let suite = suite::load(&files, &domain).unwrap_or_else(|faults| panic!("{faults}"));
    (Arc::new(domain), suite)
}

fn plan(trials: u32) -> Plan {
    Plan {
        version: VERSION,
        longstep: "0".to_owned(),
        suite: "mine".to_owned(),
        suite_sha256: String::new(),
        domain: "household".to_owned(),
        domain_sha256: String::new(),
        model: "recorded replies".to_owned(),
        model_sha256: None,
        server: None,
        settings: Settings::default().with_strategy(Strategy::Goal),
        adapters: "catalogue".to_owned(),
        temperature: 0.0,
        top_p: None,
        seed: 0,
        trials,
        tags: Vec::new(),
        cases: Vec::new(),
        wordings: Vec::new(),
        changes: Vec::new(),
    }
}

/// Runs what is missing in the folder, with so many workers; returns how many units that were.
fn go_on(folder: &Path, jobs: usize) -> usize {
    go_on_with(folder, jobs, &Alone)
}

fn go_on_with<Q: Queue<Error = Infallible>>(folder: &Path, jobs: usize, queue: &Q) -> usize {
    let (domain, suite) = suite();
    let choice = Choice {
        trials: 2,
        ..Choice::default()
    };
    let all = units(&suite, &choice);
    let plan = plan(2);
    let (mut run, _) = RunFolder::open(folder, &plan, None, &lengths(&all)).unwrap();
    let rest = &all[run.units_done()..];
    let campaign = Campaign {
        suite: &suite,
        domain,
        settings: plan.settings,
        jobs,
    };
    let source = || Box::new(Recorded::read(REPLIES).unwrap()) as Box<dyn Source>;
    let outcome: Result<(), Box<dyn Error + Send + Sync>> =
        campaign.run(rest, queue, &source, &AtomicBool::new(false), &|_| {}, |lines| {
            run.add(&lines).unwrap();
            Ok(())
        });
    outcome.unwrap();
    rest.len()
}

fn bytes(folder: &Path) -> Vec<u8> {
    std::fs::read(folder.join("results.jsonl")).unwrap()
}

#[test]
fn evaluation_resumes_after_a_cut_at_any_byte() {
    let whole = tempfile::tempdir().unwrap();
    assert_eq!(go_on(whole.path(), 1), 6);
    let results = folder::read(whole.path()).unwrap();
    let right: Vec<bool> = results.attempts.iter().map(|attempt| attempt.correct).collect();
    assert_eq!(right, [true, true, true, true, false, false, false, false]);
    let timings = std::fs::read(whole.path().join("timings.jsonl")).unwrap();
    let all = bytes(whole.path());
    // Nothing is left to do, and nothing changes.
    assert_eq!((go_on(whole.path(), 1), bytes(whole.path())), (0, all.clone()));

    // The timings of a unit are written first, so they may be ahead; every fifth place is plenty.
    for cut in (0..all.len()).step_by(all.len() / 40) {
        let part = tempfile::tempdir().unwrap();
        std::fs::copy(whole.path().join("run.json"), part.path().join("run.json")).unwrap();
        std::fs::write(part.path().join("results.jsonl"), &all[..cut]).unwrap();
        std::fs::write(part.path().join("timings.jsonl"), &timings).unwrap();
        go_on(part.path(), 1 + cut % 3);
        assert_eq!(bytes(part.path()), all, "cut off at byte {cut}");
        assert_eq!(folder::read(part.path()).unwrap().timings.len(), 8);
    }
}

#[test]
fn several_workers_write_identical_results() {
    let (one, several) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    go_on(one.path(), 1);
    go_on(several.path(), 4);
    assert_eq!(bytes(one.path()), bytes(several.path()));
}

/// A queue in memory: for each unit its lines as text; none while somebody runs it.
#[derive(Default)]
struct Shared {
    units: Mutex<BTreeMap<usize, Option<String>>>,
    /// The units that were run, in order.
    run: Mutex<Vec<usize>>,
}

impl Queue for Shared {
    type Right = ();
    type Error = Infallible;

    fn turn(&self, number: usize) -> Result<Turn<()>, Infallible> {
        let mut units = self.units.lock().unwrap();
        Ok(match units.get(&number) {
            Some(Some(text)) => Turn::Done(read_kept(text).unwrap()),
            Some(None) => Turn::Elsewhere,
            None => {
                units.insert(number, None);
                Turn::Mine(())
            }
        })
    }

    fn keep(&self, number: usize, lines: Lines) -> Result<Lines, Infallible> {
        self.run.lock().unwrap().push(number);
        let text = kept_text(&lines);
        self.units.lock().unwrap().insert(number, Some(text));
        Ok(lines)
    }
}

#[test]
fn programs_that_share_a_queue_have_identical_results_and_run_each_unit_once() {
    let one = tempfile::tempdir().unwrap();
    go_on(one.path(), 1);
    for _ in 0..20 {
        let queue = Shared::default();
        let folders: Vec<_> = (0..3).map(|_| tempfile::tempdir().unwrap()).collect();
        std::thread::scope(|scope| {
            for (number, folder) in folders.iter().enumerate() {
                let queue = &queue;
                scope.spawn(move || go_on_with(folder.path(), 1 + number, queue));
            }
        });
        for folder in &folders {
            assert_eq!(bytes(folder.path()), bytes(one.path()));
        }
        let mut run = queue.run.into_inner().unwrap();
        run.sort_unstable();
        assert_eq!(run, [0, 1, 2, 3, 4, 5]);
    }
}

#[test]
fn run_folder_refuses_to_overwrite_another_run() {
    let folder = tempfile::tempdir().unwrap();
    go_on(folder.path(), 1);
    let before = bytes(folder.path());
    let error = RunFolder::open(folder.path(), &plan(3), None, &[]).unwrap_err();
    assert!(matches!(&error, FolderError::Another { differing, .. } if differing == &["trials was 2 and is 3"]));
    assert_eq!(bytes(folder.path()), before);
}
