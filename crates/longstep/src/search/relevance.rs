//! Leaves out of a task what no plan for its goal can need.
//!
//! An operator is kept when it can be applied at all and has an effect that something kept asks for. A fact
//! that holds from the start and that no kept operator takes away needs nobody to bring it about: that is
//! what keeps a robot from considering every cup in the kitchen because putting one down frees its hand.
//!
//! Why this loses nothing: take any plan and strike the operators that are not kept. By induction over its
//! steps, every literal that is asked for and held in the plan still holds: struck operators bring about
//! nothing that is asked for (other than what held throughout), and an effect that takes such a literal away
//! fires no more often than before, since the opposite of its condition is asked for too.

use super::formula::{Formula, Literal};
use super::task::{Operator, Task};

pub(super) fn reduce(mut task: Task) -> Task {
    task.operators = reachable(&task);
    simplify(&mut task);
    task.operators = relevant(&task);
    simplify(&mut task);
    renumber(task)
}

fn index(literal: Literal) -> usize {
    literal.fact as usize * 2 + usize::from(literal.holds)
}

/// The operators that can be applied when nothing is ever lost.
fn reachable(task: &Task) -> Vec<Operator> {
    let mut reached: Vec<bool> = task.initial.iter().flat_map(|holds| [!holds, *holds]).collect();
    let mut applied = vec![false; task.operators.len()];
    loop {
        let mut changed = false;
        for (operator, applied) in task.operators.iter().zip(&mut applied) {
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
    let kept = task.operators.iter().zip(applied).filter(|(_, applied)| *applied);
    kept.map(|(operator, _)| operator.clone()).collect()
}

/// Replaces facts that never change by what they are, and drops effects that do nothing.
fn simplify(task: &mut Task) {
    let mut changes = vec![false; task.initial.len()];
    for effect in task.operators.iter().flat_map(|operator| &operator.effects) {
        let fact = effect.literal.fact as usize;
        changes[fact] |= task.initial[fact] != effect.literal.holds;
    }
    let initial = &task.initial;
    let literal = |literal: Literal| {
        let fact = literal.fact as usize;
        if changes[fact] {
            Formula::Literal(literal)
        } else if initial[fact] == literal.holds {
            Formula::TRUE
        } else {
            Formula::FALSE
        }
    };
    let take = |formula: &mut Formula| {
        *formula = std::mem::replace(formula, Formula::TRUE).map(&literal);
    };
    take(&mut task.goal);
    take(&mut task.always);
    for operator in &mut task.operators {
        take(&mut operator.precondition);
        for effect in &mut operator.effects {
            take(&mut effect.condition);
        }
        operator
            .effects
            .retain(|effect| changes[effect.literal.fact as usize] && !effect.condition.is_false());
    }
    task.operators
        .retain(|operator| !operator.precondition.is_false() && !operator.effects.is_empty());
}

fn relevant(task: &Task) -> Vec<Operator> {
    let mut search = Relevance::new(task);
    task.goal.for_each(&mut |literal| search.ask(literal));
    task.always.for_each(&mut |literal| search.ask(literal));
    while let Some(literal) = search.queue.pop() {
        search.expand(literal);
    }
    let mut operators = Vec::new();
    for (operator, _) in task.operators.iter().zip(&search.kept).filter(|(_, kept)| **kept) {
        let mut operator = operator.clone();
        // Facts that nobody asks about need no bookkeeping.
        operator.effects.retain(|effect| {
            let fact = effect.literal.fact as usize * 2;
            search.asked[fact] || search.asked[fact + 1]
        });
        operators.push(operator);
    }
    operators
}

struct Relevance<'a> {
    task: &'a Task,
    /// By literal: the operators and effects that bring it about.
    achievers: Vec<Vec<(u32, u32)>>,
    kept: Vec<bool>,
    asked: Vec<bool>,
    /// Literals for which somebody who brings them about has been looked for.
    expanded: Vec<bool>,
    /// Literals to look at again.
    queue: Vec<Literal>,
}

impl<'a> Relevance<'a> {
    fn new(task: &'a Task) -> Self {
        let literals = task.initial.len() * 2;
        let mut achievers = vec![Vec::new(); literals];
        for (number, operator) in task.operators.iter().enumerate() {
            for (at, effect) in operator.effects.iter().enumerate() {
                achievers[index(effect.literal)].push((number as u32, at as u32));
            }
        }
        Self {
            task,
            achievers,
            kept: vec![false; task.operators.len()],
            asked: vec![false; literals],
            expanded: vec![false; literals],
            queue: Vec::new(),
        }
    }

    fn ask(&mut self, literal: Literal) {
        if !std::mem::replace(&mut self.asked[index(literal)], true) {
            self.queue.push(literal);
        }
    }

    fn expand(&mut self, literal: Literal) {
        let task = self.task;
        let mut lost = task.initial[literal.fact as usize] != literal.holds;
        for at in 0..self.achievers[index(opposite(literal))].len() {
            let (operator, effect) = self.achievers[index(opposite(literal))][at];
            if self.kept[operator as usize] {
                lost = true;
                // Whether a kept operator takes the literal away must not change.
                let condition = &task.operators[operator as usize].effects[effect as usize].condition;
                condition.for_each(&mut |literal| self.ask(opposite(literal)));
            }
        }
        if !lost || std::mem::replace(&mut self.expanded[index(literal)], true) {
            return;
        }
        for at in 0..self.achievers[index(literal)].len() {
            let (number, effect) = self.achievers[index(literal)][at];
            let operator = &task.operators[number as usize];
            operator.effects[effect as usize].condition.for_each(&mut |literal| self.ask(literal));
            if std::mem::replace(&mut self.kept[number as usize], true) {
                continue;
            }
            operator.precondition.for_each(&mut |literal| self.ask(literal));
            for effect in &operator.effects {
                if self.asked[index(opposite(effect.literal))] {
                    self.queue.push(opposite(effect.literal));
                }
            }
        }
    }
}

fn opposite(literal: Literal) -> Literal {
    Literal {
        fact: literal.fact,
        holds: !literal.holds,
    }
}

/// Numbers the facts that are left without gaps.
fn renumber(mut task: Task) -> Task {
    let mut numbers: Vec<Option<u32>> = vec![None; task.initial.len()];
    let mut initial = Vec::new();
    let mut visit = |literal: Literal| {
        numbers[literal.fact as usize].get_or_insert_with(|| {
            initial.push(task.initial[literal.fact as usize]);
            (initial.len() - 1) as u32
        });
    };
    task.goal.for_each(&mut visit);
    task.always.for_each(&mut visit);
    for operator in &task.operators {
        operator.precondition.for_each(&mut visit);
        for effect in &operator.effects {
            effect.condition.for_each(&mut visit);
            visit(effect.literal);
        }
    }
    let again = |literal: Literal| Literal {
        fact: numbers[literal.fact as usize].unwrap_or_default(),
        holds: literal.holds,
    };
    let formula = |formula: Formula| formula.map(&|literal| Formula::Literal(again(literal)));
    task.goal = formula(task.goal);
    task.always = formula(task.always);
    for operator in &mut task.operators {
        operator.precondition = formula(std::mem::replace(&mut operator.precondition, Formula::TRUE));
        for effect in &mut operator.effects {
            effect.condition = formula(std::mem::replace(&mut effect.condition, Formula::TRUE));
            effect.literal = again(effect.literal);
        }
    }
    task.initial = initial;
    task
}
