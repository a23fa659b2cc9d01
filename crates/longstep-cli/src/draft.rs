//! What `longstep verify` and `longstep repair` share: a plan, the world it is for, and what it claims.

use anyhow::Result;
use longstep::answer::{Answer, Claims, Status, compare_claims};
use longstep::domain::Domain;
use longstep::json;
use longstep::plan::{PlanFile, Resolved, resolve};
use longstep::repair::{Outcome, Repaired, repair};
use longstep::verify::{Assumption, Purpose, Report, bind, check, feedback};
use longstep::world::{Claim, Voice, World};

use crate::arguments::DraftArguments;
use crate::failure::Failure;
use crate::inputs;

/// More changes than this are counted rather than told in a hint.
const TOLD: usize = 4;

/// A plan file, read and resolved.
pub(crate) struct Draft {
    pub(crate) domain: Domain,
    pub(crate) world: World,
    pub(crate) file: PlanFile,
    pub(crate) resolved: Resolved,
    pub(crate) purpose: Purpose,
    /// What was read leniently, and what of the claim means nothing.
    notes: Vec<String>,
}

impl Draft {
    pub(crate) fn read(arguments: &DraftArguments) -> Result<Self> {
        let domain = inputs::domain(&arguments.domain)?;
        let (draft, text) = inputs::plan(&arguments.plan)?;
        let file = draft.file;
        let shown = arguments.plan.display().to_string();
        let world = match (&arguments.env, &file.environment_before) {
            (Some(path), _) => inputs::world(&domain, path)?,
            (None, Some(environment)) => {
                let inside = json::Path::key("environment_before");
                inputs::read_world(&domain, environment, &shown, &text, &inside)?
            }
            (None, None) => {
                let failure = Failure::unreadable(format!("{shown} has no `environment_before`"));
                return Err(failure
                    .hint("name the world before the plan with --env ENV.json")
                    .into());
            }
        };
        let mut notes: Vec<String> = draft.leniencies.iter().map(|leniency| leniency.message()).collect();
        let claim = file
            .environment_after
            .as_ref()
            .map(|environment| Claim::read(&domain, &world, environment));
        for ignored in claim.iter().flat_map(|claim| &claim.ignored) {
            notes.push(format!("`environment_after` was compared without {ignored}"));
        }
        let resolved = resolve(&domain, &world, &file.task_cohesion);
        let summary = file.instruction_summary.trim();
        let purpose = Purpose {
            claim,
            instruction: (!summary.is_empty()).then(|| summary.to_owned()),
            ..Purpose::default()
        };
        Ok(Self {
            domain,
            world,
            file,
            resolved,
            purpose,
            notes,
        })
    }

    /// The question that the reply asks back instead of planning.
    pub(crate) fn question(&self) -> Option<Answer> {
        let asks = self.resolved.written.is_empty() && !self.file.question.trim().is_empty();
        asks.then(|| {
            let summary = &self.file.instruction_summary;
            Answer::without_plan(Status::Question, &self.world, summary, self.file.question.trim())
        })
    }

    /// Simulates the plan, if its words mean something; with it, what its open arguments were taken to be.
    pub(crate) fn simulate(&self) -> Option<(Report, Vec<Assumption>)> {
        let steps = self.resolved.complete().ok()?;
        let claim = self.purpose.claim.as_ref();
        let (plan, open) = bind(&self.domain, &self.world, &steps, &self.resolved.objects, claim);
        Some((check(&self.domain, &self.world, plan, &self.purpose), open))
    }

    /// The answer to the plan as it stands.
    pub(crate) fn verdict(&self) -> Answer {
        if let Some(question) = self.question() {
            return question;
        }
        match self.simulate() {
            Some((report, open)) => self.answer(&report, &open),
            None => {
                let mut answer = Answer::of_unresolved(&self.domain, &self.world, &self.file, &self.resolved.issues);
                self.remark(&mut answer);
                answer
            }
        }
    }

    /// The answer to a simulated plan.
    pub(crate) fn answer(&self, report: &Report, open: &[Assumption]) -> Answer {
        let (domain, world) = (&self.domain, &self.world);
        let mut answer = Answer::of_report(domain, world, report, None, &self.file.instruction_summary);
        answer.assumptions.extend(open.iter().map(|a| a.message(domain, world)));
        let claim = self.purpose.claim.as_ref();
        answer.claims = claim.map_or_else(Claims::default, |claim| {
            compare_claims(domain, world, claim, &report.after)
        });
        self.remark(&mut answer);
        answer
    }

    fn remark(&self, answer: &mut Answer) {
        answer.plan.question.clone_from(&self.file.question);
        let readings = self.resolved.readings.iter();
        let told = readings.map(|reading| reading.message(&self.domain, &self.world));
        answer.assumptions.splice(0..0, told);
        answer.notes.splice(0..0, self.notes.iter().cloned());
    }

    /// The least change that makes the plan valid.
    pub(crate) fn repair(&self) -> Outcome {
        repair(&self.domain, &self.world, &self.resolved, &self.purpose)
    }

    /// What a repaired plan does without although the draft claims it, as sentences.
    pub(crate) fn given_up(&self, repaired: &Repaired) -> Vec<String> {
        let told = |fact: &_| Voice::Person.fact(&self.domain, &self.world, *fact, true);
        repaired.given_up.iter().map(told).collect()
    }

    /// What repair would do to an invalid plan, if it can mend it.
    pub(crate) fn advice(&self) -> Option<String> {
        let Outcome::Repaired(repaired) = self.repair() else {
            return None;
        };
        let length = self.resolved.written.len();
        let mut told: Vec<String> = match repaired.edits.len() {
            0..=TOLD => repaired.edits.iter().map(|edit| edit.told(length)).collect(),
            many => vec![format!("{many} changes")],
        };
        let given_up = self.given_up(&repaired).into_iter();
        told.extend(given_up.map(|fact| format!("give up that {fact}")));
        if told.is_empty() {
            told.push("its steps stay as they are".to_owned());
        }
        Some(format!("`longstep repair` makes it valid: {}", told.join("; ")))
    }

    /// What a model would be told about the plan.
    pub(crate) fn feedback(&self) -> String {
        let (violations, steps) = match self.simulate() {
            Some((report, _)) => (report.violations, report.plan),
            None => (self.resolved.issues.clone(), longstep::plan::Plan::default()),
        };
        let edits = match self.repair() {
            Outcome::Repaired(repaired) => repaired.edits,
            _ => Vec::new(),
        };
        let length = self.resolved.written.len();
        feedback(&self.domain, &self.world, &violations, steps.steps(), length, &edits)
    }
}
