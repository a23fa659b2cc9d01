//! Scene files: the forms that are read, and the mistakes that have a place.

use super::super::*;
use super::TABLE;

#[test]
fn impossible_scenes_are_errors_with_their_place() {
    let many = vec![r#"{"name": "a", "position": [0, 0, 0], "size": [1, 1, 1]}"#; 1_001].join(",");
    let cup = |rest: &str| format!(r#"{{"boxes": [{{"name": "<cup>", {rest}}}]}}"#);
    for (text, expected) in [
        (String::new(), "boxes.json:1:1: EOF while parsing a value"),
        (
            "[1]".to_owned(),
            "boxes.json:1:2: invalid type: integer `1`, expected a box: an object with `name`",
        ),
        (
            r#"{"boxes": [{"name": "<cup>"}]}"#.to_owned(),
            "missing field `position`",
        ),
        (cup(r#""position": [0, 0], "size": [1, 1, 1]"#), "invalid length 2"),
        (
            cup(r#""position": [0, 0, 1e999], "size": [1, 1, 1]"#),
            "number out of range",
        ),
        (
            cup(r#""position": [0, 0, 1e300], "size": [1, 1, 1]"#),
            "boxes.json:1:42: boxes[0].position: a coordinate is at most 100000 m",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 0, 1]"#),
            "boxes[0].size: an edge is 0.000001 to 100000 m long",
        ),
        (cup(r#""position": [0, 0, 0], "size": [1, -1, 1]"#), "boxes[0].size"),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "orientation": [0, 0, 0, 0]"#),
            "a quaternion of length 1",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "orientation": [0, 0, 0, 1]"#),
            "boxes[0].orientation: a list does not say which number is w",
        ),
        (
            cup(r#""position": {"x": 0, "y": 0}, "size": [1, 1, 1]"#),
            "missing field `z`",
        ),
        (
            r#"[{"name": "cup", "box": {"x1": 210.0, "y1": 150.3, "x2": 260.4, "y2": 230.9}}]"#.to_owned(),
            "boxes of a picture, in pixels, have no position and no size in space",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "part_of": "<cup>""#),
            "there is no other box `<cup>`",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "open": true, "joint": {"position": 0}"#),
            "give `open` or `joint`, not both",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "colour": "red""#),
            "unknown field `colour`",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "kind": "thing""#),
            "unknown variant `thing`",
        ),
        (
            format!(r#"{{"boxes": [{many}]}}"#),
            "boxes: more than 1000 boxes and hands",
        ),
        (
            format!(r#"{{"boxes": [{TABLE}, {TABLE}]}}"#),
            "boxes[1].name: `<table>` is listed twice",
        ),
        (
            r#"{"boxes": [], "tolerances": {"contact": 0}}"#.to_owned(),
            "tolerances.contact: a tolerance is above 0 and at most 1",
        ),
        ("[".repeat(100_000), "boxes.json:1:2: invalid type"),
    ] {
        let error = Scene::parse("boxes.json", &text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

/// One quarter turn in every form in which others write it.
#[test]
fn a_pose_is_read_in_every_form_that_says_what_it_means() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let cup = |orientation: &str, more: &str| {
        format!(
            r#"{{"boxes": [{{"name": "cup", "position": {{"x": 1, "y": 2, "z": 3}}, "size": {{"x": 1, "y": 1, "z": 1}},
                "orientation": {orientation}, "score": 0.9}}]{more}}}"#
        )
    };
    let detection = r#"{"header": {"frame_id": "map"}, "detections": [{"id": "8",
        "results": [{"hypothesis": {"class_id": "mug", "score": 0.2}}, {"hypothesis": {"class_id": "cup", "score": 0.8}}],
        "bbox": {"center": {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {"x": 0, "y": 0, "z": 0.70710678, "w": 0.70710678}},
            "size": {"x": 1, "y": 1, "z": 1}}}]}"#;
    for text in [
        cup(r#"{"w": 0.70710678, "x": 0, "y": 0, "z": 0.70710678}"#, ""),
        cup("[0.70710678, 0, 0, 0.70710678]", r#", "quaternions": "wxyz""#),
        cup("[0, 0, 0.70710678, 0.70710678]", r#", "quaternions": "xyzw""#),
        detection.to_owned(),
    ] {
        let scene = Scene::parse("boxes.json", &text).unwrap();
        let [cup] = &scene.boxes[..] else { panic!("{text}") };
        assert_eq!(
            (cup.name.as_str(), cup.position, cup.size),
            ("cup", [1.0, 2.0, 3.0], [1.0; 3])
        );
        let close = cup
            .orientation
            .parts
            .iter()
            .zip([half, 0.0, 0.0, half])
            .all(|(own, other)| (own - other).abs() < 1e-6);
        assert!(close, "{text}: {:?}", cup.orientation);
    }
}

#[test]
fn boxes_of_one_class_are_numbered() {
    let boxes = |names: [&str; 3]| {
        let boxes = names.map(|name| format!(r#"{{"name": "{name}", "position": [0, 0, 0], "size": [1, 1, 1]}}"#));
        let scene = Scene::parse("boxes.json", &format!("[{}]", boxes.join(", ")));
        scene.map(|scene| scene.boxes.into_iter().map(|own| own.name).collect::<Vec<_>>())
    };
    assert_eq!(boxes(["cup", "table", "cup"]).unwrap(), ["cup 1", "table", "cup 2"]);
    let twice = boxes(["<cup>", "<table>", "<cup>"]).unwrap_err().to_string();
    assert!(twice.contains("`<cup>` is listed twice"), "{twice}");
}

/// A cup on a table as exports of other programs write it.
#[test]
fn scene_reader_accepts_field_names_of_other_tools() {
    let table = r#"{"name": "dining table", "position": [0, 0, 0.4], "size": [1.2, 0.8, 0.8]}"#;
    for cup in [
        r#"{"name": "coffee cup", "bbox": {"center": {"x": 0.1, "y": 0, "z": 0.85}, "size": {"x": 0.1, "y": 0.2, "z": 0.1}}}"#,
        r#"{"label": "coffee cup", "confidence": 0.5, "bbox": {"center": [0.1, 0, 0.85], "dimensions": [0.1, 0.2, 0.1]}}"#,
        r#"{"class_name": "coffee cup", "center": {"x": 0.1, "y": 0, "z": 0.85}, "dimensions": [0.1, 0.2, 0.1]}"#,
        r#"{"name": "coffee cup", "bbox": {"center": {"position": [0.1, 0, 0.85], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}},
            "size": [0.1, 0.2, 0.1]}}"#,
        r#"{"name": "coffee cup", "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}, "bbox": {"center": [0.1, 0, 0.85], "size": [0.1, 0.2, 0.1]}}"#,
    ] {
        for text in [
            format!(r#"{{"boxes": [{table}, {cup}]}}"#),
            format!(r#"{{"objects": [{table}, {cup}]}}"#),
        ] {
            let scene = Scene::parse("boxes.json", &text).unwrap_or_else(|error| panic!("{text}: {error}"));
            let own = &scene.boxes[1];
            assert_eq!(
                (own.name.as_str(), own.position, own.size),
                ("coffee cup", [0.1, 0.0, 0.85], [0.1, 0.2, 0.1])
            );
        }
    }
    for (cup, expected) in [
        (r#""size": [1, 1, 1]"#, "missing field `position`"),
        (r#""position": [1, 1, 1]"#, "missing field `size`"),
        (
            r#""size": [1, 1, 1], "bbox": {"center": [0, 0, 0], "size": [1, 1, 1]}"#,
            "give `bbox`, or `position` and `size`, not both",
        ),
        (
            r#""orientation": {"w": 1, "x": 0, "y": 0, "z": 0},
               "bbox": {"center": [0, 0, 0], "size": [1, 1, 1], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}"#,
            "`orientation` is given twice",
        ),
        (
            r#""bbox": {"center": [0, 0, 0], "size": [1, 1, 1], "orientation": [1, 0, 0, 0]}"#,
            "boxes[0].orientation: a list does not say which number is w",
        ),
        (
            r#""position": [0, 0, 0], "extents": [1, 1, 1]"#,
            "unknown field `extents`",
        ),
    ] {
        let text = format!(r#"{{"boxes": [{{"name": "cup", {cup}}}]}}"#);
        let error = Scene::parse("boxes.json", &text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn scene_error_explains_boxes_in_pixel_coordinates() {
    for text in [
        r#"[{"name": "cup", "class": 41, "confidence": 0.9, "box": {"x1": 1, "y1": 2, "x2": 3, "y2": 4}}]"#,
        r#"{"boxes": [{"name": "cup", "bbox": [10, 20, 30, 40], "score": 0.5}]}"#,
        r#"{"boxes": [{"label": "cup", "xyxy": [10, 20, 30, 40]}]}"#,
    ] {
        let error = Scene::parse("boxes.json", text).unwrap_err().to_string();
        assert!(
            error.contains("boxes of a picture, in pixels, have no position and no size in space"),
            "{error}"
        );
        assert!(error.contains("a `position` and a `size` in metres"), "{error}");
    }
}
