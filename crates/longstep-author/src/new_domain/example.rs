//! The worked examples and the suite of a new domain. Every answer in them was planned by search and accepted by the
//! verifier.

use rustc_hash::FxHashSet;

use super::sample::{Sample, Sampler};
use super::words::quoted;
use longstep::dialogue::scene_lists;
use longstep::domain::GoalWordId;
use longstep::goal::GoalFact;
use longstep_core::environment::{self, EntityId, Environment, World};
use longstep_core::json::Path;

/// The task of the model, `prompt/goal.md`; a template.
pub(super) const TASK: &str = include_str!("goal.md");

/// Worked examples for a model that writes goals.
const EXAMPLES: usize = 20;
/// Worlds after an example in which further goals are looked for.
const LATER: usize = 8;
/// Worked plans for a model that writes whole plans.
const PLANS: usize = 3;
/// Entities beside those of an example's plan that its scene shows.
const OTHERS: usize = 2;

/// Names for the entities of examples, which the author's own worlds do not have.
const LABELS: [&str; 20] = [
    "K", "L", "M", "N", "P", "Q", "R", "S", "T", "U", "V", "W", "X", "Y", "Z", "A", "B", "C", "D", "E",
];

/// Returns the world with other names, so that examples teach patterns and not answers.
fn renamed(world: &World) -> Option<World> {
    let domain = world.domain();
    let text = serde_json::to_string(world.environment()).ok()?;
    let mut value: serde_json::Value = serde_json::from_str(&text).ok()?;
    let mut names = std::collections::BTreeMap::new();
    let mut counts: std::collections::BTreeMap<String, usize> = std::collections::BTreeMap::new();
    for (_, entity) in world.entities().skip(domain.constants.len()) {
        let mut base = match domain.types.name(entity.kind) {
            "object" => entity.identifier.trim_matches(['<', '>']).to_owned(),
            kind => kind.to_owned(),
        };
        let end = base
            .trim_end_matches(|c: char| c.is_ascii_digit() || c == '_' || c == '-')
            .len();
        base.truncate(end);
        if base.chars().count() < 2 {
            base = "item".to_owned();
        }
        let count = counts.entry(base.clone()).or_default();
        let label = match LABELS.get(*count) {
            Some(label) => (*label).to_owned(),
            None => format!("{}", *count + 100),
        };
        *count += 1;
        names.insert(entity.identifier.clone(), format!("<{base}_{label}>"));
    }
    rename(&mut value, &names);
    let environment: Environment = serde_json::from_value(value).ok()?;
    environment::read(domain, &environment, "", "", &Path::default()).ok()
}

/// Replaces identifiers in all texts and keys. They are in angle brackets, so no name is part of another.
fn rename(value: &mut serde_json::Value, names: &std::collections::BTreeMap<String, String>) {
    let replaced = |text: &str| {
        let mut result = String::new();
        let mut rest = text;
        while let Some(start) = rest.find('<') {
            let Some(length) = rest[start..].find('>') else { break };
            let own = &rest[start..=start + length];
            result.push_str(&rest[..start]);
            result.push_str(names.get(own).map_or(own, String::as_str));
            rest = &rest[start + length + 1..];
        }
        result + rest
    };
    match value {
        serde_json::Value::String(text) => *text = replaced(text),
        serde_json::Value::Array(items) => items.iter_mut().for_each(|item| rename(item, names)),
        serde_json::Value::Object(entries) => {
            let old = std::mem::take(entries);
            for (key, mut value) in old {
                rename(&mut value, names);
                entries.insert(replaced(&key), value);
            }
        }
        _ => {}
    }
}

/// Returns the entities of a sample's plan and goal, and a few others.
fn shown(world: &World, sample: &Sample) -> FxHashSet<EntityId> {
    let mut shown: FxHashSet<EntityId> = FxHashSet::default();
    for step in sample.plan.steps() {
        shown.extend(step.arguments.iter().copied());
    }
    shown.extend(sample.goal.facts.iter().flat_map(|fact| fact.about(world.domain())));
    let others: Vec<EntityId> = world
        .entities()
        .map(|(id, _)| id)
        .filter(|id| !shown.contains(id))
        .collect();
    shown.extend(others.into_iter().take(OTHERS));
    shown
}

/// Writes `prompt/examples.toml`.
pub(super) fn examples(world: &World, sampler: &mut Sampler) -> String {
    let world = &renamed(world).unwrap_or_else(|| world.clone());
    let mut text = String::from(
        "#:schema ../schemas/examples.schema.json\n\
         # Worked examples for the model, made from the sentences in domain.toml; every answer was planned and verified.\n\
         # Replace instructions by words that people really say. Use names that your own environments do not have.\n",
    );
    // Without an example, the scene is empty.
    let mut scene = "objects = {}\nplaces = {}".to_owned();
    let mut done: Vec<String> = Vec::new();
    let mut add = |world: &World, sample: &Sample| {
        if done.contains(&sample.instruction) || done.len() >= EXAMPLES {
            return;
        }
        let (objects, places) = scene_lists(world, &shown(world, sample));
        let table = |entries: &[(String, String)]| {
            let entries = entries
                .iter()
                .map(|(name, line)| format!("{} = {}", quoted(name), quoted(line)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        };
        scene = format!("objects = {}\nplaces = {}", table(&objects), table(&places));
        let answer = sample.goal.everyday(world).join(" & ");
        text.push_str(&format!(
            "\n[[example]]\n{scene}\ninstruction = {}\nanswer = {}\n",
            quoted(&sample.instruction),
            quoted(&answer)
        ));
        done.push(sample.instruction.clone());
    };
    let words = world.domain().goal_words.len();
    // More are not shown.
    let wanted = EXAMPLES.min(words + 1);
    let first = sampler.samples(world, wanted, 0);
    first.iter().for_each(|sample| add(world, sample));
    // A goal that holds at the start is one after another goal: an empty hand after grasping.
    let mut open: FxHashSet<GoalWordId> = (0..words).map(GoalWordId::new).collect();
    let of_words = |sample: &Sample| -> Vec<GoalWordId> {
        let words = sample.goal.facts.iter().filter_map(|fact| match fact {
            GoalFact::Word { word, .. } => Some(*word),
            _ => None,
        });
        words.collect()
    };
    for sample in &first {
        of_words(sample).iter().for_each(|word| {
            open.remove(word);
        });
    }
    let endings = first.iter().filter_map(|sample| sample.plan.endings().first());
    for ending in endings.take(if first.len() < EXAMPLES { LATER } else { 0 }) {
        let later = world.after(ending);
        let still_open: Vec<GoalWordId> = (0..words).map(GoalWordId::new).filter(|id| open.contains(id)).collect();
        for sample in sampler.samples_of(&later, still_open, EXAMPLES.min(open.len() + 1), 0) {
            if of_words(&sample).iter().filter(|word| open.remove(word)).count() > 0 {
                add(&later, &sample);
            }
        }
    }
    for seed in 1..3 {
        if first.len() < EXAMPLES {
            sampler
                .samples(world, wanted, seed)
                .iter()
                .for_each(|sample| add(world, sample));
        }
    }
    for (instruction, question) in [
        ("Bring me the trumpet.", "I see no trumpet here. What should I use?"),
        ("How are you?", "What should I do?"),
    ] {
        text.push_str(&format!(
            "\n[[example]]\n{scene}\ninstruction = {}\nanswer = {}\n",
            quoted(instruction),
            quoted(&format!("question: {question}"))
        ));
    }
    text
}

/// Writes `prompt/plans.toml`.
pub(super) fn plans(world: &World, sampler: &mut Sampler) -> String {
    let world = &renamed(world).unwrap_or_else(|| world.clone());
    let mut text = String::from(
        "#:schema ../schemas/plans.schema.json\n# Worked examples for a model that writes whole plans; search plans for each `goal`.\n",
    );
    let mut environment = String::new();
    for sample in sampler.samples(world, PLANS, 0) {
        let keep: Vec<EntityId> = {
            let shown = shown(world, &sample);
            let all = world.entities().map(|(id, _)| id);
            all.filter(|id| shown.contains(id)).collect()
        };
        let part = world.narrowed(&keep);
        environment = inline(&serde_json::to_value(part.environment()).unwrap_or_default());
        text.push_str(&format!(
            "\n[[example]]\ninstruction = {}\ngoal = {}\nenvironment = {environment}\n",
            quoted(&sample.instruction),
            quoted(&sample.goal.everyday(world).join(" & ")),
        ));
    }
    text.push_str(&format!(
        "\n[[example]]\ninstruction = \"Bring me the trumpet.\"\nquestion = \"I see no trumpet here. What should I use?\"\n\
         environment = {environment}\n"
    ));
    text
}

/// Writes JSON as an inline value of TOML.
fn inline(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Object(entries) => {
            let entries = entries.iter().filter(|(_, value)| !value.is_null());
            let entries: Vec<String> = entries
                .map(|(key, value)| format!("{} = {}", quoted(key), inline(value)))
                .collect();
            format!("{{ {} }}", entries.join(", "))
        }
        serde_json::Value::Array(items) => {
            let items: Vec<String> = items.iter().map(inline).collect();
            format!("[{}]", items.join(", "))
        }
        other => other.to_string(),
    }
}

/// Returns the files of a small suite: instructions made from the domain's sentences, for the author to replace.
pub(super) fn suite(name: &str, world: &World, samples: &[Sample]) -> Vec<(String, String)> {
    let about = "Instructions made from the domain's own sentences. Replace them by what people really say.";
    let head = format!("name = {}\nabout = {}\ndomain = \"..\"\n", quoted(name), quoted(about));
    let mut cases = String::new();
    for (index, sample) in samples.iter().enumerate() {
        cases.push_str(&format!(
            "[[case]]\nid = \"{name}-{:02}\"\nscene = \"example\"\nsays = {}\ngoal = {}\n\n",
            index + 1,
            quoted(&sample.instruction),
            quoted(&sample.goal.exact(world).join(" & "))
        ));
    }
    vec![
        ("suite/suite.toml".to_owned(), head),
        ("suite/instructions.toml".to_owned(), cases),
    ]
}
