//! Lints about explanations, sentences and few-shot examples.

use longstep_core::spanned::Spanned;

use super::names::words_of;
use super::places::{Place, Places};
use super::reach::Reach;
use super::{Finding, Lint, quoted};
use longstep::domain::{Atom, Domain, GoalWord, Parameter, Template, plain_words};
use longstep::goal::{QUESTION, read_form};

pub(super) fn findings(domain: &Domain, reach: &Reach<'_>, places: &Places<'_>) -> Vec<Finding> {
    let items = items(domain, places);
    let mut findings = Vec::new();
    for thing in &items {
        missing(thing, &mut findings);
        unnamed(thing, &mut findings);
    }
    same(reach, &items, &mut findings);
    examples(domain, places, &mut findings);
    findings
}

/// An action, state, goal or predicate with its texts.
struct Item<'a> {
    what: &'static str,
    name: &'a str,
    place: Place<'a>,
    /// The `means` text, if the item has one.
    means: Option<&'a str>,
    says: Vec<Sentence<'a>>,
    parameters: &'a [Parameter],
    /// Fact of a state word. Two words for one fact may have equal texts.
    fact: Option<&'a Atom>,
}

struct Sentence<'a> {
    key: &'static str,
    template: &'a Template,
    place: Place<'a>,
    /// Parameters that the sentence must mention.
    named: Vec<usize>,
}

fn items<'a>(domain: &'a Domain, places: &'a Places<'a>) -> Vec<Item<'a>> {
    let sentence = |key, template: &'a Template, text: &Spanned<String>, named: Vec<usize>| Sentence {
        key,
        template,
        place: places.word(text),
        named,
    };
    let mut items = Vec::new();
    for (predicate, words) in domain.predicates.iter().zip(&domain.predicate_words) {
        let Some(entry) = places
            .words
            .predicate
            .iter()
            .find(|e| *e.name.get_ref() == predicate.name)
        else {
            continue;
        };
        let all: Vec<usize> = (0..predicate.parameters.len()).collect();
        let mut says = vec![
            sentence("says", &words.says, &entry.says, all.clone()),
            sentence("denies", &words.denies, &entry.denies, all.clone()),
        ];
        if let (Some(short), Some(text)) = (&words.short, &entry.short) {
            // The entry that holds the text implies the first argument.
            says.push(sentence("short", short, text, all[all.len().min(1)..].to_vec()));
        }
        items.push(Item {
            what: "predicate",
            name: &predicate.name,
            place: places.word(&entry.name),
            means: None,
            says,
            parameters: &predicate.parameters,
            fact: None,
        });
    }
    for (state, entry) in domain.states.iter().zip(&places.words.state) {
        items.push(Item {
            what: "state",
            name: &state.word,
            place: places.word(&entry.word),
            means: Some(&state.means),
            says: Vec::new(),
            parameters: &domain.predicate(state.atom.predicate).parameters,
            fact: Some(&state.atom),
        });
    }
    for action in &domain.actions {
        let Some(entry) = places.words.action.iter().find(|e| *e.name.get_ref() == action.name) else {
            continue;
        };
        // Arguments that the verifier infers may be omitted.
        let named = action.explicit.iter().copied().chain(action.object).collect();
        items.push(Item {
            what: "action",
            name: &action.call,
            place: places.word(&entry.name),
            means: Some(&action.means),
            says: vec![sentence("says", &action.says, &entry.says, named)],
            parameters: &action.parameters,
            fact: None,
        });
    }
    for (word, entry) in domain.goal_words.iter().zip(&places.words.goal) {
        let named = (0..word.parameters.len()).collect();
        items.push(Item {
            what: "goal",
            name: entry.form.get_ref(),
            place: places.word(&entry.form),
            means: Some(&word.means),
            says: vec![sentence("says", &word.says, &entry.says, named)],
            parameters: &word.parameters,
            fact: None,
        });
    }
    items
}

fn missing(thing: &Item<'_>, findings: &mut Vec<Finding>) {
    let Item { what, name, .. } = thing;
    for Sentence { key, place, .. } in thing.says.iter().filter(|sentence| sentence.template.is_blank()) {
        findings.push(Finding::new(
            Lint::MissingExplanation,
            &[name],
            *place,
            format!("`{key}` of the {what} `{name}` is empty"),
            "write a sentence with the parameters in braces: people read it in reports",
        ));
    }
    let Some(means) = thing.means else { return };
    let words = plain_words(means);
    let own = words_of(name.split('(').next().unwrap_or_default());
    let message = if words.is_empty() {
        format!("the {what} `{name}` has no explanation")
    } else if words.iter().all(|word| own.contains(word)) {
        format!("the explanation of the {what} `{name}` says no more than its name")
    } else {
        return;
    };
    findings.push(Finding::new(
        Lint::MissingExplanation,
        &[name],
        thing.place,
        message,
        "say in `means` what it does and when it is the right one: models and people know only this of it",
    ));
}

fn unnamed(thing: &Item<'_>, findings: &mut Vec<Finding>) {
    for sentence in thing.says.iter().filter(|sentence| !sentence.template.is_blank()) {
        let Sentence {
            key, template, place, ..
        } = sentence;
        for index in sentence.named.iter().filter(|index| !template.mentions(**index)) {
            let parameter = thing.parameters[*index].name.as_str();
            findings.push(Finding::new(
                Lint::UnnamedParameter,
                &[thing.name, parameter],
                *place,
                format!(
                    "`{key}` of the {} `{}` does not say which `{parameter}`",
                    thing.what, thing.name
                ),
                format!("put `{{{parameter}}}` into the sentence"),
            ));
        }
    }
}

fn same(reach: &Reach<'_>, items: &[Item<'_>], findings: &mut Vec<Finding>) {
    for (index, later) in items.iter().enumerate() {
        let family = items[..index].iter().filter(|earlier| earlier.what == later.what);
        for earlier in family {
            let alike = |(left, right): (&Parameter, &Parameter)| reach.overlap(left.kind, right.kind);
            let same_kinds = later.parameters.len() == earlier.parameters.len()
                && later.parameters.iter().zip(earlier.parameters).all(alike);
            let means = |thing: &Item<'_>| thing.means.map(plain_words).filter(|words| !words.is_empty());
            let same_fact = later.fact.is_some() && later.fact == earlier.fact;
            let mut sentences = later.says.iter().zip(&earlier.says);
            let sentence =
                sentences.find(|(own, other)| same_kinds && own.template == other.template && !own.template.is_blank());
            let (key, place) = if let Some((sentence, _)) = sentence {
                (sentence.key, sentence.place)
            } else if !same_fact && means(later).is_some() && means(later) == means(earlier) {
                ("means", later.place)
            } else {
                continue;
            };
            let names = [earlier.name, later.name];
            findings.push(Finding::new(
                Lint::SameExplanation,
                &names,
                place,
                format!("the {}s {} have the same `{key}`", later.what, quoted(&names)),
                "say what tells them apart, or keep only one of them",
            ));
        }
        if let [says, denies, ..] = &later.says[..]
            && says.template == denies.template
            && !says.template.is_blank()
        {
            findings.push(Finding::new(
                Lint::SameExplanation,
                &[later.name],
                denies.place,
                format!("`says` and `denies` of the predicate `{}` are the same", later.name),
                "say in `denies` that it does not hold",
            ));
        }
    }
}

/// The goals in a part of an answer: itself, or those of both branches of a condition.
fn goals_of(part: &str) -> Vec<&str> {
    match part.strip_prefix("if ").and_then(|rest| rest.split_once(" then ")) {
        Some((_, branches)) => branches
            .split(" else ")
            .flat_map(|branch| branch.split(" and "))
            .collect(),
        None => vec![part],
    }
}

fn examples(domain: &Domain, places: &Places<'_>, findings: &mut Vec<Finding>) {
    if domain.prompts.examples.is_empty() {
        findings.push(Finding::new(
            Lint::MissingExample,
            &[&domain.name],
            places.examples(),
            "there are no worked examples, and a model learns how to answer from them",
            "write twenty to thirty: each goal, two goals at once, and when to ask back",
        ));
        return;
    }
    let shows = |word: &GoalWord| {
        let is_value = |name: &str| matches!(domain.value(name), Some(Ok(_)));
        let in_scene =
            |names: Vec<&str>, known: &[&str]| names.iter().all(|name| known.contains(name) || is_value(name));
        domain.prompts.examples.iter().any(|example| {
            let scene = example.objects.iter().chain(&example.places);
            let known: Vec<&str> = scene.map(|(name, _)| name.as_str()).collect();
            let mut parts = example.answer.split(" & ").flat_map(goals_of);
            parts.any(|part| read_form(word, part).is_some_and(|names| in_scene(names, &known)))
        })
    };
    let words = domain.goal_words.iter().zip(&places.words.goal);
    for (_, entry) in words.filter(|(word, _)| !shows(word)) {
        let form = entry.form.get_ref().as_str();
        findings.push(Finding::new(
            Lint::MissingExample,
            &[form],
            places.word(&entry.form),
            format!("no worked example shows the goal `{form}`, and what a model is not shown it seldom says"),
            "add one to prompt/examples.toml, with things that your environments do not have",
        ));
    }
    if !domain
        .prompts
        .examples
        .iter()
        .any(|example| example.answer.starts_with(QUESTION))
    {
        findings.push(Finding::new(
            Lint::MissingExample,
            &["question"],
            places.examples(),
            "no worked example asks back, so a model will answer what it cannot know",
            "add one with `answer = \"question: ...\"`, about a thing that its scene does not have",
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::goals_of;

    #[test]
    fn goals_of_a_conditional_goal_include_both_branches() {
        let cases: [(&str, &[&str]); 3] = [
            ("put(letter, hangar)", &["put(letter, hangar)"]),
            (
                "if wet(coat) then hung(coat) and lit(stove)",
                &["hung(coat)", "lit(stove)"],
            ),
            (
                "if wet(coat) then hung(coat) else put(coat, chest)",
                &["hung(coat)", "put(coat, chest)"],
            ),
        ];
        for (part, goals) in cases {
            assert_eq!(goals_of(part), goals, "{part}");
        }
    }
}
