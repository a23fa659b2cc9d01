//! The pages of a hub with a scripted model and simulated robots, read as a browser reads them.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep::{Clock, Limits, report};
use longstep_core::schedule;
use longstep_robot::SimOptions;
use scraper::{ElementRef, Html, Selector};
use tempfile::TempDir;

use super::picture::moments;
use super::plan::PlanTree;
use super::*;
use crate::hub::{Hub, NewSession};
use crate::id::{RunId, SessionId};
use crate::problem::{Problem, ProblemKind};
use crate::run::Body;

use crate::support::{self, hub, simulated, until};

/// A name that would be markup, and that turns the text behind it around.
const HOSTILE: &str = "\"><script>alert(1)</script><img src=x onerror=alert(2)>&amp;\u{202e}'";

/// The same for an entity, whose name may not have the signs of the goal language.
const HOSTILE_ENTITY: &str = "<b><script>alert`1`</script><img src=x onerror=alert`2`>\u{202e}>";

fn select(text: &str) -> Selector {
    Selector::parse(text).unwrap()
}

fn texts(page: &Html, selector: &str) -> Vec<String> {
    let selector = select(selector);
    let found = page.select(&selector);
    found
        .map(|own| own.text().collect::<Vec<_>>().join("").trim().to_owned())
        .collect()
}

/// Checks what holds for every page, and returns it.
#[track_caller]
fn checked(sheet: &Sheet) -> Html {
    let html = sheet.html();
    assert!(html.contains(&sheet.fragment()), "the fragment is a part of the page");
    assert!(!html.contains('\u{202e}'));
    let page = Html::parse_document(&html);
    let everything = select("*");
    let mut ids = BTreeSet::new();
    for element in page.select(&everything) {
        let (name, own) = (element.value().name(), element.html());
        for (attribute, value) in element.value().attrs() {
            assert!(!attribute.starts_with("on") && attribute != "style", "{own}");
            let is_address = ["src", "href", "action", "data-stop"].contains(&attribute);
            assert!(
                !is_address || (value.starts_with(['/', '#']) && !value.starts_with("//")),
                "{own}"
            );
        }
        assert!(!["style", "iframe", "object", "img", "base"].contains(&name), "{own}");
        if let Some(id) = element.value().id() {
            assert!(ids.insert(id.to_owned()), "the id `{id}` is there twice");
        }
        if name == "form" {
            check_form(&element);
        }
    }
    assert_eq!(texts(&page, "script"), [""]);
    assert_eq!(page.select(&select("h1")).count(), 1);
    assert_eq!(page.select(&select("form[data-stop] button.stop")).count(), 1);
    for label in page.select(&select("label[for], [aria-labelledby], [aria-describedby]")) {
        let named = ["for", "aria-labelledby", "aria-describedby"];
        let named = named.iter().filter_map(|name| label.value().attr(name));
        for id in named.flat_map(str::split_whitespace) {
            assert!(ids.contains(id), "`{id}` in {}", label.html());
        }
    }
    page
}

/// A form changes something with `post`; only the slider, which changes nothing, is sent with `get`.
#[track_caller]
fn check_form(form: &ElementRef<'_>) {
    let method = form.value().attr("method");
    let is_slider = form.value().classes().any(|class| class == "slider");
    assert_eq!(method, Some(if is_slider { "get" } else { "post" }), "{}", form.html());
    assert!(
        form.select(&select("button[type=submit]")).next().is_some() || is_slider,
        "{}",
        form.html()
    );
}

/// A server of the tests with a session.
struct Place {
    hub: Arc<Hub>,
    id: SessionId,
    _folder: TempDir,
}

impl Place {
    fn new(environment: &str, robots: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let robots = robots.iter().map(|(name, options)| {
            let options: SimOptions = options.parse().unwrap();
            simulated(name, options, Body::PerSession)
        });
        let hub = hub(&folder, robots.collect());
        let created = hub
            .create(&NewSession::of_environment("household", environment))
            .unwrap();
        let id = created.view.id.clone();
        Self {
            hub,
            id,
            _folder: folder,
        }
    }

    fn desk(robots: &[(&str, &str)]) -> Self {
        Self::new(support::DESK, robots)
    }

    fn act(&self, deed: SessionDeed, fields: &[(&str, &str)]) -> Result<Next, Problem> {
        act_on_session(&self.hub, &self.id, deed, &form(fields), "ada")
    }

    /// Does what a form says, and waits for the model.
    fn say(&self, deed: SessionDeed, text: &str) {
        self.act(deed, &[("text", text)]).unwrap();
        let began = Instant::now();
        while self.hub.session(&self.id).unwrap().view.state == "thinking" {
            assert!(began.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn page(&self, query: &str) -> Html {
        checked(&session(&self.hub, &self.id, &Look::read(query), None).unwrap())
    }

    fn plan(&self) -> String {
        self.hub.session(&self.id).unwrap().view.proposal.clone().unwrap().plan
    }
}

fn form(fields: &[(&str, &str)]) -> Fields {
    let mut body = form_urlencoded::Serializer::new(String::new());
    Fields::read(body.extend_pairs(fields).finish().as_bytes())
}

#[test]
fn session_shows_the_goal_the_plan_and_the_scene_and_leads_to_a_run() {
    let place = Place::desk(&[("sim", "")]);
    let page = place.page("");
    assert_eq!(texts(&page, "#state"), ["Ready for an instruction."]);
    assert_eq!(page.select(&select("textarea#instruct")).count(), 1);

    place.say(SessionDeed::Instruct, "Put the pen on the shelf");
    let page = place.page("");
    assert_eq!(
        texts(&page, "#state"),
        ["There is a verified plan of 6 steps. Nothing moves before you approve it."]
    );
    assert_eq!(texts(&page, ".goals .sentence"), ["the pen is at the shelf"]);
    assert!(texts(&page, ".words .part.goal")[0].starts_with("Put the pen on the shelf"));
    assert_eq!(page.select(&select(".plan .step")).count(), 6);
    assert!(texts(&page, ".effects li").contains(&"pen: on shelf (before: desk)".to_owned()));
    assert_eq!(page.select(&select(".pictures svg")).count(), 1);

    let page = place.page("step=2");
    assert_eq!(page.select(&select(".pictures svg")).count(), 2);
    assert_eq!(page.select(&select("#step-2 [aria-current=step]")).count(), 1);
    assert!(texts(&page, "#moment")[0].contains("Without it: step 3"));

    let plan = place.plan();
    assert_eq!(
        page.select(&select(&format!("input[name=plan][value=\"{plan}\"]")))
            .count(),
        2
    );
    let Ok(Next::Approved(_, approval)) = place.act(SessionDeed::Approve, &[("plan", &plan), ("robot", "sim")]) else {
        panic!()
    };
    let page = place.page(&format!("approval={approval}"));
    assert_eq!(texts(&page, ".decision button"), ["Start on sim"]);
    let Ok(Next::Run(id)) = place.act(SessionDeed::Start, &[("approval", approval.as_str())]) else {
        panic!()
    };
    until(&place.hub, &id, |run| run.state.is_ended());
    let page = checked(&run(&place.hub, &id, false, None).unwrap());
    assert_eq!(
        texts(&page, "#end + .sentence"),
        ["the goal is reached in the observed world"]
    );
    assert_eq!(texts(&page, ".mark"), ["done"; 6]);
    assert_eq!(texts(&page, ".stop"), ["Stop sim"]);
    let page = place.page(&format!("approval={approval}"));
    assert!(
        texts(&page, ".decision").is_empty(),
        "what was carried out is not offered again"
    );
    let page = checked(&audit(&place.hub).unwrap());
    assert_eq!(
        texts(&page, ".audit td:nth-child(3)"),
        ["ended", "started", "approved", "accepted"]
    );
    let page = checked(&start(&place.hub, None).unwrap());
    assert_eq!(texts(&page, ".rows .what"), ["Put the pen on the shelf"; 2]);
}

#[test]
fn deeds_that_do_not_fit_change_nothing() {
    let place = Place::desk(&[("sim", "")]);
    place.say(SessionDeed::Instruct, "Put the pen on the shelf");
    let plan = place.plan();
    let other = "0".repeat(32);
    for (deed, fields) in [
        (SessionDeed::Accept, vec![("plan", other.as_str())]),
        (SessionDeed::Accept, vec![]),
        (SessionDeed::Approve, vec![("plan", other.as_str()), ("robot", "sim")]),
        (SessionDeed::Approve, vec![("plan", plan.as_str()), ("robot", "other")]),
        (SessionDeed::Approve, vec![("plan", plan.as_str())]),
        (SessionDeed::Start, vec![("approval", other.as_str())]),
        (SessionDeed::Start, vec![("approval", "../etc")]),
        (SessionDeed::Undo, vec![]),
        (SessionDeed::Ended, vec![("ending", "x")]),
        (SessionDeed::Instruct, vec![("text", "And the cup on the shelf")]),
    ] {
        assert!(place.act(deed, &fields).is_err(), "{deed:?} {fields:?}");
        let view = &place.hub.session(&place.id).unwrap().view;
        assert_eq!((view.state, view.accepted.len()), ("plan", 0), "{deed:?} {fields:?}");
    }
    assert!(place.hub.runs().is_empty());
}

#[test]
fn a_second_plan_is_approved_after_the_first_one() {
    let place = Place::desk(&[("sim", "")]);
    place.say(SessionDeed::Instruct, "Put the pen on the shelf");
    let first = place.plan();
    place.act(SessionDeed::Accept, &[("plan", &first)]).unwrap();
    place.say(SessionDeed::Instruct, "Put the cup on the shelf");
    let second = place.plan();
    let page = place.page("");
    assert_eq!(page.select(&select("form.approve")).count(), 0);
    let refused = place.act(SessionDeed::Approve, &[("plan", &second), ("robot", "sim")]);
    assert_eq!(refused.unwrap_err().kind, ProblemKind::Conflict);
    assert_eq!(place.plan(), second, "it still waits for its decision");
    place.act(SessionDeed::Accept, &[("plan", &second)]).unwrap();
    let page = place.page("");
    let approved = page.select(&select("form.approve input[name=plan]")).next().unwrap();
    assert_eq!(approved.value().attr("value"), Some(first.as_str()));
}

#[test]
fn an_attempt_shows_its_text_and_its_reason_where_it_was_made() {
    let place = Place::desk(&[]);
    let problem = Problem::new(ProblemKind::Busy, "too much waits").hint("wait");
    for (form, selector, is_there) in [
        ("instruct", "form textarea#instruct", true),
        ("feedback", ".attempt q", false),
    ] {
        let attempt = Attempt::new(
            form_name(form),
            &super::tests::form(&[("text", HOSTILE)]),
            problem.clone(),
        );
        let page = checked(&session(&place.hub, &place.id, &Look::default(), Some(&attempt)).unwrap());
        let visible = HOSTILE.replace('\u{202e}', "\\u{202e}");
        assert_eq!(texts(&page, selector), [visible], "{form}");
        assert_eq!(page.select(&select(".problem[role=alert]")).count(), 1);
        assert_eq!(
            page.select(&select("#instruct-problem .problem")).count() == 1,
            is_there
        );
        assert!(texts(&page, ".problem")[0].contains("too much waits"));
    }
}

fn form_name(name: &str) -> &'static str {
    SessionDeed::named(name).unwrap().name()
}

#[test]
fn hostile_names_and_texts_are_text_in_every_place() {
    let name = serde_json::to_string(HOSTILE_ENTITY).unwrap();
    let environment = format!(
        r#"{{"assets": ["<desk>", "<shelf>", {name}], "objects": ["<pen>"], "object_states": {{"<pen>": "on_something(<desk>)"}}}}"#
    );
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, vec![simulated(HOSTILE, SimOptions::default(), Body::Shared)]);
    let created = hub
        .create(&NewSession::of_environment("household", &environment))
        .unwrap();
    let place = Place {
        id: created.view.id.clone(),
        hub,
        _folder: folder,
    };
    let (page, boxes) = (place.page(""), select(".pictures [data-id]"));
    let mut ids = page.select(&boxes).filter_map(|own| own.value().attr("data-id"));
    assert!(ids.any(|id| id.contains("<script>alert`1`</script>")));
    place.say(SessionDeed::Instruct, &format!("Put the pen on the shelf {HOSTILE}"));
    let page = place.page("step=1");
    assert!(texts(&page, "h1")[0].contains("<script>alert(1)</script>"));
    assert!(texts(&page, ".approve button")[0].contains("<img"));
    let plan = place.plan();
    let fields = [("plan", plan.as_str()), ("robot", HOSTILE)];
    let Ok(Next::Approved(_, approval)) =
        act_on_session(&place.hub, &place.id, SessionDeed::Approve, &form(&fields), HOSTILE)
    else {
        panic!()
    };
    place.page(&format!("approval={approval}&scene={HOSTILE}"));
    let Ok(Next::Run(id)) = place.act(SessionDeed::Start, &[("approval", approval.as_str())]) else {
        panic!()
    };
    until(&place.hub, &id, |run| run.state.is_ended());
    checked(&run(&place.hub, &id, false, None).unwrap());
    let page = checked(&audit(&place.hub).unwrap());
    assert!(
        texts(&page, ".audit td:nth-child(2)")
            .iter()
            .any(|who| who.contains("<script>"))
    );
    checked(&start(&place.hub, None).unwrap());
    checked(&failed(&Problem::new(ProblemKind::Missing, HOSTILE).hint(HOSTILE)));
}

#[test]
fn question_of_a_run_is_answered_by_its_id() {
    let place = Place::desk(&[("clumsy", "seed=3,faults=2,horizon=4,kinds=slips+moved")]);
    place.say(SessionDeed::Instruct, "Put the pen on the shelf");
    let plan = place.plan();
    let Ok(Next::Approved(_, approval)) = place.act(SessionDeed::Approve, &[("plan", &plan), ("robot", "clumsy")])
    else {
        panic!()
    };
    let Ok(Next::Run(id)) = place.act(SessionDeed::Start, &[("approval", approval.as_str())]) else {
        panic!()
    };
    let asked = until(&place.hub, &id, |run| run.question.is_some() || run.state.is_ended());
    let question = asked.question.clone().expect("these mishaps need a change of the plan");
    let page = checked(&run(&place.hub, &id, false, None).unwrap());
    assert_eq!(texts(&page, ".asks button"), ["Approve and go on", "Refuse"]);
    let named = select(&format!("input[name=question][value=\"{}\"]", question.id));
    assert_eq!(page.select(&named).count(), 2);
    let decide = |question: &str, answer: &str| {
        act_on_run(
            &place.hub,
            &id,
            RunDeed::Decide,
            &form(&[("question", question), ("answer", answer)]),
            "ada",
        )
    };
    assert!(decide("another", "yes").is_err() && decide(&question.id, "maybe").is_err());
    assert!(place.hub.run(&id).unwrap().question.is_some());
    decide(&question.id, "no").unwrap();
    until(&place.hub, &id, |run| run.state.is_ended());
    let page = checked(&run(&place.hub, &id, false, None).unwrap());
    assert!(texts(&page, ".asks").is_empty() && texts(&page, "#end") == ["Stopped"]);
}

#[test]
fn branches_have_the_condition_in_words_and_lanes_are_beside_each_other() {
    let kitchen = include_str!("../../scenes/kitchen.json");
    let plan = |domain: &str, environment: &str, goal: &str| {
        let planner = longstep::Planner::shipped(domain).unwrap();
        let world = planner.world(environment).unwrap();
        let goal = planner.goal(&world, goal).unwrap();
        let solution = report::of_goal(&world, &goal, "", &Limits::default(), &Clock::none());
        (goal.purpose(&world), solution.plan.unwrap(), solution.answer)
    };
    let (_, branching, answer) = plan(
        "household-checks",
        kitchen,
        "if expired(cream) then put(cream, scrap bin) else put(cream, ledge)",
    );
    let shown = |plan: &longstep::VerifiedPlan, answer: &report::Answer| {
        let moments = moments(plan);
        let tree = PlanTree::new(
            (plan.world(), plan.plan()),
            answer,
            &moments,
            None,
            "/sessions/s".to_owned(),
        );
        Html::parse_fragment(&tree.html().into_string())
    };
    let page = shown(&branching, &answer);
    let cases = texts(&page, ".case");
    assert!(
        cases.len() == 2 && cases[0].starts_with("If the cream is") && cases[1] == "Otherwise",
        "{cases:?}"
    );
    assert_eq!(page.select(&select(".step")).count(), branching.steps().len());

    let bench = r#"{"assets": ["<bench>", "<left shelf>", "<right shelf>"], "objects": ["<nut>", "<bolt>"],
        "object_states": {"<nut>": "on_something(<bench>)", "<bolt>": "on_something(<bench>)"}}"#;
    let (purpose, sequence, mut answer) =
        plan("household-dual", bench, "put(nut, left shelf) & put(bolt, right shelf)");
    let world = sequence.world().clone();
    let compacted = schedule::share(&world, &sequence, &purpose).expect("two hands gain time");
    answer.side_by_side(&world, &compacted);
    let page = shown(&compacted.plan, &answer);
    assert_eq!(page.select(&select("table.lanes th")).count(), 2);
    assert_eq!(
        page.select(&select("table.lanes .step")).count(),
        compacted.plan.steps().len()
    );
}

#[test]
fn pages_for_strangers_and_failures_are_whole() {
    let page = Html::parse_document(&stranger());
    assert!(texts(&page, "h1") == ["Open the link that the server printed"]);
    let missing = Problem::missing("session", "x");
    assert!(texts(&checked(&failed(&missing)), ".problem")[0].contains("there is no session `x`"));
    let id = RunId::parse("none").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, Vec::new());
    assert_eq!(run(&hub, &id, false, None).err().unwrap().kind, ProblemKind::Missing);
}

#[test]
fn script_and_style_stay_small_and_load_nothing() {
    assert!(SCRIPT.len() < 10_000, "{} bytes", SCRIPT.len());
    for (name, text) in [("script", SCRIPT.to_owned()), ("style", style())] {
        for word in [
            "http:",
            "https:",
            "@import",
            "url(",
            "innerHTML",
            "eval(",
            "insertAdjacentHTML",
        ] {
            assert!(!text.contains(word), "{word} in the {name}");
        }
    }
}
