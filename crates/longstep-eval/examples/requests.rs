#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]
use longstep::dialogue::{ConstraintKind, Dialogue};
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_eval::suite::{self, Files};
use longstep_llm::read_texts;
use std::path::Path;
fn main() {
    for folder in std::env::args().skip(1) {
        let folder = Path::new(&folder);
        let mut cases = read_texts(folder, |name| name.ends_with(".toml")).unwrap();
        let scenes = read_texts(&folder.join("scenes"), |name| name.ends_with(".json")).unwrap();
        let files = Files {
            folder: format!("{}/", folder.display()),
            suite: cases.remove("suite.toml").unwrap(),
            cases,
            scenes: scenes
                .into_iter()
                .map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text))
                .collect(),
        };
        let domain = suite::domain_name(&files).unwrap();
        let beside = folder.join(&domain);
        let domain = longstep_llm::load_domain(&if beside.is_dir() {
            beside.display().to_string()
        } else {
            domain
        })
        .unwrap();
        let suite = suite::load(&files, &domain).unwrap();
        for case in &suite.cases {
            let [step] = &case.steps[..] else { continue };
            let mut world = suite.world(case);
            world.add_values(&step.says);
            let input = UnderstandingInput {
                examples: Some(0),
                ..UnderstandingInput::new(&domain, &world, &step.says, ConstraintKind::JsonSchema)
            };
            let request = Understanding::new(input).request();
            let texts: Vec<&str> = request.messages.iter().map(|own| own.text.as_str()).collect();
            println!(
                "{}",
                serde_json::json!({"suite": suite.name, "case": case.id, "messages": texts})
            );
        }
    }
}
