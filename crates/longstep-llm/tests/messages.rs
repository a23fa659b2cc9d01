//! Whether a real model finds that somebody is to be told something: 80 instructions for development and 80 sealed ones, in nine
//! languages, 32 of each with a message. `LONGSTEP_MODEL` and `LONGSTEP_THREADS` as for `screening`.
//!
//! ```text
//! cargo test --release -p longstep-llm --features embedded --test messages -- --ignored --nocapture
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod opened;

use longstep::coverage::Gap;
use longstep::dialogue::{MessageDialogue, ScreeningDialogue};
use longstep_llm::{ChatModel, Progress, converse};

/// The instructions of one kind: all of them, those that the screening marks, and those that are confirmed.
#[derive(Debug, Default, PartialEq, Eq, Clone, Copy)]
struct Counts {
    all: usize,
    marked: usize,
    confirmed: usize,
}

/// Counts the instructions with a message, and those without.
fn measure(model: &mut dyn ChatModel, text: &str) -> [Counts; 2] {
    let mut counts = [Counts::default(); 2];
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split('|').collect();
        let [_, kind, instruction, _] = fields[..] else {
            panic!("{line}")
        };
        let own = &mut counts[usize::from(kind == "plain")];
        own.all += 1;
        let marks = converse(model, &mut ScreeningDialogue::new(instruction), &mut |_: Progress| {}).unwrap();
        if marks.iter().any(|mark| mark.gap == Gap::Quotation) {
            own.marked += 1;
            let is_told = converse(model, &mut MessageDialogue::new(instruction), &mut |_: Progress| {}).unwrap();
            own.confirmed += usize::from(is_told);
        }
    }
    counts
}

/// Most messages that the screening marks are confirmed, and few of the others.
#[test]
#[ignore = "asks a real model about 160 instructions"]
fn what_is_no_message_is_not_confirmed() {
    let mut model = opened::model();
    for (name, text) in [
        ("development", include_str!("messages/development.txt")),
        ("sealed", include_str!("messages/sealed.txt")),
    ] {
        let [told, plain] = measure(&mut *model, text);
        println!("== {name}, with a message: {told:?}");
        println!("== {name}, without one: {plain:?}");
        assert!(told.confirmed * 5 >= told.marked * 4, "{told:?}");
        assert!(plain.confirmed * 2 <= plain.marked, "{plain:?}");
    }
}
