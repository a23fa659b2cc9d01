//! Compilation of a draft to a search task: the position in the draft is a fact of the task.

use std::cmp::Ordering;

use rustc_hash::FxHashSet;

use super::pins::{Pins, Reach, Unwanted};
use super::target::Meant;
use crate::search::{
    Always, Formula, GroundAction, GroundEffect, GroundNumericEffect, Grounder, Literal, Operator, Requirements, Scope,
    Task,
};
use longstep_model::effort;
use longstep_model::model::{
    ActionId, Domain, EntityId, Fact, NumberTest, Wanted, World, plain_words, singular, subject_of,
};
use longstep_verify::plan::{DraftStep, Resolved};
use longstep_verify::verify::{Candidate, Purpose, can_apply, candidates, claimed_places};

/// Meaning of an operator for the draft. Steps of the draft count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Move {
    /// Executes a step as written in the draft.
    Keep(usize, GroundAction),
    /// Executes a new step.
    Insert(GroundAction),
    /// Executes another action on the same objects, or lets another actor execute the step.
    Replace(usize, GroundAction),
    /// Skips a step.
    Drop(usize, Reason),
    /// Postpones a step.
    Postpone(usize),
    /// Executes the postponed step.
    Resume(usize, GroundAction),
    /// At the end, gives up a fact that the draft claims.
    Forgo(Fact),
}

/// Reason why a step is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    /// The step cannot be resolved.
    Unknown,
    /// The step can never be applicable in this world.
    Impossible,
    /// The step would have no effect.
    Idle,
    /// The step conflicts with other requirements.
    Unwanted,
}

/// The compiled task without its goal.
pub(super) struct Compiled<'a> {
    scope: &'a Scope,
    grounder: Grounder<'a>,
    operators: Vec<Operator>,
    moves: Vec<Move>,
    always: Always,
    /// Holds if the whole draft has been processed and no step is postponed.
    arrived: Formula,
    /// The operators that record progress through the stages of the purpose.
    marks: Vec<Operator>,
    /// Holds if all stages of the purpose are complete.
    complete: Formula,
}

impl Compiled<'_> {
    /// Adds the goal: the end of the draft and the target of the repair.
    pub(super) fn task(mut self, domain: &Domain, meant: &Meant) -> (Task, Vec<Move>) {
        let costs = domain.repair;
        let mut goals = vec![
            self.arrived.clone(),
            self.complete.clone(),
            self.grounder.goal(&meant.required),
        ];
        for promise in &meant.promises {
            let fulfilled = self.fact(domain, promise.fact);
            let nearly: Vec<Formula> = promise.related.iter().map(|fact| self.fact(domain, *fact)).collect();
            let other = self.forgone(promise.fact, costs.other_relation);
            let forgone = self.forgone(promise.fact, costs.forgo);
            // Soft goals are compiled away (Keyder and Geffner, 2009): the claim holds, or an operator at the end
            // gives it up at a cost.
            goals.push(Formula::or([
                fulfilled,
                Formula::and([Formula::or(nearly), other]),
                forgone,
            ]));
        }
        let in_scope = |fact: &&Fact| self.scope.contains(subject_of(domain, **fact));
        for fact in meant.kept.iter().filter(in_scope) {
            let kept = self.fact(domain, *fact);
            let forgone = self.forgone(*fact, costs.unsettle);
            goals.push(Formula::or([kept, forgone]));
        }
        self.operators.append(&mut self.marks);
        let task = self.grounder.task(self.operators, Formula::and(goals), self.always);
        (task, self.moves)
    }

    fn fact(&mut self, domain: &Domain, fact: Fact) -> Formula {
        let wanted = Wanted::of_fact(domain, fact);
        self.grounder.formula(&wanted.condition, &mut wanted.bindings.clone())
    }

    /// Adds an operator that gives up the fact at a cost, applicable only at the end; returns the formula for "given
    /// up".
    fn forgone(&mut self, fact: Fact, cost: u32) -> Formula {
        let forgone = self.grounder.extra(false);
        self.operators.push(Operator {
            step: nothing(),
            is_mark: false,
            cost,
            tag: self.moves.len() as u32,
            outcome: None,
            // Only at the end: to give a fact up earlier leads to the same ends by more paths.
            precondition: self.arrived.clone(),
            effects: vec![effect(forgone, true)],
            numeric: Vec::new(),
        });
        self.moves.push(Move::Forgo(fact));
        literal(forgone, true)
    }
}

/// Returns the requirements of a repair, and the entities that the draft and its target mention.
pub(super) fn requirements(world: &World, draft: &Resolved, meant: &Meant) -> (Requirements, Vec<EntityId>) {
    let domain = world.domain();
    let stages = || meant.stages.iter().flatten().map(|milestone| &milestone.wanted);
    let target = || meant.required.iter().chain(stages());
    let mut requirements = Requirements::of(world, &meant.required, &meant.stages);
    let mut about = draft.objects.clone();
    about.extend(target().flat_map(|wanted| &wanted.bindings));
    for fact in meant.kept.iter().chain(meant.promised()) {
        requirements.literal(fact.predicate(), true);
    }
    about.extend(meant.promised().flat_map(|fact| domain.arguments(*fact)));
    for step in draft.steps.iter().flatten() {
        let action = domain.action(step.action);
        for (atom, holds) in action.precondition.atoms() {
            requirements.literal(atom.predicate, holds);
        }
        for function in action.precondition.numbers().flat_map(NumberTest::functions) {
            requirements.function(function);
        }
        for effect in &action.numeric {
            requirements.function(effect.fluent.function);
        }
        // A replacement for the step changes some of the same facts.
        for effect in &action.effects {
            requirements.literal(effect.atom.predicate, effect.adds);
            for (atom, _) in effect.condition.atoms() {
                requirements.literal(atom.predicate, true);
                requirements.literal(atom.predicate, false);
            }
        }
        about.extend(step.arguments.iter().flatten());
    }
    (requirements, about)
}

/// Work units for an operator besides its effects, for its step and its condition.
const OPERATOR: usize = 12 * effort::KEPT;

/// Compiles the draft to a task over the entities in scope.
pub(super) fn compile<'a>(
    world: &'a World,
    scope: &'a Scope,
    draft: &Resolved,
    purpose: &Purpose,
    pins: &Pins,
) -> Compiled<'a> {
    let domain = world.domain();
    let mut grounder = Grounder::new(world, scope);
    let always = grounder.always();
    let (marks, complete) = grounder.stages(&purpose.stages);
    let in_draft = draft
        .steps
        .iter()
        .flatten()
        .flat_map(|step| step.arguments.iter().flatten());
    let places = claimed_places(world, purpose.claim.as_ref(), &draft.objects);
    let mentioned: FxHashSet<EntityId> = in_draft.chain(&draft.objects).chain(&places).copied().collect();
    let mut inserted = grounder.operators(&mentioned);
    inserted.retain(|operator| {
        let step = &operator.step;
        let forbids = |unwanted: &Unwanted| unwanted.forbids(step.action, &step.arguments);
        !pins.unwanted.iter().any(forbids)
    });
    let taken_out: Vec<TakenOut> = pins
        .unwanted
        .iter()
        .filter(|unwanted| unwanted.arguments.iter().all(|thing| scope.contains(*thing)))
        .map(|unwanted| {
            let Operator {
                mut effects, numeric, ..
            } = grounder.operator(unwanted.step());
            effects.sort();
            TakenOut {
                before: unwanted.before,
                anywhere: unwanted.reach != Reach::Here,
                effects,
                numeric,
            }
        })
        .collect();
    // A dropped `move_object()` must not return as a `move_hand()` with the same effects.
    inserted.retain(|operator| !taken_out.iter().any(|out| out.anywhere && out.is_like(operator)));
    let length = draft.steps.len();
    let reached: Vec<u32> = (0..=length).map(|index| grounder.extra(index == 0)).collect();
    let free_handed = grounder.extra(true);
    let mut writer = Writer {
        domain,
        world,
        grounder,
        inserted: &inserted,
        taken_out: &taken_out,
        pins,
        reached,
        free_handed,
        operators: Vec::new(),
        moves: Vec::new(),
    };
    for (index, step) in draft.steps.iter().enumerate() {
        if effort::is_exhausted() {
            break;
        }
        match step {
            Some(step) => {
                let mut choices = candidates(world, step, &draft.objects, &places);
                choices.retain(|choice| choice.arguments.iter().all(|thing| scope.contains(*thing)));
                writer.step(index, step, &choices);
            }
            None => writer.drop(index, Reason::Unknown, Formula::TRUE, domain.repair.drop_impossible),
        }
    }
    // Behind the operators of the draft, which the search tries first.
    for operator in &inserted {
        let step = operator.step.clone();
        let elsewhere = writer.elsewhere(operator);
        writer.push(elsewhere, domain.repair.insert, Move::Insert(step));
    }
    let Writer {
        grounder,
        operators,
        moves,
        reached,
        ..
    } = writer;
    let arrived = [reached[length], free_handed].map(|fact| literal(fact, true));
    Compiled {
        scope,
        grounder,
        operators,
        moves,
        always,
        arrived: Formula::and(arrived),
        marks,
        complete,
    }
}

/// Returns true if arguments differ in this place and in no other one.
fn differ_only_in(place: usize, one: &[EntityId], other: &[EntityId]) -> bool {
    let mut pairs = one.iter().zip(other).enumerate();
    pairs.all(|(at, (one, other))| (one == other) == (at != place))
}

/// Compares how well a step's explanation matches two entities; greater if it prefers `one`.
pub(super) fn compare_mentions(world: &World, explanation: &str, one: EntityId, other: EntityId) -> Ordering {
    let words: Vec<String> = plain_words(explanation).iter().map(|word| singular(word)).collect();
    let named = |entity: EntityId| world.entity(entity).words_in(&words);
    named(one).cmp(&named(other))
}

fn literal(fact: u32, holds: bool) -> Formula {
    Formula::Literal(Literal { fact, holds })
}

/// Placeholder action of an operator without an effect on the world.
fn nothing() -> GroundAction {
    GroundAction {
        action: ActionId::new(0),
        arguments: Vec::new(),
    }
}

fn effect(fact: u32, holds: bool) -> GroundEffect {
    GroundEffect {
        condition: Formula::TRUE,
        literal: Literal { fact, holds },
        may: false,
    }
}

/// A step that the user removed; neither it nor a step with equal effects may return to its position.
struct TakenOut {
    before: usize,
    anywhere: bool,
    effects: Vec<GroundEffect>,
    numeric: Vec<GroundNumericEffect>,
}

impl TakenOut {
    fn is_like(&self, operator: &Operator) -> bool {
        let mut effects = operator.effects.clone();
        effects.sort();
        self.effects == effects && self.numeric == operator.numeric
    }
}

struct Writer<'a, 'b> {
    domain: &'a Domain,
    world: &'a World,
    grounder: Grounder<'a>,
    inserted: &'b [Operator],
    taken_out: &'b [TakenOut],
    pins: &'b Pins,
    /// By position in the draft: the fact that it is the current position.
    reached: Vec<u32>,
    /// The fact that no step is postponed.
    free_handed: u32,
    operators: Vec<Operator>,
    moves: Vec<Move>,
}

impl Writer<'_, '_> {
    fn push(&mut self, mut operator: Operator, cost: u32, meaning: Move) {
        effort::spend(OPERATOR + effort::KEPT * operator.effects.len());
        operator.cost = cost;
        operator.tag = self.moves.len() as u32;
        operator.effects.sort();
        self.moves.push(meaning);
        self.operators.push(operator);
    }

    /// Makes the operator process a step of the draft: it advances from `index` to the next position.
    fn reading(&self, index: usize, mut operator: Operator) -> Operator {
        operator.precondition = Formula::and([literal(self.reached[index], true), operator.precondition]);
        // Exact allocation, since there is an operator for each choice of implicit arguments and an effect for each
        // entity that it may change.
        operator.effects.reserve_exact(2);
        operator.effects.push(effect(self.reached[index], false));
        operator.effects.push(effect(self.reached[index + 1], true));
        operator
    }

    /// Restricts the operator to positions where no equal step was removed.
    fn elsewhere(&self, operator: &Operator) -> Operator {
        let mut operator = operator.clone();
        let alike = self.taken_out.iter().filter(|taken_out| taken_out.is_like(&operator));
        let mut conditions: Vec<Formula> = alike
            .map(|taken_out| literal(self.reached[taken_out.before], false))
            .collect();
        if !conditions.is_empty() {
            conditions.push(operator.precondition);
            operator.precondition = Formula::and(conditions);
        }
        operator
    }

    /// Returns an operator that processes a step without an effect on the world.
    fn pass(&self, index: usize, condition: Formula) -> Operator {
        let nothing = Operator {
            step: nothing(),
            is_mark: false,
            cost: 0,
            tag: 0,
            outcome: None,
            precondition: condition,
            effects: Vec::new(),
            numeric: Vec::new(),
        };
        self.reading(index, nothing)
    }

    fn drop(&mut self, index: usize, reason: Reason, condition: Formula, cost: u32) {
        let operator = self.pass(index, condition);
        self.push(operator, cost, Move::Drop(index, reason));
    }

    fn step(&mut self, index: usize, step: &DraftStep, choices: &[Candidate]) {
        let costs = self.domain.repair;
        let mut kept: Vec<(Operator, u32)> = Vec::new();
        let mut brings: FxHashSet<Literal> = FxHashSet::default();
        let mut changes: FxHashSet<u32> = FxHashSet::default();
        let mut handles: FxHashSet<EntityId> = FxHashSet::default();
        let mut idle: Vec<Formula> = Vec::new();
        for choice in choices {
            let ground = GroundAction {
                action: step.action,
                arguments: choice.arguments.clone(),
            };
            let operator = self.grounder.operator(ground);
            let always: Vec<Literal> = operator
                .effects
                .iter()
                .filter(|effect| effect.condition.is_true())
                .map(|effect| effect.literal)
                .collect();
            // Only arguments that the explanation allows decide what the step was meant to do.
            if !choice.mismatch {
                brings.extend(&always);
                let numeric = operator.numeric.iter().filter(|effect| effect.condition.is_true());
                changes.extend(numeric.map(|effect| effect.variable));
                handles.extend(&choice.arguments);
                if !always.is_empty() && operator.numeric.is_empty() {
                    let has_no_effect = operator
                        .effects
                        .iter()
                        .map(|effect| Formula::or([effect.condition.negated(), Formula::Literal(effect.literal)]));
                    idle.push(Formula::and(has_no_effect));
                }
            }
            let forbidden = self.world.forbids(step.action, &choice.arguments).is_some();
            if !forbidden && can_apply(self.world, step.action, &choice.arguments) {
                let cost = if choice.mismatch { costs.rebind } else { 0 };
                kept.push((operator, cost));
            }
        }
        let possible = !kept.is_empty();
        let before = self.operators.len();
        for (operator, cost) in &kept {
            let meaning = Move::Keep(index, operator.step.clone());
            self.push(self.reading(index, operator.clone()), *cost, meaning);
        }
        if self.pins.kept.contains(&index) {
            return;
        }
        // On either side of its old position, a replacement could bring the removed step back.
        let beside = |taken_out: &&TakenOut| taken_out.before == index || taken_out.before == index + 1;
        let taken_out: Vec<&TakenOut> = self.taken_out.iter().filter(beside).collect();
        for operator in self.inserted {
            if taken_out.iter().any(|taken_out| taken_out.is_like(operator)) {
                continue;
            }
            let same_things = operator.step.arguments.iter().all(|entity| handles.contains(entity));
            let mut effects = operator.effects.iter().filter(|effect| effect.condition.is_true());
            let mut numeric = operator.numeric.iter().filter(|effect| effect.condition.is_true());
            let alike = effects.any(|effect| brings.contains(&effect.literal))
                || numeric.any(|effect| changes.contains(&effect.variable));
            if operator.step.action != step.action && same_things && alike {
                let meaning = Move::Replace(index, operator.step.clone());
                self.push(self.reading(index, operator.clone()), costs.replace, meaning);
            }
        }
        self.by_others(index, step, choices, &taken_out);
        if self.operators.len() == before {
            self.drop(index, Reason::Impossible, Formula::TRUE, costs.drop_impossible);
            return;
        }
        // A step after a removed one is not dropped or postponed, since the removed step could then return after it.
        if self.taken_out.iter().any(|out| out.before == index) {
            return;
        }
        self.drop(index, Reason::Idle, Formula::or(idle), costs.drop_idle);
        self.drop(index, Reason::Unwanted, Formula::TRUE, costs.drop);
        // The only step of a draft has no later place.
        if possible && self.reached.len() > 2 {
            self.postpone(index, kept);
        }
    }

    /// Adds operators that let other actors execute the step.
    fn by_others(&mut self, index: usize, step: &DraftStep, choices: &[Candidate], taken_out: &[&TakenOut]) {
        let Some(actor) = self.domain.action(step.action).actor else {
            return;
        };
        for operator in self
            .inserted
            .iter()
            .filter(|operator| operator.step.action == step.action)
        {
            let arguments = &operator.step.arguments;
            let mut choices = choices.iter();
            let Some(choice) = choices.find(|choice| differ_only_in(actor, &choice.arguments, arguments)) else {
                continue;
            };
            if taken_out.iter().any(|taken_out| taken_out.is_like(operator)) {
                continue;
            }
            let costs = self.domain.repair;
            let (written, other) = (choice.arguments[actor], operator.step.arguments[actor]);
            let changed = match compare_mentions(self.world, &step.explanation, other, written) {
                // The explanation names the other actor, so only the call is wrong.
                Ordering::Greater => costs.rebind,
                Ordering::Equal => costs.other_actor,
                Ordering::Less => costs.other_actor + costs.rebind,
            };
            let rebound = if choice.mismatch { costs.rebind } else { 0 };
            let meaning = Move::Replace(index, operator.step.clone());
            self.push(self.reading(index, operator.clone()), changed + rebound, meaning);
        }
    }

    fn postpone(&mut self, index: usize, kept: Vec<(Operator, u32)>) {
        let laid_aside = self.grounder.extra(false);
        let free = self.free_handed;
        // One postponed step at a time: any set of them would make the number of states exponential.
        let mut operator = self.pass(index, literal(free, true));
        operator.effects.extend([effect(free, false), effect(laid_aside, true)]);
        self.push(operator, self.domain.repair.postpone, Move::Postpone(index));
        for (mut operator, cost) in kept {
            operator.precondition = Formula::and([literal(laid_aside, true), operator.precondition]);
            operator.effects.extend([effect(free, true), effect(laid_aside, false)]);
            let meaning = Move::Resume(index, operator.step.clone());
            self.push(operator, cost, meaning);
        }
    }
}
