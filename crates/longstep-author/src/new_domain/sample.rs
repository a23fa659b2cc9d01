//! Instructions made from a domain's own goal words and sentences, each with the goal that it was made from.

use rustc_hash::FxHashMap;

use crate::new_domain::wording::capitalized;
use longstep::Clock;
use longstep::domain::GoalWordId;
use longstep::goal::{Goal, GoalFact};
use longstep::report;
use longstep_core::effort;
use longstep_core::environment::{Bindings, EntityId, Moment, World, holds};
use longstep_core::search::{Effort, Limits};
use longstep_core::verify::VerifiedPlan;

/// Argument lists of one goal word that are looked at.
const BINDINGS: usize = 2_000;
/// Searches for one goal word and round.
const SEARCHES: usize = 6;

/// The work units for all instructions of a new domain, about half a second.
const EFFORT: u64 = 10_000_000;

/// The effort of the search for one of them, in millions of work units.
const SEARCH: u32 = 2;

/// An instruction with a known meaning.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Sample {
    /// The instruction, from the sentence of the plan's last step or of the goal.
    pub instruction: String,
    /// The goal that it was made from.
    pub goal: Goal,
    /// A plan that search finds for the goal; it has a step.
    pub plan: VerifiedPlan,
}

/// Makes up to `count` instructions for a world: one for each goal word in turn, the last for two goals if there are
/// two. Fewer if the world has fewer goals that do not hold already and can be reached. Equal inputs give equal
/// samples; another `seed` gives other arguments.
///
/// ```
/// let planner = longstep::Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<counter>", "<table>"], "objects": ["<milk>"],
///     "object_states": {"<milk>": "on_something(<counter>)"}}"#)?;
/// let samples = longstep_author::samples(&world, 5, 0);
/// assert!(samples.iter().all(|sample| !sample.plan.steps().is_empty()));
/// # Ok::<(), longstep::Error>(())
/// ```
pub fn samples(world: &World, count: usize, seed: u64) -> Vec<Sample> {
    let words = (0..world.domain().goal_words.len()).map(GoalWordId::new);
    samples_of(world, words.collect(), count, seed, &Limits::from(Effort::SMALL))
}

/// Makes the instructions of a new domain, each of which takes a search, within one budget of work.
#[derive(Debug)]
pub(super) struct Sampler {
    left: u64,
}

impl Default for Sampler {
    fn default() -> Self {
        Self { left: EFFORT }
    }
}

impl Sampler {
    /// Returns true if the budget is exhausted: there are fewer instructions than wanted.
    pub(super) fn is_exhausted(&self) -> bool {
        self.left == 0
    }

    /// Makes up to `count` instructions; see [`samples`].
    pub(super) fn samples(&mut self, world: &World, count: usize, seed: u64) -> Vec<Sample> {
        let words = (0..world.domain().goal_words.len()).map(GoalWordId::new);
        self.samples_of(world, words.collect(), count, seed)
    }

    /// Makes up to `count` instructions with some of the goal words; see [`samples`].
    pub(super) fn samples_of(&mut self, world: &World, words: Vec<GoalWordId>, count: usize, seed: u64) -> Vec<Sample> {
        let limits = Limits::from(Effort::try_from(SEARCH).unwrap_or(Effort::SMALL));
        let spent = effort::within(self.left, || samples_of(world, words, count, seed, &limits));
        self.left -= spent.units.min(self.left);
        spent.result
    }
}

/// Makes up to `count` instructions with some of the goal words, each with a search within these limits; see [`samples`].
fn samples_of(world: &World, words: Vec<GoalWordId>, count: usize, seed: u64, limits: &Limits) -> Vec<Sample> {
    let order = shuffled(words, seed);
    // The goals of a word are looked for when its turn comes.
    let mut known: FxHashMap<GoalWordId, Vec<GoalFact>> = FxHashMap::default();
    let singles = count - usize::from(count > 2);
    let mut found: Vec<Sample> = Vec::new();
    let mut open = true;
    while found.len() < singles && open {
        open = false;
        for word in &order {
            if found.len() == singles {
                break;
            }
            let goals = known
                .entry(*word)
                .or_insert_with(|| shuffled(candidates(world, *word), seed.wrapping_add(word.index() as u64)));
            for _ in 0..SEARCHES {
                let Some(fact) = goals.pop().filter(|_| effort::spend(1)) else {
                    break;
                };
                if let Some(sample) = sample(world, vec![fact], found.len(), limits) {
                    found.push(sample);
                    open = true;
                    break;
                }
            }
        }
    }
    // Two goals about different entities, in one instruction.
    let pairs = found
        .iter()
        .enumerate()
        .flat_map(|(place, left)| found[place + 1..].iter().map(move |right| (left, right)));
    let apart = pairs.filter(|(left, right)| {
        let named = entities(&right.goal);
        entities(&left.goal).first() != named.first()
    });
    let joined = apart.take(SEARCHES).find_map(|(left, right)| {
        let facts = left.goal.facts.iter().chain(&right.goal.facts).cloned().collect();
        let both = sample(world, facts, 0, limits)?;
        let instruction = format!("{} {}", left.instruction, right.instruction);
        Some(Sample { instruction, ..both })
    });
    if found.len() < count {
        found.extend(joined);
    }
    found
}

fn entities(goal: &Goal) -> Vec<EntityId> {
    let arguments = goal.facts.iter().filter_map(|fact| match fact {
        GoalFact::Word { arguments, .. } => Some(arguments.iter().copied()),
        _ => None,
    });
    arguments.flatten().collect()
}

/// Returns the goals of one word that are offered and do not hold.
fn candidates(world: &World, id: GoalWordId) -> Vec<GoalFact> {
    let word = world.domain().goal_word(id);
    let moment = Moment {
        world,
        state: &world.state,
    };
    let mut lists: Vec<Bindings> = vec![Vec::new()];
    for parameter in &word.parameters {
        let mut longer = Vec::new();
        for list in &lists {
            if longer.len() >= BINDINGS {
                break;
            }
            for entity in world.of_kind(parameter.kind) {
                // An instruction about one entity twice is rarely meant.
                if !list.contains(entity) && longer.len() < BINDINGS && effort::spend(1 + list.len()) {
                    longer.push(list.iter().copied().chain([*entity]).collect());
                }
            }
        }
        lists = longer;
    }
    lists.retain(|list| {
        holds(moment, &word.offered, &mut list.clone()) && !holds(moment, &word.condition, &mut list.clone())
    });
    let goal = |arguments| GoalFact::Word { word: id, arguments };
    lists.into_iter().map(goal).collect()
}

/// Returns the sample for a goal, if search finds a plan with a step; `place` alternates the form of the sentence.
fn sample(world: &World, facts: Vec<GoalFact>, place: usize, limits: &Limits) -> Option<Sample> {
    let goal = Goal::from(facts);
    if goal.depends_on_sensing(world.domain()) {
        return None;
    }
    let plan = report::of_goal(world, &goal, "", limits, &Clock::none()).plan?;
    let last = plan.steps().last()?.explanation.clone();
    let named = entities(&goal);
    let mut names = named.iter().map(|id| world.entity(*id).name.as_str());
    // The last step of a shortest plan achieves the goal; its sentence is how the author says it.
    let instruction = if names.all(|name| last.contains(name)) && place.is_multiple_of(2) {
        format!("{}.", capitalized(&last))
    } else {
        let sentence = goal.sentences(world).join(", ");
        match world.domain().article.as_str() {
            "the" => format!("Make sure that {sentence}."),
            // A domain in another language: its own sentence, as a wish.
            _ => format!("{}!", capitalized(&sentence)),
        }
    };
    Some(Sample {
        instruction,
        goal,
        plan,
    })
}

/// Returns the items in an order that depends on the seed (Fisher and Yates, with Knuth's generator).
fn shuffled<T>(mut items: Vec<T>, seed: u64) -> Vec<T> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
    for end in (1..items.len()).rev() {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        items.swap(end, ((state >> 33) as usize) % (end + 1));
    }
    items
}
