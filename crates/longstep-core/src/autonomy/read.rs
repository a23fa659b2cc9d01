//! The reader of the tables `[autonomy]` and `[[limit]]`.

use std::ops::Range;
use std::time::Duration;

use indexmap::IndexMap;
use longstep_model::spanned::Spanned;
use serde::Deserialize;
use serde_json::Value;

use super::limit::is_measurable;
use super::{Autonomy, Bound, Level, Limit, LimitSubject};
use longstep_model::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_model::model::{ActionId, Domain, Number, QuantityForm, SkillParameter, TypeId, ValueForm, World};

/// The level of actions that a file does not name.
const DEFAULT: &str = "default";
/// The seconds from an announcement to its step.
const ANNOUNCE_S: &str = "announce_s";
/// The largest number of seconds of an announcement: an hour.
const LONGEST_ANNOUNCEMENT: f64 = 3_600.0;
/// The largest number of limits.
const LIMITS: usize = 1_000;
/// The longest file, in bytes.
const LONGEST: usize = 4 << 20;

type Text = Spanned<String>;

/// Returns the JSON Schema of a file of levels and limits.
///
/// ```
/// assert!(longstep_core::autonomy::schema()["properties"]["limit"].is_object());
/// ```
#[cfg(feature = "schema")]
pub fn schema() -> Value {
    longstep_model::schema::of::<OwnFile>("The levels and limits of a robot in Longstep")
}

/// A file of its own.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct OwnFile {
    /// The level of each action: `free`, `announce`, `approve` or `never`; `default` for the others; `announce_s` is the number of
    /// seconds from an announcement to its step.
    #[serde(default)]
    autonomy: IndexMap<Text, Spanned<LevelText>>,
    /// Limits of the values of steps and goals.
    #[serde(default)]
    limit: Vec<Spanned<LimitEntry>>,
}

/// A file that has other tables too.
#[derive(Debug, Deserialize)]
struct SharedFile {
    #[serde(default)]
    autonomy: IndexMap<Text, Spanned<LevelText>>,
    #[serde(default)]
    limit: Vec<Spanned<LimitEntry>>,
}

/// A level, or a number of seconds.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum LevelText {
    Whole(i64),
    Decimal(f64),
    Text(String),
}

#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct LimitEntry {
    /// The action; without it, the limit is one of all steps and goals.
    action: Option<Text>,
    /// The parameter, or the skill parameter, of the action.
    parameter: Option<Text>,
    /// The type of values.
    value: Option<Text>,
    /// Entities that no step may have there.
    forbidden: Option<Vec<Text>>,
    /// The smallest value.
    min: Option<Spanned<BoundText>>,
    /// The largest value.
    max: Option<Spanned<BoundText>>,
    /// The reason, for people.
    says: Option<String>,
}

/// A number, or one with a unit.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum BoundText {
    Whole(i64),
    Decimal(f64),
    Text(String),
}

impl Autonomy {
    /// Reads a file of levels and limits. Places are looked up in the world, if there is one. See the
    /// [example](Self#example).
    ///
    /// # Errors
    ///
    /// All mistakes, with their places.
    pub fn parse(domain: &Domain, world: Option<&World>, file: &str, text: &str) -> Result<Self, Diagnostics> {
        let OwnFile { autonomy, limit } = parsed(file, text)?;
        Self::read((domain, world), (file, text), autonomy, limit)
    }

    /// Reads the levels and limits of a file that has other tables too, such as `robot.toml`. Other tables are ignored.
    ///
    /// # Errors
    ///
    /// All mistakes in these tables, with their places.
    pub fn parse_within(domain: &Domain, world: Option<&World>, file: &str, text: &str) -> Result<Self, Diagnostics> {
        let SharedFile { autonomy, limit } = parsed(file, text)?;
        Self::read((domain, world), (file, text), autonomy, limit)
    }

    /// Reads the object that [`Autonomy::to_value`] writes.
    ///
    /// # Errors
    ///
    /// All mistakes. Places are not looked up.
    pub fn from_value(domain: &Domain, value: &Value) -> Result<Self, Diagnostics> {
        if value.is_null() {
            return Ok(Self::default());
        }
        let file = "autonomy";
        let text = toml::to_string(value);
        let text = text.map_err(|error| Diagnostics(vec![Diagnostic::whole(file, error.to_string())]))?;
        Self::parse(domain, None, file, &text)
    }

    fn read(
        (domain, world): (&Domain, Option<&World>),
        (file, text): (&str, &str),
        levels: IndexMap<Text, Spanned<LevelText>>,
        limits: Vec<Spanned<LimitEntry>>,
    ) -> Result<Self, Diagnostics> {
        let mut reader = Reader {
            domain,
            world,
            file,
            text,
            autonomy: Self::default(),
            findings: Vec::new(),
        };
        for (name, level) in &levels {
            reader.level(name, level);
        }
        if let Some(one_too_many) = limits.get(LIMITS) {
            reader.report(&one_too_many.span(), format!("more than {LIMITS} limits"));
        }
        for limit in limits.into_iter().take(LIMITS) {
            reader.limit(limit);
        }
        if reader.findings.is_empty() {
            Ok(reader.autonomy)
        } else {
            Err(Diagnostics::sorted(reader.findings))
        }
    }
}

fn parsed<T: serde::de::DeserializeOwned>(file: &str, text: &str) -> Result<T, Diagnostics> {
    if text.len() > LONGEST {
        let message = format!("the file has more than {} MiB", LONGEST >> 20);
        return Err(Diagnostics(vec![Diagnostic::whole(file, message)]));
    }
    toml::from_str(text).map_err(|error| {
        let position = Position::of(text, error.span().map_or(0, |span| span.start));
        let message = error.message().trim().replace('\n', "; ");
        Diagnostics(vec![Diagnostic::at(file, position, message)])
    })
}

struct Reader<'a> {
    domain: &'a Domain,
    world: Option<&'a World>,
    file: &'a str,
    text: &'a str,
    autonomy: Autonomy,
    findings: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn finding(&self, span: &Range<usize>, message: impl Into<String>) -> Diagnostic {
        Diagnostic::at(self.file, Position::of(self.text, span.start), message)
    }

    fn report(&mut self, span: &Range<usize>, message: impl Into<String>) {
        let finding = self.finding(span, message);
        self.findings.push(finding);
    }

    /// Reports an unknown name, with the nearest known one, or else all of them.
    fn unknown<'n>(&mut self, name: &Text, kind: &str, known: impl IntoIterator<Item = &'n str>) {
        let known: Vec<&str> = known.into_iter().collect();
        let finding = self.finding(&name.span(), format!("unknown {kind} `{}`", name.get_ref()));
        let finding = match nearest(name.get_ref(), known.iter().copied()) {
            Some(near) => finding.hint(format!("did you mean `{near}`?")),
            None if known.is_empty() => finding,
            None => finding.hint(format!("write one of {}", listed(&known))),
        };
        self.findings.push(finding);
    }

    fn action(&mut self, name: &Text) -> Option<ActionId> {
        let domain = self.domain;
        let found = domain.action_ids().find(|(_, action)| action.name == *name.get_ref());
        if found.is_none() {
            self.unknown(name, "action", domain.actions.iter().map(|own| own.name.as_str()));
        }
        found.map(|(id, _)| id)
    }

    fn level(&mut self, name: &Text, written: &Spanned<LevelText>) {
        if name.get_ref() == ANNOUNCE_S {
            return self.announcement(written);
        }
        let level = match written.get_ref() {
            LevelText::Text(text) => Level::ALL.into_iter().find(|own| own.name() == text),
            LevelText::Whole(_) | LevelText::Decimal(_) => None,
        };
        if level.is_none() {
            self.report(
                &written.span(),
                "expected a level: `free`, `announce`, `approve` or `never`",
            );
        }
        if name.get_ref() == DEFAULT {
            self.autonomy.default = level.unwrap_or_default();
        } else if let (Some(action), Some(level)) = (self.action(name), level) {
            self.autonomy.levels.insert(action, level);
        }
    }

    fn announcement(&mut self, written: &Spanned<LevelText>) {
        let seconds = match written.get_ref() {
            LevelText::Whole(seconds) => *seconds as f64,
            LevelText::Decimal(seconds) => *seconds,
            LevelText::Text(_) => f64::NAN,
        };
        if (0.0..=LONGEST_ANNOUNCEMENT).contains(&seconds) {
            self.autonomy.announce = Some(Duration::from_secs_f64(seconds));
        } else {
            let message = format!("`{ANNOUNCE_S}` is a number of seconds from 0 to {LONGEST_ANNOUNCEMENT}");
            self.report(&written.span(), message);
        }
    }

    fn limit(&mut self, entry: Spanned<LimitEntry>) {
        let span = entry.span();
        let entry = entry.into_inner();
        let action = match &entry.action {
            Some(name) => match self.action(name) {
                Some(action) => Some(action),
                None => return,
            },
            None => None,
        };
        match (&entry.parameter, &entry.value, &entry.forbidden) {
            (Some(parameter), None, None) => self.skill_limit(&span, parameter, action, &entry),
            (None, Some(kind), None) => self.value_limit(&span, kind, action, &entry),
            (None, None, Some(places)) => self.forbidden(&span, places, action, &entry),
            _ => self.report(&span, "a limit has one of `parameter`, `value` and `forbidden`"),
        }
    }

    fn add(&mut self, subject: LimitSubject, entry: &LimitEntry) {
        self.autonomy.limits.push(Limit {
            subject,
            says: entry.says.clone(),
        });
    }

    /// Adds the limit of a skill parameter, for each action that declares it.
    fn skill_limit(&mut self, span: &Range<usize>, name: &Text, only: Option<ActionId>, entry: &LimitEntry) {
        let domain = self.domain;
        let declared = |action: ActionId| {
            let mut skills = domain.action(action).skills.iter();
            Some((action, skills.find(|own| own.name == *name.get_ref())?))
        };
        let actions = domain.action_ids().map(|(id, _)| id);
        let actions: Vec<ActionId> = actions.filter(|id| only.is_none_or(|only| only == *id)).collect();
        let found: Vec<(ActionId, &SkillParameter)> = actions.iter().copied().filter_map(declared).collect();
        if found.is_empty() {
            let skills = actions.iter().flat_map(|id| domain.action(*id).skills.iter());
            let known = skills.map(|own| own.name.as_str());
            return self.unknown(name, "skill parameter", known);
        }
        for (action, parameter) in found {
            if !is_measurable(parameter.kind) {
                let message = format!(
                    "`{}` of `{}` is a {}, which has no range",
                    parameter.name,
                    domain.action(action).name,
                    parameter.kind.name()
                );
                let finding = self.finding(&name.span(), message);
                let finding = finding.hint("a limit is for an angle, a force, a number, or the length of a vector");
                self.findings.push(finding);
                return;
            }
            let unit = Unit::OfSkill(parameter.unit.as_deref().unwrap_or_default());
            let Some((minimum, maximum)) = self.range(span, entry, &unit) else {
                return;
            };
            let parameter = parameter.name.clone();
            let subject = LimitSubject::Skill {
                action,
                parameter,
                minimum,
                maximum,
            };
            self.add(subject, entry);
        }
    }

    fn value_limit(&mut self, span: &Range<usize>, name: &Text, action: Option<ActionId>, entry: &LimitEntry) {
        let domain = self.domain;
        let quantities = domain.values.iter().filter_map(|own| match &own.form {
            ValueForm::Quantity(form) => Some((own.kind, form)),
            ValueForm::Text => None,
        });
        let quantities: Vec<(TypeId, &QuantityForm)> = quantities.collect();
        let named = quantities
            .iter()
            .find(|(kind, _)| domain.types.name(*kind) == name.get_ref());
        let Some((kind, form)) = named.copied() else {
            let known = quantities.iter().map(|(kind, _)| domain.types.name(*kind));
            return self.unknown(name, "type of values", known);
        };
        let takes = |action: ActionId| {
            let mut parameters = domain.action(action).parameters.iter();
            parameters.any(|own| domain.types.is_a(kind, own.kind))
        };
        if let Some(action) = action.filter(|action| !takes(*action)) {
            let message = format!(
                "`{}` has no argument of the type `{}`",
                domain.action(action).name,
                name.get_ref()
            );
            return self.report(&name.span(), message);
        }
        if let Some((minimum, maximum)) = self.range(span, entry, &Unit::OfValue(form)) {
            let subject = LimitSubject::Value {
                action,
                kind,
                minimum,
                maximum,
            };
            self.add(subject, entry);
        }
    }

    fn forbidden(&mut self, span: &Range<usize>, places: &[Text], action: Option<ActionId>, entry: &LimitEntry) {
        if entry.min.is_some() || entry.max.is_some() {
            self.report(span, "`forbidden` has no range");
        }
        if places.is_empty() {
            self.report(span, "`forbidden` lists no place");
        }
        if let Some(world) = self.world {
            for place in places.iter().filter(|place| world.named(place.get_ref()).is_empty()) {
                let entities = world.entities().filter(|(_, entity)| !entity.is_value);
                self.unknown(place, "place", entities.map(|(_, entity)| entity.name.as_str()));
            }
        }
        let places = places.iter().map(|place| place.get_ref().clone()).collect();
        self.add(LimitSubject::Forbidden { action, places }, entry);
    }

    /// Reads a range; none, with a finding, if it is none.
    fn range(
        &mut self,
        span: &Range<usize>,
        entry: &LimitEntry,
        unit: &Unit<'_>,
    ) -> Option<(Option<Bound>, Option<Bound>)> {
        let minimum = match &entry.min {
            Some(written) => Some(self.bound(written, unit)?),
            None => None,
        };
        let maximum = match &entry.max {
            Some(written) => Some(self.bound(written, unit)?),
            None => None,
        };
        match (&minimum, &maximum) {
            (None, None) => self.report(span, "a limit of a number has `min`, `max` or both"),
            (Some(minimum), Some(maximum)) if minimum.number > maximum.number => {
                self.report(span, "`min` is greater than `max`");
            }
            _ => return Some((minimum, maximum)),
        }
        None
    }

    fn bound(&mut self, written: &Spanned<BoundText>, unit: &Unit<'_>) -> Option<Bound> {
        let text = match written.get_ref() {
            BoundText::Whole(number) => number.to_string(),
            BoundText::Decimal(number) => number.to_string(),
            BoundText::Text(text) => text.trim().to_owned(),
        };
        let (number, given) = text.split_once(char::is_whitespace).unwrap_or((&text, ""));
        let given = given.trim();
        let Some(number) = Number::parse(number) else {
            let message =
                "expected a number with at most six places after the point, and its unit, such as \"0.25 m/s\"";
            self.report(&written.span(), message);
            return None;
        };
        let own = unit.name();
        if given.is_empty() || given == own {
            return Some(Bound {
                number,
                written: with_unit(number, own),
            });
        }
        let Some(converted) = unit.converted(self.domain, number, given) else {
            let known = unit.convertible(self.domain);
            let finding = self.finding(&written.span(), format!("unknown unit `{given}`"));
            let finding = match (nearest(given, known.iter().copied()), &known[..]) {
                (Some(near), _) => finding.hint(format!("did you mean `{near}`?")),
                (None, []) => finding.hint("this number has no unit"),
                (None, known) => finding.hint(format!("write one of {}", listed(known))),
            };
            self.findings.push(finding);
            return None;
        };
        Some(Bound {
            number: converted,
            written: with_unit(number, given),
        })
    }
}

/// The unit of what is limited.
enum Unit<'a> {
    /// A skill parameter declares it; empty for a plain number.
    OfSkill(&'a str),
    /// A type of values has several.
    OfValue(&'a QuantityForm),
}

impl Unit<'_> {
    fn name(&self) -> &str {
        match self {
            Self::OfSkill(unit) => unit,
            Self::OfValue(form) => &form.unit,
        }
    }

    /// Returns the type of values whose units convert into this one.
    fn form<'d>(&'d self, domain: &'d Domain) -> Option<&'d QuantityForm> {
        let has = |form: &&QuantityForm| form.units.iter().any(|(unit, _)| unit == self.name());
        match self {
            Self::OfValue(form) => Some(form),
            Self::OfSkill(_) => {
                let forms = domain.values.iter().filter_map(|own| match &own.form {
                    ValueForm::Quantity(form) => Some(form),
                    ValueForm::Text => None,
                });
                forms.into_iter().find(has)
            }
        }
    }

    /// Returns a number in another unit as one in this unit; none if the units do not convert.
    fn converted(&self, domain: &Domain, number: Number, given: &str) -> Option<Number> {
        let form = self.form(domain)?;
        let size = |unit: &str| {
            let found = form.units.iter().find(|(own, _)| own == unit);
            found.map(|(_, size)| *size)
        };
        number.times(size(given)?)?.over(size(self.name())?)
    }

    /// Returns the units that convert into this one.
    fn convertible<'d>(&'d self, domain: &'d Domain) -> Vec<&'d str> {
        let all = match self.form(domain) {
            Some(form) => form.units.iter().map(|(unit, _)| unit.as_str()).collect(),
            None => vec![self.name()],
        };
        all.into_iter().filter(|unit| !unit.is_empty()).collect()
    }
}

fn with_unit(number: Number, unit: &str) -> String {
    match unit {
        "" => number.to_string(),
        unit => format!("{number} {unit}"),
    }
}

/// Lists names, at most ten.
fn listed(names: &[&str]) -> String {
    let first: Vec<String> = names.iter().take(10).map(|name| format!("`{name}`")).collect();
    first.join(", ")
}
