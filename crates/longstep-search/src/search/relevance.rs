//! Relevance analysis: removes operators and facts that no plan for the goal needs.
//!
//! An operator is kept if it is reachable and has an effect that a kept condition requires. A fact that holds in the
//! initial state and that no kept operator deletes needs no achiever. This prevents a robot from considering every cup
//! in the kitchen because putting one down frees its hand.
//!
//! Completeness: take any plan and remove the operators that are not kept. By induction over its steps, every required
//! literal that held in the plan still holds. The removed operators achieve no required literal (except those that held
//! throughout). An effect that deletes a required literal fires no more often than before, since the negation of its
//! condition is required too.
//!
//! Two things can be worse if more literals hold. An operator that records progress applies as soon as it can, and a plan
//! may have to delay the beginning of a stage. And a rule that is broken binds from the first state in which it holds, so
//! that a plan may have to keep it broken. Therefore both polarities of their literals are required
//! ([`Relevance::require_delays`], [`Relevance::require_rules`]).

use std::collections::VecDeque;

use rustc_hash::{FxHashMap, FxHashSet};

use super::GroundAction;
use super::formula::{Formula, Literal};
use super::operator::Operator;
use super::task::Task;
use longstep_model::effort;

/// Removes everything that no plan needs; the task keeps its shortest plans.
pub(crate) fn reduce(mut task: Task) -> Task {
    keep_reachable(&mut task);
    simplify(&mut task);
    // Without forbidden operators, less is reachable and more facts are static.
    if keep_allowed(&mut task) {
        keep_reachable(&mut task);
        simplify(&mut task);
    }
    keep_relevant(&mut task, false);
    simplify(&mut task);
    renumber(task)
}

/// Reduces the task to the most direct operators. The result may be unsolvable although the task is not, and its
/// shortest plan may be longer; but it is small, and each of its plans is a plan for the task.
///
/// A required literal is left to operators that are already kept if one of them achieves it. Otherwise the operators
/// whose effect fires in the initial state are kept, if there are any. So a plate need not be put on every shelf only
/// because a robot at that shelf would then reach the plate.
pub(super) fn focus(task: &Task) -> Task {
    let mut task = task.clone();
    keep_relevant(&mut task, true);
    keep_reachable(&mut task);
    simplify(&mut task);
    renumber(task)
}

/// Returns the index of a literal in a list by literal.
pub(super) fn index(literal: Literal) -> usize {
    literal.fact as usize * 2 + usize::from(literal.holds)
}

/// Maximum number of disjunctions of rules for which operators are removed, each of which takes one reachability analysis.
const DISJUNCTIONS: usize = 32;

/// Returns the facts that sensing reveals.
fn revealed(task: &Task) -> FxHashSet<u32> {
    let sensing = task.operators.iter().filter(|operator| operator.outcome.is_some());
    let facts = sensing.flat_map(|operator| operator.effects.iter().map(|effect| effect.literal.fact));
    facts.collect()
}

/// Returns true if a rule holds in every state of every plan: it holds in the initial state, so no step may break it, and
/// no sensing outcome can.
fn always_binds(task: &Task, revealed: &FxHashSet<u32>, rule: &Formula) -> bool {
    let mut binds = rule.holds(&|literal| task.initial[literal.fact as usize] == literal.holds);
    rule.for_each(&mut |literal| binds &= !revealed.contains(&literal.fact));
    binds
}

/// Removes the operators that break a rule whenever they are applied. A rule that always binds holds in every state, so an
/// operator that always makes one of its conjuncts false leads nowhere. Returns true if there were any.
fn keep_allowed(task: &mut Task) -> bool {
    let mut kept: FxHashSet<Literal> = FxHashSet::default();
    let mut disjunctions: Vec<Vec<Formula>> = Vec::new();
    let revealed = revealed(task);
    for rule in task.always.iter().filter(|rule| always_binds(task, &revealed, rule)) {
        let conjuncts = match rule {
            Formula::And(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        for part in conjuncts {
            match part {
                Formula::Literal(literal) => {
                    kept.insert(*literal);
                }
                Formula::Or(parts) => disjunctions.push(parts.clone()),
                // `Formula::and` flattens conjunctions, so there is none.
                Formula::And(_) => {}
            }
        }
    }
    let before = task.operators.len();
    task.operators.retain(|operator| {
        !operator.effects.iter().any(|effect| {
            let literal = effect.literal.opposite();
            kept.contains(&literal) && breaks(operator, literal)
        })
    });
    // Prohibitions come after the rules of the domain.
    disjunctions
        .iter()
        .rev()
        .take(DISJUNCTIONS)
        .for_each(|parts| keep_disjunction(task, parts));
    task.operators.len() < before
}

/// Returns true if the operator makes the literal false whenever it is applied.
fn breaks(operator: &Operator, literal: Literal) -> bool {
    let mut effects = operator.effects.iter();
    effects.any(|effect| !effect.may && effect.literal == literal.opposite() && effect.condition.is_true())
        // As in PDDL, a fact that is both deleted and added holds afterwards.
        && !(literal.holds && operator.effects.iter().any(|effect| effect.literal == literal))
}

/// Removes the operators that break the only part of a disjunction that can be true, if the disjunction must stay true.
///
/// Let one part hold initially. The operators that always break it, and change no fact of another part, are left out. If
/// no other part is reachable without them, then no plan can use them: the first one in a plan would leave every part
/// false.
fn keep_disjunction(task: &mut Task, parts: &[Formula]) {
    let initially = |literal: Literal| task.initial[literal.fact as usize] == literal.holds;
    let mut holding = (0..parts.len()).filter(|index| parts[*index].holds(&initially));
    // If two parts hold, an operator that breaks one of them leaves the other.
    let (Some(own), None) = (holding.next(), holding.next()) else {
        return;
    };
    let mut others: FxHashSet<Literal> = FxHashSet::default();
    for other in parts.iter().enumerate().filter(|(index, _)| *index != own) {
        other.1.for_each(&mut |literal| {
            others.insert(literal);
        });
    }
    let conjuncts = match &parts[own] {
        Formula::And(conjuncts) => conjuncts.as_slice(),
        other => std::slice::from_ref(other),
    };
    let (without, removed): (Vec<Operator>, Vec<Operator>) = task
        .operators
        .iter()
        .cloned()
        .partition(|operator| !breaks_only(operator, conjuncts, &others));
    if removed.is_empty() {
        return;
    }
    let (reached, _) = relaxed(&task.initial, &without, task.units());
    let is_reached = |literal: Literal| reached[index(literal)];
    let mut others = parts.iter().enumerate().filter(|(index, _)| *index != own);
    // An analysis that ran out of budget has not reached everything.
    if !effort::is_exhausted() && !others.any(|(_, part)| part.holds(&is_reached)) {
        task.operators = without;
    }
}

/// Keeps the operators that are reachable in the delete relaxation.
fn keep_reachable(task: &mut Task) {
    let units = task.units();
    let (_, applied) = relaxed(&task.initial, &task.operators, units);
    keep(&mut task.operators, &applied);
}

/// By literal ([`index`]): true if the delete relaxation reaches it.
pub(super) fn reached(initial: &[bool], operators: &[Operator]) -> Vec<bool> {
    relaxed(initial, operators, operators.len()).0
}

/// Returns the literals and the operators that the delete relaxation reaches; a round takes `units` of work.
fn relaxed(initial: &[bool], operators: &[Operator], units: usize) -> (Vec<bool>, Vec<bool>) {
    let mut reached: Vec<bool> = initial.iter().flat_map(|holds| [!holds, *holds]).collect();
    let mut applied = vec![false; operators.len()];
    // A round without budget reaches too little, but no result of an exhausted budget is used.
    while effort::spend(units) {
        let mut changed = false;
        for (operator, applied) in operators.iter().zip(&mut applied) {
            // An applied operator is visited again, since conditions of its other effects may have become reachable.
            if !*applied && !operator.precondition.holds(&|literal| reached[index(literal)]) {
                continue;
            }
            changed |= !*applied;
            *applied = true;
            for effect in &operator.effects {
                let place = index(effect.literal);
                if !reached[place] && effect.condition.holds(&|literal| reached[index(literal)]) {
                    reached[place] = true;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    (reached, applied)
}

/// Returns true if an operator always breaks one of the conjuncts and changes none of the other literals.
fn breaks_only(operator: &Operator, conjuncts: &[Formula], others: &FxHashSet<Literal>) -> bool {
    let mut literals = conjuncts.iter().filter_map(|part| match part {
        Formula::Literal(literal) => Some(*literal),
        _ => None,
    });
    literals.any(|literal| breaks(operator, literal))
        && !operator.effects.iter().any(|effect| others.contains(&effect.literal))
}

/// Keeps the marked operators.
fn keep(operators: &mut Vec<Operator>, marked: &[bool]) {
    let mut marks = marked.iter();
    operators.retain(|_| marks.next().is_some_and(|mark| *mark));
}

/// Replaces the facts of a formula that no operator changes by their values.
fn evaluate(formula: &mut Formula, changes: &[bool], initial: &[bool]) {
    let mut open = true;
    formula.for_each(&mut |literal| open &= changes[literal.fact as usize]);
    // Most formulas have no static fact and are not copied.
    if open {
        return;
    }
    *formula = std::mem::replace(formula, Formula::TRUE).map(&|literal| {
        let fact = literal.fact as usize;
        if changes[fact] {
            Formula::Literal(literal)
        } else if initial[fact] == literal.holds {
            Formula::TRUE
        } else {
            Formula::FALSE
        }
    });
}

/// Replaces static facts by their values, and drops effects without an effect on the state.
fn simplify(task: &mut Task) {
    effort::spend(2 * task.units());
    let mut changes = vec![false; task.initial.len()];
    for effect in task.operators.iter().flat_map(|operator| &operator.effects) {
        let fact = effect.literal.fact as usize;
        changes[fact] |= task.initial[fact] != effect.literal.holds;
    }
    let initial = &task.initial;
    let take = |formula: &mut Formula| evaluate(formula, &changes, initial);
    take(&mut task.goal);
    task.always.iter_mut().for_each(take);
    for operator in &mut task.operators {
        take(&mut operator.precondition);
        for effect in &mut operator.effects {
            take(&mut effect.condition);
        }
        operator
            .effects
            .retain(|effect| changes[effect.literal.fact as usize] && !effect.condition.is_false());
    }
    for operator in &mut task.operators {
        operator
            .numeric
            .iter_mut()
            .for_each(|effect| take(&mut effect.condition));
        operator.numeric.retain(|effect| !effect.condition.is_false());
    }
    // A change of a number counts through its marks on tests, which are effects. Without effects nothing changes.
    task.operators
        .retain(|operator| !operator.precondition.is_false() && !operator.effects.is_empty());
}

fn keep_relevant(task: &mut Task, focused: bool) {
    let mut search = Relevance::new(task, focused);
    search.require_all(&task.goal);
    task.always.iter().for_each(|rule| search.require_all(rule));
    // The focused task may lose plans, so it spares the operators for delays and for broken rules.
    if !focused {
        search.require_rules();
        search.require_delays();
    }
    while let Some(literal) = search.queue.pop_front() {
        search.expand(literal);
        if effort::is_exhausted() {
            break;
        }
    }
    let required: Vec<bool> = search
        .required
        .chunks(2)
        .map(|literals| literals[0] || literals[1])
        .collect();
    let kept = search.kept;
    keep(&mut task.operators, &kept);
    let tracked = tracked(task, required);
    for operator in &mut task.operators {
        // Facts that no condition requires need not be tracked.
        operator.effects.retain(|effect| tracked[effect.literal.fact as usize]);
    }
}

/// By fact: true if its value matters to a required fact. These are the required facts and those in the conditions of
/// effects on such facts, directly or through others: without their effects, a state would have a wrong value.
fn tracked(task: &Task, required: Vec<bool>) -> Vec<bool> {
    let mut conditions: Vec<Vec<&Formula>> = vec![Vec::new(); required.len()];
    for effect in task.operators.iter().flat_map(|operator| &operator.effects) {
        conditions[effect.literal.fact as usize].push(&effect.condition);
    }
    let mut tracked = required;
    let mut queue: Vec<u32> = (0..tracked.len() as u32)
        .filter(|fact| tracked[*fact as usize])
        .collect();
    while let Some(fact) = queue.pop() {
        let conditions = &conditions[fact as usize];
        effort::spend(1 + conditions.len() / 4);
        for condition in conditions {
            condition.for_each(&mut |literal| {
                if !std::mem::replace(&mut tracked[literal.fact as usize], true) {
                    queue.push(literal.fact);
                }
            });
        }
    }
    tracked
}

struct Relevance<'a> {
    task: &'a Task,
    focused: bool,
    /// By literal: the operators and effects that achieve it.
    achievers: Vec<Vec<(u32, u32)>>,
    kept: Vec<bool>,
    /// By literal: the effects of kept operators that achieve it, and how many of them were processed as deleters of
    /// the opposite literal.
    brought_about: Vec<(Vec<(u32, u32)>, usize)>,
    /// By sensing step: the operators of its outcomes, which are kept or removed together.
    siblings: FxHashMap<&'a GroundAction, Vec<u32>>,
    required: Vec<bool>,
    /// Literals whose achievers have been processed.
    expanded: Vec<bool>,
    /// Literals to process, possibly again.
    queue: VecDeque<Literal>,
    /// By literal that holds in the initial state and that no kept operator deletes: disjunctions that rely on it, so
    /// that their other parts are not required.
    relied_on: FxHashMap<usize, Vec<&'a Formula>>,
}

impl<'a> Relevance<'a> {
    fn new(task: &'a Task, focused: bool) -> Self {
        let literals = task.initial.len() * 2;
        let mut achievers = vec![Vec::new(); literals];
        for (number, operator) in task.operators.iter().enumerate() {
            for (at, effect) in operator.effects.iter().enumerate() {
                achievers[index(effect.literal)].push((number as u32, at as u32));
            }
        }
        let mut siblings: FxHashMap<&GroundAction, Vec<u32>> = FxHashMap::default();
        for (number, operator) in task.operators.iter().enumerate().filter(|(_, o)| o.outcome.is_some()) {
            siblings.entry(&operator.step).or_default().push(number as u32);
        }
        Self {
            task,
            focused,
            siblings,
            achievers,
            kept: vec![false; task.operators.len()],
            brought_about: vec![Default::default(); literals],
            required: vec![false; literals],
            expanded: vec![false; literals],
            queue: VecDeque::new(),
            relied_on: FxHashMap::default(),
        }
    }

    /// Requires the literals of a condition.
    fn require_all(&mut self, condition: &'a Formula) {
        match condition {
            Formula::And(parts) => parts.iter().for_each(|part| self.require_all(part)),
            Formula::Or(parts) => {
                let literals = parts.iter().filter_map(|part| match part {
                    Formula::Literal(literal) => Some(*literal),
                    _ => None,
                });
                // A literal that stays true decides the disjunction, so nothing has to achieve its other parts.
                match literals.into_iter().find(|literal| self.is_safe(*literal)) {
                    Some(literal) => self.relied_on.entry(index(literal)).or_default().push(condition),
                    None => parts.iter().for_each(|part| self.require_all(part)),
                }
            }
            Formula::Literal(literal) => self.require(*literal),
        }
    }

    /// Returns true if the literal holds in the initial state and no kept operator deletes it.
    fn is_safe(&self, literal: Literal) -> bool {
        let (takers, _) = &self.brought_about[index(literal.opposite())];
        self.task.initial[literal.fact as usize] == literal.holds && takers.is_empty()
    }

    /// Requires both polarities of what a rule is about that does not always bind.
    fn require_rules(&mut self) {
        let task = self.task;
        let revealed = revealed(task);
        for rule in task.always.iter().filter(|rule| !always_binds(task, &revealed, rule)) {
            rule.for_each(&mut |literal| self.require_both(literal));
        }
    }

    /// Requires both polarities of what the stages are about, if there are several: the state in which a stage begins
    /// decides what counts in it.
    fn require_delays(&mut self) {
        let marks = self.task.marks();
        let recorded: FxHashSet<Literal> = marks
            .iter()
            .flat_map(|mark| mark.effects.iter().map(|effect| effect.literal))
            .collect();
        let mut depends = false;
        for mark in marks {
            mark.precondition
                .for_each(&mut |literal| depends |= recorded.contains(&literal));
        }
        for mark in marks.iter().filter(|_| depends) {
            mark.precondition.for_each(&mut |literal| self.require_both(literal));
            for effect in &mark.effects {
                effect.condition.for_each(&mut |literal| self.require_both(literal));
            }
        }
    }

    fn require_both(&mut self, literal: Literal) {
        self.require(literal);
        self.require(literal.opposite());
    }

    fn require(&mut self, literal: Literal) {
        if !std::mem::replace(&mut self.required[index(literal)], true) {
            self.queue.push_back(literal);
        }
    }

    fn condition(&self, (operator, effect): (u32, u32)) -> &'a Formula {
        &self.task.operators[operator as usize].effects[effect as usize].condition
    }

    /// Returns true if the effect fires in the initial state.
    fn fires(&self, achiever: (u32, u32)) -> bool {
        let initially = |literal: Literal| self.task.initial[literal.fact as usize] == literal.holds;
        self.condition(achiever).holds(&initially)
    }

    fn expand(&mut self, literal: Literal) {
        let (takers, looked_at) = &mut self.brought_about[index(literal.opposite())];
        let lost = self.task.initial[literal.fact as usize] != literal.holds || !takers.is_empty();
        let mut new = takers[std::mem::replace(looked_at, takers.len())..].to_vec();
        effort::spend(1 + new.len());
        if !self.focused {
            // The conditions under which kept operators delete the literal must be preserved.
            new.sort_unstable();
            for taker in new {
                let mut literals = 0;
                self.condition(taker).for_each(&mut |literal| {
                    literals += 1;
                    self.require(literal.opposite());
                });
                effort::spend(literals / 8);
            }
        }
        if !lost || std::mem::replace(&mut self.expanded[index(literal)], true) {
            return;
        }
        let mut achievers = self.achievers[index(literal)].clone();
        effort::spend(achievers.len() / 4);
        if self.focused {
            if achievers
                .iter()
                .any(|achiever| self.kept[achiever.0 as usize] && self.fires(*achiever))
            {
                return;
            }
            if achievers.iter().any(|achiever| self.fires(*achiever)) {
                achievers.retain(|achiever| self.fires(*achiever));
            }
        }
        for achiever in achievers {
            if !(self.focused && self.fires(achiever)) {
                self.condition(achiever).for_each(&mut |literal| self.require(literal));
            }
            self.keep(achiever.0 as usize);
        }
    }

    fn keep(&mut self, number: usize) {
        if std::mem::replace(&mut self.kept[number], true) {
            return;
        }
        let task = self.task;
        let operator = &task.operators[number];
        for (at, effect) in operator.effects.iter().enumerate() {
            let (brought_about, _) = &mut self.brought_about[index(effect.literal)];
            brought_about.push((number as u32, at as u32));
        }
        if operator.outcome.is_some() {
            for sibling in self.siblings.get(&operator.step).cloned().unwrap_or_default() {
                self.keep(sibling as usize);
            }
        }
        self.require_all(&operator.precondition);
        for effect in &operator.effects {
            for alternatives in self
                .relied_on
                .remove(&index(effect.literal.opposite()))
                .unwrap_or_default()
            {
                self.require_all(alternatives);
            }
            if self.required[index(effect.literal.opposite())] {
                self.queue.push_back(effect.literal.opposite());
            }
        }
    }
}

/// New numbers of facts, without gaps, in the order of their first visits.
struct Renumbering<'a> {
    facts: &'a [bool],
    /// By old number: the new one.
    numbers: Vec<Option<u32>>,
    /// By new number: the initial value.
    initial: Vec<bool>,
}

impl Renumbering<'_> {
    fn visit(&mut self, literal: Literal) {
        let fact = literal.fact as usize;
        if self.numbers[fact].is_none() {
            self.numbers[fact] = Some(self.initial.len() as u32);
            self.initial.push(self.facts[fact]);
        }
    }

    fn visit_all(&mut self, formula: &Formula) {
        formula.for_each(&mut |literal| self.visit(literal));
    }
}

/// Renumbers the remaining facts without gaps.
fn renumber(mut task: Task) -> Task {
    let facts = std::mem::take(&mut task.initial);
    let mut again = Renumbering {
        facts: &facts,
        numbers: vec![None; facts.len()],
        initial: Vec::new(),
    };
    again.visit_all(&task.goal);
    task.always.iter().for_each(|rule| again.visit_all(rule));
    for operator in &task.operators {
        again.visit_all(&operator.precondition);
        for effect in &operator.effects {
            again.visit_all(&effect.condition);
            again.visit(effect.literal);
        }
    }
    // The conditions of changes of numbers on which a test depends may refer to further tests.
    while effort::spend(1) && !task.numbers.tests.is_empty() {
        let before = again.initial.len();
        let is_kept = |fact: u32| again.numbers[fact as usize].is_some();
        let needed = task.numbers.needed(&task.operators, &is_kept);
        let effects = task.operators.iter().flat_map(|operator| &operator.numeric);
        for effect in effects.filter(|effect| needed[effect.variable as usize]) {
            again.visit_all(&effect.condition);
        }
        if again.initial.len() == before {
            break;
        }
    }
    let Renumbering { numbers, initial, .. } = again;
    task.numbers.keep(&mut task.operators, |fact| numbers[fact as usize]);
    let renumber = &mut |literal: &mut Literal| literal.fact = numbers[literal.fact as usize].unwrap_or_default();
    task.goal.for_each_mut(renumber);
    task.always.iter_mut().for_each(|rule| rule.for_each_mut(renumber));
    for operator in &mut task.operators {
        operator.precondition.for_each_mut(renumber);
        for effect in &mut operator.effects {
            effect.condition.for_each_mut(renumber);
            renumber(&mut effect.literal);
        }
        for effect in &mut operator.numeric {
            effect.condition.for_each_mut(renumber);
        }
    }
    task.initial = initial;
    task
}
