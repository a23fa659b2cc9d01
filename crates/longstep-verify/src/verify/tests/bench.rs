//! A small test domain for plan trees: either hand can switch lamps on and off, and sensing reveals whether a lamp is
//! warm.

use crate::plan::{Lane, LaneItem, Node, Plan, Step, StepId, Test};
use crate::verify::{Purpose, Report, check};
use longstep_model::domain::{self, Files};
use longstep_model::model::{Domain, EntityId, Fact, World};
use longstep_model::testing;

const PDDL: &str = "
(define (domain bench)
  (:requirements :strips :typing :negative-preconditions :conditional-effects)
  (:types table lamp hand)
  (:constants left right - hand)
  (:predicates (lit ?lamp - lamp) (linked ?lamp - lamp ?other - lamp) (warm ?lamp - lamp) (cold ?lamp - lamp))
  (:action press :parameters (?hand - hand ?lamp - lamp)
    :precondition (not (lit ?lamp)) :effect (lit ?lamp))
  (:action unpress :parameters (?hand - hand ?lamp - lamp)
    :precondition (lit ?lamp) :effect (not (lit ?lamp)))
  (:action pass :parameters (?hand - hand ?lamp - lamp ?other - lamp)
    :precondition (and (lit ?lamp) (not (= ?lamp ?other))) :effect (and (lit ?other) (not (lit ?lamp))))
  (:action link :parameters (?hand - hand ?lamp - lamp ?other - lamp)
    :precondition (and) :effect (when (lit ?other) (linked ?lamp ?other)))
  (:action feel :parameters (?lamp - lamp) :precondition (and) :effect (and))
  (:action cool :parameters (?lamp - lamp) :precondition (warm ?lamp) :effect (and (cold ?lamp) (not (warm ?lamp))))
  (:action wait :parameters (?lamp - lamp) :precondition (and) :effect (and (not (cold ?lamp)) (not (warm ?lamp)))))
";

const WORDS: &str = r#"
name = "bench"
about = "Lamps on a bench."
[environment]
assets = "table"
objects = "lamp"
[[predicate]]
name = "lit"
says = "{lamp} is lit"
denies = "{lamp} is not lit"
[[predicate]]
name = "linked"
says = "{lamp} is linked to {other}"
denies = "{lamp} is not linked to {other}"
[[predicate]]
name = "warm"
says = "{lamp} is warm"
denies = "{lamp} is not warm"
[[predicate]]
name = "cold"
says = "{lamp} is cold"
denies = "{lamp} is not cold"
[[state]]
word = "LIT"
fact = "(lit ?self)"
means = "It is lit."
[[state]]
word = "WARM"
fact = "(warm ?self)"
means = "It is warm."
[[action]]
name = "press"
call = "press(hand, lamp)"
actor = "?hand"
says = "press {lamp}"
means = "Light it."
[[action]]
name = "unpress"
call = "unpress(hand, lamp)"
actor = "?hand"
says = "press {lamp} again"
means = "Put it out."
[[action]]
name = "pass"
call = "pass_on(hand, lamp, other)"
actor = "?hand"
says = "pass the light of {lamp} on to {other}"
means = "Pass the light on."
[[action]]
name = "link"
call = "link(hand, lamp, other)"
actor = "?hand"
says = "link {lamp} to {other}"
means = "Link two lamps."
[[action]]
name = "feel"
call = "feel(lamp)"
senses = ["(warm ?lamp)", "(cold ?lamp)"]
says = "feel {lamp}"
means = "Tell whether it is warm."
[[action]]
name = "cool"
call = "cool(lamp)"
says = "cool {lamp}"
means = "Cool what is warm."
[[action]]
name = "wait"
call = "wait(lamp)"
says = "wait at {lamp}"
means = "Nobody knows how warm it is then."
"#;

pub(crate) fn domain() -> Domain {
    domain_with("")
}

/// Returns the domain with additional words, such as rules.
pub(crate) fn domain_with(words: &str) -> Domain {
    loaded(PDDL.to_owned(), words)
}

/// Returns the domain with costs: 2 to light a lamp, 3 to put it out.
pub(crate) fn domain_with_costs() -> Domain {
    let pddl = PDDL
        .replace("(:predicates", "(:functions (total-cost) - number) (:predicates")
        .replace(
            "(not (lit ?lamp)) :effect (lit ?lamp))",
            "(not (lit ?lamp)) :effect (and (lit ?lamp) (increase (total-cost) 2)))",
        )
        .replace(
            "(lit ?lamp) :effect (not (lit ?lamp)))",
            "(lit ?lamp) :effect (and (not (lit ?lamp)) (increase (total-cost) 3)))",
        );
    loaded(pddl, "")
}

fn loaded(pddl: String, words: &str) -> Domain {
    let files = Files {
        pddl,
        words: format!("{WORDS}{words}"),
        ..Files::default()
    };
    domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"))
}

/// Returns a world with lamps `<lamp_1>`, `<lamp_2>`, ...; only those in `lit` are lit, and no temperature is known.
pub(crate) fn world(domain: &Domain, lamps: usize, lit: &[usize]) -> World {
    let names: Vec<String> = (1..=lamps).map(|number| format!("\"<lamp_{number}>\"")).collect();
    let states: Vec<String> = lit
        .iter()
        .map(|number| format!("\"<lamp_{number}>\": \"LIT()\""))
        .collect();
    let text = format!(
        r#"{{"assets": ["<bench>"], "objects": [{}], "object_states": {{{}}}}}"#,
        names.join(", "),
        states.join(", ")
    );
    testing::world_of(domain, &text)
}

/// Shorthand for a plan node, for example `press left 1` or `feel 2`.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    Do(String),
    If(Guard, Vec<Part>, Vec<Part>),
    While(Guard, Vec<Part>),
    Repeat(u32, Vec<Part>),
    Lanes(Vec<(&'static str, Vec<String>)>),
}

/// Shorthand for a condition.
#[derive(Debug, Clone)]
pub(crate) enum Guard {
    /// Senses whether the lamp is warm.
    Feel(usize),
    /// A state of a lamp: `lit`, `warm` or `cold`.
    Is(&'static str, usize),
    Not(Box<Guard>),
    All(Vec<Guard>),
    Any(Vec<Guard>),
}

pub(crate) fn does(text: &str) -> Part {
    Part::Do(text.to_owned())
}

pub(crate) fn not(guard: Guard) -> Guard {
    Guard::Not(Box::new(guard))
}

pub(crate) fn lamp(world: &World, number: usize) -> EntityId {
    world.find(&format!("<lamp_{number}>")).unwrap()
}

pub(crate) fn fact(world: &World, predicate: &str, number: usize) -> Fact {
    let domain = world.domain();
    let index = domain.predicates.iter().position(|p| p.name == predicate).unwrap();
    Fact::new(domain::PredicateId::new(index), [lamp(world, number)])
}

struct Builder<'a> {
    domain: &'a Domain,
    world: &'a World,
    steps: Vec<Step>,
}

impl Builder<'_> {
    fn step(&mut self, text: &str) -> StepId {
        let mut words = text.split_whitespace();
        let name = words.next().unwrap();
        let (action, _) = self.domain.action_ids().find(|(_, a)| a.name == name).unwrap();
        let argument = |word: &str| match word.parse() {
            Ok(number) => lamp(self.world, number),
            Err(_) => self.world.find(word).unwrap(),
        };
        let arguments = words.map(argument).collect();
        self.steps.push(Step::explained(self.world, action, arguments));
        StepId::new(self.steps.len() - 1)
    }

    fn test(&mut self, guard: &Guard) -> Test {
        match guard {
            Guard::Feel(number) => Test::Sense(self.step(&format!("feel {number}"))),
            Guard::Is(predicate, number) => Test::Holds(fact(self.world, predicate, *number)),
            Guard::Not(inner) => Test::Not(Box::new(self.test(inner))),
            Guard::All(parts) => Test::All(parts.iter().map(|part| self.test(part)).collect()),
            Guard::Any(parts) => Test::Any(parts.iter().map(|part| self.test(part)).collect()),
        }
    }

    fn nodes(&mut self, parts: &[Part]) -> Vec<Node> {
        parts.iter().map(|part| self.node(part)).collect()
    }

    fn node(&mut self, part: &Part) -> Node {
        match part {
            Part::Do(text) => Node::Step(self.step(text)),
            Part::If(guard, then, otherwise) => Node::If {
                condition: self.test(guard),
                then: self.nodes(then),
                otherwise: self.nodes(otherwise),
            },
            Part::While(guard, body) => Node::While {
                condition: self.test(guard),
                body: self.nodes(body),
            },
            Part::Repeat(times, body) => Node::Repeat {
                times: *times,
                body: self.nodes(body),
            },
            Part::Lanes(lanes) => Node::Parallel {
                lanes: lanes.iter().map(|(actor, items)| self.lane(actor, items)).collect(),
            },
        }
    }

    fn lane(&mut self, actor: &str, items: &[String]) -> Lane {
        let actor = self.world.find(actor).unwrap();
        let item = |text: &String| match text.strip_prefix("sync ") {
            Some(name) => LaneItem::Sync(name.to_owned()),
            None => LaneItem::Step(self.step(text)),
        };
        Lane {
            actor,
            items: items.iter().map(item).collect(),
        }
    }
}

pub(crate) fn plan(world: &World, parts: &[Part]) -> Plan {
    let domain = world.domain();
    let mut builder = Builder {
        domain,
        world,
        steps: Vec::new(),
    };
    let body = builder.nodes(parts);
    Plan::tree(builder.steps, body).unwrap()
}

pub(crate) fn report(world: &World, parts: &[Part]) -> Report {
    check(world, plan(world, parts), &Purpose::default())
}

/// Returns all violations and warnings as sentences.
pub(crate) fn messages(world: &World, report: &Report) -> Vec<String> {
    let all = report.violations.iter().chain(&report.warnings);
    all.map(|found| found.message(world, report.plan.steps(), None))
        .collect()
}
