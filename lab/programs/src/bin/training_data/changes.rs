//! Training data for changes of a plan.
//!
//! A text begins with its suite (`suite: lab/understanding/training/bakery`). A paragraph has the id of a case, whose plan is searched
//! for, and lines with a remark on the plan and its answer (`Leave out step 3. => drop 3`).

use std::error::Error;
use std::path::Path;

use longstep::dialogue::{ConstraintKind, Dialogue};
use longstep::domain::Domain;
use longstep::feedback::{Amended, FeedbackDialogue, FeedbackInput, Wish, amend};
use longstep_core::environment::World;
use longstep_core::plan::Plan;
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::verify::Purpose;
use longstep_eval::suite::{Case, Suite};
use serde_json::json;

use crate::request::{learned_answer, mistake, pairs, reply};
use crate::suites::{find_case, read_suite};

/// The plan of a case with one instruction.
struct PlannedCase {
    world: World,
    purpose: Purpose,
    plan: Plan,
    instruction: String,
}

impl PlannedCase {
    /// Searches for the plan of a case; none if the case is a chain, has no goal, or its plan branches.
    fn new(suite: &Suite, case: &Case) -> Option<Self> {
        let [step] = &case.steps[..] else { return None };
        let world = suite.judged_world(case);
        let purpose = step.expected.goals().first()?.purpose(&world);
        match search::solve(&world, &purpose, &Limits::default()) {
            Outcome::Solved { plan, .. } if plan.is_sequence() => Some(Self {
                plan: Plan::sequence(plan.steps().to_vec()),
                instruction: step.says.clone(),
                world,
                purpose,
            }),
            _ => None,
        }
    }

    fn dialogue(&self, domain: &Domain, remark: &str) -> FeedbackDialogue {
        FeedbackDialogue::new(FeedbackInput {
            domain,
            world: &self.world,
            plan: &self.plan,
            instruction: &self.instruction,
            feedback: remark,
            kind: ConstraintKind::Grammar,
        })
    }
}

/// Prints the cases with plans of two steps and more, as a model sees them when a person comments on them.
pub(crate) fn print_plans(domain: &Domain, suite: &Suite) {
    for case in &suite.cases {
        let Some(planned) = PlannedCase::new(suite, case) else {
            continue;
        };
        if planned.plan.steps().len() > 1 {
            let request = planned.dialogue(domain, "").request();
            let text = request.messages.last().map_or("", |message| message.text.as_str());
            let text = text.rsplit_once('\n').map_or(text, |(before, _)| before);
            println!("{}\n{text}\n", case.id);
        }
    }
}

/// Prints the training data of a text.
pub(crate) fn print_text(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let (folder, text) = text.split_once('\n').ok_or("there is nothing behind the suite")?;
    let (domain, suite) = read_suite(Path::new(folder.trim()))?;
    let (mut printed, mut impossible) = (0, 0);
    for paragraph in text.trim().split("\n\n") {
        let mistake = |reason: &str| mistake(name, paragraph, reason);
        let (id, lines) = paragraph
            .trim()
            .split_once('\n')
            .ok_or_else(|| mistake("there is no remark"))?;
        let case = find_case(&suite, id).ok_or_else(|| mistake("there is no such case"))?;
        let planned = PlannedCase::new(&suite, case).ok_or_else(|| mistake("there is no plan"))?;
        for line in lines.lines() {
            let (remark, answer) = line.rsplit_once(" => ").ok_or_else(|| mistake("there is no arrow"))?;
            let change = Change {
                remark: remark.trim(),
                answer: answer.trim(),
            };
            let is_possible = change
                .print(&domain, &suite.name, id, &planned)
                .map_err(|error| mistake(&error.to_string()))?;
            impossible += usize::from(!is_possible);
            printed += 1;
        }
    }
    eprintln!("{name}: {printed}, of which {impossible} are not possible in their plan");
    Ok(())
}

/// A remark on a plan with its answer.
struct Change<'a> {
    remark: &'a str,
    answer: &'a str,
}

impl Change<'_> {
    /// Prints the training data of a remark, and returns whether its plan can be changed like that.
    fn print(&self, domain: &Domain, suite: &str, id: &str, planned: &PlannedCase) -> Result<bool, Box<dyn Error>> {
        let mut dialogue = planned.dialogue(domain, self.remark);
        let request = dialogue.request();
        let is_possible = match dialogue.supply(&reply(self.answer))? {
            Some(Wish::Steps(wishes)) => {
                let amended = amend(&planned.world, &planned.plan, &wishes, &planned.purpose);
                matches!(amended, Amended::Done(_))
            }
            Some(Wish::Goal | Wish::Further | Wish::Question(_)) => true,
            None => return Err("the answer is not whole".into()),
        };
        let query = &request.messages[request.fixed].text;
        let (plan, instruction) = query
            .rsplit_once("The person says:")
            .ok_or("the request has no remark")?;
        println!(
            "{}",
            json!({"suite": suite, "id": id, "fixed": pairs(&request.messages[..request.fixed]), "lead": "",
                "plan": format!("{plan}The person says:"), "instruction": instruction, "answer": learned_answer(self.answer)})
        );
        Ok(is_possible)
    }
}
