//! Requests for a meaning, and replies to them.

use super::{Examples, Understanding, UnderstandingInput};
use crate::dialogue::{Constraint, ConstraintKind, Decision, Dialogue, Finish, Likelihood, Reply, Round};
use crate::domain::{Domain, shipped};
use crate::environment::World;
use longstep_core::testing;

fn kitchen() -> (Domain, World) {
    let domain = shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<butter>", "<fridge_handle>"],
        "object_states": {"<butter>": "inside_something(<fridge>)", "<fridge_handle>": "closed()"}}"#;
    let world = testing::world_of(&domain, text);
    (domain, world)
}

fn asked(domain: &Domain, world: &World, instruction: &str) -> Understanding {
    Understanding::new(UnderstandingInput::new(
        domain,
        world,
        instruction,
        ConstraintKind::JsonSchema,
    ))
}

#[test]
fn a_reply_that_cannot_be_read_is_asked_for_once_more() {
    let (domain, world) = kitchen();
    let right = r#"{"goal": "put(butter, counter)", "left_out": [], "question": ""}"#;
    for (wrong, reason) in [
        ("Sure, I will do that!", "Sure, I will do that!"),
        (r#"{"goal": "put(butter, moon)"}"#, "`moon`"),
        (r#"{"goal": 7}"#, "did not match"),
        ("{}", "neither a goal nor a question"),
        ("", "EOF"),
    ] {
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        let before = dialogue.request();
        assert_eq!(dialogue.supply(&Reply::complete(wrong)), Ok(None), "{wrong}");
        let request = dialogue.request();
        assert_eq!(
            (request.messages.len(), request.answer_so_far.as_str()),
            (before.messages.len() + 2, "")
        );
        let last = &request.messages[request.messages.len() - 1].text;
        assert!(
            last.starts_with("This answer cannot be used: ") && last.contains(reason),
            "{last}"
        );
        assert!(request.messages.iter().all(|message| !message.text.is_empty()));
        assert!(
            matches!(dialogue.supply(&Reply::complete(right)), Ok(Some(_))),
            "{wrong}"
        );
        // The second reply is the last. What is no goal is a question then.
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        dialogue.supply(&Reply::complete(wrong)).unwrap();
        match dialogue.supply(&Reply::complete(wrong)) {
            Ok(Some(meant)) => assert!(meant.question.is_some_and(|own| own.contains("`moon`")), "{wrong}"),
            other => assert!(other.is_err(), "{wrong}: {other:?}"),
        }
    }
    for finish in [Finish::Refused, Finish::Length] {
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        let reply = Reply {
            finish,
            ..Reply::complete("I will not.")
        };
        assert!(dialogue.supply(&reply).is_err());
    }
}

/// The answers of servers that are taken, with what they mean.
#[test]
fn answers_of_servers_are_read() {
    let (domain, world) = kitchen();
    for (reply, goal, left_out, question) in [
        (
            r#"{"goal": "put(butter, counter)", "left_out": [], "question": ""}"#,
            "put(butter, counter)",
            "",
            "",
        ),
        (
            r#"{"goal": ["put(butter, counter)", "never closed(fridge)"]}"#,
            "put(butter, counter) & never closed(fridge)",
            "",
            "",
        ),
        (
            r#"{"goals": ["opened(fridge)"], "question": null}"#,
            "opened(fridge)",
            "",
            "",
        ),
        (
            r#"{"goal": "opened(fridge) then put(butter, counter)", "left_out": [{"text": "by noon", "kind": "time"}]}"#,
            "opened(fridge) & then put(butter, counter)",
            "by noon (time)",
            "",
        ),
        (
            r#"{"goal": "opened(fridge) | left out amount: half", "left_out": ["and smile", {"text": "soon", "kind": "haste"}]}"#,
            "opened(fridge)",
            "half (amount), and smile (wish), soon (wish)",
            "",
        ),
        (r#"{"goal": "", "question": "Which butter?"}"#, "", "", "Which butter?"),
        (
            r#"{"goal": "opened(fridge)", "question": "Really?"}"#,
            "opened(fridge)",
            "",
            "Really?",
        ),
    ] {
        let meant = asked(&domain, &world, "Do it")
            .supply(&Reply::complete(reply))
            .unwrap()
            .unwrap();
        let own = meant
            .goal
            .map_or(String::new(), |goal| goal.everyday(&world).join(" & "));
        let words: Vec<String> = meant
            .left_out
            .iter()
            .map(|own| format!("{} ({})", own.text, own.kind.name()))
            .collect();
        assert_eq!((own.as_str(), words.join(", ").as_str()), (goal, left_out), "{reply}");
        assert_eq!(meant.question.unwrap_or_default(), question, "{reply}");
    }
}

/// The replies of a model under a grammar, with their likelihoods, and what becomes of them.
#[test]
fn decision_table_covers_answers_under_a_grammar() {
    let (domain, world) = kitchen();
    let butter = "put(butter, counter)";
    let sure = "Should I put the butter at the counter?";
    // Behind a goal that is acted on, the model is asked for a prohibition: the beginning of one, and then all of it.
    let (beginning, whole) = (" & never", " & never opened(fridge)");
    let forbidden = format!("{butter}{whole}");
    for (replies, decision, question) in [
        (&[(butter, -20), (beginning, -16_000)][..], Decision::Act, ""),
        (
            &[(butter, -20), (beginning, -7000), (whole, -12_000)],
            Decision::Act,
            "",
        ),
        (
            &[(butter, -20), (beginning, -3000), (whole, -4000)],
            Decision::AskForProhibition,
            "Do you mean: the butter is at the counter; at no time: the fridge is open?",
        ),
        (&[(&*forbidden, -20)], Decision::Act, ""),
        (&[(butter, -9000)], Decision::AskForUnlikely, sure),
        (&[("question:", -10), (butter, -9000)], Decision::Ask, sure),
        (
            &[("question:", -500), (butter, -20), (beginning, -16_000)],
            Decision::ActInsteadOfAsking,
            "",
        ),
    ] {
        let input = UnderstandingInput::new(&domain, &world, "Butter, counter", ConstraintKind::Grammar);
        let mut dialogue = Understanding::new(input);
        let (mut meant, mut meanings) = (None, 0);
        for (text, likelihood) in replies {
            assert!(meant.is_none());
            let Constraint::Lark(grammar) = dialogue.request().constraint else {
                panic!("no grammar")
            };
            let may_ask = meanings == 0;
            assert_eq!(grammar.contains("question:"), may_ask, "{text}");
            meanings += 1;
            let likelihood = Some(Likelihood {
                text: *likelihood,
                is_trained: true,
                ..Likelihood::default()
            });
            let reply = Reply {
                likelihood,
                ..Reply::complete(*text)
            };
            meant = dialogue.supply(&reply).unwrap();
        }
        let meant = meant.unwrap();
        assert_eq!(meant.reading.decision, decision);
        assert_eq!(meant.question.unwrap_or_default(), question);
        let beginnings = replies.iter().filter(|(text, _)| *text == whole).count();
        assert_eq!(meant.reading.candidates.len() + beginnings, replies.len());
        let goal = meant.goal.unwrap().everyday(&world);
        let is_forbidden = replies[0].0 == forbidden || decision == Decision::AskForProhibition;
        let expected = if is_forbidden {
            &[butter, "never opened(fridge)"][..]
        } else {
            &[butter]
        };
        assert_eq!(goal, expected);
    }
}

#[test]
fn request_sends_later_words_as_conversation_turns() {
    let (domain, world) = kitchen();
    let rounds = [Round {
        reply: "put(butter, counter)".to_owned(),
        message: "and close\nthe fridge".to_owned(),
    }];
    for (kind, reply) in [
        (ConstraintKind::Grammar, "put(butter, counter)"),
        (
            ConstraintKind::JsonSchema,
            r#"{"goal":"put(butter, counter)","left_out":[],"question":""}"#,
        ),
    ] {
        let input = UnderstandingInput {
            rounds: &rounds,
            ..UnderstandingInput::new(&domain, &world, "Butter, counter", kind)
        };
        let request = Understanding::new(input).request();
        let texts: Vec<&str> = request.messages.iter().map(|own| own.text.as_str()).collect();
        assert!(texts[request.fixed].ends_with("Instruction: Butter, counter"));
        assert_eq!(texts[request.fixed + 1..], [reply, "and close the fridge"]);
    }
}

#[test]
fn an_embedded_model_gets_few_examples_with_every_goal_word() {
    let (domain, world) = kitchen();
    let answers = |kind, examples| {
        let input = UnderstandingInput {
            examples,
            ..UnderstandingInput::new(&domain, &world, "Close the fridge", kind)
        };
        let messages = Understanding::new(input).request().messages;
        let answers: Vec<String> = messages.iter().skip(2).step_by(2).map(|own| own.text.clone()).collect();
        answers
    };
    let all = answers(ConstraintKind::Grammar, Examples::All);
    let first = answers(ConstraintKind::Grammar, Examples::of(ConstraintKind::Grammar));
    assert_eq!(all.len(), domain.prompts.examples.len());
    assert_eq!(first.len(), Examples::FEW);
    for word in ["put(", "wiped(", "opened(", "closed(", "question:"] {
        let showing = |answers: &[String]| answers.iter().any(|answer| answer.contains(word));
        assert_eq!(showing(&first), showing(&all), "{word}");
    }
    assert_eq!(Examples::of(ConstraintKind::JsonSchema), Examples::All);
}
