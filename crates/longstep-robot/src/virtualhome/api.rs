//! The HTTP interface of the simulator: a JSON object in a POST request for each action, and one for its answer.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use longstep_core::secret;
use serde::Deserialize;
use serde_json::{Value, json};

use super::graph::Graph;
use super::script::Line;
use crate::error::RobotError;

/// Maximum length of an answer. The graph of a flat has about 1 MB.
const LARGEST: usize = 32 << 20;
/// The time to connect.
const CONNECT: Duration = Duration::from_secs(5);
/// The timeout of requests that move nothing.
pub(super) const QUESTION: Duration = Duration::from_secs(30);
/// The timeout for loading a scene.
const LOAD: Duration = Duration::from_secs(120);
/// The time between two looks at a request to stop.
const TICK: Duration = Duration::from_millis(20);
/// Maximum length of a reason that the simulator gives.
const LONGEST_REASON: usize = 500;
/// The width and the height of a picture, in pixels.
const PICTURE: (u32, u32) = (640, 480);

/// A client of a running simulator. Its calls wait for the answer.
#[derive(Debug, Clone)]
pub struct Simulator {
    client: reqwest::Client,
    url: String,
    /// The address without a password, for messages.
    shown: String,
    numbers: Arc<AtomicU64>,
    stopped: Arc<AtomicBool>,
}

/// The answer to a request.
#[derive(Debug, Deserialize)]
struct ApiAnswer {
    success: bool,
    #[serde(default)]
    message: Value,
    #[serde(default)]
    value: Value,
    #[serde(default)]
    message_list: Option<Vec<String>>,
}

/// A request, and whether a stop ends the wait for its answer.
struct ApiRequest<'a> {
    action: &'static str,
    numbers: &'a [i64],
    texts: &'a [String],
    limit: Duration,
    is_cancelled_by_stop: bool,
}

impl<'a> ApiRequest<'a> {
    fn new(action: &'static str, numbers: &'a [i64], texts: &'a [String], limit: Duration) -> Self {
        Self {
            action,
            numbers,
            texts,
            limit,
            is_cancelled_by_stop: true,
        }
    }
}

impl Simulator {
    /// Returns a client of the simulator at an address. Sends nothing.
    ///
    /// # Errors
    ///
    /// A client that cannot be made.
    pub fn new(url: &str) -> Result<Self, RobotError> {
        // A program that has installed its own cryptography provider keeps it.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = reqwest::Client::builder()
            .connect_timeout(CONNECT)
            .redirect(reqwest::redirect::Policy::none())
            // An idle connection does not notice when the simulator closes it.
            .pool_max_idle_per_host(0)
            .no_proxy()
            .build();
        let shown = secret::in_addresses(url).into_owned();
        let client = client.map_err(|error| RobotError::Unreachable {
            robot: shown.clone(),
            reason: root(&error),
        })?;
        Ok(Self {
            client,
            url: url.to_owned(),
            shown,
            numbers: Arc::default(),
            stopped: Arc::default(),
        })
    }

    /// The address.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// The address without a password, for messages.
    pub fn shown_url(&self) -> &str {
        &self.shown
    }

    /// Sends nothing more, and ends the wait for every answer but that of a line.
    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }

    /// Asks whether the simulator answers.
    ///
    /// # Errors
    ///
    /// [`RobotError::Unreachable`] if it does not.
    pub fn check(&self) -> Result<(), RobotError> {
        self.settle(QUESTION)
    }

    /// Waits until the simulator answers. It answers one request after the other: a line of an earlier client, which was killed, has
    /// ended then.
    pub(super) fn settle(&self, limit: Duration) -> Result<(), RobotError> {
        match self.request(&ApiRequest::new("idle", &[], &[], limit)) {
            Ok(_) => Ok(()),
            Err(RobotError::Gone { reason, .. }) => Err(RobotError::Unreachable {
                robot: self.shown.clone(),
                reason,
            }),
            Err(error) => Err(error),
        }
    }

    /// Loads a scene again, by its number, or the present one: without characters, and with everything in its place.
    ///
    /// # Errors
    ///
    /// A refusal, and every failure of the connection.
    pub fn reset(&self, scene: Option<i64>) -> Result<(), RobotError> {
        let scene: Vec<i64> = scene.into_iter().collect();
        self.accepted("clear", &ApiRequest::new("clear", &scene, &[], LOAD))?;
        self.accepted("environment", &ApiRequest::new("environment", &scene, &[], LOAD))?;
        Ok(())
    }

    /// Returns the graph of the scene as it is.
    ///
    /// # Errors
    ///
    /// A refusal, an answer that is no graph, and every failure of the connection.
    pub fn graph(&self) -> Result<Graph, RobotError> {
        let request = ApiRequest::new("environment_graph", &[], &[], QUESTION);
        let answer = self.accepted("environment_graph", &request)?;
        let Value::String(text) = &answer.message else {
            return Err(protocol("`environment_graph` has no text in `message`"));
        };
        Graph::parse(text).map_err(|error| protocol(&format!("`environment_graph`: {error}")))
    }

    /// Adds a character, in a room or at a random place.
    ///
    /// # Errors
    ///
    /// A refusal, and every failure of the connection.
    pub fn add_character(&self, resource: &str, room: Option<&str>) -> Result<(), RobotError> {
        let mode = match room {
            Some(_) => "fix_room",
            None => "random",
        };
        let wanted = json!({
            "character_resource": resource,
            "mode": mode,
            "character_position": { "x": 0, "y": 0, "z": 0 },
            "initial_room": room.unwrap_or_default(),
        });
        let texts = [wanted.to_string()];
        self.accepted("add_character", &ApiRequest::new("add_character", &[], &texts, LOAD))?;
        Ok(())
    }

    /// Performs one line, and waits for its end. The inner error is the simulator's reason why it could not.
    ///
    /// # Errors
    ///
    /// Every failure of the connection: what became of the line is unknown then.
    pub fn render(&self, line: &Line, limit: Duration) -> Result<Result<(), String>, RobotError> {
        let (width, height) = PICTURE;
        let config = json!({
            "randomize_execution": false, "random_seed": -1, "processing_time_limit": 10, "skip_execution": false,
            "find_solution": false, "output_folder": "Output/", "file_name_prefix": "longstep", "frame_rate": 10,
            "image_synthesis": ["normal"], "save_pose_data": false, "save_scene_states": false, "camera_mode": ["AUTO"],
            "recording": false, "image_width": width, "image_height": height, "time_scale": 1.0, "skip_animation": false,
        });
        let texts = [config.to_string(), line.to_string()];
        let request = ApiRequest {
            is_cancelled_by_stop: false,
            ..ApiRequest::new("render_script", &[], &texts, limit)
        };
        let answer = self.request(&request)?;
        Ok(if answer.success {
            Ok(())
        } else {
            Err(reason(&answer.message))
        })
    }

    /// Returns a picture from behind the character, as a file: PNG or JPEG.
    ///
    /// # Errors
    ///
    /// A simulator without cameras, and every failure of the connection.
    pub fn picture(&self) -> Result<Vec<u8>, RobotError> {
        let count = self.accepted("camera_count", &ApiRequest::new("camera_count", &[], &[], QUESTION))?;
        let names = self.accepted(
            "character_cameras",
            &ApiRequest::new("character_cameras", &[], &[], QUESTION),
        )?;
        let count = count.value.as_i64().filter(|count| *count > 0);
        let count = count.ok_or_else(|| refused("camera_count", "there is no camera"))?;
        let camera = [camera(count, &names.message)];
        let (width, height) = PICTURE;
        let size = json!({ "mode": "normal", "image_width": width, "image_height": height });
        let texts = [size.to_string()];
        let answer = self.accepted(
            "camera_image",
            &ApiRequest::new("camera_image", &camera, &texts, QUESTION),
        )?;
        let text = answer.message_list.and_then(|pictures| pictures.into_iter().next());
        let text = text.ok_or_else(|| protocol("`camera_image` has no picture"))?;
        let picture = STANDARD.decode(text.trim());
        picture.map_err(|error| protocol(&format!("the picture of `camera_image` is no base64: {error}")))
    }

    /// Sends a request that must succeed.
    fn accepted(&self, method: &str, request: &ApiRequest<'_>) -> Result<ApiAnswer, RobotError> {
        let answer = self.request(request)?;
        if answer.success {
            Ok(answer)
        } else {
            Err(refused(method, &reason(&answer.message)))
        }
    }

    fn request(&self, request: &ApiRequest<'_>) -> Result<ApiAnswer, RobotError> {
        if self.is_stopped() {
            return Err(RobotError::Stopped);
        }
        let number = self.numbers.fetch_add(1, Ordering::SeqCst) + 1;
        let mut body = json!({ "id": number.to_string(), "action": request.action });
        if !request.numbers.is_empty() {
            body["intParams"] = json!(request.numbers);
        }
        if !request.texts.is_empty() {
            body["stringParams"] = json!(request.texts);
        }
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| gone(error.to_string()))?;
        let bytes = runtime.block_on(self.exchange(request, body.to_string()));
        runtime.shutdown_background();
        let bytes = bytes?;
        serde_json::from_slice(&bytes).map_err(|error| {
            let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
            let beginning: String = secret::redacted(&text).chars().take(200).collect();
            let beginning = longstep_core::visible::line(&beginning).into_owned();
            protocol(&format!(
                "the answer to `{}` cannot be read ({error}): {beginning}",
                request.action
            ))
        })
    }

    /// Sends a body and returns the answer's, within the time and the limit of bytes.
    async fn exchange(&self, request: &ApiRequest<'_>, body: String) -> Result<Vec<u8>, RobotError> {
        let begun = Instant::now();
        let post = self.client.post(&self.url);
        let post = post.header("Content-Type", "application/json").body(body);
        let mut work = std::pin::pin!(receive(post));
        loop {
            if request.is_cancelled_by_stop && self.is_stopped() {
                return Err(RobotError::Stopped);
            }
            let left = request.limit.saturating_sub(begun.elapsed());
            if left.is_zero() {
                return Err(RobotError::TimedOut {
                    what: format!("`{}` of {}", request.action, self.shown),
                    limit: request.limit,
                });
            }
            if let Ok(done) = tokio::time::timeout(TICK.min(left), work.as_mut()).await {
                return done;
            }
        }
    }
}

async fn receive(post: reqwest::RequestBuilder) -> Result<Vec<u8>, RobotError> {
    let broken = |error: reqwest::Error| gone(root(&error));
    let mut response = post.send().await.map_err(broken)?;
    if !response.status().is_success() {
        return Err(protocol(&format!("HTTP status {}", response.status())));
    }
    let mut bytes = Vec::new();
    while let Some(part) = response.chunk().await.map_err(broken)? {
        if bytes.len() + part.len() > LARGEST {
            return Err(protocol(&format!("an answer has more than {} MiB", LARGEST >> 20)));
        }
        bytes.extend_from_slice(&part);
    }
    Ok(bytes)
}

/// Returns the index of the camera behind the character. The cameras of the scene come first, those of the character last.
fn camera(count: i64, names: &Value) -> i64 {
    let read = names
        .as_str()
        .and_then(|text| serde_json::from_str::<Vec<String>>(text).ok());
    let names = read.unwrap_or_default();
    let behind = names
        .iter()
        .rev()
        .position(|name| name == "PERSON_FROM_BACK")
        .unwrap_or(0);
    let behind = i64::try_from(behind).unwrap_or(0);
    (count - 1 - behind).max(0)
}

/// Returns the reason in a message: a text, or a JSON text with a message for each character.
fn reason(message: &Value) -> String {
    let Value::String(text) = message else {
        return shortened(&message.to_string());
    };
    let by_character: Option<serde_json::Map<String, Value>> = serde_json::from_str(text).ok();
    let messages: Vec<String> = by_character
        .iter()
        .flat_map(serde_json::Map::values)
        .filter_map(|own| own.get("message").unwrap_or(own).as_str().map(str::to_owned))
        .collect();
    match (messages.is_empty(), text.trim().is_empty()) {
        (false, _) => shortened(&messages.join("; ")),
        (true, false) => shortened(text),
        (true, true) => "the simulator gives no reason".to_owned(),
    }
}

fn shortened(text: &str) -> String {
    // A part of a password would not be recognized.
    let text: String = secret::redacted(text).chars().take(LONGEST_REASON).collect();
    longstep_core::visible::line(&text).into_owned()
}

/// The innermost source of an error. The outer errors contain the address.
fn root(error: &(dyn Error + 'static)) -> String {
    let mut deepest = error;
    while let Some(source) = deepest.source() {
        deepest = source;
    }
    deepest.to_string()
}

fn gone(reason: String) -> RobotError {
    RobotError::Gone {
        reason,
        messages: String::new(),
    }
}

fn protocol(reason: &str) -> RobotError {
    RobotError::Protocol {
        reason: shortened(reason),
    }
}

fn refused(method: &str, reason: &str) -> RobotError {
    RobotError::Refused {
        method: method.to_owned(),
        reason: reason.to_owned(),
    }
}
