//! Two small worlds of shipped domains.

use std::sync::LazyLock;

use longstep::domain::{self, Domain};
use longstep_core::environment::{self, Environment, World};
use longstep_core::json::Path;

/// A domain and a world of it.
pub struct Scene {
    /// The domain.
    pub domain: Domain,
    /// The world.
    pub world: World,
}

impl Scene {
    fn new(domain: &str, environment: &str) -> Self {
        let domain = domain::shipped(domain).expect("it is shipped").expect("it is valid");
        let environment = Environment::from_json(environment).expect("it is JSON");
        let world = environment::read(&domain, &environment, "scene", "", &Path::default()).expect("it is a world");
        Self { domain, world }
    }
}

/// One arm and actions that sense; a handle, a bin and a tool.
pub static CHECKS: LazyLock<Scene> = LazyLock::new(|| {
    Scene::new(
        "household-checks",
        r#"{"assets": ["<table>", "<fridge>", "<bin>"], "objects": ["<milk>", "<sponge>", "<fridge_handle>"],
            "object_states": {"<milk>": "on_something(<table>)", "<sponge>": "on_something(<table>)",
                "<fridge_handle>": "closed()"}}"#,
    )
});

/// Two arms, one of which cannot reach the shelf.
pub static DUAL: LazyLock<Scene> = LazyLock::new(|| {
    Scene::new(
        "household-dual",
        r#"{"assets": ["<bench>", "<shelf>"], "asset_states": {"<shelf>": "reachable_by(right)"},
            "objects": ["<drill>", "<rag>"],
            "object_states": {"<drill>": "on_something(<bench>)", "<rag>": "on_something(<bench>)"}}"#,
    )
});
