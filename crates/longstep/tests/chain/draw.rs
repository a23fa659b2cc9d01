//! Draws instructions that make sense in a world: what to reach, and words for it.

use longstep::Clock;
use longstep::domain::{Domain, PredicateId};
use longstep::goal::{Goal, GoalFact, parse};
use longstep::instruction::offers;
use longstep::report;
use longstep_core::environment::{EntityId, Fact, World};

/// An instruction, and what is meant by it.
#[derive(Debug, Clone)]
pub struct Drawn {
    pub words: String,
    pub goal: Goal,
    /// The form of the goal, as `put(ITEM, PLACE)`.
    pub kind: String,
}

impl Drawn {
    /// True if a model that is asked for a goal has a way to say the one that is meant.
    pub fn can_be_said(&self, world: &World) -> bool {
        parse(world, &self.told(world)).is_ok_and(|goal| goal == self.goal)
    }

    /// The meaning.
    pub fn told(&self, world: &World) -> String {
        self.goal.everyday(world).join(" & ")
    }
}

/// Equal seeds draw equal instructions for equal worlds.
pub struct Draw {
    state: u64,
}

/// How a goal of the domain `virtualhome` is said, and how often it is drawn. What people want most is that things go
/// somewhere else, and that doors and switches are in another state.
const SAYINGS: [(&str, u32, &[&str]); 10] = [
    (
        "put(ITEM, PLACE)",
        12,
        &[
            "{0} should go {at} {1}",
            "Please place {0} {at} {1}",
            "I would like to have {0} {at} {1}",
            "Could you set {0} down {at} {1}?",
            "Bring {0} over and leave it {at} {1}",
        ],
    ),
    (
        "put(ITEM, top of PLACE)",
        3,
        &["Please set {0} on top of {1}", "{0} should stand on top of {1}"],
    ),
    (
        "opened(THING)",
        3,
        &["Please open {0}", "I want {0} open", "Leave {0} open for me"],
    ),
    (
        "closed(THING)",
        3,
        &["Please close {0}", "{0} should be closed", "Shut {0}, would you?"],
    ),
    (
        "on(DEVICE)",
        3,
        &["Switch {0} on, please", "Turn on {0}", "Could you start {0}?"],
    ),
    ("off(DEVICE)", 3, &["Switch {0} off again", "Turn off {0}, please"]),
    (
        "moved(ITEM)",
        2,
        &["Shift {0} a little", "Move {0} to a different spot where it is"],
    ),
    (
        "heated(ITEM, DEVICE)",
        2,
        &["Warm up {0} with {1}", "Heat {0} in {1}, please"],
    ),
    ("wet(ITEM)", 1, &["Rinse {0} with water", "Get {0} wet, please"]),
    (
        "drunk(ITEM)",
        1,
        &["Drink from {0}", "I am thirsty on your behalf: drink from {0}"],
    ),
];

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// SplitMix64.
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[(self.next() % all.len() as u64) as usize]
    }

    /// An instruction for the world as it is, which some plan carries out.
    pub fn instruction(&mut self, world: &World) -> Drawn {
        let domain = world.domain();
        let offers = offers(world);
        let mut urn = Vec::new();
        for offer in &offers {
            let shown = domain.goal_word(offer.word).shown();
            if let Some(saying) = SAYINGS.iter().find(|saying| saying.0 == shown) {
                urn.extend(std::iter::repeat_n((offer, saying), saying.1 as usize));
            }
        }
        loop {
            let (offer, (kind, _, wordings)) = *self.one_of(&urn);
            let arguments = self.one_of(&offer.arguments).clone();
            if arguments.get(1).is_some_and(|place| is_gadget(world, *place)) {
                continue;
            }
            let wording: &&str = self.one_of(wordings);
            let words = said(world, wording, &arguments);
            let goal = Goal::from(vec![GoalFact::Word {
                word: offer.word,
                arguments,
            }]);
            if report::of_goal(world, &goal, "", &longstep::Limits::default(), &Clock::none())
                .plan
                .is_some()
            {
                let kind = (*kind).to_owned();
                return Drawn { words, goal, kind };
            }
        }
    }
}

/// Nobody puts things on a tap, a toaster or a television.
fn is_gadget(world: &World, place: EntityId) -> bool {
    holds(world, "has-switch", place) && !holds(world, "can-open", place)
}

fn holds(world: &World, predicate: &str, entity: EntityId) -> bool {
    let domain = world.domain();
    let found = domain.predicates.iter().position(|p| p.name == predicate).unwrap();
    world.state.holds(Fact::new(PredicateId::new(found), [entity]))
}

fn said(world: &World, wording: &str, arguments: &[EntityId]) -> String {
    let name = |index: usize| world.with_article(arguments[index]);
    let mut text = wording.replace("{0}", &name(0));
    if arguments.len() > 1 {
        let hollow = ["drawer", "sink"].iter().any(|hollow| name(1).contains(hollow));
        let within = hollow || holds(world, "can-open", arguments[1]);
        text = text.replace("{1}", &name(1));
        text = text.replace("{at}", if within { "in" } else { "on" });
    }
    let first = text.chars().take(1).flat_map(char::to_uppercase);
    first.chain(text.chars().skip(1)).collect()
}
