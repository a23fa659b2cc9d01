use super::{Language, write};
use longstep_model::domain::shipped;
use longstep_model::model::{Domain, Term};

const LANGUAGES: [Language; 2] = [Language::Cpp, Language::Python];

fn changed(name: &str, change: impl FnOnce(&mut longstep_model::model::DomainData)) -> Domain {
    let mut data = (*shipped(name).unwrap().unwrap()).clone();
    change(&mut data);
    data.into()
}

#[test]
fn text_is_a_function_of_the_domain() {
    for language in LANGUAGES {
        let text = |name| write(&shipped(name).unwrap().unwrap(), language);
        assert_eq!(text("household-checks"), text("household-checks"));
        assert_ne!(text("household-checks"), text("household"));
    }
}

#[test]
fn every_leaf_has_a_function() {
    let checks = shipped("household-checks").unwrap().unwrap();
    let header = write(&checks, Language::Cpp);
    let module = write(&checks, Language::Python);
    for (cpp, python) in [
        (
            "virtual Begun<Done> detach_from_plane(const std::string& item, const std::string& from_) = 0;",
            "def detach_from_plane(self, item: str, from_: str) -> Task[Done]:",
        ),
        (
            "virtual Begun<check_damage_outcome> check_damage(const std::string& item) = 0;",
            "def check_damage(self, item: str) -> Task[check_damage_outcome]:",
        ),
        (
            "virtual bool holding(const std::string& item) = 0;",
            "def holding(self, item: str) -> bool:",
        ),
        (
            "virtual bool can_open(const std::string& /* thing */) {",
            "def can_open(self, thing: str) -> bool:",
        ),
        ("\"detach_from_plane\", {\"item\", \"from\"}", "[\"item\", \"from\"]"),
    ] {
        assert!(header.contains(cpp), "{cpp}\n{header}");
        assert!(module.contains(python), "{python}\n{module}");
    }
}

#[test]
fn no_sentence_leaves_its_comment() {
    let sentences = [
        "it ends */ system(); /*",
        "\"\"\" system() \"\"\"",
        "system()\nsystem();",
        "system() \\",
        "\u{202e}system()",
        "\\\"\"\" system()",
    ];
    for sentence in sentences {
        let domain = changed("household", |data| {
            data.about = sentence.to_owned();
            data.actions[0].means = sentence.to_owned();
        });
        let header = write(&domain, Language::Cpp);
        for line in header.lines().filter(|line| line.contains("system()")) {
            assert!(line.trim_start().starts_with("/// ") && !line.ends_with('\\'), "{line}");
        }
        let module = write(&domain, Language::Python);
        for line in module.lines().filter(|line| line.contains("system()")) {
            let backslashes = line.matches('\\').count();
            assert!(
                !line.contains("\"\"\" system") && backslashes.is_multiple_of(2),
                "{line}"
            );
        }
        for text in [header, module] {
            assert!(!text.contains('\u{202e}'));
        }
    }
}

#[test]
fn outcome_that_entities_tell_apart_has_their_names_in_its_word() {
    let domain = changed("household-checks", |data| {
        let action = data
            .actions
            .iter_mut()
            .find(|action| action.call == "check_damage")
            .unwrap();
        let second = action.parameters[0].clone();
        action.parameters.push(second);
        let mut other = action.senses[0].clone();
        other.terms = vec![Term::Variable(1)];
        action.senses[1] = other;
    });
    let header = write(&domain, Language::Cpp);
    assert!(
        header.contains("detail::Texts{\"intact\", texts[0]}, detail::Texts{\"intact\", texts[1]}"),
        "{header}"
    );
    let module = write(&domain, Language::Python);
    assert!(
        module.contains("lambda texts: [[\"intact\", texts[0]], [\"intact\", texts[1]]],"),
        "{module}"
    );
}
