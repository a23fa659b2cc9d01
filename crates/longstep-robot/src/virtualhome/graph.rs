//! The graph of a scene: nodes with properties and states, and relations between them.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// The graph of a scene, as the simulator describes it.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
pub struct Graph {
    /// The rooms, the furniture, the things and the characters.
    pub nodes: Vec<Node>,
    /// The relations between them.
    pub edges: Vec<Edge>,
}

/// A node of a graph. What else the simulator says about it (its place in the room) is not needed.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
pub struct Node {
    /// Its number, unique in the scene.
    pub id: i64,
    /// Its class: `fridge`.
    pub class_name: String,
    /// Its category: `Rooms`, `Furniture`, `Characters`.
    #[serde(default)]
    pub category: Option<String>,
    /// Its properties: `GRABBABLE`, `CAN_OPEN`, `HAS_SWITCH`.
    #[serde(default)]
    pub properties: Vec<String>,
    /// Its states: `OPEN`, `ON`.
    #[serde(default)]
    pub states: Vec<String>,
}

/// A relation between two nodes: `ON`, `INSIDE`, `CLOSE`, `HOLDS_RH`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
pub struct Edge {
    /// The node that is on, inside, close or holding.
    pub from_id: i64,
    /// The relation.
    pub relation_type: String,
    /// The other node.
    pub to_id: i64,
}

/// A graph that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// The text is no graph.
    #[error("it is no graph of a scene: {0}")]
    Unreadable(String),
    /// Two nodes have the same number.
    #[error("two nodes have the number {0}")]
    Twice(i64),
}

impl Graph {
    /// Reads a graph from the simulator's JSON.
    ///
    /// # Errors
    ///
    /// JSON of another shape, and two nodes with the same number.
    pub fn parse(text: &str) -> Result<Self, GraphError> {
        let graph: Self = serde_json::from_str(text).map_err(|error| GraphError::Unreadable(error.to_string()))?;
        let mut numbers = BTreeSet::new();
        match graph.nodes.iter().find(|node| !numbers.insert(node.id)) {
            Some(node) => Err(GraphError::Twice(node.id)),
            None => Ok(graph),
        }
    }

    /// Returns the nodes by their numbers.
    pub fn by_number(&self) -> BTreeMap<i64, &Node> {
        self.nodes.iter().map(|node| (node.id, node)).collect()
    }

    /// Returns the first character of the scene.
    pub fn character(&self) -> Option<&Node> {
        let characters = self.nodes.iter().filter(|node| node.is_character());
        characters.min_by_key(|node| node.id)
    }

    /// Returns the numbers of what the first character holds.
    pub fn held(&self) -> BTreeSet<i64> {
        let Some(character) = self.character() else {
            return BTreeSet::new();
        };
        let holds = |edge: &&Edge| edge.from_id == character.id && edge.relation_type.starts_with("HOLDS");
        self.edges.iter().filter(holds).map(|edge| edge.to_id).collect()
    }

    /// Returns true if a relation holds.
    pub fn has_edge(&self, from: i64, relation: &str, to: i64) -> bool {
        self.edges
            .iter()
            .any(|edge| edge.from_id == from && edge.to_id == to && edge.relation_type.eq_ignore_ascii_case(relation))
    }

    /// Returns the places that each node is on or in, in the order of the edges.
    pub fn places(&self) -> BTreeMap<i64, Vec<&Edge>> {
        let mut places: BTreeMap<i64, Vec<&Edge>> = BTreeMap::new();
        let mut known = BTreeSet::new();
        let is_place = |edge: &&Edge| matches!(edge.relation_type.as_str(), "ON" | "INSIDE");
        for edge in self.edges.iter().filter(is_place) {
            if known.insert((edge.from_id, edge.relation_type.as_str(), edge.to_id)) {
                places.entry(edge.from_id).or_default().push(edge);
            }
        }
        places
    }
}

impl Node {
    /// The identifier in an environment: `<fridge_306>`.
    pub fn identifier(&self) -> String {
        format!("<{}_{}>", self.class_name, self.id)
    }

    /// Returns true for a room.
    pub fn is_room(&self) -> bool {
        self.category.as_deref() == Some("Rooms")
    }

    /// Returns true for a character.
    pub fn is_character(&self) -> bool {
        self.class_name == "character" || self.category.as_deref() == Some("Characters")
    }

    /// Returns true if the node has the property.
    pub fn can(&self, property: &str) -> bool {
        self.properties.iter().any(|own| own == property)
    }

    /// Returns true if the node is in the state.
    pub fn is(&self, state: &str) -> bool {
        self.states.iter().any(|own| own == state)
    }
}
