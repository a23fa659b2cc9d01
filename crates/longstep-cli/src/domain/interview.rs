//! The order of the questions of `longstep domain new`.
//!
//! An interview is a function of the answers so far: it reads them from the start and ends at the first question without an
//! answer. So an answer can be taken back, and kept answers can be used again, without a state of its own.

use longstep_author::{
    ActionAnswer, AnswerMistake, Answers, KindAnswer, action_mistake, guess_removed, guess_start, missed_removals,
    misspelt_kind, replace_state, same_state, sentence_mistake, start_mistake, unmade_states, unused_kinds,
};

/// Actions that are asked for; more can be added to answers.toml.
const ACTIONS: usize = 50;

/// The end of an interview that has no answer to its next question.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct NextQuestion {
    /// The question.
    pub(super) text: String,
    /// The answer of an empty line; empty if there is none.
    pub(super) default: String,
    /// Explanations that belong before it.
    pub(super) introduction: Vec<String>,
    /// The mistake in the last answer, which has to be given again.
    pub(super) rejected: Option<AnswerMistake>,
}

/// The answers that were given, and the place of the next one.
struct Given<'a> {
    answers: &'a [String],
    at: usize,
}

impl Given<'_> {
    /// Returns the answer to the question.
    fn take(&mut self, question: NextQuestion) -> Result<&str, Box<NextQuestion>> {
        match self.answers.get(self.at) {
            Some(answer) => {
                self.at += 1;
                Ok(answer)
            }
            None => Err(Box::new(question)),
        }
    }

    /// Returns the answer to the question, unless it has a mistake.
    fn take_right(
        &mut self,
        question: NextQuestion,
        mistake: impl Fn(&str) -> Option<AnswerMistake>,
    ) -> Result<&str, Box<NextQuestion>> {
        let again = question.clone();
        let answer = self.take(question)?;
        match mistake(answer) {
            None => Ok(answer),
            rejected => Err(Box::new(NextQuestion { rejected, ..again })),
        }
    }
}

fn question(text: impl Into<String>, default: &str) -> NextQuestion {
    NextQuestion {
        text: text.into(),
        default: default.to_owned(),
        ..NextQuestion::default()
    }
}

fn mistake(message: &str, hint: &str) -> Option<AnswerMistake> {
    Some(AnswerMistake {
        message: message.to_owned(),
        hint: hint.to_owned(),
    })
}

/// Reads the answers; returns the next question if they do not suffice.
pub(super) fn interview(name: &str, given: &[String]) -> Result<Answers, Box<NextQuestion>> {
    let given = &mut Given { answers: given, at: 0 };
    let mut answers = Answers {
        name: name.to_owned(),
        ..Answers::default()
    };
    let introduced = NextQuestion {
        introduction: vec![
            "Questions about the robot: who it is, what it handles, its actions, and a first world.".to_owned(),
            "An empty line takes the answer in brackets. \"back\" goes to the previous question.".to_owned(),
            "Answers are kept: after Ctrl-C, the same command goes on where you were.".to_owned(),
        ],
        ..question("What is the robot called in a sentence? \"the ...\"", "robot")
    };
    answers.robot = Some(given.take(introduced)?.to_owned());
    kinds(&mut answers, given)?;
    while answers.action.len() < ACTIONS && (action(&mut answers, given)? || wants_more(&mut answers, given)?) {}
    for state in unmade_states(&answers) {
        let text = format!(
            "No action makes \"{}\" true. Is it the same as \"{}\"? (yes or no)",
            state.needed, state.made
        );
        if yes_or_no(given, question(text, "yes"))? {
            replace_state(&mut answers, &state);
        }
    }
    first_world(&mut answers, given)?;
    confirm(&answers, given)?;
    Ok(answers)
}

fn kinds(answers: &mut Answers, given: &mut Given<'_>) -> Result<(), Box<NextQuestion>> {
    let things = question(
        "Which kinds of things does it move or carry? (one kind for all that are handled alike; with commas: box, letter)",
        "box",
    );
    let things = split(given.take(things)?, ',');
    let places = question(
        "Which kinds of places and furniture stay where they are? (shelf, door)",
        "shelf",
    );
    let known = things.clone();
    let places = given.take_right(places, |text| {
        let all: Vec<String> = known.iter().cloned().chain(split(text, ',')).collect();
        let twice = all.iter().enumerate().find(|(at, name)| all[..*at].contains(name));
        if let Some((_, name)) = twice {
            return mistake(&format!("`{name}` is in both lists"), "a kind either moves or stays");
        }
        all.is_empty()
            .then(|| mistake("there are no kinds", "name at least one kind of things or places"))
            .flatten()
    })?;
    for (stays, list) in [(false, things), (true, split(places, ','))] {
        answers.kind.extend(list.into_iter().map(|name| KindAnswer {
            name,
            stays,
            examples: Vec::new(),
        }));
    }
    Ok(())
}

/// Reads the answers about one action; returns false after the last one.
fn action(answers: &mut Answers, given: &mut Given<'_>) -> Result<bool, Box<NextQuestion>> {
    let number = answers.action.len() + 1;
    let examples = Examples::of(answers);
    let mut first = question(format!("Action {number} (empty: no more)"), "");
    if number == 1 {
        first.text = format!("Action 1, with its kinds ({})", examples.actions);
        first.introduction = vec![
            "Now the actions, one after another. The same state is always written in the same words.".to_owned(),
            format!(
                "Separate sentences by \";\". \"no {0}\" and \"any {0}\" mean all of them, \"not\" the opposite, \"-\" nothing.",
                examples.kind
            ),
        ];
    }
    let so_far = answers.clone();
    let words = given
        .take_right(first, |words| match (words, number) {
            ("" | "-", 1) => mistake("a robot needs an action", "write what it does: \"open a door\""),
            ("" | "-", _) => None,
            _ => action_mistake(&so_far, words),
        })?
        .to_owned();
    if matches!(words.as_str(), "" | "-") {
        return Ok(false);
    }
    let words = spelled(answers, given, words)?;
    let mut action = ActionAnswer {
        words: words.clone(),
        ..ActionAnswer::default()
    };
    let needs = format!("Before \"{words}\", what has to hold? ({})", examples.before);
    action.needs = states(answers, &action, given, question(needs, "-"), true)?;
    let then = question(format!("After it, what holds? ({})", examples.after), "");
    action.then = states(answers, &action, given, then, false)?;
    let guess = guess_removed(answers, &action).join("; ");
    let default = if guess.is_empty() { "-" } else { &guess };
    let removed = states(
        answers,
        &action,
        given,
        question("After it, what holds no longer?", default),
        true,
    )?;
    action.no_longer = Some(removed);
    answers.action.push(action);
    for missed in missed_removals(answers) {
        let words = &answers.action[missed.action].words;
        let text = format!(
            "After \"{words}\", does \"{}\" hold no longer? (yes or no)",
            missed.state
        );
        if yes_or_no(given, question(text, "yes"))? {
            let removed = answers.action[missed.action].no_longer.get_or_insert_default();
            removed.push(missed.state);
        }
    }
    Ok(true)
}

/// Asks whether kinds without an action are left out; returns true for more actions.
fn wants_more(answers: &mut Answers, given: &mut Given<'_>) -> Result<bool, Box<NextQuestion>> {
    let unused = unused_kinds(answers);
    if unused.is_empty() {
        return Ok(false);
    }
    let text = format!(
        "No action is about: {}. Leave that out? (yes, or no for more actions)",
        unused.join(", ")
    );
    if yes_or_no(given, question(text, "yes"))? {
        answers.kind.retain(|kind| !unused.contains(&kind.name));
        return Ok(false);
    }
    Ok(true)
}

fn yes_or_no(given: &mut Given<'_>, question: NextQuestion) -> Result<bool, Box<NextQuestion>> {
    let answer = given.take_right(question, |answer| match is_yes(answer) {
        Some(_) => None,
        None => mistake("this is neither yes nor no", "answer yes or no"),
    })?;
    Ok(is_yes(answer) == Some(true))
}

/// Reads sentences about states, and asks about other words for a known state.
fn states(
    answers: &Answers,
    action: &ActionAnswer,
    given: &mut Given<'_>,
    question: NextQuestion,
    may_be_empty: bool,
) -> Result<Vec<String>, Box<NextQuestion>> {
    let text = given.take_right(question, |text| {
        let all = split(text, ';');
        if all.is_empty() && !may_be_empty {
            return mistake(
                "an action without a result is of no use in a plan",
                "say what is different afterwards",
            );
        }
        all.iter().find_map(|own| sentence_mistake(answers, own))
    })?;
    let mut action = action.clone();
    let mut sentences = Vec::new();
    for sentence in split(text, ';') {
        let mut own = spelled(answers, given, sentence)?;
        if let Some(known) = same_state(answers, &action, &own) {
            let text = format!("Is \"{own}\" the same as \"{known}\"? (yes or no)");
            if yes_or_no(given, self::question(text, "yes"))? {
                own = known;
            }
        }
        action.needs.push(own.clone());
        sentences.push(own);
    }
    Ok(sentences)
}

/// Asks about a word that is nearly a kind; returns the sentence with the kind that is meant.
fn spelled(answers: &Answers, given: &mut Given<'_>, sentence: String) -> Result<String, Box<NextQuestion>> {
    let Some(misspelt) = misspelt_kind(answers, &sentence) else {
        return Ok(sentence);
    };
    let text = format!("Is \"{}\" the kind \"{}\"? (yes or no)", misspelt.word, misspelt.kind);
    Ok(if yes_or_no(given, question(text, "yes"))? {
        misspelt.mended(&sentence)
    } else {
        sentence
    })
}

fn is_yes(answer: &str) -> Option<bool> {
    match answer.to_lowercase().as_str() {
        "yes" | "y" => Some(true),
        "no" | "n" => Some(false),
        _ => None,
    }
}

/// Reads the examples of each kind, and what holds at the start.
fn first_world(answers: &mut Answers, given: &mut Given<'_>) -> Result<(), Box<NextQuestion>> {
    for index in 0..answers.kind.len() {
        let name = answers.kind[index].name.clone();
        let default = if answers.kind[index].stays {
            format!("left {name}, right {name}")
        } else {
            format!("red {name}, blue {name}")
        };
        let mut text = question(
            format!("Which ones of the kind \"{name}\" are there? (with commas)"),
            &default,
        );
        if index == 0 {
            text.introduction =
                vec!["Now a first world to try the robot in: some things by name, and where they are.".to_owned()];
        }
        let before = answers.clone();
        let examples = given.take_right(text, |text| examples_mistake(&before, &name, &examples_of(text)))?;
        answers.kind[index].examples = examples_of(examples);
    }
    let guess = guess_start(answers).join("; ");
    let default = if guess.is_empty() { "-" } else { &guess };
    let text = question(
        "What holds at the start? (sentences with these names, separated by \";\")",
        default,
    );
    let start = given.take_right(text, |text| {
        split(text, ';').iter().find_map(|own| start_mistake(answers, own))
    })?;
    answers.start = split(start, ';');
    Ok(())
}

/// Returns the names of things; an article before a name is none of its words.
fn examples_of(text: &str) -> Vec<String> {
    let bare = |name: String| match name.split_once(' ') {
        Some((article, rest)) if matches!(article.to_lowercase().as_str(), "the" | "a" | "an") => rest.to_owned(),
        _ => name,
    };
    split(text, ',').into_iter().map(bare).collect()
}

fn examples_mistake(answers: &Answers, kind: &str, examples: &[String]) -> Option<AnswerMistake> {
    if examples.is_empty() {
        return mistake(
            "a first world needs one of each kind",
            &format!("name one: \"red {kind}\""),
        );
    }
    let taken = |name: &&String| {
        answers
            .kind
            .iter()
            .any(|own| own.examples.contains(name) || own.name == **name && own.name != kind)
    };
    if let Some(name) = examples.iter().find(taken) {
        return mistake(
            &format!("`{name}` is the name of something else"),
            "give each thing a name of its own",
        );
    }
    let twice = examples
        .iter()
        .enumerate()
        .find(|(at, name)| examples[..*at].contains(name));
    twice.and_then(|(_, name)| mistake(&format!("`{name}` is there twice"), "give each thing a name of its own"))
}

/// Shows all answers, and asks whether the domain is made of them.
fn confirm(answers: &Answers, given: &mut Given<'_>) -> Result<(), Box<NextQuestion>> {
    let last = NextQuestion {
        introduction: summary(answers),
        ..question("Is this right? (yes, or \"back\" to change the last answers)", "yes")
    };
    given.take_right(last, |answer| match is_yes(answer) {
        Some(true) => None,
        _ => mistake(
            "nothing is written yet",
            "\"back\" goes to the previous question; after Ctrl-C the answers are kept",
        ),
    })?;
    Ok(())
}

/// Returns the answers as lines.
fn summary(answers: &Answers) -> Vec<String> {
    let listed = |texts: &[String]| match texts {
        [] => "nothing".to_owned(),
        texts => texts.join("; "),
    };
    let mut lines = vec![format!("The {} and its world:", name_of_robot(answers))];
    for kind in &answers.kind {
        let stays = if kind.stays { "stays" } else { "moves" };
        lines.push(format!("  {} ({stays}): {}", kind.name, kind.examples.join(", ")));
    }
    for action in &answers.action {
        lines.push(format!("  {}", action.words));
        lines.push(format!("    before: {}", listed(&action.needs)));
        lines.push(format!("    after: {}", listed(&action.then)));
        lines.push(format!(
            "    no longer: {}",
            listed(action.no_longer.as_deref().unwrap_or_default())
        ));
    }
    lines.push(format!("  at the start: {}", listed(&answers.start)));
    lines
}

fn name_of_robot(answers: &Answers) -> String {
    let name = answers.robot.as_deref().unwrap_or("robot");
    name.strip_prefix("the ").unwrap_or(name).to_owned()
}

/// Examples in the questions, with the author's own words.
struct Examples {
    kind: String,
    actions: String,
    before: String,
    after: String,
}

impl Examples {
    fn of(answers: &Answers) -> Self {
        let robot = name_of_robot(answers);
        let first = |stays: bool| {
            answers
                .kind
                .iter()
                .find(|kind| kind.stays == stays)
                .map(|kind| kind.name.as_str())
        };
        match (first(false), first(true)) {
            (Some(thing), Some(place)) => Self {
                kind: thing.to_owned(),
                actions: format!("\"pick up a {thing}\", \"put a {thing} on a {place}\""),
                before: format!("the {robot} holds the {thing}; the {thing} is on a {place}"),
                after: format!("the {thing} is on the {place}"),
            },
            (thing, place) => {
                let kind = thing.or(place).unwrap_or("box");
                Self {
                    kind: kind.to_owned(),
                    actions: format!("\"go to a {kind}\", \"clean a {kind}\""),
                    before: format!("the {robot} is at the {kind}; the {kind} is dirty"),
                    after: format!("the {kind} is clean"),
                }
            }
        }
    }
}

fn split(text: &str, separator: char) -> Vec<String> {
    let parts = text.split(separator).map(str::trim);
    parts
        .filter(|part| !part.is_empty() && *part != "-")
        .map(str::to_owned)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives the answers one after another, as a person does; "back" takes one back. Returns the last question.
    fn last_question(lines: &[&str]) -> Result<Answers, Box<NextQuestion>> {
        let mut given: Vec<String> = Vec::new();
        for line in lines {
            let next = interview("mine", &given).unwrap_err();
            match *line {
                "back" => drop(given.pop()),
                "" => given.push(next.default),
                line => given.push(line.to_owned()),
            }
            if interview("mine", &given).is_err_and(|next| next.rejected.is_some()) && lines.last() != Some(line) {
                given.pop();
            }
        }
        interview("mine", &given)
    }

    const PICK: [&str; 7] = [
        "porter",
        "box",
        "shelf",
        "pick up a box",
        "the box is on a shelf; the porter holds no box",
        "the porter holds the box",
        "",
    ];

    #[test]
    fn interview_derives_the_next_question_from_the_answers() {
        for (lines, text, default) in [
            (&[][..], "What is the robot called", "robot"),
            (&PICK[..2], "Which kinds of places", "shelf"),
            (&PICK[..6], "what holds no longer", "the box is on a shelf"),
            (&PICK, "Action 2", ""),
            (
                &[&PICK[..], &["back"]].concat(),
                "what holds no longer",
                "the box is on a shelf",
            ),
            (
                &[&PICK[..], &[""]].concat(),
                "Which ones of the kind \"box\"",
                "red box, blue box",
            ),
            (
                &[&PICK[..], &["", "", ""]].concat(),
                "What holds at the start",
                "the red box is on the left shelf; the blue box is on the right shelf",
            ),
            (&[&PICK[..], &["", "", "", ""]].concat(), "Is this right?", "yes"),
            (
                &[&PICK[..], &["put a box on a shelf", "the porter is holding the box"]].concat(),
                "Is \"the porter is holding the box\" the same as \"the porter holds the box\"?",
                "yes",
            ),
            (
                &[
                    &PICK[..],
                    &["wash a box", "the porter has the box", "the box is clean", "", ""],
                ]
                .concat(),
                "No action makes \"the porter has the box\" true. Is it the same as \"the porter holds the box\"?",
                "yes",
            ),
        ] {
            let found = last_question(lines).unwrap_err();
            assert!(found.text.contains(text), "{}", found.text);
            assert_eq!(found.default, default);
            assert_eq!(found.rejected, None);
        }
        let answers = last_question(&[&PICK[..], &["", "", "", "", "yes"]].concat()).unwrap();
        assert_eq!(answers.kind[1].examples, ["left shelf", "right shelf"]);
        assert_eq!(answers.action.len(), 1);
    }

    #[test]
    fn interview_repeats_a_question_after_an_invalid_answer() {
        for (lines, expected) in [
            (&["porter", "box", "box"][..], "`box` is in both lists"),
            (&["porter", "box", "shelf", "sing"], "does not name what it is done to"),
            (&["porter", "box", "shelf", ""], "a robot needs an action"),
            (
                &["porter", "box", "shelf", "pick up boxes"],
                "\"boxes\" is more than one box",
            ),
            (
                &["porter", "box", "shelf", "pick, put a box"],
                "is more than one action",
            ),
            (
                &[&PICK[..4], &["the box is on a shelf, the porter holds no box"]].concat(),
                "is more than one sentence",
            ),
            (&[&PICK[..5], &["-"]].concat(), "without a result"),
            (&[&PICK[..], &["pick up a box"]].concat(), "there is an action"),
            (
                &[&PICK[..], &["", "red box, red box"]].concat(),
                "`red box` is there twice",
            ),
            (
                &[&PICK[..], &["", "", "", "the red box is wet"]].concat(),
                "no action speaks of",
            ),
            (
                &[&PICK[..], &["", "", "", "the box is on the left shelf"]].concat(),
                "does not say which box",
            ),
            (&[&PICK[..], &["", "", "", "", "no"]].concat(), "nothing is written yet"),
        ] {
            let found = last_question(lines).unwrap_err();
            let message = found.rejected.map(|own| own.message).unwrap_or_default();
            assert!(message.contains(expected), "{expected}: {message}");
        }
    }
}
