//! The steps of a plan as planners print them.
//!
//! Fast Downward and its relatives write `(move a b)` a line, temporal planners (POPF, OPTIC, TFD, LPG) and VAL `0.003: (move a b)
//! [5.0]`, Metric-FF `step 0: MOVE A B`, Fast Downward's own output `move a b (1)`, and unified-planning `move(a, b)`. All of
//! them may stand in a log, in a list or in a fence.

use longstep_model::diagnostic::Position;

/// One word of a step, in lower case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Word {
    pub(super) text: String,
    pub(super) position: Position,
}

/// How a step is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// `(move a b)`.
    Bracketed,
    /// `move(a, b)`, as people and models write it too.
    Call,
    /// `step 0: MOVE A B`.
    Counted,
    /// `move a b (1)`.
    Priced,
}

/// A line that is a step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    pub(super) form: Form,
    /// The name of the action and its arguments.
    pub(super) words: Vec<Word>,
    /// When it begins; none in a plan without times.
    pub(super) start: Option<f64>,
    /// How long it takes.
    duration: Option<f64>,
}

/// The steps of a text.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Lines {
    /// In the order in which they begin.
    pub(super) steps: Vec<Line>,
    /// The lines that look like steps and are none.
    pub(super) misfits: Vec<Position>,
    /// True if two steps are under way at the same time.
    pub(super) overlaps: bool,
    /// The lines between its steps that are none.
    pub(super) between: Vec<Position>,
    /// Number of plans before this one; planners print each better plan behind the last one.
    pub(super) earlier: usize,
}

impl Lines {
    /// Reads the last plan of a text. `is_action` decides whether a word, in lower case, is the name of an action: a step without
    /// brackets around it is one only then, or if another step of the text has its form and such a name.
    pub(super) fn read(text: &str, is_action: impl Fn(&str) -> bool) -> Self {
        let named = [Form::Call, Form::Counted, Form::Priced].map(|form| {
            let mut lines = text.lines().map(|line| Reader::new(line, 1).line(&is_action, &[]));
            lines
                .any(|found| matches!(found, PlanLine::Step(step) if step.form == form))
                .then_some(form)
        });
        let forms: Vec<Form> = named.into_iter().flatten().collect();
        let mut plans = vec![Self::default()];
        // Lines that are between two steps if another step follows.
        let mut behind = Vec::new();
        for (index, line) in text.lines().enumerate() {
            if begins_a_plan(line) && plans.last().is_some_and(|plan| !plan.steps.is_empty()) {
                plans.push(Self::default());
                behind.clear();
            }
            let Some(plan) = plans.last_mut() else { continue };
            let reader = Reader::new(line, index + 1);
            match reader.line(&is_action, &forms) {
                PlanLine::Step(step) => {
                    plan.steps.push(step);
                    plan.between.append(&mut behind);
                }
                PlanLine::Misfit(position) => plan.misfits.push(position),
                PlanLine::Nothing if line.trim().is_empty() || line.trim_start().starts_with([';', '#']) => {}
                PlanLine::Nothing if plan.steps.is_empty() => {}
                PlanLine::Nothing => behind.push(Reader::new(line, index + 1).position(0)),
            }
        }
        plans.retain(|plan| !plan.steps.is_empty() || !plan.misfits.is_empty());
        let earlier = plans.len().saturating_sub(1);
        let mut last = plans.pop().unwrap_or_default();
        // Steps that begin at the same time stay in their order, and so do those without a time.
        last.steps.sort_by(|one, other| match (one.start, other.start) {
            (Some(one), Some(other)) => one.total_cmp(&other),
            _ => std::cmp::Ordering::Equal,
        });
        last.overlaps = last.steps.windows(2).any(|pair| pair[0].overlaps(&pair[1]));
        last.earlier = earlier;
        last
    }
}

impl Line {
    fn overlaps(&self, next: &Self) -> bool {
        match (self.start, self.duration, next.start) {
            (Some(start), Some(duration), Some(next)) => start + duration > next + 1e-9,
            _ => false,
        }
    }
}

/// Returns true for what planners print before each plan that they find, and before they print one again.
fn begins_a_plan(line: &str) -> bool {
    let line = line.to_ascii_lowercase();
    [
        "plan found",
        "solution found",
        "found a plan",
        "found legal plan",
        "makespan",
        "rescheduled plan",
        "solution number",
    ]
    .iter()
    .any(|words| line.contains(words))
}

enum PlanLine {
    Step(Line),
    Misfit(Position),
    Nothing,
}

/// A line, and how much of it is read.
struct Reader<'a> {
    line: &'a str,
    rest: &'a str,
    number: usize,
}

impl<'a> Reader<'a> {
    fn new(line: &'a str, number: usize) -> Self {
        Self {
            line,
            rest: line.trim_end(),
            number,
        }
    }

    /// Returns the place of a part of the line.
    fn offset(&self, part: &str) -> usize {
        part.as_ptr() as usize - self.line.as_ptr() as usize
    }

    /// Returns the position of a byte of the line.
    fn position(&self, offset: usize) -> Position {
        Position {
            line: u32::try_from(self.number).unwrap_or(u32::MAX),
            column: u32::try_from(offset + 1).unwrap_or(u32::MAX),
        }
    }

    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest[bytes..].trim_start();
    }

    /// Takes a number at the beginning, if one of `end` follows it.
    fn number_before(&mut self, end: &[char]) -> Option<f64> {
        let is_digit = |c: char| c.is_ascii_digit() || (c == '.' && !end.contains(&c));
        let digits = self.rest.find(|c: char| !is_digit(c))?;
        let number = self.rest[..digits].parse().ok()?;
        let behind = self.rest[digits..].trim_start();
        let end = end.iter().find(|end| behind.starts_with(**end))?;
        self.rest = behind[end.len_utf8()..].trim_start();
        Some(number)
    }

    /// Reads the line; a step in one of `forms` may have any name.
    fn line(mut self, is_action: &impl Fn(&str) -> bool, forms: &[Form]) -> PlanLine {
        self.skip(0);
        if self.rest.starts_with("- ") || self.rest.starts_with("* ") {
            self.skip(2);
        }
        let quotes = ['`', '"', '\''];
        if self.rest.starts_with(quotes) {
            self.skip(1);
        }
        let is_counted = self.rest.get(..4).is_some_and(|word| word.eq_ignore_ascii_case("step"));
        if is_counted {
            self.skip(4);
        }
        let start = self.number_before(&[':']);
        // A number of a list says nothing about time.
        let is_listed = start.is_none() && self.number_before(&['.', ')']).is_some();
        let position = self.position(self.offset(self.rest));
        let (inside, behind) = match self.rest.strip_prefix('(') {
            Some(rest) => match rest.split_once(')') {
                Some((inside, behind)) if !inside.contains('(') => {
                    self.skip(1);
                    (inside, behind)
                }
                _ => return PlanLine::Misfit(position),
            },
            None => return self.bare(start, is_counted || is_listed, is_action, forms),
        };
        let words = self.words(inside, &[]);
        if words.is_empty() {
            PlanLine::Misfit(position)
        } else {
            self.step(Form::Bracketed, words, start, behind)
        }
    }

    /// Reads a step without brackets, or with brackets behind its name.
    fn bare(self, start: Option<f64>, is_counted: bool, is_action: &impl Fn(&str) -> bool, forms: &[Form]) -> PlanLine {
        let end = |c: char| c.is_whitespace() || matches!(c, '(' | ',' | ':');
        let name = self.rest.split(end).next().unwrap_or_default();
        let is_named = is_action(&name.to_ascii_lowercase());
        let begins = name.starts_with(char::is_alphabetic);
        if !is_named && (!begins || forms.is_empty()) {
            return PlanLine::Nothing;
        }
        let may_be = |form: Form, is_whole: bool| is_named || (is_whole && forms.contains(&form));
        let behind_name = self.rest[name.len()..].trim_start();
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit());
        if let Some(arguments) = behind_name.strip_prefix('(')
            && let Some((arguments, behind)) = arguments.split_once(')')
        {
            // The cost of a step of Fast Downward's own output.
            let is_cost = is_number(arguments) && self.rest[name.len()..].starts_with(' ');
            if is_cost && may_be(Form::Priced, behind.trim().is_empty()) {
                let words = self.words(name, &[]);
                return self.step(Form::Priced, words, start, behind);
            }
            let is_joined = self.rest[name.len()..].starts_with('(');
            let is_whole = is_joined && behind.trim_matches(['`', '"', '\'', ';', ',', '.', ' ']).is_empty();
            return if may_be(Form::Call, is_whole) {
                let inside = &self.rest[..self.rest.len() - behind.len() - 1];
                let words = self.words(inside, &['(', ',', ')']);
                self.step(Form::Call, words, start, behind)
            } else {
                PlanLine::Nothing
            };
        }
        let (words, cost) = match self.rest.rsplit_once('(') {
            Some((words, cost)) => (words, Some(cost)),
            None => (self.rest, None),
        };
        let form = match cost {
            Some(cost) if cost.strip_suffix(')').is_some_and(|cost| cost.parse::<f64>().is_ok()) => Form::Priced,
            Some(_) => return PlanLine::Nothing,
            // Behind the first step, `1: PICK-UP C` counts too.
            None if is_counted || start.is_some() => Form::Counted,
            None => return PlanLine::Nothing,
        };
        if !may_be(form, true) {
            return PlanLine::Nothing;
        }
        let words = self.words(words.split('[').next().unwrap_or_default(), &[]);
        self.step(form, words, start, "")
    }

    /// Splits the words of a part of the line.
    fn words(&self, inside: &'a str, also: &[char]) -> Vec<Word> {
        let before = self.offset(inside);
        let is_end = |c: char| c.is_whitespace() || also.contains(&c);
        let mut words = Vec::new();
        let mut place = 0;
        for word in inside.split_inclusive(is_end) {
            let text = word.trim_end_matches(is_end);
            if !text.is_empty() {
                words.push(Word {
                    text: text.to_ascii_lowercase(),
                    position: self.position(before + place),
                });
            }
            place += word.len();
        }
        words
    }

    fn step(&self, form: Form, words: Vec<Word>, start: Option<f64>, behind: &str) -> PlanLine {
        let behind = behind.trim_start();
        let duration = behind.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        PlanLine::Step(Line {
            form,
            words,
            start,
            duration: duration.and_then(|(number, _)| number.trim_start_matches("D:").trim().parse().ok()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> String {
        let is_action = |word: &str| matches!(word, "move" | "pick-up" | "rest");
        let lines = Lines::read(text, is_action);
        let steps = lines.steps.iter().map(|step| {
            let words: Vec<&str> = step.words.iter().map(|word| word.text.as_str()).collect();
            words.join(" ")
        });
        steps.collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn the_notations_of_planners_are_read() {
        for (text, expected) in [
            (
                "(move a b)\n(PICK-UP c )\n; cost = 2 (unit cost)\n",
                "move a b; pick-up c",
            ),
            ("0.000: (move a b)  [5.000]\n 5.001:   (rest)\t[1]", "move a b; rest"),
            ("5: (MOVE B C) [1]\n0.0002: (MOVE A B) [5]", "move a b; move b c"),
            (
                "ff: found legal plan as follows\nstep    0: MOVE A B\n        1: PICK-UP C\n\ntime spent",
                "move a b; pick-up c",
            ),
            (
                "[t=0.1s] Solution found!\nmove a b (1)\nrest (1)\n[t=0.2s] Plan length: 2 step(s).",
                "move a b; rest",
            ),
            ("SequentialPlan:\n    move(a, b)\n    rest()", "move a b; rest"),
            ("    0.0: move(a, b) [5.0]", "move a b"),
            ("1. (move a b)\n2) rest()\n- `(rest)`", "move a b; rest; rest"),
            (
                "; Plan found with metric 9\n0: (rest) [1]\n; Plan found with metric 5\n0: (move a b) [1]",
                "move a b",
            ),
            (
                "Rescheduled Plan:\n0.1: (rest) [1]\nSolution with original makespan 2 found.\nRescheduled Makespan   : 1\n0.1: (rest) [1]",
                "rest",
            ),
            // Beside a step with a known name, one of the same form with another name is a step too.
            ("move(a, b)\nscan(c)\nThe scan(c) is last.", "move a b; scan c"),
            ("step 0: MOVE A B\n 1: SCAN C\nscan it", "move a b; scan c"),
            ("move a b (1)\nscan c (1)\nPlan cost (2): 7", "move a b; scan c"),
            ("scan(c)\nfetch(d)", ""),
            ("The robot should move carefully.\nIt can rest.\nmove it", ""),
            ("", ""),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn plan_lines_give_the_position_of_each_word() {
        let lines = Lines::read("  0.1: (move  a b)\n move(a, c)", |word| word == "move");
        let places = lines.steps.iter().flat_map(|step| &step.words);
        let places: Vec<(u32, u32)> = places.map(|word| (word.position.line, word.position.column)).collect();
        assert_eq!(places, [(1, 9), (1, 15), (1, 17), (2, 2), (2, 7), (2, 10)]);
    }

    #[test]
    fn plan_lines_detect_steps_that_overlap_in_time() {
        let overlaps = |text: &str| Lines::read(text, |_| false).overlaps;
        assert!(overlaps("0: (move a b) [5]\n4.9: (rest) [1]"));
        assert!(!overlaps("0: (move a b) [5]\n5: (rest) [1]"));
        assert!(!overlaps("(move a b)\n(rest)"));
    }
}
