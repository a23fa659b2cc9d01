//! The landmark-cut heuristic: a lower bound on the cost of reaching the goal.
//!
//! Helmert and Domshlak, *Landmarks, Critical Paths and Abstractions: What's the Difference Anyway?* (2009),
//! with conditional effects as in Röger, Pommerening and Helmert (2014): the cost that a cut takes is taken
//! from the whole action, whichever of its effects are in the cut, so the bound stays a lower bound.
//!
//! Conditions need not be conjunctions: every inner node of a formula becomes a proposition of its own that
//! costs nothing to derive from its parts.

use super::formula::{Formula, Literal};
use super::task::Task;

/// A rule of the relaxed task: from all of `needs`, at the cost of `operator`, follow all of `gives`.
#[derive(Debug)]
struct Rule {
    needs: Vec<u32>,
    gives: Vec<u32>,
    /// The operator that pays, none for the inner nodes of formulas.
    operator: Option<u32>,
}

const UNREACHED: u32 = u32::MAX;

/// What the bound is computed from, made once for a task, and room to compute in.
#[derive(Debug)]
pub(super) struct LandmarkCut {
    rules: Vec<Rule>,
    /// By proposition: the rules that need it.
    needed_by: Vec<Vec<u32>>,
    /// By proposition: the rules that give it.
    given_by: Vec<Vec<u32>>,
    /// By fact: the propositions for "holds not" and "holds", if anything needs them.
    literals: Vec<[Option<u32>; 2]>,
    truth: u32,
    goal: u32,
    /// By operator: what it costs.
    operator_costs: Vec<u32>,
    // Scratch space.
    cost: Vec<u32>,
    value: Vec<u32>,
    missing: Vec<u32>,
    supporter: Vec<u32>,
}

/// What is known of a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Estimate {
    /// No plan costs less; `None` if there is no plan.
    pub(super) cost: Option<u32>,
    /// Operators in the cuts, of which some must be applied, sorted.
    pub(super) preferred: Vec<u32>,
}

impl LandmarkCut {
    pub(super) fn new(task: &Task) -> Self {
        let mut heuristic = Self {
            rules: Vec::new(),
            needed_by: Vec::new(),
            given_by: Vec::new(),
            literals: vec![[None; 2]; task.initial.len()],
            truth: 0,
            goal: 0,
            operator_costs: task.operators.iter().map(|operator| operator.cost).collect(),
            cost: Vec::new(),
            value: Vec::new(),
            missing: Vec::new(),
            supporter: Vec::new(),
        };
        heuristic.truth = heuristic.proposition();
        heuristic.goal = heuristic.proposition();
        let mut needs = heuristic.needs(&task.goal);
        needs.push(heuristic.truth);
        let goal = heuristic.goal;
        heuristic.rule(needs, vec![goal], None);
        // Conditions first, so that every literal that is needed is known when effects are looked at.
        let mut conditions = Vec::new();
        for operator in &task.operators {
            let precondition = heuristic.needs(&operator.precondition);
            let applicable = heuristic.proposition();
            let truth = heuristic.truth;
            heuristic.rule([precondition, vec![truth]].concat(), vec![applicable], None);
            let mut groups: Vec<(Formula, Vec<u32>, Vec<Literal>)> = Vec::new();
            for effect in &operator.effects {
                match groups.iter_mut().find(|(condition, ..)| *condition == effect.condition) {
                    Some((_, _, gives)) => gives.push(effect.literal),
                    None => {
                        let mut needs = heuristic.needs(&effect.condition);
                        needs.push(applicable);
                        groups.push((effect.condition.clone(), needs, vec![effect.literal]));
                    }
                }
            }
            conditions.push(groups);
        }
        for (number, groups) in conditions.into_iter().enumerate() {
            for (_, needs, gives) in groups {
                let gives: Vec<u32> = gives
                    .into_iter()
                    .filter_map(|literal| heuristic.literals[literal.fact as usize][usize::from(literal.holds)])
                    .collect();
                if !gives.is_empty() {
                    heuristic.rule(needs, gives, Some(number as u32));
                }
            }
        }
        heuristic
    }

    fn proposition(&mut self) -> u32 {
        self.needed_by.push(Vec::new());
        self.given_by.push(Vec::new());
        (self.needed_by.len() - 1) as u32
    }

    fn rule(&mut self, mut needs: Vec<u32>, gives: Vec<u32>, operator: Option<u32>) {
        needs.sort_unstable();
        needs.dedup();
        let number = self.rules.len() as u32;
        for proposition in &needs {
            self.needed_by[*proposition as usize].push(number);
        }
        for proposition in &gives {
            self.given_by[*proposition as usize].push(number);
        }
        self.rules.push(Rule { needs, gives, operator });
    }

    /// Propositions that together mean the formula.
    fn needs(&mut self, formula: &Formula) -> Vec<u32> {
        match formula {
            Formula::And(all) => all.iter().flat_map(|part| self.needs(part)).collect(),
            Formula::Or(any) => {
                let node = self.proposition();
                for part in any {
                    let mut needs = self.needs(part);
                    needs.push(self.truth);
                    self.rule(needs, vec![node], None);
                }
                vec![node]
            }
            Formula::Literal(Literal { fact, holds }) => {
                let known = self.literals[*fact as usize][usize::from(*holds)];
                let proposition = known.unwrap_or_else(|| self.proposition());
                self.literals[*fact as usize][usize::from(*holds)] = Some(proposition);
                vec![proposition]
            }
        }
    }

    /// The bound for a state.
    pub(super) fn estimate(&mut self, holds: impl Fn(u32) -> bool) -> Estimate {
        let mut start = vec![self.truth];
        for (fact, propositions) in self.literals.iter().enumerate() {
            start.extend(propositions[usize::from(holds(fact as u32))]);
        }
        self.cost.clone_from(&self.operator_costs);
        let mut bound = 0;
        let mut preferred = Vec::new();
        loop {
            self.values(&start);
            match self.value[self.goal as usize] {
                UNREACHED => {
                    return Estimate {
                        cost: None,
                        preferred: Vec::new(),
                    };
                }
                0 => break,
                _ => {}
            }
            let cut = self.cut(&start);
            let least = cut.iter().map(|operator| self.cost[*operator as usize]).min();
            let Some(least) = least.filter(|least| *least > 0) else {
                // Unreachable by construction; a bound that is too low is still a bound.
                debug_assert!(false, "an empty cut");
                break;
            };
            bound += least;
            for operator in &cut {
                self.cost[*operator as usize] -= least;
            }
            preferred.extend(cut);
        }
        preferred.sort_unstable();
        preferred.dedup();
        Estimate {
            cost: Some(bound),
            preferred,
        }
    }

    fn price(&self, rule: u32) -> u32 {
        self.rules[rule as usize]
            .operator
            .map_or(0, |operator| self.cost[operator as usize])
    }

    /// The cheapest way to each proposition when a rule costs as much as the dearest of its needs; the
    /// dearest is the rule's supporter.
    fn values(&mut self, start: &[u32]) {
        self.value.clear();
        self.value.resize(self.needed_by.len(), UNREACHED);
        self.missing.clear();
        self.missing
            .extend(self.rules.iter().map(|rule| rule.needs.len() as u32));
        self.supporter.clear();
        self.supporter.resize(self.rules.len(), UNREACHED);
        // Costs are small whole numbers: a bucket for each sum of them.
        let mut buckets: Vec<Vec<u32>> = vec![start.to_vec()];
        for proposition in start {
            self.value[*proposition as usize] = 0;
        }
        let mut distance = 0;
        while distance < buckets.len() {
            let Some(proposition) = buckets[distance].pop() else {
                distance += 1;
                continue;
            };
            if self.value[proposition as usize] != distance as u32 {
                continue;
            }
            for at in 0..self.needed_by[proposition as usize].len() {
                let rule = self.needed_by[proposition as usize][at];
                let missing = &mut self.missing[rule as usize];
                if *missing == 0 {
                    continue;
                }
                *missing -= 1;
                if *missing > 0 {
                    continue;
                }
                // The last need to be reached is the dearest.
                self.supporter[rule as usize] = proposition;
                let value = distance as u32 + self.price(rule);
                for given in 0..self.rules[rule as usize].gives.len() {
                    let proposition = self.rules[rule as usize].gives[given];
                    if value < self.value[proposition as usize] {
                        self.value[proposition as usize] = value;
                        if buckets.len() <= value as usize {
                            buckets.resize(value as usize + 1, Vec::new());
                        }
                        buckets[value as usize].push(proposition);
                    }
                }
            }
        }
    }

    /// The operators that lead from what is reached without them into what leads on to the goal for nothing.
    fn cut(&self, start: &[u32]) -> Vec<u32> {
        let mut near_goal = vec![false; self.needed_by.len()];
        near_goal[self.goal as usize] = true;
        let mut queue = vec![self.goal];
        while let Some(proposition) = queue.pop() {
            for rule in &self.given_by[proposition as usize] {
                let supporter = self.supporter[*rule as usize];
                if supporter != UNREACHED
                    && self.price(*rule) == 0
                    && !std::mem::replace(&mut near_goal[supporter as usize], true)
                {
                    queue.push(supporter);
                }
            }
        }
        let mut reached = vec![false; self.needed_by.len()];
        let mut cut = Vec::new();
        let mut queue: Vec<u32> = Vec::new();
        for proposition in start {
            if !near_goal[*proposition as usize] {
                reached[*proposition as usize] = true;
                queue.push(*proposition);
            }
        }
        while let Some(proposition) = queue.pop() {
            for rule in &self.needed_by[proposition as usize] {
                if self.supporter[*rule as usize] != proposition {
                    continue;
                }
                for given in &self.rules[*rule as usize].gives {
                    if near_goal[*given as usize] {
                        cut.extend(self.rules[*rule as usize].operator);
                    } else if !std::mem::replace(&mut reached[*given as usize], true) {
                        queue.push(*given);
                    }
                }
            }
        }
        cut.sort_unstable();
        cut.dedup();
        cut
    }
}
