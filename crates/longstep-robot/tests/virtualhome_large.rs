//! Scenes of VirtualHome with tens of thousands of nodes, as a server may send them.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::time::{Duration, Instant};

use longstep_core::environment::{self, ObservedFacts as Seen};
use longstep_core::json::Path;
use longstep_core::testing;
use longstep_robot::virtualhome::{Graph, environment, statements};
use serde_json::{Value, json};

const NODES: usize = 60_000;
const WORLD: usize = 2_000;
/// A pair of nodes would have taken many minutes for each node.
const LIMIT: Duration = Duration::from_secs(60);

fn node(id: usize, class: &str, category: &str, property: &str) -> Value {
    json!({"id": id, "class_name": class, "category": category, "properties": [property], "states": ["OPEN"]})
}

/// Cups, each in the next one.
fn chain(count: usize) -> Value {
    let nodes: Vec<Value> = (0..count).map(|id| node(id, "cup", "Props", "GRABBABLE")).collect();
    let edges = (0..count).map(|id| json!({"from_id": id, "relation_type": "INSIDE", "to_id": (id + 1) % count}));
    json!({"nodes": nodes, "edges": edges.collect::<Vec<_>>()})
}

/// Rooms, and cups that are all on one table, which is in all of the rooms.
fn crowd(count: usize) -> Value {
    let mut nodes: Vec<Value> = (2..count).map(|id| node(id, "cup", "Props", "GRABBABLE")).collect();
    nodes.push(node(0, "table", "Furniture", "SURFACES"));
    nodes.push(node(1, "character", "Characters", ""));
    let mut edges = Vec::new();
    for id in 2..count {
        edges.push(json!({"from_id": id, "relation_type": "ON", "to_id": 0}));
        edges.push(json!({"from_id": 1, "relation_type": "HOLDS_RH", "to_id": id}));
    }
    for room in count..count + 2_000 {
        nodes.push(node(room, "kitchen", "Rooms", ""));
        edges.push(json!({"from_id": 0, "relation_type": "INSIDE", "to_id": room}));
    }
    json!({"nodes": nodes, "edges": edges})
}

#[test]
fn the_environment_of_a_large_scene_takes_linear_time() {
    let virtualhome = testing::domain("virtualhome");
    for (name, scene) in [("chain", chain(NODES)), ("crowd", crowd(NODES))] {
        let graph = Graph::parse(&scene.to_string()).unwrap();
        let begun = Instant::now();
        let found = environment(&graph, &[]);
        assert!(found.objects.len() >= NODES - 2, "{name}");
        let text = serde_json::to_string(&found).unwrap();
        // A scene of this size is too large for the domain, which is known in time.
        let refused = environment::read(&virtualhome, &found, "graph", &text, &Path::default()).unwrap_err();
        let expected = match name {
            "chain" => "make the environment smaller",
            _ => "more than 60000 entities",
        };
        assert!(refused.to_string().contains(expected), "{name}: {refused}");
        assert!(begun.elapsed() < LIMIT, "{name}: {:?}", begun.elapsed());
    }
}

#[test]
fn the_observation_of_a_large_scene_takes_linear_time() {
    let virtualhome = testing::domain("virtualhome");
    // The world is as large as the domain allows; the scene has many more nodes.
    let small = environment(&Graph::parse(&chain(WORLD).to_string()).unwrap(), &[]);
    let text = serde_json::to_string(&small).unwrap();
    let world = environment::read(&virtualhome, &small, "graph", &text, &Path::default()).unwrap();
    for (name, scene) in [("chain", chain(NODES)), ("crowd", crowd(NODES))] {
        let graph = Graph::parse(&scene.to_string()).unwrap();
        let begun = Instant::now();
        let observed = statements(&graph, &world);
        assert!(observed.states.len() >= WORLD - 2, "{name}");
        let seen = Seen::read(&world, &[], &observed).unwrap();
        let state = seen.revised(&world, &world.state);
        assert_eq!(environment::write(&world, &state).objects.len(), small.objects.len());
        assert!(begun.elapsed() < LIMIT, "{name}: {:?}", begun.elapsed());
    }
}
