//! Texts of a domain's `prompt/` folder.

use std::collections::BTreeMap;

use longstep_core::domain::Files;

/// Prompt texts of a domain.
#[derive(Debug, Clone, Default)]
pub struct Prompts {
    /// System prompt of the goal strategy: `prompt/goal.md`, rendered.
    pub goal: String,
    /// Few-shot examples of `prompt/examples.toml`.
    pub examples: Vec<Example>,
    /// Prompt parts of the direct strategy, not rendered.
    pub parts: PartTexts,
    /// Few-shot examples of `prompt/feedback.toml`.
    pub feedback_examples: Vec<FeedbackExample>,
}

/// A few-shot example: a small scene, an instruction and its answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Example {
    /// Names and descriptions of objects.
    pub objects: Vec<(String, String)>,
    /// Names and descriptions of places.
    pub places: Vec<(String, String)>,
    /// The instruction.
    pub instruction: String,
    /// Goals joined by ` & `, or `question: ...`.
    pub answer: String,
}

impl Example {
    /// Returns the names of objects and places.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().chain(&self.places).map(|(name, _)| name.as_str())
    }
}

/// A few-shot example of feedback: a plan, an utterance about it, and the answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FeedbackExample {
    /// The instruction that the plan is for.
    pub instruction: String,
    /// The steps, each a call and its sentence: `grasp_object(): grasp the mug`.
    pub plan: Vec<String>,
    /// The utterance about the plan.
    pub says: String,
    /// `goal`, changes joined by ` & `, or `question: ...`.
    pub answer: String,
}

/// Source texts of the direct strategy's prompt parts, with their paths.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartTexts {
    /// By file name.
    sources: BTreeMap<String, Source>,
}

/// A text with the path that diagnostics show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Source {
    pub(crate) path: String,
    pub(crate) text: String,
}

impl Default for PartTexts {
    /// The default texts of this library, without examples.
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
    /// Returns the default texts, replaced by those of `files` where it has them.
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
