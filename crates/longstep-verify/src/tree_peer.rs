//! Behavior trees ticked by BehaviorTree.CPP, step by step beside a cursor. For tests: it starts a program.
//!
//! The program is `tools/peers/behavior_trees/runner.cpp`, which asks what its leaves do.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::cursor::Cursor;
use crate::plan::StepId;
use crate::plan::behavior_tree::{LeafNames, outcomes, port};
use crate::verify::VerifiedPlan;
use longstep_model::model::{EntityId, Fact, PredicateId, World, unmet};

/// The most steps of one run; a loop that senses may never end.
const LONGEST: usize = 200;

/// A program that ticks behavior trees.
#[derive(Debug)]
pub struct Peer {
    child: Child,
    questions: BufReader<ChildStdout>,
    answers: ChildStdin,
    folder: PathBuf,
}

/// An event of a run that its plan does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    None,
    /// The step with this number, from 0 and in the order of the run, fails.
    Failure(usize),
    /// After so many steps a fact is changed; which one, is up to the choices.
    Change(usize),
    /// The tree is halted after the tick in which the step with this number begins.
    Halt(usize),
    /// The step with this number throws an exception, which the runner of `nodes` knows.
    Exception(usize),
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The tree succeeded at the end of the plan.
    Done,
    /// The tree failed where it had to.
    Failed,
    /// The tree was halted, and every step that had begun.
    Halted,
    /// The run was too long.
    Endless,
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Peer {
    /// Starts the program. `folder` gets a file with each tree.
    ///
    /// # Errors
    ///
    /// The program does not start.
    pub fn start(program: &Path, folder: &Path) -> std::io::Result<Self> {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let (Some(answers), Some(questions)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(std::io::Error::other("the program has no pipes"));
        };
        Ok(Self {
            child,
            questions: BufReader::new(questions),
            answers,
            folder: folder.to_owned(),
        })
    }

    fn question(&mut self) -> Result<Vec<String>, String> {
        let mut line = String::new();
        let read = self.questions.read_line(&mut line);
        match read {
            Ok(1..) => {
                let mut words: Vec<String> = line.trim_end_matches('\n').split('\t').map(str::to_owned).collect();
                // The program has the ports in no order.
                words.get_mut(2..).unwrap_or_default().sort();
                Ok(words)
            }
            other => Err(format!("the program ended: {other:?}")),
        }
    }

    fn answer(&mut self, text: &str) -> Result<(), String> {
        writeln!(self.answers, "{text}").map_err(|error| error.to_string())
    }

    /// Gives a tree to the program.
    ///
    /// # Errors
    ///
    /// The file cannot be written, or the program ended.
    fn begin(&mut self, xml: &str) -> Result<(), String> {
        let path = self.folder.join("tree.xml");
        std::fs::write(&path, xml).map_err(|error| error.to_string())?;
        self.answer(&path.display().to_string())
    }

    /// Returns why a tree is refused.
    ///
    /// # Errors
    ///
    /// It is not refused.
    pub fn refusal(&mut self, xml: &str) -> Result<String, String> {
        self.begin(xml)?;
        let question = self.question()?;
        match &question[..] {
            [word, reason] if word == "refused" => Ok(reason.clone()),
            _ => Err(format!("it was not refused: {question:?}")),
        }
    }

    /// Ticks the tree of a plan, and checks that its leaves are those that a cursor allows, one after another, to an end where
    /// the cursor ends. `choose` returns a number below its argument.
    ///
    /// # Errors
    ///
    /// The first difference.
    pub fn tick(
        &mut self,
        plan: &VerifiedPlan,
        xml: &str,
        trouble: Trouble,
        choose: &mut dyn FnMut(usize) -> usize,
    ) -> Result<End, String> {
        self.begin(xml)?;
        let mut run = Run {
            names: LeafNames::of(plan.world().domain()),
            world: plan.world(),
            cursor: plan.cursor(),
            running: Vec::new(),
            begun: 0,
            done: 0,
            trouble,
            has_failed: false,
            is_halted: false,
            is_endless: false,
        };
        loop {
            let question = self.question()?;
            let (word, call) = question.split_first().ok_or("an empty line")?;
            match (word.as_str(), call) {
                ("end", [status]) => return run.ended(status),
                ("refused", [reason]) => return Err(format!("refused: {reason}")),
                ("halted", call) => run.halted(call)?,
                ("do", call) => {
                    let answer = run.begins(call, choose)?;
                    self.answer(&answer)?;
                }
                ("still", call) => {
                    let step = run.running.iter().position(|step| run.call(*step) == call);
                    let step = run
                        .running
                        .remove(step.ok_or_else(|| format!("{call:?} goes on and did not begin"))?);
                    let answer = run.goes_on(step, choose)?;
                    self.answer(&answer)?;
                }
                ("ask", call) => {
                    let holds = run.cursor.state().holds(run.fact(call)?);
                    self.answer(if holds { "success" } else { "failure" })?;
                }
                _ => return Err(format!("unknown words: {question:?}")),
            }
        }
    }
}

/// A run of a tree beside a cursor.
struct Run<'a> {
    names: LeafNames,
    world: &'a World,
    cursor: Cursor,
    /// The steps that have begun and have not ended.
    running: Vec<StepId>,
    begun: usize,
    done: usize,
    trouble: Trouble,
    has_failed: bool,
    is_halted: bool,
    is_endless: bool,
}

impl Run<'_> {
    /// The words of a leaf: its name, and its ports in the order of the alphabet, as the program has them.
    fn words(&self, name: &str, arguments: Vec<(String, EntityId)>) -> Vec<String> {
        let value = |(port, entity): &(String, EntityId)| format!("{port}={}", self.world.entity(*entity).identifier);
        let mut ports: Vec<String> = arguments.iter().map(value).collect();
        ports.sort();
        std::iter::once(name.to_owned()).chain(ports).collect()
    }

    fn call(&self, step: StepId) -> Vec<String> {
        let step = self.cursor.step(step);
        let action = self.world.domain().action(step.action);
        let parameters = action.parameters.iter().map(|parameter| port(&parameter.name));
        self.words(
            self.names.action(step.action),
            parameters.zip(step.arguments.iter().copied()).collect(),
        )
    }

    fn fact(&self, call: &[String]) -> Result<Fact, String> {
        let domain = self.world.domain();
        let unknown = || format!("{call:?} is no fact");
        let (name, ports) = call.split_first().ok_or_else(unknown)?;
        let mut ids = (0..domain.predicates.len()).map(PredicateId::new);
        let id = ids.find(|id| self.names.predicate(*id) == name).ok_or_else(unknown)?;
        let argument = |parameter: &str| {
            let prefix = format!("{}=", port(parameter));
            let value = ports.iter().find_map(|port| port.strip_prefix(&prefix))?;
            self.world
                .entities()
                .find(|(_, entity)| entity.identifier == value)
                .map(|(id, _)| id)
        };
        let parameters = domain.predicate(id).parameters.iter();
        let arguments: Option<Vec<EntityId>> = parameters.map(|parameter| argument(&parameter.name)).collect();
        Ok(Fact::new(id, arguments.ok_or_else(unknown)?))
    }

    fn begins(&mut self, call: &[String], choose: &mut dyn FnMut(usize) -> usize) -> Result<String, String> {
        if self.has_failed || self.is_endless {
            return Err(format!("{call:?} begins after a failure"));
        }
        let ready = self.cursor.ready().iter().copied();
        let step = ready
            .filter(|step| !self.running.contains(step))
            .find(|step| self.call(*step) == call);
        let step = step.ok_or_else(|| {
            let ready: Vec<_> = self.cursor.ready().iter().map(|step| self.call(*step)).collect();
            format!("{call:?} begins, and {ready:?} may begin")
        })?;
        if !self.allows(step) {
            return Err(format!("{call:?} begins although its precondition does not hold"));
        }
        let number = self.begun;
        self.begun += 1;
        if self.trouble == Trouble::Failure(number) {
            self.has_failed = true;
            return Ok("failure".to_owned());
        }
        if self.trouble == Trouble::Exception(number) {
            self.has_failed = true;
            return Ok("exception".to_owned());
        }
        if self.trouble == Trouble::Halt(number) {
            self.is_halted = true;
            self.running.push(step);
            return Ok("halt".to_owned());
        }
        if self.begun > LONGEST {
            self.is_endless = true;
            return Ok("failure".to_owned());
        }
        self.goes_on(step, choose)
    }

    /// Ends a step, or lets it wait.
    fn goes_on(&mut self, step: StepId, choose: &mut dyn FnMut(usize) -> usize) -> Result<String, String> {
        if choose(3) == 0 {
            self.running.push(step);
            return Ok("later".to_owned());
        }
        let facts = self.cursor.outcomes(step);
        let known = facts.iter().position(|fact| self.cursor.state().holds(*fact));
        let outcome = known.or_else(|| (!facts.is_empty()).then(|| choose(facts.len())));
        let action = self.world.domain().action(self.cursor.step(step).action);
        let words = outcomes(self.world, action, &facts);
        self.cursor
            .complete(step, outcome.map(|index| facts[index]))
            .map_err(|error| error.to_string())?;
        self.done += 1;
        if self.trouble == Trouble::Change(self.done) {
            self.change(choose);
        }
        Ok(outcome.map_or_else(|| "success".to_owned(), |index| format!("success\t{}", words[index])))
    }

    /// Changes a fact that a precondition of the plan asks.
    fn change(&mut self, choose: &mut dyn FnMut(usize) -> usize) {
        let domain = self.world.domain();
        let plan = self.cursor.plan().plan();
        let step = &plan.steps()[choose(plan.steps().len())];
        let mut state = self.cursor.state().clone();
        for (atom, _) in domain.action(step.action).precondition.atoms() {
            if !domain.words(atom.predicate).fluent || choose(2) == 0 {
                continue;
            }
            let slots = atom.terms.iter().all(|term| match term {
                longstep_model::model::Term::Variable(slot) => *slot < step.arguments.len(),
                longstep_model::model::Term::Constant(_) => true,
            });
            if slots {
                let fact = longstep_model::model::ground(atom, &step.arguments);
                let holds = state.holds(fact);
                state.set(fact, !holds);
            }
        }
        self.cursor.correct(state);
    }

    fn allows(&self, step: StepId) -> bool {
        let step = self.cursor.step(step);
        let condition = &self.world.domain().action(step.action).precondition;
        unmet(self.world, self.cursor.state(), condition, &mut step.arguments.clone()).is_empty()
    }

    /// Only a failure halts a step.
    fn halted(&mut self, call: &[String]) -> Result<(), String> {
        let has_reason =
            self.has_failed || self.is_halted || self.is_endless || matches!(self.trouble, Trouble::Change(_));
        if !has_reason {
            return Err(format!("{call:?} was halted"));
        }
        let place = self.running.iter().position(|step| self.call(*step) == call);
        let place = place.ok_or_else(|| format!("{call:?} was halted and was not running"))?;
        self.running.remove(place);
        Ok(())
    }

    fn ended(&self, status: &str) -> Result<End, String> {
        let is_stuck = || self.cursor.ready().iter().any(|step| !self.allows(*step));
        if let Some(step) = self.running.first() {
            return Err(format!(
                "the tree ended with {status}, and {:?} goes on",
                self.call(*step)
            ));
        }
        match status {
            "HALTED" if self.is_halted => Ok(End::Halted),
            "EXCEPTION" if matches!(self.trouble, Trouble::Exception(_)) && self.has_failed => Ok(End::Failed),
            _ if matches!(self.trouble, Trouble::Exception(_)) && self.has_failed => {
                Err(format!("the exception was lost, and the tree ended with {status}"))
            }
            "SUCCESS" if self.has_failed => Err("the tree succeeded although a step failed".to_owned()),
            "SUCCESS" if !self.cursor.is_finished() => Err("the tree ended before the plan".to_owned()),
            "SUCCESS" => Ok(End::Done),
            "FAILURE" if self.is_endless => Ok(End::Endless),
            "FAILURE" if self.has_failed => Ok(End::Failed),
            "FAILURE" if matches!(self.trouble, Trouble::Change(_)) && is_stuck() => Ok(End::Failed),
            _ => Err(format!("the tree ended with {status}")),
        }
    }
}
