//! Repair of a plan that branches.
//!
//! The steps behind a branch are first written into both of its sides. Then every way through the plan is a plain list
//! of steps that begins like the ones before it: each is repaired like any other draft, and what earlier ways settled
//! is kept. What both sides of a branch end with stands behind it again afterwards, and the whole is verified as one
//! plan. So every way is mended at the least cost, but not all of them together.

use super::{Edit, EditKind, Outcome, Pins, Repaired, repair_within};
use crate::domain::{Atom, Condition, Domain, Effect, Term};
use crate::plan::{DraftStep, LaneItem, Node, Plan, Resolved, Step, StepId, Test};
use crate::verify::{Purpose, Violation, apply, bind_tree, check};
use crate::world::{EntityId, Fact, State, Voice, World};

/// Ways through a plan that are repaired; a plan with more is given up.
const WAYS: usize = 64;
/// Steps that a plan may have once what follows a branch is written into both sides.
const STEPS: usize = 2_000;

/// A step on its way to the repaired plan.
#[derive(Debug, Clone)]
struct Item {
    step: DraftStep,
    /// What its open arguments were taken to be.
    bound: Vec<EntityId>,
    written: String,
    /// Its number in the draft; for a step that is new, that of the one before which it was put in.
    from: usize,
    /// How it came here; none for a step as the draft has it.
    edit: Option<(EditKind, String)>,
    /// Whether a way that was repaired already goes through it.
    settled: bool,
}

/// The plan while it is changed: its steps by number, whatever the order, and its tree.
#[derive(Debug, Clone, Default)]
struct Draft {
    items: Vec<Item>,
    blocks: Vec<Vec<Part>>,
    /// Steps that were left out: which, why, and the step before which they stood.
    dropped: Vec<(usize, String, String, Option<usize>)>,
}

/// A part of a block; blocks go by number.
#[derive(Debug, Clone)]
enum Part {
    Step(usize),
    If(Test, usize, usize),
    While(Test, usize),
    Repeat(u32, usize),
    Remark(String),
}

/// Which outcome of sensing is followed first.
#[derive(Debug, Clone, Copy)]
enum Order {
    FirstOutcome,
    LastOutcome,
}

/// One way through the draft.
#[derive(Debug, Default)]
struct Way {
    /// The steps with the blocks that they stand in; sensing steps of conditions with none.
    steps: Vec<(usize, Option<usize>)>,
    /// The block that the way ends in.
    last: usize,
    /// What sensing tells on it.
    told: Vec<(usize, Fact)>,
    /// What is told at the head of a loop.
    looped: Vec<Fact>,
    /// Which of its sides each branch took, and how many there were.
    decisions: Vec<(usize, usize)>,
}

pub(super) fn repair_branches(
    limit: usize,
    domain: &Domain,
    world: &World,
    resolved: &Resolved,
    purpose: &Purpose,
) -> Outcome {
    let gave_up = |why: &str| Outcome::GaveUp {
        why: why.to_owned(),
        expanded: 0,
    };
    let Some((plan, _)) = bind_tree(domain, world, resolved, purpose.claim.as_ref()) else {
        return Outcome::Unclear {
            why: "its words mean nothing here, and which way of the plan they are on is not clear".to_owned(),
        };
    };
    let report = match check(domain, world, plan, purpose).into_verified() {
        Ok(plan) => return Outcome::Valid(plan),
        Err(report) => report,
    };
    let mut draft = Draft::of(domain, world, resolved, &report.plan);
    draft.sense(domain, world, &report.violations);
    if !draft.unfold(0) {
        return gave_up("the plan has too many branches one after the other");
    }
    // What the first way settles, the others have to live with: if they cannot, another one goes first.
    let first = way_by_way(
        limit,
        domain,
        world,
        resolved,
        purpose,
        draft.clone(),
        Order::FirstOutcome,
    );
    match first {
        Outcome::Repaired(_) => first,
        _ => match way_by_way(limit, domain, world, resolved, purpose, draft, Order::LastOutcome) {
            other @ Outcome::Repaired(_) => other,
            _ => first,
        },
    }
}

/// Repairs one way after the other.
fn way_by_way(
    limit: usize,
    domain: &Domain,
    world: &World,
    resolved: &Resolved,
    purpose: &Purpose,
    mut draft: Draft,
    order: Order,
) -> Outcome {
    // What the draft claims is the world of one ending; each way has its own.
    let each = Purpose {
        claim: None,
        step_claims: Vec::new(),
        ..purpose.clone()
    };
    let (mut decisions, mut expanded, mut cost) = (Vec::new(), 0, 0);
    for _ in 0..WAYS {
        let way = draft.way(domain, world, &decisions, order);
        let told = with_outcomes(domain, &way.told.iter().map(|(_, fact)| *fact).collect::<Vec<_>>());
        let (linear, pins) = draft.linear(resolved, &way);
        match repair_within(limit, &told, world, &linear, &each, &pins) {
            Outcome::Valid(plan) => draft.settle(&way, plan.steps(), &[]),
            Outcome::Repaired(repaired) => {
                expanded += repaired.expanded;
                cost += repaired.cost;
                let (steps, edits) = behind_sensing(domain, &told, world, *repaired, &each, &way.looped);
                draft.settle(&way, &steps, &edits);
            }
            other => return other,
        }
        decisions = way.decisions;
        while decisions.last().is_some_and(|(taken, of)| taken + 1 == *of) {
            decisions.pop();
        }
        match decisions.last_mut() {
            Some((taken, _)) => *taken += 1,
            None => {
                draft.fold(0);
                return draft.whole(domain, world, resolved, purpose, cost, expanded);
            }
        }
    }
    Outcome::GaveUp {
        why: "the plan has too many ways through it".to_owned(),
        expanded,
    }
}

/// The domain in which sensing tells just this: on one way through a plan, it is an action like any other.
fn with_outcomes(domain: &Domain, told: &[Fact]) -> Domain {
    let mut known = domain.clone();
    for action in &mut known.actions {
        for atom in std::mem::take(&mut action.senses) {
            for fact in told.iter().filter(|fact| fact.predicate() == atom.predicate) {
                let same = |(place, term): (usize, &Term)| Condition::Equal {
                    left: *term,
                    right: Term::Constant(fact.argument(place)),
                    holds: true,
                };
                action.effects.push(Effect {
                    forall: Vec::new(),
                    condition: Condition::And(atom.terms.iter().enumerate().map(same).collect()),
                    atom: atom.clone(),
                    adds: true,
                });
            }
        }
    }
    known
}

/// The steps and edits of a repaired way, with what was put in before sensing put behind it where that will do: there it
/// concerns this way alone.
fn behind_sensing(
    domain: &Domain,
    told: &Domain,
    world: &World,
    repaired: Repaired,
    purpose: &Purpose,
    looped: &[Fact],
) -> (Vec<Step>, Vec<Edit>) {
    let mut steps = repaired.plan.steps().to_vec();
    let mut edits = repaired.edits;
    // Behind the head of a loop it would be done again and again.
    let senses = |step: &Step| {
        let mut outcomes = domain
            .action(step.action)
            .senses
            .iter()
            .map(|atom| crate::world::ground(atom, &step.arguments));
        !domain.action(step.action).senses.is_empty() && !outcomes.any(|fact| looped.contains(&fact))
    };
    for at in (0..steps.len().saturating_sub(1)).rev() {
        let mut place = at;
        while place + 1 < steps.len() {
            let inserted = edits
                .iter()
                .position(|edit| edit.at == place && edit.kind == EditKind::Insert);
            let Some(edit) = inserted.filter(|_| senses(&steps[place + 1])) else {
                break;
            };
            let mut swapped = steps.clone();
            swapped.swap(place, place + 1);
            if !check(told, world, Plan::sequence(swapped.clone()), purpose)
                .violations
                .is_empty()
            {
                break;
            }
            steps = swapped;
            edits[edit].at = place + 1;
            place += 1;
        }
    }
    edits.sort_by_key(|edit| edit.at);
    (steps, edits)
}

impl Draft {
    fn of(domain: &Domain, world: &World, resolved: &Resolved, plan: &Plan) -> Self {
        let item = |(from, step): (usize, &Step)| Item {
            // What the plan leaves open may be something else once it is repaired, but not what it asks about.
            step: match &resolved.steps[from] {
                Some(draft) if domain.action(step.action).senses.is_empty() => draft.clone(),
                _ => draft_step(step),
            },
            bound: step.arguments.clone(),
            written: step.call(domain, world).to_string(),
            from,
            edit: None,
            settled: false,
        };
        let mut draft = Self {
            items: plan.steps().iter().enumerate().map(item).collect(),
            blocks: vec![Vec::new()],
            dropped: Vec::new(),
        };
        draft.blocks[0] = draft.parts(plan.body());
        draft
    }

    fn parts(&mut self, nodes: &[Node]) -> Vec<Part> {
        let mut parts = Vec::new();
        for node in nodes {
            match node {
                Node::Step(id) => parts.push(Part::Step(id.index())),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let (then, otherwise) = (self.block(then), self.block(otherwise));
                    parts.push(Part::If(condition.clone(), then, otherwise));
                }
                Node::While { condition, body } => {
                    let body = self.block(body);
                    parts.push(Part::While(condition.clone(), body));
                }
                Node::Repeat { times, body } => {
                    let body = self.block(body);
                    parts.push(Part::Repeat(*times, body));
                }
                Node::Parallel { lanes } => {
                    let lanes: Vec<&[LaneItem]> = lanes.iter().map(|lane| lane.items.as_slice()).collect();
                    parts.extend(in_turn(&lanes).into_iter().map(Part::Step));
                }
                Node::Remark(text) => parts.push(Part::Remark(text.clone())),
            }
        }
        parts
    }

    fn block(&mut self, nodes: &[Node]) -> usize {
        let parts = self.parts(nodes);
        self.blocks.push(parts);
        self.blocks.len() - 1
    }

    /// Puts sensing before the conditions that ask what nothing has sensed.
    fn sense(&mut self, domain: &Domain, world: &World, violations: &[Violation]) {
        for violation in violations {
            let plain = match violation {
                Violation::When { violation, .. } => violation,
                plain => plain,
            };
            let Violation::Unsensed { fact, .. } = plain else {
                continue;
            };
            let tells = |atom: &Atom| atom.predicate == fact.predicate();
            let sensing = domain.action_ids().find(|(_, action)| action.senses.iter().any(tells));
            let Some((action, declared)) = sensing else { continue };
            let Some(atom) = declared.senses.first() else { continue };
            let mut arguments: Vec<Option<EntityId>> = vec![None; declared.parameters.len()];
            for (place, term) in atom.terms.iter().enumerate() {
                if let Term::Variable(slot) = term {
                    arguments[*slot] = Some(fact.argument(place));
                }
            }
            let complete: Option<Vec<EntityId>> = arguments.iter().copied().collect();
            let Some(complete) = complete else { continue };
            let step = Step::explained(domain, world, action, complete);
            let asked = Voice::Person.fact(domain, world, *fact, true);
            for block in 0..self.blocks.len() {
                let asks =
                    |part: &Part| matches!(part, Part::If(test, ..) | Part::While(test, _) if holds_in(test, *fact));
                let Some(place) = self.blocks[block].iter().position(asks) else {
                    continue;
                };
                let from = self.number_from(block, place);
                self.items.push(Item {
                    step: draft_step(&step),
                    bound: step.arguments.clone(),
                    written: step.call(domain, world).to_string(),
                    from,
                    edit: Some((
                        EditKind::Insert,
                        format!("a condition asks whether {asked}, and nothing had sensed that"),
                    )),
                    settled: false,
                });
                let new = self.items.len() - 1;
                self.blocks[block].insert(place, Part::Step(new));
                break;
            }
        }
    }

    /// The number in the draft of the first step from a place on.
    fn number_from(&self, block: usize, place: usize) -> usize {
        let mut numbers = Vec::new();
        for part in &self.blocks[block][place..] {
            self.collect(part, &mut numbers);
        }
        let next = numbers.first().map(|number| self.items[*number].from);
        next.unwrap_or_else(|| self.items.iter().map(|item| item.from + 1).max().unwrap_or(0))
    }

    fn collect(&self, part: &Part, numbers: &mut Vec<usize>) {
        let block = |block: usize, numbers: &mut Vec<usize>| {
            self.blocks[block].iter().for_each(|part| self.collect(part, numbers));
        };
        match part {
            Part::Step(number) => numbers.push(*number),
            Part::If(test, then, otherwise) => {
                numbers.extend(test.steps().iter().map(|step| step.index()));
                block(*then, numbers);
                block(*otherwise, numbers);
            }
            Part::While(test, body) => {
                numbers.extend(test.steps().iter().map(|step| step.index()));
                block(*body, numbers);
            }
            Part::Repeat(_, body) => block(*body, numbers),
            Part::Remark(_) => {}
        }
    }

    /// Writes what follows a branch into both of its sides; false if that is too much.
    fn unfold(&mut self, block: usize) -> bool {
        let Some(place) = self.blocks[block].iter().position(|part| matches!(part, Part::If(..))) else {
            return self.blocks[block].clone().iter().all(|part| match part {
                Part::While(_, body) | Part::Repeat(_, body) => self.unfold(*body),
                _ => true,
            });
        };
        let tail = self.blocks[block].split_off(place + 1);
        let Part::If(_, then, otherwise) = self.blocks[block][place].clone() else {
            return true;
        };
        let copy = self.copied(&tail);
        self.blocks[then].extend(tail);
        self.blocks[otherwise].extend(copy);
        self.items.len() <= STEPS && self.unfold(then) && self.unfold(otherwise)
    }

    /// The same parts with steps of their own.
    fn copied(&mut self, parts: &[Part]) -> Vec<Part> {
        parts
            .iter()
            .map(|part| match part {
                Part::Step(number) => Part::Step(self.another(*number)),
                Part::If(test, then, otherwise) => {
                    let test = self.test(test);
                    let (then, otherwise) = (self.copied_block(*then), self.copied_block(*otherwise));
                    Part::If(test, then, otherwise)
                }
                Part::While(test, body) => {
                    let test = self.test(test);
                    Part::While(test, self.copied_block(*body))
                }
                Part::Repeat(times, body) => Part::Repeat(*times, self.copied_block(*body)),
                Part::Remark(text) => Part::Remark(text.clone()),
            })
            .collect()
    }

    fn copied_block(&mut self, block: usize) -> usize {
        let parts = self.blocks[block].clone();
        let copy = self.copied(&parts);
        self.blocks.push(copy);
        self.blocks.len() - 1
    }

    fn another(&mut self, number: usize) -> usize {
        self.items.push(self.items[number].clone());
        self.items.len() - 1
    }

    fn test(&mut self, test: &Test) -> Test {
        match test {
            Test::Sense(step) => Test::Sense(StepId::new(self.another(step.index()))),
            Test::Holds(fact) => Test::Holds(*fact),
            Test::Not(inner) => Test::Not(Box::new(self.test(inner))),
            Test::All(parts) => Test::All(parts.iter().map(|part| self.test(part)).collect()),
            Test::Any(parts) => Test::Any(parts.iter().map(|part| self.test(part)).collect()),
        }
    }

    /// The way that takes these decisions and the first one wherever there are more, as if every step worked.
    fn way(&self, domain: &Domain, world: &World, decisions: &[(usize, usize)], order: Order) -> Way {
        let mut follower = Follower {
            draft: self,
            domain,
            world,
            state: world.state.clone(),
            given: decisions,
            order,
            way: Way::default(),
        };
        follower.block(0);
        follower.way
    }

    /// The way as a draft of its own, and what of it may not be changed: what other ways go through, and sensing.
    fn linear(&self, resolved: &Resolved, way: &Way) -> (Resolved, Pins) {
        let items = || way.steps.iter().map(|(number, _)| &self.items[*number]);
        let body = (0..way.steps.len())
            .map(|index| Node::Step(StepId::new(index)))
            .collect();
        let linear = Resolved {
            steps: items().map(|item| Some(item.step.clone())).collect(),
            written: items().map(|item| item.written.clone()).collect(),
            body,
            objects: resolved.objects.clone(),
            ..Resolved::default()
        };
        let kept = way.steps.iter().enumerate().filter(|(place, (number, _))| {
            self.items[*number].settled || way.told.iter().any(|(told, _)| told == place)
        });
        let pins = Pins {
            kept: kept.map(|(place, _)| place).collect(),
            ..Pins::default()
        };
        (linear, pins)
    }

    /// Takes over what a way has become.
    fn settle(&mut self, way: &Way, steps: &[Step], edits: &[Edit]) {
        let place_of = |edit: &Edit| edit.step;
        let gone: Vec<usize> = edits
            .iter()
            .filter(|edit| edit.kind != EditKind::Insert)
            .map(place_of)
            .collect();
        let mut kept = (0..way.steps.len()).filter(|place| !gone.contains(place));
        for edit in edits
            .iter()
            .filter(|edit| matches!(edit.kind, EditKind::Drop | EditKind::Move))
        {
            let (number, block) = way.steps[edit.step];
            if let Some(block) = block {
                self.blocks[block].retain(|part| !matches!(part, Part::Step(other) if *other == number));
            }
            if edit.kind == EditKind::Drop {
                let item = &self.items[number];
                let next = way.steps[edit.step + 1..].iter().map(|(number, _)| *number);
                let next = next.into_iter().next();
                self.dropped
                    .push((item.from, item.written.clone(), edit.why.clone(), next));
            }
        }
        for (at, step) in steps.iter().enumerate() {
            let edit = edits.iter().find(|edit| edit.at == at && edit.kind != EditKind::Drop);
            let number = match edit {
                None => kept.next().map(|place| way.steps[place].0),
                Some(edit) if edit.kind == EditKind::Replace => {
                    let number = way.steps[edit.step].0;
                    self.items[number].edit = Some((EditKind::Replace, edit.why.clone()));
                    Some(number)
                }
                Some(edit) => {
                    // It goes before the next step of the way that stays where it is.
                    let next = kept.clone().next().map(|place| way.steps[place]);
                    let from = match edit.kind {
                        EditKind::Move => self.items[way.steps[edit.step].0].from,
                        _ => next.map_or_else(|| self.end(), |(number, _)| self.items[number].from),
                    };
                    self.items.push(Item {
                        step: draft_step(step),
                        bound: step.arguments.clone(),
                        written: edit.before.clone().unwrap_or_default(),
                        from,
                        edit: Some((edit.kind, edit.why.clone())),
                        settled: true,
                    });
                    let new = self.items.len() - 1;
                    self.put_before(new, next, way.last);
                    Some(new)
                }
            };
            if let Some(number) = number {
                let item = &mut self.items[number];
                item.step = draft_step(step);
                item.bound.clone_from(&step.arguments);
                item.settled = true;
            }
        }
    }

    /// One past the last number of the draft.
    fn end(&self) -> usize {
        let own = self
            .items
            .iter()
            .filter(|item| !matches!(item.edit, Some((EditKind::Insert, _))));
        own.map(|item| item.from + 1).max().unwrap_or(0)
    }

    fn put_before(&mut self, new: usize, next: Option<(usize, Option<usize>)>, last: usize) {
        let Some((next, block)) = next else {
            return self.blocks[last].push(Part::Step(new));
        };
        let is_next = |part: &Part| match part {
            Part::Step(number) => *number == next,
            // A step of a condition: what comes before it comes before the branch.
            Part::If(test, ..) | Part::While(test, _) => test.steps().iter().any(|step| step.index() == next),
            Part::Repeat(..) | Part::Remark(_) => false,
        };
        let blocks = match block {
            Some(block) => block..block + 1,
            None => 0..self.blocks.len(),
        };
        for block in blocks {
            if let Some(place) = self.blocks[block].iter().position(is_next) {
                return self.blocks[block].insert(place, Part::Step(new));
            }
        }
    }

    /// Puts what both sides of a branch end with behind it.
    fn fold(&mut self, block: usize) {
        let mut parts = std::mem::take(&mut self.blocks[block]);
        if let Some(Part::If(_, then, otherwise)) = parts.last().cloned() {
            self.fold(then);
            self.fold(otherwise);
            let mut tail = Vec::new();
            while let (Some(one), Some(other)) = (self.blocks[then].last(), self.blocks[otherwise].last()) {
                if !self.same(one, other) {
                    break;
                }
                self.blocks[otherwise].pop();
                tail.extend(self.blocks[then].pop());
            }
            parts.extend(tail.into_iter().rev());
        }
        self.blocks[block] = parts;
    }

    fn same(&self, one: &Part, other: &Part) -> bool {
        match (one, other) {
            (Part::Step(one), Part::Step(other)) => {
                let (one, other) = (&self.items[*one], &self.items[*other]);
                one.step == other.step
            }
            (Part::Remark(one), Part::Remark(other)) => one == other,
            _ => false,
        }
    }

    /// The repaired plan, if it is valid as a whole.
    fn whole(
        &self,
        domain: &Domain,
        world: &World,
        resolved: &Resolved,
        purpose: &Purpose,
        cost: u32,
        expanded: usize,
    ) -> Outcome {
        let mut order = Vec::new();
        let body = self.nodes(0, &mut order);
        let step = |number: &usize| {
            let draft = &self.items[*number].step;
            let arguments = draft.arguments.iter().flatten().copied().collect();
            let mut step = Step::explained(domain, world, draft.action, arguments);
            if !draft.explanation.is_empty() {
                step.explanation.clone_from(&draft.explanation);
            }
            step
        };
        let plan = Plan::tree(order.iter().map(step).collect(), body);
        let verified = plan.and_then(|plan| check(domain, world, plan, purpose).into_verified().ok());
        let Some(plan) = verified else {
            return Outcome::GaveUp {
                why: "each way through the plan could be repaired, and together they are no valid plan".to_owned(),
                expanded,
            };
        };
        let mut edits: Vec<Edit> = Vec::new();
        for (at, number) in order.iter().enumerate() {
            let item = &self.items[*number];
            let Some((kind, why)) = &item.edit else { continue };
            let step = plan.plan().step(StepId::new(at));
            edits.push(Edit {
                kind: *kind,
                at,
                step: item.from,
                before: (*kind != EditKind::Insert).then(|| resolved.written[item.from].clone()),
                after: Some(step.call(domain, world).to_string()),
                about: domain
                    .action(step.action)
                    .implicit()
                    .next()
                    .map(|_| step.explanation.clone()),
                why: why.clone(),
            });
        }
        for (from, written, why, next) in &self.dropped {
            let at = next.and_then(|next| order.iter().position(|number| *number == next));
            let edit = Edit {
                kind: EditKind::Drop,
                at: at.unwrap_or(order.len()),
                step: *from,
                before: Some(written.clone()),
                after: None,
                about: None,
                why: why.clone(),
            };
            // A step behind a branch was left out of both of its sides.
            if !edits
                .iter()
                .any(|known| known.kind == EditKind::Drop && known.step == *from)
            {
                edits.push(edit);
            }
        }
        edits.sort_by_key(|edit| (edit.at, edit.kind != EditKind::Drop));
        Outcome::Repaired(Box::new(Repaired {
            plan,
            edits,
            cost,
            cheapest: false,
            given_up: Vec::new(),
            expanded,
        }))
    }

    /// The tree of a block; its steps are added to `order`, and numbered so.
    fn nodes(&self, block: usize, order: &mut Vec<usize>) -> Vec<Node> {
        let mut nodes = Vec::new();
        for part in &self.blocks[block] {
            nodes.push(match part {
                Part::Step(number) => {
                    order.push(*number);
                    Node::Step(StepId::new(order.len() - 1))
                }
                Part::If(test, then, otherwise) => Node::If {
                    condition: numbered(test, order),
                    then: self.nodes(*then, order),
                    otherwise: self.nodes(*otherwise, order),
                },
                Part::While(test, body) => Node::While {
                    condition: numbered(test, order),
                    body: self.nodes(*body, order),
                },
                Part::Repeat(times, body) => Node::Repeat {
                    times: *times,
                    body: self.nodes(*body, order),
                },
                Part::Remark(text) => Node::Remark(text.clone()),
            });
        }
        nodes
    }
}

fn numbered(test: &Test, order: &mut Vec<usize>) -> Test {
    match test {
        Test::Sense(step) => {
            order.push(step.index());
            Test::Sense(StepId::new(order.len() - 1))
        }
        Test::Holds(fact) => Test::Holds(*fact),
        Test::Not(inner) => Test::Not(Box::new(numbered(inner, order))),
        Test::All(parts) => Test::All(parts.iter().map(|part| numbered(part, order)).collect()),
        Test::Any(parts) => Test::Any(parts.iter().map(|part| numbered(part, order)).collect()),
    }
}

fn draft_step(step: &Step) -> DraftStep {
    DraftStep {
        action: step.action,
        arguments: step.arguments.iter().copied().map(Some).collect(),
        explanation: step.explanation.clone(),
    }
}

fn holds_in(test: &Test, fact: Fact) -> bool {
    match test {
        Test::Sense(_) => false,
        Test::Holds(other) => *other == fact,
        Test::Not(inner) => holds_in(inner, fact),
        Test::All(parts) | Test::Any(parts) => parts.iter().any(|part| holds_in(part, fact)),
    }
}

/// The steps of lanes one after the other, as their sync points allow.
fn in_turn(lanes: &[&[LaneItem]]) -> Vec<usize> {
    let mut places = vec![0; lanes.len()];
    let mut order = Vec::new();
    loop {
        let mut moved = false;
        for (lane, items) in lanes.iter().enumerate() {
            while let Some(item) = items.get(places[lane]) {
                match item {
                    LaneItem::Step(step) => order.push(step.index()),
                    LaneItem::Remark(_) => {}
                    LaneItem::Sync(_) => break,
                }
                places[lane] += 1;
                moved = true;
            }
        }
        // Every lane waits or is done: what they wait at is passed, whether or not it can be.
        for (lane, items) in lanes.iter().enumerate() {
            if !moved && places[lane] < items.len() {
                places[lane] += 1;
            }
        }
        if places.iter().zip(lanes).all(|(place, items)| *place >= items.len()) {
            return order;
        }
    }
}

/// Goes one way through a draft.
struct Follower<'a> {
    draft: &'a Draft,
    domain: &'a Domain,
    world: &'a World,
    state: State,
    given: &'a [(usize, usize)],
    order: Order,
    way: Way,
}

impl Follower<'_> {
    fn block(&mut self, block: usize) {
        self.way.last = block;
        for part in &self.draft.blocks[block] {
            match part {
                Part::Step(number) => {
                    self.step(*number, Some(block));
                }
                Part::If(test, then, otherwise) => {
                    let side = if self.test(test) { then } else { otherwise };
                    self.block(*side);
                }
                // Once round is enough to see what is wrong with it.
                Part::While(test, body) => {
                    let before = self.way.told.len();
                    let goes_on = self.test(test);
                    let told = self.way.told[before..].iter().map(|(_, fact)| *fact);
                    self.way.looped.extend(told);
                    if goes_on {
                        self.block(*body);
                        self.way.last = block;
                    }
                }
                Part::Repeat(times, body) => {
                    if *times > 0 {
                        self.block(*body);
                        self.way.last = block;
                    }
                }
                Part::Remark(_) => {}
            }
        }
    }

    /// Does a step; returns which of its outcomes came, if it senses.
    fn step(&mut self, number: usize, block: Option<usize>) -> Option<usize> {
        let item = &self.draft.items[number];
        let (action, arguments) = (self.domain.action(item.step.action), &item.bound);
        self.way.steps.push((number, block));
        apply(self.world, &mut self.state, action, arguments);
        let outcomes: Vec<Fact> = action
            .senses
            .iter()
            .map(|atom| crate::world::ground(atom, arguments))
            .collect();
        if outcomes.is_empty() {
            return None;
        }
        let known = outcomes.iter().position(|fact| self.state.holds(*fact));
        let taken = known.unwrap_or_else(|| self.decide(outcomes.len()));
        self.state.set(outcomes[taken], true);
        self.way.told.push((self.way.steps.len() - 1, outcomes[taken]));
        Some(taken)
    }

    fn decide(&mut self, of: usize) -> usize {
        let given = self.given.get(self.way.decisions.len());
        let taken = given.map_or(0, |(taken, _)| *taken);
        self.way.decisions.push((taken, of));
        match self.order {
            Order::FirstOutcome => taken,
            Order::LastOutcome => of - 1 - taken,
        }
    }

    fn test(&mut self, test: &Test) -> bool {
        match test {
            Test::Sense(step) => self.step(step.index(), None) == Some(0),
            Test::Holds(fact) => self.state.holds(*fact),
            Test::Not(inner) => !self.test(inner),
            Test::All(parts) => parts.iter().all(|part| self.test(part)),
            Test::Any(parts) => parts.iter().any(|part| self.test(part)),
        }
    }
}
