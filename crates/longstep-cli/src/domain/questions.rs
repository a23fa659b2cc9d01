//! The questions of `longstep domain new`.

use std::io::IsTerminal;

use anyhow::Result;
use longstep_author::Answers;

use super::interview::{NextQuestion, interview};
use super::kept_answers::KeptAnswers;
use crate::failure::Failure;
use crate::output::{Style, remark};
use crate::question::ask;

/// Asks about a robot. The questions go to stderr, one answer a line; "back" takes the last answer back.
pub(super) fn answers(name: &str) -> Result<Answers> {
    let keeps = std::io::stdin().is_terminal();
    let mut given = if keeps { kept(name)? } else { Vec::new() };
    let mut taken_back: Option<String> = None;
    loop {
        let next = match interview(name, &given) {
            Ok(answers) => return Ok(answers),
            Err(next) => *next,
        };
        if let Some(mistake) = &next.rejected {
            remark!("{} {}", "error:".red().bold(), mistake.message);
            remark!("{} {}", "hint:".cyan().bold(), mistake.hint);
            given.pop();
        } else if taken_back.is_none() {
            next.introduction.iter().for_each(|line| remark!("{line}"));
        }
        let default = taken_back.take().unwrap_or_else(|| next.default.clone());
        match ask(&next.text, &default)? {
            None if keeps => {
                let failure = Failure::unreadable("the questions are not finished");
                return Err(failure
                    .hint("the answers are kept: the same command goes on here")
                    .into());
            }
            // A pipe may leave out the last answers.
            None => given.push(at_end(&next)?),
            Some(answer) if answer == "back" => match given.pop() {
                Some(last) => taken_back = Some(last),
                None => remark!("This is the first question."),
            },
            Some(answer) => given.push(answer),
        }
        if keeps {
            let folder = name.to_owned();
            let answers = given.clone();
            KeptAnswers { folder, answers }.write();
        }
    }
}

/// Returns the answer to a question after the end of the input.
fn at_end(question: &NextQuestion) -> Result<String> {
    match &question.rejected {
        None => Ok(question.default.clone()),
        Some(mistake) => Err(
            Failure::unreadable(format!("the input ends after a mistake: {}", mistake.message))
                .hint(mistake.hint.clone())
                .into(),
        ),
    }
}

/// Offers the answers of an interview that was interrupted.
fn kept(name: &str) -> Result<Vec<String>> {
    let Some(mut kept) = KeptAnswers::read() else {
        return Ok(Vec::new());
    };
    // A mistake that was kept is asked for again.
    if interview(name, &kept.answers).is_err_and(|next| next.rejected.is_some()) {
        kept.answers.pop();
    }
    let count = kept.answers.len();
    let text = format!(
        "{count} answers for `{}` are kept. Go on with them? (yes or no)",
        kept.folder
    );
    let default = if kept.folder == name { "yes" } else { "no" };
    match ask(&text, default)?.as_deref() {
        Some("no" | "n") => {
            KeptAnswers::remove();
            Ok(Vec::new())
        }
        _ => {
            if let Some(last) = kept.answers.last() {
                remark!("Your last answer was: {last}");
            }
            Ok(kept.answers)
        }
    }
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
    text.push_str(&format!("start = {}\n", list(&answers.start)));
    for kind in &answers.kind {
        text.push_str(&format!(
            "\n[[kind]]\nname = {}\nstays = {}\nexamples = {}\n",
            quoted(&kind.name),
            kind.stays,
            list(&kind.examples)
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
