//! Commands, which begin with a slash.

use std::path::Path;

use anyhow::Result;
use longstep::session::{self, RuleError, Strategy};
use longstep_core::diagnostic::nearest;
use longstep_core::plan::StepId;
use longstep_files::{create_private_folder, plain_reason};
use longstep_llm::ModelError;

use super::input::Lines;
use super::{Chat, Next, screen};
use crate::failure::Failure;
use crate::output::{counted, print_line};
use crate::{ask, explain, inputs, output, show};

const COMMANDS: [(&str, &str); 13] = [
    ("/plan", "show the current plan, or the last accepted one"),
    ("/why STEP", "show what a step achieves, and what would fail without it"),
    (
        "/explain",
        "show how your last words were understood, and why there is a question",
    ),
    ("/env", "show the current world"),
    ("/undo", "undo the last accepted plan, or cancel the current one"),
    ("/run", "carry out the accepted plans on the robot of `--robot`"),
    (
        "/observe [FILE]",
        "observe the world with the robot, or read an observation; the next plan begins there",
    ),
    (
        "/save FOLDER",
        "save the accepted plans to a folder: 0.json, 1.json, ...",
    ),
    (
        "/rules [RULE]",
        "list the rules that bind every plan, or add one: never opened(fridge)",
    ),
    ("/model NAME", "use another model from now on"),
    ("/strategy goal|direct", "let the model write a goal, or the whole plan"),
    ("/help", "show this list"),
    ("/quit", "end the conversation; the session is saved"),
];

fn unfit(error: RuleError) -> Failure {
    let hint = match &error {
        RuleError::Unknown(number) => {
            return Failure::unreadable(format!("there is no rule {}", number + 1)).hint("`/rules` lists them");
        }
        RuleError::OutOfTurn(_) => "accept the plan or `/undo` it first",
        _ => "a rule is `never GOAL`, `always GOAL` or `untouched(NAME)`",
    };
    Failure::unreadable(error.to_string()).hint(hint)
}

impl Chat<'_> {
    pub(super) fn command(&mut self, line: &str, lines: &mut Lines) -> Result<Next> {
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "plan" => screen::plan(&self.session),
            "why" => self.why(rest)?,
            "explain" => explain::readings(self.session.readings()),
            "env" => screen::environment(&self.session),
            "rules" => self.rules(rest)?,
            "undo" => self.undo()?,
            "run" => self.run_plans(lines)?,
            "observe" => self.observe(rest)?,
            "save" => self.save(rest)?,
            "model" => self.change_model(rest)?,
            "strategy" => self.change_strategy(rest)?,
            "help" => help(),
            "quit" | "exit" => return Ok(Next::Quit),
            other => {
                let words = COMMANDS.iter().filter_map(|(form, _)| form[1..].split(' ').next());
                let hint = match nearest(other, words) {
                    Some(near) => format!("did you mean `/{near}`?"),
                    None => "`/help` lists the commands".to_owned(),
                };
                return Err(Failure::unreadable(format!("there is no command `/{other}`"))
                    .hint(hint)
                    .into());
            }
        }
        Ok(Next::GoOn)
    }

    fn why(&self, rest: &str) -> Result<()> {
        let Some((world, plan, purpose, goal)) = screen::at_hand(&self.session) else {
            return Err(Failure::unreadable("there is no plan yet").into());
        };
        let length = plan.steps().len();
        if length == 0 {
            return Err(Failure::unreadable("the plan has no steps: there is nothing to do").into());
        }
        if rest.is_empty() {
            return Err(Failure::unreadable("`/why` needs the number of a step")
                .hint(format!("`/why STEP`; steps are numbered from 1 to {length}"))
                .into());
        }
        let number: Option<usize> = rest.parse().ok().filter(|number| (1..=length).contains(number));
        let Some(number) = number else {
            let failure = Failure::unreadable(format!("`{rest}` is not a step of the plan"));
            return Err(failure.hint(format!("steps are numbered from 1 to {length}")).into());
        };
        let why = session::why(world, plan, &purpose, goal, StepId::new(number - 1));
        show::list("It achieves", &why.brings_about);
        if why.without_it.is_empty() {
            output::blank();
            print_line!("Without it, the plan would still be valid.");
        } else {
            show::list("Without it", &why.without_it)
        }
        Ok(())
    }

    /// Lists the rules in force, adds one or lifts one.
    fn rules(&mut self, rest: &str) -> Result<()> {
        if rest.is_empty() {
            screen::rules(&self.session);
            return Ok(());
        }
        let lifted = rest.strip_prefix("lift ").map(str::trim);
        let notice = match lifted {
            Some(number) => {
                let number: Option<usize> = number.parse().ok().and_then(|number: usize| number.checked_sub(1));
                let number = number.ok_or_else(|| {
                    Failure::unreadable("`/rules lift` needs the number of a rule").hint("`/rules` lists them")
                })?;
                let lifted = self.session.lift_rule(number).map_err(unfit)?;
                format!("Lifted: {lifted}")
            }
            None => {
                self.session.add_rule(rest).map_err(unfit)?;
                "From now on, no plan breaks this rule; `/rules lift NUMBER` lifts it".to_owned()
            }
        };
        // The change is saved before it is reported.
        self.folder.keep(&mut self.session)?;
        screen::notice(&notice);
        Ok(())
    }

    fn undo(&mut self) -> Result<()> {
        if self.session.proposal().is_some() || self.session.question().is_some() {
            self.session.cancel()?;
            screen::notice("Cancelled; nothing has changed");
            return Ok(());
        }
        let after = self.session.world().environment().clone();
        let was_run = self.session.accepted().len() == self.session.pending().start;
        let number = self
            .session
            .undo()
            .map_err(|_| Failure::unreadable("there is no accepted plan to undo"))?;
        // The undo is saved before it is reported.
        self.folder.keep(&mut self.session)?;
        screen::notice(&format!("Plan {number} is undone"));
        if was_run {
            screen::notice("The robot has carried it out, and does not go back: the world stays as it was observed");
        }
        show::changes(&after, self.session.world().environment());
        Ok(())
    }

    fn save(&self, rest: &str) -> Result<()> {
        if rest.is_empty() {
            return Err(Failure::unreadable("`/save` needs a folder")
                .hint("`/save FOLDER`")
                .into());
        }
        let folder = Path::new(rest);
        create_private_folder(folder).map_err(|error| {
            Failure::unreadable(format!("cannot create {rest}: {}", plain_reason(&error))).hint("check the path")
        })?;
        let count = self.session.accepted().len();
        for number in 0..count {
            if let Some(plan) = self.session.plan_file(number) {
                inputs::save(&folder.join(format!("{number}.json")), &plan, self.session.domain())?;
            }
        }
        screen::notice(&format!("{} saved in {rest}", counted(count, "plan")));
        Ok(())
    }

    fn change_model(&mut self, rest: &str) -> Result<()> {
        if rest.is_empty() {
            print_line!("{}", self.model_name);
            return Ok(());
        }
        // The old model stays if the new one cannot be opened, or if Ctrl-C cancels the request for its context.
        ask::interrupted().set(false);
        let model = ask::model(rest, self.arguments)?;
        let facts = model.facts();
        if ask::interrupted().is_set() {
            return Err(ModelError::Stopped.into());
        }
        self.session.set_model(facts);
        self.model = Some(model);
        rest.clone_into(&mut self.model_name);
        screen::notice(&format!("Now using the model {rest}"));
        Ok(())
    }

    fn change_strategy(&mut self, rest: &str) -> Result<()> {
        let strategy = match rest {
            "goal" => Strategy::Goal,
            "direct" => Strategy::Direct,
            _ => {
                return Err(Failure::unreadable("`/strategy` needs a strategy")
                    .hint("`/strategy goal` or `/strategy direct`")
                    .into());
            }
        };
        self.session
            .set_settings(self.session.settings().with_strategy(strategy));
        Ok(())
    }
}

fn help() {
    print_line!("Write an instruction, for example: Put the juice on the table.");
    print_line!("When a plan is shown, Enter accepts it, `no` cancels it, and any other text is a change to it:");
    print_line!("\"not that plate, the blue one\", \"you can omit step 5\".");
    output::blank();
    for (form, means) in COMMANDS {
        print_line!("  {form:22}  {means}");
    }
    output::blank();
    print_line!("Ctrl-C stops the model, Ctrl-D ends the conversation.");
}
