//! The environment of a scene, in the words of a domain.

use indexmap::IndexMap;
use rustc_hash::FxHashSet;

use super::relation::{Found, SceneFinding, relations};
use super::scene::{Kind, Scene, words};
use crate::call::Call;
use crate::effort;
use crate::environment::Environment;
use crate::model::{Domain, SpatialRelation};

/// The work for one scene, above that of the relations between 1,000 boxes that do not all overlap.
const WORK: u64 = 4 * effort::OPERATION;

/// An environment that was found in a scene.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Look {
    /// The environment.
    pub environment: Environment,
    /// The reason of every statement, in the order of the boxes.
    pub reasons: Vec<Reason>,
    /// The boxes that fit no world.
    pub findings: Vec<SceneFinding>,
    /// The lists that the scene does not give.
    pub assumed: Vec<Assumed>,
    /// Relations of the scene for which the domain has no word.
    pub wordless: Vec<SpatialRelation>,
}

/// A statement and its reason.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Reason {
    /// The entity of the entry.
    pub subject: String,
    /// The state in the domain's words.
    pub statement: String,
    /// The reason as a sentence, with the measures.
    pub text: String,
}

/// A box whose list was not given.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Assumed {
    /// The name of the box.
    pub name: String,
    /// The list.
    pub kind: Kind,
    /// The assumption as a sentence.
    pub text: String,
}

/// The reason why a scene has no environment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LookError {
    /// The domain does not say which states are relations in space.
    #[error("no state of the domain `{0}` has `geometry`, which says the relations between boxes")]
    NoGeometry(String),
    /// The boxes overlap in too many ways.
    #[error("comparing the boxes takes too much work: too many of them overlap")]
    TooMuchWork,
}

/// Finds the environment of a scene.
///
/// ```
/// use longstep_model::{domain, geometry::{self, Scene}};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let scene = Scene::parse("boxes.json", r#"{"boxes": [
///     {"name": "<table>", "position": [0, 0, 0.4], "size": [1.2, 0.8, 0.8]},
///     {"name": "<cup>", "position": [0.1, 0, 0.852], "size": [0.08, 0.08, 0.1]}]}"#).unwrap();
/// let look = geometry::look(&household, &scene).unwrap();
/// assert_eq!(look.environment.objects, ["<cup>"]);
/// assert_eq!(look.reasons[0].statement, "on_something(<table>)");
/// assert_eq!(
///     look.reasons[0].text,
///     "<cup> is on <table>: its lowest point is 2 mm above the top of <table>, and 100 % of it is over <table>"
/// );
/// ```
///
/// # Errors
///
/// A domain without relations in space, and boxes that take more work than the budget.
pub fn look(domain: &Domain, scene: &Scene) -> Result<Look, LookError> {
    if domain.states.iter().all(|state| state.relations.is_empty()) {
        return Err(LookError::NoGeometry(domain.name.clone()));
    }
    let spent = effort::within(WORK, || relations(scene));
    if spent.exhausted {
        return Err(LookError::TooMuchWork);
    }
    let found = spent.result;
    let mut reasons = Vec::new();
    let mut wordless: Vec<SpatialRelation> = Vec::new();
    let mut moved: FxHashSet<usize> = FxHashSet::default();
    for related in &found.related {
        let (relation, argument) = worded(scene, related.relation);
        if matches!(related.relation, Found::On(_) | Found::Inside(_) | Found::Held { .. }) {
            moved.insert(related.subject);
        }
        let word = domain.states.iter().find(|state| state.relations.contains(&relation));
        let Some(word) = word else {
            if !wordless.contains(&relation) {
                wordless.push(relation);
            }
            continue;
        };
        let arguments = argument.into_iter().take(word.parameters.len());
        let call = Call {
            name: word.word.clone(),
            arguments: arguments.map(str::to_owned).collect(),
        };
        reasons.push((
            related.subject,
            Reason {
                subject: scene.boxes[related.subject].name.clone(),
                statement: call.to_string(),
                text: related.reason.clone(),
            },
        ));
    }
    wordless.sort_unstable();
    reasons.sort_by_key(|(subject, _)| *subject);
    let reasons: Vec<Reason> = reasons.into_iter().map(|(_, reason)| reason).collect();
    let mut assumed = Vec::new();
    let kinds: Vec<Kind> = scene
        .boxes
        .iter()
        .enumerate()
        .map(|(index, body)| {
            body.kind.unwrap_or_else(|| {
                let is_moved = moved.contains(&index) || body.part_of.is_some();
                let own = assumption(&body.name, is_moved);
                let kind = own.kind;
                assumed.push(own);
                kind
            })
        })
        .collect();
    Ok(Look {
        environment: environment(scene, &kinds, &reasons),
        reasons,
        findings: found.findings,
        assumed,
        wordless,
    })
}

fn assumption(name: &str, is_moved: bool) -> Assumed {
    let (kind, text) = if is_moved {
        (
            Kind::Object,
            format!("{name} is an object: it is on, in or part of something, or held"),
        )
    } else {
        (
            Kind::Asset,
            format!("{name} is an asset: it is on nothing and in nothing"),
        )
    };
    Assumed {
        name: name.to_owned(),
        kind,
        text,
    }
}

/// Returns the relation for a state word, and its argument.
fn worded(scene: &Scene, found: Found) -> (SpatialRelation, Option<&str>) {
    let name = |index: usize| Some(scene.boxes[index].name.as_str());
    match found {
        Found::On(place) => (SpatialRelation::On, name(place)),
        Found::Inside(place) => (SpatialRelation::Inside, name(place)),
        Found::NextTo(other) => (SpatialRelation::NextTo, name(other)),
        Found::Held { hand } => (SpatialRelation::Held, Some(scene.hands[hand].name.as_str())),
        Found::Open => (SpatialRelation::Open, None),
        Found::Closed => (SpatialRelation::Closed, None),
    }
}

fn environment(scene: &Scene, kinds: &[Kind], reasons: &[Reason]) -> Environment {
    let mut environment = Environment::default();
    let mut texts: IndexMap<&str, Vec<String>> = IndexMap::new();
    for reason in reasons {
        texts.entry(&reason.subject).or_default().push(reason.statement.clone());
    }
    let mut types = IndexMap::new();
    for (body, kind) in scene.boxes.iter().zip(kinds) {
        let (list, states, properties) = match kind {
            Kind::Asset => (
                &mut environment.assets,
                &mut environment.asset_states,
                &mut environment.asset_properties,
            ),
            Kind::Object => (
                &mut environment.objects,
                &mut environment.object_states,
                &mut environment.object_properties,
            ),
        };
        list.push(body.name.clone());
        let mut own = texts.swap_remove(body.name.as_str()).unwrap_or_default();
        own.extend(body.states.iter().cloned());
        if !own.is_empty() {
            states.insert(body.name.clone(), words(own));
        }
        if !body.properties.is_empty() {
            let all = properties.get_or_insert_default();
            all.insert(body.name.clone(), words(body.properties.clone()));
        }
        if let Some(type_name) = &body.type_name {
            types.insert(body.name.clone(), type_name.clone());
        }
    }
    environment.types = (!types.is_empty()).then_some(types);
    environment
}
