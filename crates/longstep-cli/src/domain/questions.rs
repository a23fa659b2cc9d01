//! The questions of `longstep domain new`.

use anyhow::Result;
use longstep::domain::{ActionAnswer, Answers, KindAnswer, guess_removed};

use crate::output::remark;
use crate::question::ask;

/// Actions that are asked for; more can be added to answers.toml.
const ACTIONS: usize = 50;

/// Asks about a robot. The questions go to stderr, one answer a line.
pub(super) fn answers(name: &str) -> Result<Answers> {
    remark!("A few questions about the robot. An empty line takes the answer in brackets.");
    let robot = ask("What is the robot called in a sentence? \"the ...\"", "robot")?.unwrap_or_default();
    let mut answers = Answers {
        name: name.to_owned(),
        robot: Some(robot.clone()),
        ..Answers::default()
    };
    let things = ask(
        "Which kinds of things does it move or carry? (with commas: box, letter)",
        "box",
    )?;
    let places = ask(
        "Which kinds of places and furniture stay where they are? (shelf, door)",
        "shelf",
    )?;
    for (stays, list) in [(false, things), (true, places)] {
        for kind in split(&list.unwrap_or_default(), ',') {
            answers.kind.push(KindAnswer {
                name: kind,
                stays,
                examples: Vec::new(),
            });
        }
    }
    remark!("Now its actions, each with its kinds: \"pick up a box\", \"put a box on a shelf\", \"open a door\".");
    remark!(
        "Separate sentences by \";\". \"no box\" and \"any box\" mean all of them, \"not\" the opposite, \"-\" nothing."
    );
    while answers.action.len() < ACTIONS {
        let number = answers.action.len() + 1;
        let Some(words) = ask(&format!("Action {number} (empty: no more)"), "")?.filter(|words| !words.is_empty())
        else {
            break;
        };
        let example = format!("Before it, what has to hold? (the {robot} holds the box; the box is on a shelf)");
        let needs = ask(&example, "-")?.unwrap_or_default();
        let then = loop {
            match ask("After it, what holds? (the box is on the shelf)", "")? {
                Some(then) if then.is_empty() => remark!("An action without a result is of no use in a plan."),
                then => break then.unwrap_or_default(),
            }
        };
        let mut action = ActionAnswer {
            words,
            needs: sentences(&needs),
            then: sentences(&then),
            no_longer: None,
        };
        let guess = guess_removed(&answers, &action).join("; ");
        let default = if guess.is_empty() { "-" } else { &guess };
        let removed = ask("After it, what holds no longer?", default)?.unwrap_or_default();
        action.no_longer = Some(sentences(&removed));
        answers.action.push(action);
    }
    Ok(answers)
}

fn split(text: &str, separator: char) -> Vec<String> {
    let parts = text
        .split(separator)
        .map(str::trim)
        .filter(|part| !part.is_empty() && *part != "-");
    parts.map(str::to_owned).collect()
}

fn sentences(text: &str) -> Vec<String> {
    split(text, ';')
}

/// Writes the answers as a file for `--from`.
pub(super) fn written(answers: &Answers) -> String {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let list = |texts: &[String]| {
        let texts: Vec<String> = texts.iter().map(|text| quoted(text)).collect();
        format!("[{}]", texts.join(", "))
    };
    let mut text = format!(
        "# The answers that this domain was made from: change them and make it anew with\n\
         # longstep domain new FOLDER --from answers.toml\nname = {}\n",
        quoted(&answers.name)
    );
    if let Some(robot) = &answers.robot {
        text.push_str(&format!("robot = {}\n", quoted(robot)));
    }
    for kind in &answers.kind {
        text.push_str(&format!(
            "\n[[kind]]\nname = {}\nstays = {}\n",
            quoted(&kind.name),
            kind.stays
        ));
    }
    for action in &answers.action {
        text.push_str(&format!(
            "\n[[action]]\nwords = {}\nneeds = {}\nthen = {}\nno_longer = {}\n",
            quoted(&action.words),
            list(&action.needs),
            list(&action.then),
            list(action.no_longer.as_deref().unwrap_or_default())
        ));
    }
    text
}
