//! Graphs of scenes as environments and observations, in the words of the `virtualhome` domain.

use std::collections::{BTreeMap, BTreeSet};

use indexmap::IndexMap;
use longstep_core::environment::{Environment, Observation, Words, World};

use super::graph::{Edge, Graph, Node};

/// Properties of what takes part in a task; walls, ceilings and pictures have none of them.
const USES: [&str; 5] = ["GRABBABLE", "CAN_OPEN", "HAS_SWITCH", "SURFACES", "CONTAINERS"];

/// Returns the environment of a scene: what can be moved, opened, switched on or put on, and what that stands on or in.
/// With `rooms`, only what is in a room of these classes. A thing that can be grabbed is an object, everything else an
/// asset.
///
/// ```
/// use longstep_robot::virtualhome::{Graph, environment};
/// let graph = Graph::parse(r#"{"nodes": [
///     {"id": 1, "class_name": "kitchen", "category": "Rooms"},
///     {"id": 2, "class_name": "table", "properties": ["SURFACES"]},
///     {"id": 3, "class_name": "mug", "properties": ["GRABBABLE", "RECIPIENT"]}],
///     "edges": [{"from_id": 2, "relation_type": "INSIDE", "to_id": 1},
///               {"from_id": 3, "relation_type": "INSIDE", "to_id": 1},
///               {"from_id": 3, "relation_type": "ON", "to_id": 2}]}"#)?;
/// let environment = environment(&graph, &[]);
/// assert_eq!(environment.assets, ["<kitchen_1>", "<table_2>"]);
/// assert_eq!(environment.object_states["<mug_3>"].as_slice(), ["ON(<table_2>)"]);
/// # Ok::<(), longstep_robot::virtualhome::GraphError>(())
/// ```
pub fn environment(graph: &Graph, rooms: &[String]) -> Environment {
    let scene = Scene::of(graph);
    let kept = scene.kept(rooms);
    let (mut assets, mut objects) = (Part::default(), Part::default());
    for node in graph.nodes.iter().filter(|node| kept.contains(&node.id)) {
        let part = if node.can("GRABBABLE") {
            &mut objects
        } else {
            &mut assets
        };
        part.add(node, scene.placed(node, &kept));
    }
    Environment {
        assets: assets.identifiers,
        asset_states: assets.states,
        asset_properties: Some(assets.properties),
        objects: objects.identifiers,
        object_states: objects.states,
        object_properties: Some(objects.properties),
        ..Environment::default()
    }
}

/// The entities of one of the two lists of an environment.
#[derive(Default)]
struct Part {
    identifiers: Vec<String>,
    states: IndexMap<String, Words>,
    properties: IndexMap<String, Words>,
}

impl Part {
    fn add(&mut self, node: &Node, mut states: Vec<String>) {
        let identifier = node.identifier();
        // That something which can be opened is closed is what the domain assumes.
        states.extend(conditions(node).filter(|word| *word != "CLOSED()").map(str::to_owned));
        if !states.is_empty() {
            self.states.insert(identifier.clone(), Words::Many(states));
        }
        if !node.is_room() {
            let words = properties(node).into_iter().map(str::to_owned).collect();
            self.properties.insert(identifier.clone(), Words::Many(words));
        }
        self.identifiers.push(identifier);
    }
}

/// The relations of a graph, by the numbers of its nodes. A graph may have tens of thousands of them.
struct Scene<'g> {
    graph: &'g Graph,
    nodes: BTreeMap<i64, &'g Node>,
    places: BTreeMap<i64, Vec<&'g Edge>>,
    held: BTreeSet<i64>,
}

impl<'g> Scene<'g> {
    fn of(graph: &'g Graph) -> Self {
        Self {
            graph,
            nodes: graph.by_number(),
            places: graph.places(),
            held: graph.held(),
        }
    }

    /// Returns what a node stands on or is in.
    fn supports(&self, number: i64) -> impl Iterator<Item = &'g Node> {
        let places = self.places.get(&number).into_iter().flatten();
        places.filter_map(|edge| self.nodes.get(&edge.to_id).copied())
    }

    /// Returns the numbers of the nodes that take part in tasks in these rooms, and of what they stand on or in.
    fn kept(&self, rooms: &[String]) -> BTreeSet<i64> {
        let is_room = |node: &Node| node.is_room() && rooms.contains(&node.class_name);
        let is_wanted = |node: &Node| rooms.is_empty() || is_room(node) || self.supports(node.id).any(is_room);
        let is_floor = |node: &Node| node.class_name == "floor";
        let is_used = |node: &&Node| {
            !node.is_character()
                && (node.is_room() || !is_floor(node) && USES.iter().any(|property| node.can(property)))
        };
        let wanted = self.graph.nodes.iter().filter(is_used).filter(|node| is_wanted(node));
        let mut todo: Vec<i64> = wanted.map(|node| node.id).collect();
        let mut kept = BTreeSet::new();
        while let Some(number) = todo.pop() {
            if kept.insert(number) {
                let supports = self.supports(number).filter(|support| !support.is_character());
                todo.extend(supports.map(|support| support.id));
            }
        }
        kept
    }

    /// Returns where a node is, as statements. A thing that can be moved is in a room only if it is nowhere else: the rooms of
    /// things are not part of what the domain follows.
    fn placed(&self, node: &Node, known: &BTreeSet<i64>) -> Vec<String> {
        if self.held.contains(&node.id) {
            return vec!["HELD()".to_owned()];
        }
        let all = self.places.get(&node.id).into_iter().flatten();
        let all = all.filter(|edge| known.contains(&edge.to_id));
        let all = all.filter_map(|edge| Some((edge, *self.nodes.get(&edge.to_id)?)));
        let all: Vec<(&&Edge, &Node)> = all.collect();
        let is_somewhere = all.iter().any(|(_, place)| !place.is_room());
        let is_left_out = |place: &Node| node.can("GRABBABLE") && is_somewhere && place.is_room();
        all.iter()
            .filter(|(_, place)| !is_left_out(place))
            .map(|(edge, place)| format!("{}({})", edge.relation_type, place.identifier()))
            .collect()
    }
}

/// The states of a node that the domain has words for.
fn conditions(node: &Node) -> impl Iterator<Item = &'static str> {
    let door = match (node.is("OPEN"), node.is("CLOSED")) {
        (true, _) if node.can("CAN_OPEN") => Some("OPEN()"),
        (_, true) if node.can("CAN_OPEN") => Some("CLOSED()"),
        _ => None,
    };
    let switch = (node.is("ON") && node.can("HAS_SWITCH")).then_some("SWITCHED_ON()");
    door.into_iter().chain(switch)
}

fn properties(node: &Node) -> Vec<&'static str> {
    let mut words = vec![if node.can("CAN_OPEN") {
        "IS_OPENABLE"
    } else {
        "NOT_OPENABLE"
    }];
    words.push(if node.can("HAS_SWITCH") {
        "HAS_SWITCH"
    } else {
        "NO_SWITCH"
    });
    if node.can("RECIPIENT") || node.can("DRINKABLE") {
        words.push("RECIPIENT");
    }
    if node.can("GRABBABLE") && node.can("SURFACES") {
        words.push("SURFACE");
    }
    words
}

/// Returns what a graph says about the entities of a world, as an observation. What it says about others is left out, and
/// entities that it lacks were not seen.
///
/// The rooms of objects are those of the world's environment: the domain does not follow what is carried from room to
/// room.
pub fn statements(graph: &Graph, world: &World) -> Observation {
    let environment = world.environment();
    let nodes = graph.nodes.iter().map(|node| (node.identifier(), node));
    let nodes: IndexMap<String, &Node> = nodes.collect();
    let named = environment.assets.iter().chain(&environment.objects);
    let known = named
        .clone()
        .filter_map(|name| nodes.get(name))
        .map(|node| node.id)
        .collect();
    let rooms = graph.nodes.iter().filter(|room| room.is_room());
    let in_rooms: BTreeSet<String> = rooms.map(|room| format!("INSIDE({})", room.identifier())).collect();
    let scene = Scene::of(graph);
    let mut states = IndexMap::new();
    for name in named {
        let Some(node) = nodes.get(name) else {
            continue;
        };
        let mut words = scene.placed(node, &known);
        if let Some(stated) = environment.object_states.get(name) {
            words.retain(|word| !in_rooms.contains(word));
            let stated = stated.as_slice().iter();
            words.extend(stated.filter(|word| in_rooms.contains(*word)).cloned());
        }
        words.extend(conditions(node).map(str::to_owned));
        states.insert(name.clone(), Words::Many(words));
    }
    Observation { states, facts: None }
}
