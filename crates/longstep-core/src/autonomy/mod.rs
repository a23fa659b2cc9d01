//! Levels of autonomy and limits: the steps that a robot performs by itself, announced, approved or never, and the ranges
//! of the values with which it performs them.
//!
//! They belong to a robot or to a place, and not to an instruction. A file has them ([`Autonomy::parse`]):
//!
//! ```toml
//! [autonomy]
//! default = "free"              # every action that is not named
//! announce_s = 3                # seconds from an announcement to its step
//! grasp = "announce"
//! attach = "approve"
//! wipe = "never"
//!
//! [[limit]]
//! parameter = "speed"           # a skill parameter
//! action = "move-hand"          # without it, of every action that declares it
//! max = "0.25 m/s"
//! says = "people walk here"
//!
//! [[limit]]
//! value = "temperature"         # a type of values
//! min = "5 degC"
//! max = "80 degC"
//!
//! [[limit]]
//! forbidden = ["stove"]         # no step may have it as an argument
//! ```

mod limit;
mod read;
mod refusal;

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use longstep_model::model::{ActionId, Domain, EntityId, Prohibition, StepPattern, World};

pub use limit::{Bound, Limit, LimitSubject};
#[cfg(feature = "schema")]
pub use read::schema;
pub use refusal::{Refusal, RefusalKind};

/// The time from an announcement to its step, where no file says another one.
const ANNOUNCE: Duration = Duration::from_secs(3);

/// The level of autonomy of an action. A later value is stricter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// The robot performs the step.
    #[default]
    Free,
    /// The step is announced some seconds before it is ordered.
    Announce,
    /// A person approves each such step before it is ordered.
    Approve,
    /// The step is not performed, and no plan contains it.
    Never,
}

impl Level {
    /// All levels.
    pub const ALL: [Self; 4] = [Self::Free, Self::Announce, Self::Approve, Self::Never];

    /// Returns the name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Announce => "announce",
            Self::Approve => "approve",
            Self::Never => "never",
        }
    }
}

/// The levels of the actions of a domain, and the limits of their values.
///
/// ```
/// use longstep_core::autonomy::{Autonomy, Level};
/// use longstep_core::{domain, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<stove>", "<shelf>"]}"#).unwrap();
/// let text = "[autonomy]\nattach = \"approve\"\n[[limit]]\nforbidden = [\"stove\"]\n";
/// let autonomy = Autonomy::parse(&household, Some(&world), "autonomy.toml", text)?;
/// let action = |name: &str| household.action_ids().find(|(_, own)| own.name == name).unwrap().0;
/// assert_eq!(autonomy.level(action("attach")), Level::Approve);
/// assert_eq!(autonomy.level(action("grasp")), Level::Free);
/// let to = |place: &str| [world.find(place).unwrap()];
/// let refused = |place: &str| autonomy.refusal(&world, action("move-hand"), &to(place), &Default::default());
/// assert_eq!(refused("<stove>").unwrap().to_string(), "the stove is forbidden");
/// assert_eq!(refused("<shelf>"), None);
///
/// let wrong = Autonomy::parse(&household, Some(&world), "autonomy.toml", "[autonomy]\natach = \"never\"").unwrap_err();
/// assert_eq!(wrong.to_string(), "autonomy.toml:2:1: unknown action `atach`\n  hint: did you mean `attach`?");
/// # Ok::<(), longstep_core::diagnostic::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Autonomy {
    default: Level,
    levels: BTreeMap<ActionId, Level>,
    /// None for [`ANNOUNCE`].
    announce: Option<Duration>,
    limits: Vec<Limit>,
}

impl Autonomy {
    /// Returns the level of an action. See the [example](Self#example).
    pub fn level(&self, action: ActionId) -> Level {
        self.levels.get(&action).copied().unwrap_or(self.default)
    }

    /// Returns the time from an announcement to its step.
    pub fn announcement(&self) -> Duration {
        self.announce.unwrap_or(ANNOUNCE)
    }

    /// Returns the limits.
    pub fn limits(&self) -> &[Limit] {
        &self.limits
    }

    /// Returns true if every action is free and nothing is limited.
    pub fn is_empty(&self) -> bool {
        let is_free = |level: &Level| *level == Level::Free;
        is_free(&self.default) && self.levels.values().all(is_free) && self.limits.is_empty()
    }

    /// Returns the stricter of both levels for each action, the longer time of announcements, and the limits of both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let actions = self.levels.keys().chain(other.levels.keys());
        let mut limits = self.limits.clone();
        limits.extend(other.limits.iter().filter(|own| !self.limits.contains(own)).cloned());
        Self {
            default: self.default.max(other.default),
            levels: actions
                .map(|own| (*own, self.level(*own).max(other.level(*own))))
                .collect(),
            announce: self.announce.max(other.announce),
            limits,
        }
    }

    /// Returns true if nothing that these levels and limits refuse, ask or announce is free with the others.
    pub fn is_as_strict_as(&self, other: &Self) -> bool {
        let actions = self.levels.keys().chain(other.levels.keys());
        self.default >= other.default
            && actions.into_iter().all(|own| self.level(*own) >= other.level(*own))
            && (!other.announces() || self.announcement() >= other.announcement())
            && other.limits.iter().all(|own| self.limits.contains(own))
    }

    fn announces(&self) -> bool {
        let mut levels = self.levels.values().chain([&self.default]);
        levels.any(|level| *level == Level::Announce)
    }

    /// Returns the prohibitions and limits without a person: what is announced or approved is free. For dry runs.
    #[must_use]
    pub fn without_people(self) -> Self {
        let lowered = |level: Level| if level == Level::Never { level } else { Level::Free };
        Self {
            default: lowered(self.default),
            levels: self
                .levels
                .into_iter()
                .map(|(own, level)| (own, lowered(level)))
                .collect(),
            ..self
        }
    }

    /// Returns the reason why a step with these skill values is not performed; none if it may be. See the
    /// [example](Self#example).
    pub fn refusal(
        &self,
        world: &World,
        action: ActionId,
        arguments: &[EntityId],
        skills: &Map<String, Value>,
    ) -> Option<Refusal> {
        if self.level(action) == Level::Never {
            let action = world.domain().action(action).name.clone();
            return Some(Refusal::new(RefusalKind::Never { action }, None));
        }
        self.limits
            .iter()
            .find_map(|limit| limit.refusal(world, action, arguments, skills))
    }

    /// Returns the reasons why a goal is not pursued: values in it that are outside of limits for every action.
    pub fn refused_values(&self, domain: &Domain, goal: &str) -> Vec<Refusal> {
        let mentions = domain.values_in(goal).into_iter();
        let values = mentions.filter_map(|mention| mention.value.ok());
        values
            .flat_map(|value| {
                let limits = self.limits.iter().filter(|limit| limit.action().is_none());
                let refused = limits.filter_map(|limit| limit.refusal_of_value(&value));
                refused.map(|own| own.named(domain, value.kind)).collect::<Vec<_>>()
            })
            .collect()
    }

    /// Returns the forbidden places that the world does not have: a limit that forbids nothing is a mistake.
    pub fn unknown_places<'a>(&'a self, world: &World) -> Vec<&'a str> {
        let places = self.limits.iter().flat_map(Limit::places);
        places.filter(|place| world.named(place).is_empty()).collect()
    }

    /// Returns the prohibitions for a search in a world: actions that are never performed, forbidden places, and values
    /// outside of their limits. Limits of skill parameters are none: their values depend on the step.
    pub fn prohibitions(&self, world: &World) -> Vec<Prohibition> {
        let domain = world.domain();
        let never = domain.action_ids().filter(|(id, _)| self.level(*id) == Level::Never);
        let never = never.map(|(id, action)| {
            let pattern = StepPattern {
                action: Some(id),
                arguments: vec![None; action.parameters.len()],
                anywhere: None,
            };
            let name = action.name.clone();
            let says = Refusal::new(RefusalKind::Never { action: name.clone() }, None).to_string();
            Prohibition::new(format!("autonomy: never {name}"), says, None, vec![pattern])
        });
        let limited = self.limits.iter().flat_map(|limit| limit.prohibitions(world));
        never.chain(limited).collect()
    }

    /// Returns the levels and limits as the object that [`Autonomy::from_value`] reads; null if there are none.
    pub fn to_value(&self, domain: &Domain) -> Value {
        if self.is_empty() {
            return Value::Null;
        }
        let mut levels = Map::new();
        levels.insert("default".to_owned(), json!(self.default));
        if let Some(announce) = self.announce {
            levels.insert("announce_s".to_owned(), json!(announce.as_secs_f64()));
        }
        for (action, level) in &self.levels {
            levels.insert(domain.action(*action).name.clone(), json!(level));
        }
        let limits: Vec<Value> = self.limits.iter().map(|own| own.to_value(domain)).collect();
        let mut object = Map::new();
        object.insert("autonomy".to_owned(), Value::Object(levels));
        if !limits.is_empty() {
            object.insert("limit".to_owned(), Value::Array(limits));
        }
        Value::Object(object)
    }
}

#[cfg(test)]
pub(crate) mod tests;
