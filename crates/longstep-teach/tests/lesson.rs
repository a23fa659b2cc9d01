//! Every row of the paper's table of actions and parameters, and every finding, from demonstrations with 5 mm of noise.
#![allow(clippy::unwrap_used, clippy::panic)]

mod person;

use longstep_core::skill::Skills;
use longstep_core::{domain, testing};
use longstep_teach::{
    Demonstration, Expectations, Format, Hand, Lesson, Request, cut, cut_at_times, learn, one_each, skills_file,
    step_times,
};
use nalgebra::Vector3;
use person::{ALL, CALLS, Columns, HINGE, Line, Person, csv, plan, recording, shown, world};
use serde_json::Value;

const NOISE: f64 = 0.005;

fn lesson_of(requests: &[Request], recording: &Demonstration) -> Lesson {
    learn(requests, &cut(recording, requests).unwrap(), &Expectations::default())
}

#[track_caller]
fn value<'a>(lesson: &'a Lesson, step: usize, parameter: &str) -> (&'a Value, Option<f64>) {
    let of_step = lesson.steps.iter().find(|own| own.step == step);
    let found = of_step.and_then(|own| own.values.iter().find(|own| own.parameter == parameter));
    let found = found.unwrap_or_else(|| panic!("step {step} has no `{parameter}`: {:?}", lesson.findings));
    (&found.value, found.uncertainty)
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_iterator(value.as_array().unwrap().iter().map(|part| part.as_f64().unwrap()))
}

/// An expected value with the largest error: metres for positions and displacements, degrees for directions and angles.
enum Expected {
    Text(&'static str),
    Point([f64; 3], f64),
    Direction([f64; 3], f64),
    Number(f64, f64),
    /// The number of points, at least.
    Path(usize),
}

use Expected::{Direction, Number, Path, Point, Text};

#[test]
fn every_row_of_the_paper_s_table_is_taught() {
    let world = world();
    let requests = plan(&world, &CALLS);
    let lesson = lesson_of(&requests, &recording(&shown(NOISE).lines, ALL));
    assert_eq!(lesson.findings, []);
    let near = 0.02;
    let rows: Vec<(usize, &str, Expected)> = vec![
        // move_hand()
        (1, "first_position", Point([0.0, -1.0, 1.0], near)),
        (1, "last_position", Point([0.3, -0.5, 0.6], near)),
        // grasp_object()
        (2, "object_position", Point([0.3, -0.3, 0.6], near)),
        (2, "approach", Direction([0.0, 1.0, 0.0], 8.0)),
        (2, "grasp_type", Text("power")),
        // release_object()
        (6, "retreat", Direction([0.0, -0.894, 0.447], 10.0)),
        // move_object()
        (16, "first_position", Point([2.0, 0.0, 0.6], near)),
        (16, "last_position", Point([3.0, 0.0, 0.8], near)),
        // detach_from_plane()
        (15, "displacement", Point([0.0, 0.0, 0.1], near)),
        (15, "last_position", Point([2.0, 0.0, 0.6], near)),
        // attach_to_plane()
        (17, "displacement", Point([0.0, 0.0, -0.1], near)),
        (17, "first_position", Point([3.0, 0.0, 0.8], near)),
        // open_by_rotate(), adjust_by_rotate(), close_by_rotate()
        (3, "path", Path(70)),
        (3, "axis", Direction([0.0, 0.0, -1.0], 3.0)),
        (3, "centre", Point(HINGE, 0.03)),
        (3, "radius", Number(0.44, 0.02)),
        (3, "angle", Number(80f64.to_radians(), 0.07)),
        (4, "path", Path(70)),
        (4, "axis", Direction([0.0, 0.0, -1.0], 4.0)),
        (4, "centre", Point(HINGE, 0.05)),
        (4, "radius", Number(0.44, 0.04)),
        (4, "angle", Number(50f64.to_radians(), 0.09)),
        (5, "path", Path(70)),
        (5, "axis", Direction([0.0, 0.0, 1.0], 3.0)),
        (5, "centre", Point(HINGE, 0.02)),
        (5, "radius", Number(0.44, 0.01)),
        (5, "angle", Number(130f64.to_radians(), 0.07)),
        // open_by_slide(), adjust_by_slide(), close_by_slide()
        (9, "path", Path(35)),
        (9, "displacement", Point([0.0, -0.2, 0.0], near)),
        (10, "path", Path(35)),
        (10, "displacement", Point([0.0, -0.08, 0.0], near)),
        (11, "path", Path(35)),
        (11, "displacement", Point([0.0, 0.28, 0.0], near)),
        // wipe_on_plane()
        (18, "path", Path(100)),
        (18, "normal", Direction([0.0, 0.0, 1.0], 2.0)),
    ];
    let of_hand_and_arm = (1..=CALLS.len()).flat_map(|step| {
        [
            (step, "hand", Text("right")),
            (step, "upper_arm_first", Text("place_low")),
            (step, "upper_arm_last", Text("place_low")),
            (step, "lower_arm_first", Text("forward_middle")),
            (step, "lower_arm_last", Text("forward_middle")),
        ]
    });
    for (step, parameter, expected) in rows.into_iter().chain(of_hand_and_arm) {
        let (found, uncertainty) = value(&lesson, step, parameter);
        let what = format!("step {step}, {parameter}: {found} ± {uncertainty:?}");
        let error = match expected {
            Text(text) => {
                assert_eq!(found, text, "{what}");
                continue;
            }
            Path(least) => {
                assert!(found.as_array().unwrap().len() >= least, "{what}");
                continue;
            }
            Point(expected, most) => (vector(found) - Vector3::from(expected)).norm() / most,
            Direction(expected, most) => vector(found).angle(&Vector3::from(expected)).to_degrees() / most,
            Number(expected, most) => (found.as_f64().unwrap() - expected).abs() / most,
        };
        assert!(error <= 1.0, "{what}");
        assert!(uncertainty.unwrap() > 0.0, "{what}");
    }
}

#[test]
fn the_skills_file_is_read_by_runs_and_lacks_nothing() {
    let world = world();
    let requests = plan(&world, &CALLS);
    let lesson = lesson_of(&requests, &recording(&shown(NOISE).lines, ALL));
    let file = serde_json::to_string(&skills_file(&requests, &lesson)).unwrap();
    let skills = Skills::parse(world.domain(), "skills.json", &file).unwrap();
    for request in &requests {
        let (id, _) = world
            .domain()
            .action_ids()
            .find(|(_, own)| own.name == request.action)
            .unwrap();
        let arguments: Vec<_> = request.arguments.iter().map(|own| world.find(own).unwrap()).collect();
        let values = skills.values(&world, Some(request.step), id, &arguments);
        assert_eq!(values.len(), request.parameters.len(), "{}", request.call);
    }
    assert!(file.contains(r#""source":"demo.csv, "#), "{file}");
}

#[test]
fn recordings_are_cut_at_grips_and_rests_and_times_and_files() {
    let world = world();
    let requests = plan(&world, &CALLS);
    let lines = shown(NOISE).lines;
    let expected = lesson_of(&requests, &recording(&lines, ALL));
    let whole = recording(&lines, Columns { step: false, ..ALL });
    let begin = |step: usize| lines.iter().find(|line| line.step == step).unwrap().time;
    let end = |step: usize| lines.iter().rfind(|line| line.step == step).unwrap().time;

    let times: Vec<String> = (1..=CALLS.len())
        .map(|step| format!("{step}:{}-{}", begin(step), end(step)))
        .collect();
    let at_times = cut_at_times(&whole, &step_times(&times.join(",")).unwrap());
    let part = |step: usize| {
        let own: Vec<Line> = lines.iter().filter(|line| line.step == step).cloned().collect();
        recording(&own, Columns { step: false, ..ALL })
    };
    let files: Vec<Demonstration> = (1..=CALLS.len()).map(part).collect();
    let of_files = one_each(&files, &requests).unwrap();
    let at_grips = cut(&whole, &requests).unwrap();
    assert_eq!(at_grips.len(), CALLS.len());
    for segments in [at_times, of_files, at_grips] {
        let lesson = learn(&requests, &segments, &Expectations::default());
        assert!(lesson.is_complete(), "{:?}", lesson.findings);
        for step in [3, 5] {
            let (one, other) = (value(&expected, step, "radius").0, value(&lesson, step, "radius").0);
            assert!(
                (one.as_f64().unwrap() - other.as_f64().unwrap()).abs() < 0.02,
                "{one} {other}"
            );
        }
        let displacement = vector(value(&lesson, 9, "displacement").0);
        assert!(
            (displacement - Vector3::new(0.0, -0.2, 0.0)).norm() < 0.02,
            "{displacement}"
        );
    }
    let two = one_each(&files[..2], &requests).unwrap_err();
    assert_eq!(
        two.to_string(),
        "demo.csv: 2 recordings for 19 steps; give one for each step"
    );
}

/// Steps 1 to 6: a door, shown by a hand with changes.
fn door(change: impl FnOnce(&mut Vec<Line>)) -> Lesson {
    let world = world();
    let requests = plan(&world, &CALLS[..6]);
    let mut lines: Vec<Line> = shown(NOISE).lines.into_iter().filter(|line| line.step <= 6).collect();
    change(&mut lines);
    lesson_of(&requests, &recording(&lines, ALL))
}

#[track_caller]
fn found(lesson: &Lesson, expected: &str) {
    let messages: Vec<String> = lesson.findings.iter().map(ToString::to_string).collect();
    assert!(
        messages.iter().any(|own| own.contains(expected)),
        "{expected}: {messages:#?}"
    );
}

fn without_value(lesson: &Lesson, step: usize, parameter: &str) -> bool {
    let mut values = lesson
        .steps
        .iter()
        .filter(|own| own.step == step)
        .flat_map(|own| &own.values);
    !values.any(|own| own.parameter == parameter)
}

#[test]
fn the_wrong_hand_is_named() {
    let lesson = door(|lines| {
        for line in lines.iter_mut().filter(|line| line.step == 3) {
            line.hand = "left";
        }
    });
    found(
        &lesson,
        "step 3 `open_by_rotate(<fridge_handle>)`: shown with the left hand, but step 2 grasped with the right one; show it with the right hand",
    );
    assert!(without_value(&lesson, 3, "axis"));
    let world = world();
    let requests = plan(&world, &CALLS[..1]);
    let lines: Vec<Line> = shown(NOISE).lines.into_iter().filter(|line| line.step == 1).collect();
    let expectations = Expectations {
        hand: Some(Hand::Left),
        ..Expectations::default()
    };
    let segments = cut(&recording(&lines, ALL), &requests).unwrap();
    found(
        &learn(&requests, &segments, &expectations),
        "shown with the right hand, but the demonstration is with the left one",
    );
}

#[test]
fn swapped_segments_are_named() {
    let lesson = door(|lines| {
        for line in lines {
            line.step = match line.step {
                1 => 3,
                3 => 1,
                step => step,
            };
        }
    });
    found(
        &lesson,
        "step 1 `move_hand(<fridge_handle>)`: this recording shows step 3",
    );
    found(
        &lesson,
        "step 3 `open_by_rotate(<fridge_handle>)`: this recording shows step 1",
    );
    assert!(without_value(&lesson, 3, "axis"));
}

#[test]
fn too_short_an_arc_is_named() {
    let world = world();
    let requests = plan(&world, &CALLS[2..3]);
    let mut person = Person::new(NOISE);
    person.position = Vector3::new(0.3, -0.3, 0.6);
    person.turn([0.0, 0.0, -1.0], HINGE, 20.0);
    let lesson = lesson_of(&requests, &recording(&person.lines, ALL));
    let messages: Vec<String> = lesson.findings.iter().map(ToString::to_string).collect();
    let [message] = &messages[..] else {
        panic!("{messages:?}")
    };
    // The noise adds some degrees to the largest angle between two frames.
    let degrees: f64 = message
        .split("the arc is ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((15.0..35.0).contains(&degrees), "{message}");
    assert!(message.ends_with("degrees; show at least 45"), "{message}");
    assert!(
        ["axis", "centre", "radius", "angle"]
            .iter()
            .all(|name| without_value(&lesson, 1, name))
    );
}

#[test]
fn a_gap_is_named() {
    let lesson = door(|lines| {
        let begin = lines.iter().find(|line| line.step == 3).unwrap().time + 1.0;
        lines.retain(|line| !(begin..begin + 0.7).contains(&line.time));
    });
    found(
        &lesson,
        "step 3 `open_by_rotate(<fridge_handle>)`: no frames for 0.7 s after",
    );
    assert!(without_value(&lesson, 3, "axis"));
}

#[test]
fn lesson_names_missing_steps_and_other_mistakes() {
    found(
        &door(|lines| lines.retain(|line| line.step != 4)),
        "step 4 `adjust_by_rotate(<fridge_handle>)`: no recording shows it",
    );
    let lesson = door(|lines| {
        for line in lines.iter_mut().filter(|line| line.step >= 4) {
            line.point += Vector3::new(0.0, 0.0, 0.2);
        }
    });
    found(
        &lesson,
        "step 4 `adjust_by_rotate(<fridge_handle>)`: the hand starts 20 cm from the end of step 3",
    );
    assert!(lesson.is_complete());
    found(
        &door(|lines| lines.iter_mut().for_each(|line| line.grip = 0.0)),
        "the hand does not close",
    );
    found(
        &door(|lines| lines.iter_mut().for_each(|line| line.grip = 1.0)),
        "the hand does not open",
    );
    let still = door(|lines| {
        for line in lines.iter_mut().filter(|line| line.step == 3) {
            line.point = Vector3::new(0.3, -0.3, 0.6);
        }
    });
    found(
        &still,
        "step 3 `open_by_rotate(<fridge_handle>)`: the hand does not move on an arc",
    );
    let few = door(|lines| {
        let mut kept = 0;
        lines.retain(|line| {
            kept += usize::from(line.step == 3);
            line.step != 3 || kept < 5
        });
    });
    found(&few, "only 4 frames of the hand");
}

#[test]
fn slides_and_wipes_that_show_too_little_are_named() {
    let world = world();
    let of = |call: &str, show: &dyn Fn(&mut Person)| {
        let requests = plan(&world, &[call]);
        let mut person = Person::new(NOISE);
        show(&mut person);
        lesson_of(&requests, &recording(&person.lines, ALL))
    };
    let lesson = of("open-by-slide drawer_handle", &|person| {
        person.by([0.0, 0.005, 0.0]);
    });
    found(&lesson, "cm; show at least 3 cm");
    let lesson = of("open-by-slide drawer_handle", &|person| {
        person.turn([0.0, 0.0, 1.0], [0.3, -1.0, 1.0], 180.0);
    });
    found(&lesson, "the hand leaves a straight line by");
    let lesson = of("wipe sponge table", &|person| {
        person.by([0.2, 0.0, 0.0]).by([-0.2, 0.0, 0.0]);
    });
    found(&lesson, "the normal is uncertain");
    let lesson = of("wipe sponge table", &|person| {
        person
            .by([0.2, 0.1, 0.2])
            .by([-0.2, 0.1, 0.1])
            .by([0.1, -0.3, 0.3])
            .by([0.0, 0.3, 0.0]);
    });
    found(&lesson, "the hand leaves a plane by");
}

#[test]
fn lesson_names_columns_and_frames_that_the_recording_lacks() {
    let world = world();
    let requests = plan(&world, &CALLS[..2]);
    let lines: Vec<Line> = shown(NOISE).lines.into_iter().filter(|line| line.step <= 2).collect();
    let bare = recording(
        &lines,
        Columns {
            step: true,
            arm: false,
            grasp: false,
        },
    );
    let lesson = lesson_of(&requests, &bare);
    found(
        &lesson,
        "step 2 `grasp_object(<fridge_handle>)`: `grasp_type` needs a column `grasp`, which the recording lacks",
    );
    found(&lesson, "`upper_arm_first` needs columns of elbow and shoulder");
    found(&lesson, "`lower_arm_last` needs columns of the elbow");
    let camera = csv(&lines, ALL)
        .replacen("t,hand", "frame,t,hand", 1)
        .replace('\n', "\ncamera,");
    let camera = Demonstration::read("demo.csv", Format::Csv, camera.as_bytes()).unwrap();
    found(
        &lesson_of(&requests, &camera),
        "positions are in the frame `camera`, not in `world`",
    );
    let objects = [("<fridge_handle>".to_owned(), [0.3, 0.2, 0.6])].into();
    let expectations = Expectations {
        objects,
        ..Expectations::default()
    };
    let segments = cut(&recording(&lines, ALL), &requests).unwrap();
    found(
        &learn(&requests, &segments, &expectations),
        "<fridge_handle> is 50 cm from where the world says",
    );
}

#[test]
fn steps_that_cannot_be_told_apart_are_named() {
    let world = world();
    let requests = plan(&world, &CALLS);
    let lines = shown(NOISE).lines;
    let columns = Columns { step: false, ..ALL };
    let short: Vec<Line> = lines.iter().filter(|line| line.step < 12).cloned().collect();
    let error = cut(&recording(&short, columns), &requests).unwrap_err().to_string();
    assert!(error.contains("the plan has grasp, release, grasp, release, grasp, release, and the recording shows grasp, release, grasp;"), "{error}");
    let error = cut(&recording(&lines, ALL), &requests[..4]).unwrap_err().to_string();
    assert_eq!(
        error,
        "demo.csv: it shows step 19, and the plan has 4; record this plan"
    );
    let mut hurried = Person::new(NOISE);
    hurried.rest(0.3).go([0.3, -0.3, 0.6]).close().open();
    let error = cut(
        &recording(&hurried.lines, columns),
        &plan(&world, &[CALLS[0], CALLS[1], CALLS[5]]),
    )
    .unwrap_err()
    .to_string();
    assert!(error.contains("steps 1 to 2: the hand rests 0 times"), "{error}");
    assert!(
        error.ends_with("give `--segments`, a column `step`, or one recording a step"),
        "{error}"
    );
}

#[test]
fn priors_of_the_domain_are_compared() {
    let mut files = domain::shipped_files("household-taught").unwrap();
    let (_, text) = files.skills.as_mut().unwrap();
    *text = text
        .replace(
            r#"fit = "displacement" }"#,
            r#"fit = "displacement", prior = [0, 1, 0] }"#,
        )
        .replace(r#"fit = "axis" }"#, r#"fit = "axis", prior = [1, 0, 0] }"#);
    let domain = domain::load(&files).unwrap();
    let text = r#"{"assets": ["<drawer>", "<fridge>"], "objects": ["<drawer_handle>", "<fridge_handle>"]}"#;
    let world = testing::world_of(&domain, text);
    let mut person = Person::new(NOISE);
    person.by([0.0, -0.2, 0.0]);
    let requests = plan(&world, &["open-by-slide drawer_handle"]);
    let lesson = lesson_of(&requests, &recording(&person.lines, ALL));
    found(&lesson, "`displacement` is 1");
    found(&lesson, "degrees from the direction that the domain expects");
    assert!(without_value(&lesson, 1, "displacement"));
    let mut person = Person::new(NOISE);
    person.turn([0.0, 0.0, 1.0], [0.4, -1.0, 1.0], 90.0);
    let requests = plan(&world, &["open-by-rotate fridge_handle"]);
    let lesson = lesson_of(&requests, &recording(&person.lines, ALL));
    found(
        &lesson,
        "degrees from the one that the domain expects, which is not used",
    );
    assert!(lesson.is_complete() && !without_value(&lesson, 1, "axis"));
}
