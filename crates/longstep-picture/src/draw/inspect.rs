//! Checks of a picture for tests: well-formed XML, boxes inside their parents, no overlaps, texts inside their boxes.

use roxmltree::{Document, Node, ParsingOptions};

use super::canvas::Area;
use super::text::{Font, width};

/// Slack for coordinates, which are written with one decimal place.
const SLACK: f64 = 0.11;

/// Checks a picture; returns the `data-id` of its boxes, in order.
///
/// # Panics
///
/// If the picture is not well-formed, or something is out of place.
#[track_caller]
pub(crate) fn check(svg: &str, prefix: &str) -> Vec<String> {
    let options = ParsingOptions {
        nodes_limit: 10_000_000,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(svg, options).unwrap_or_else(|error| panic!("{error}\n{svg}"));
    let root = document.root_element();
    assert_eq!(root.attribute("role"), Some("img"));
    for node in root.descendants() {
        if let Some(id) = node.attribute("id") {
            assert!(id.starts_with(prefix), "{id}");
        }
    }
    for name in ["title", "desc"] {
        let own = root.children().find(|node| node.has_tag_name(name)).unwrap();
        assert!(own.text().is_some_and(|text| !text.is_empty()), "{name}");
    }
    let frame: Vec<f64> = root
        .attribute("viewBox")
        .unwrap()
        .split(' ')
        .map(|part| part.parse().unwrap())
        .collect();
    let whole = Area {
        x: frame[0],
        y: frame[1],
        width: frame[2],
        height: frame[3],
    };
    check_children(root, whole);
    let boxes = root.descendants().filter_map(|node| node.attribute("data-id"));
    boxes.map(str::to_owned).collect()
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).and_then(|value| value.parse().ok()).unwrap_or(0.0)
}

/// Returns the area of a box: its first rectangle.
fn area(group: Node<'_, '_>) -> Area {
    let rect = group.children().find(|node| node.has_tag_name("rect")).unwrap();
    Area {
        x: number(rect, "x"),
        y: number(rect, "y"),
        width: number(rect, "width"),
        height: number(rect, "height"),
    }
}

fn is_inside(inner: Area, outer: Area) -> bool {
    inner.x >= outer.x - SLACK
        && inner.y >= outer.y - SLACK
        && inner.x + inner.width <= outer.x + outer.width + SLACK
        && inner.y + inner.height <= outer.y + outer.height + SLACK
}

fn overlap(one: Area, other: Area) -> bool {
    let apart = |from: f64, length: f64, next: f64, next_length: f64| {
        from + length <= next + SLACK || next + next_length <= from + SLACK
    };
    !apart(one.x, one.width, other.x, other.width) && !apart(one.y, one.height, other.y, other.height)
}

#[track_caller]
fn check_children(parent: Node<'_, '_>, outer: Area) {
    let groups: Vec<Node<'_, '_>> = parent.children().filter(|node| node.has_tag_name("g")).collect();
    let areas: Vec<Area> = groups.iter().map(|group| area(*group)).collect();
    for (index, own) in areas.iter().enumerate() {
        assert!(own.width > 0.0 && own.height > 0.0, "{own:?}");
        assert!(is_inside(*own, outer), "{own:?} is outside {outer:?}");
        for other in &areas[..index] {
            assert!(!overlap(*own, *other), "{own:?} overlaps {other:?}");
        }
    }
    for (group, own) in groups.iter().zip(&areas) {
        check_children(*group, *own);
    }
    for text in parent.children().filter(|node| node.has_tag_name("text")) {
        let size = number(text, "font-size");
        let font = Font {
            size,
            bold: text.attribute("font-weight").is_some(),
        };
        let content = text.text().unwrap_or_default();
        let own = Area {
            x: number(text, "x"),
            y: number(text, "y") - size,
            width: width(content, font),
            height: size * 1.2,
        };
        assert!(is_inside(own, outer), "`{content}` {own:?} is outside {outer:?}");
        for other in &areas {
            assert!(!overlap(own, *other), "`{content}` {own:?} overlaps {other:?}");
        }
    }
}
