//! The texts of a domain's `prompt/` folder, as data.

use std::collections::BTreeMap;

use longstep_core::domain::Files;

/// The texts with which a model is asked about a domain.
#[derive(Debug, Clone, Default)]
pub struct Prompts {
    /// The goal strategy's task: `prompt/goal.md`, rendered.
    pub goal: String,
    /// The worked examples of `prompt/examples.toml`.
    pub examples: Vec<Example>,
    /// The texts of the direct strategy's parts, not rendered yet.
    pub parts: PartTexts,
    /// The worked examples of `prompt/feedback.toml`.
    pub feedback_examples: Vec<FeedbackExample>,
}

/// A worked example for the model: a small scene, an instruction and the answer to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Example {
    /// Names of things and what is said of them.
    pub objects: Vec<(String, String)>,
    /// Names of places and what is said of them.
    pub places: Vec<(String, String)>,
    /// The instruction.
    pub instruction: String,
    /// Goals joined by ` & `, or `question: ...`.
    pub answer: String,
}

impl Example {
    /// The names of its objects and places.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().chain(&self.places).map(|(name, _)| name.as_str())
    }
}

/// A worked example for the model: a plan, what a person says about it, and the answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FeedbackExample {
    /// The instruction that the plan is for.
    pub instruction: String,
    /// The steps, each a call and its sentence: `grasp_object(): grasp the mug`.
    pub plan: Vec<String>,
    /// The person's words about the plan.
    pub says: String,
    /// `goal`, changes joined by ` & `, or `question: ...`.
    pub answer: String,
}

/// The texts that the direct strategy's parts are made from, with their paths.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartTexts {
    /// By file name.
    sources: BTreeMap<String, Source>,
}

/// A text and what findings call it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Source {
    pub(crate) path: String,
    pub(crate) text: String,
}

impl Default for PartTexts {
    /// The library's own, which have no examples.
    fn default() -> Self {
        let own = [
            ("role.md", include_str!("../dialogue/parts/role.md")),
            ("actions.md", include_str!("../dialogue/parts/actions.md")),
            ("environment.md", include_str!("../dialogue/parts/environment.md")),
            ("format.md", include_str!("../dialogue/parts/format.md")),
            ("query.md", include_str!("../dialogue/parts/query.md")),
            ("plans.toml", ""),
        ];
        let source = |(name, text): (&str, &str)| {
            let path = format!("longstep's own {name}");
            (
                name.to_owned(),
                Source {
                    path,
                    text: text.to_owned(),
                },
            )
        };
        Self {
            sources: own.into_iter().map(source).collect(),
        }
    }
}

impl PartTexts {
    /// The library's own texts, less those that the files replace.
    pub(crate) fn of(files: &Files) -> Self {
        let mut texts = Self::default();
        for (name, text) in &files.parts {
            let source = Source {
                path: files.prompt_path(name),
                text: text.clone(),
            };
            texts.sources.insert(name.clone(), source);
        }
        texts
    }

    pub(crate) fn source(&self, file: &str) -> &Source {
        &self.sources[file]
    }
}
