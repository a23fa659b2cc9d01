//! Instructions made from a domain's own goal words and sentences, each with the goal that it was made from.

use crate::environment::{Bindings, EntityId, Moment, World, holds};
use crate::goal::{Goal, GoalFact};
use crate::model::GoalWordId;
use crate::new_domain::wording::capitalized;
use crate::report;
use crate::search::{Effort, Limits};
use crate::verify::VerifiedPlan;

/// Argument lists of one goal word that are looked at.
const BINDINGS: usize = 2_000;
/// Searches for one goal word and round.
const SEARCHES: usize = 6;

/// An instruction with a known meaning.
#[derive(Debug, Clone)]
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
/// let samples = longstep::domain::samples(&world, 5, 0);
/// assert!(samples.iter().all(|sample| !sample.plan.steps().is_empty()));
/// # Ok::<(), longstep::Error>(())
/// ```
pub fn samples(world: &World, count: usize, seed: u64) -> Vec<Sample> {
    let words = world.domain().goal_words.len();
    let mut candidates: Vec<Vec<GoalFact>> = (0..words)
        .map(|index| {
            shuffled(
                candidates(world, GoalWordId::new(index)),
                seed.wrapping_add(index as u64),
            )
        })
        .collect();
    let order = shuffled((0..words).collect(), seed);
    let singles = count - usize::from(count > 2);
    let mut found: Vec<Sample> = Vec::new();
    let mut open = true;
    while found.len() < singles && open {
        open = false;
        for index in &order {
            if found.len() == singles {
                break;
            }
            for _ in 0..SEARCHES {
                let Some(fact) = candidates[*index].pop() else { break };
                if let Some(sample) = sample(world, vec![fact], found.len()) {
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
        let both = sample(world, facts, 0)?;
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
            for entity in world.of_kind(parameter.kind) {
                // An instruction about one entity twice is rarely meant.
                if !list.contains(entity) && longer.len() < BINDINGS {
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
fn sample(world: &World, facts: Vec<GoalFact>, place: usize) -> Option<Sample> {
    let goal = Goal::from(facts);
    if goal.depends_on_sensing(world.domain()) {
        return None;
    }
    let plan = report::of_goal(world, &goal, "", &Limits::from(Effort::SMALL), || 0.0).plan?;
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
