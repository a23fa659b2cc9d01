//! A face against a bridge in this process, which sees every message.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep_robot::SimOptions;
use longstep_robot::ros2::Configuration;
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

use super::rate::Bucket;
use super::{RosFace, RosOptions};
use crate::{APPROVAL_LIFETIME, Body, Hub, SessionId};

use crate::support::{hub, simulated};

const LONGEST: Duration = Duration::from_secs(20);

/// A bridge, a server with a simulated robot, and the face between them.
struct Bench {
    _folder: TempDir,
    hub: Arc<Hub>,
    listener: TcpListener,
    face: RosFace,
    socket: WebSocket<TcpStream>,
    count: u64,
}

impl Bench {
    fn new(serving: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let hub = hub(&folder, vec![simulated("sim", SimOptions::default(), Body::PerSession)]);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let text = format!(
            "name = \"arm\"\nurl = \"ws://127.0.0.1:{port}\"\nallow = [\"grasp\"]\n[timeouts]\nsilence = 3\n[serve]\n{serving}\n\
             [[action]]\nname = \"*\"\nserver = \"/step\"\ntype = \"a/action/B\"\ngoal = {{}}\n"
        );
        let configuration = Configuration::parse("robot.toml", &text).unwrap();
        let face = RosFace::start(Arc::clone(&hub), RosOptions::new(&configuration)).unwrap();
        let socket = accepted(&listener);
        Self {
            _folder: folder,
            hub,
            listener,
            face,
            socket,
            count: 0,
        }
    }

    fn send(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    /// Returns the next message that fits.
    fn next(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        while began.elapsed() < LONGEST {
            if let Ok(Message::Text(text)) = self.socket.read() {
                let message: Value = serde_json::from_str(text.as_str()).unwrap();
                if fits(&message) {
                    return message;
                }
            }
        }
        panic!("no such message")
    }

    /// Returns the next content of a topic that fits.
    fn shown(&mut self, topic: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let text = |message: &Value| {
            let is_own = message["op"] == "publish" && message["topic"] == topic;
            is_own.then(|| serde_json::from_str::<Value>(message["msg"]["data"].as_str().unwrap()).unwrap())
        };
        let found = self.next(|message| text(message).is_some_and(|content| fits(&content)));
        text(&found).unwrap()
    }

    fn publish(&mut self, topic: &str, data: &str) {
        self.send(&json!({"op": "publish", "topic": topic, "msg": {"data": data}}));
    }

    /// Sends a request, and returns its answer.
    fn ask(&mut self, kind: &str, mut request: Value) -> Value {
        self.count += 1;
        let id = format!("request-{}", self.count);
        request["id"] = json!(id);
        self.publish(&format!("/longstep/{kind}/request"), &request.to_string());
        self.shown(&format!("/longstep/{kind}/response"), |answer| answer["id"] == id)
    }

    /// Has the server make a plan; returns its session and its hash.
    fn planned(&mut self) -> (SessionId, String) {
        let answer = self.ask("say", json!({"text": "Put the pen on the shelf"}));
        assert_eq!(
            (&answer["ok"], &answer["state"]),
            (&json!(true), &json!("plan")),
            "{answer}"
        );
        let session = SessionId::parse(answer["session"].as_str().unwrap()).unwrap();
        (session, answer["plan"].as_str().unwrap().to_owned())
    }
}

fn accepted(listener: &TcpListener) -> WebSocket<TcpStream> {
    let (stream, _) = listener.accept().unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    tungstenite::accept(stream).unwrap()
}

#[track_caller]
fn check_refused(answer: &Value, words: &str) {
    let message = answer["error"]["message"].as_str().unwrap_or_default();
    assert!(
        answer["ok"] == false && message.contains(words),
        "no `{words}` in {answer}"
    );
}

#[test]
fn greeting_announces_topics_and_services_before_it_listens() {
    for (serving, services) in [("", 0), ("services = true", 2)] {
        let mut bench = Bench::new(serving);
        let mut messages = Vec::new();
        for _ in 0..7 + services {
            messages.push(bench.next(|_| true));
        }
        let of = |op: &str, name: &str| -> Vec<String> {
            let own = messages.iter().filter(|message| message["op"] == op);
            own.map(|message| message[name].as_str().unwrap().to_owned()).collect()
        };
        let latched = messages.iter().filter(|message| message["latch"] == true);
        let latched: Vec<&Value> = latched.map(|message| &message["topic"]).collect();
        assert_eq!(
            latched[..3],
            ["/longstep/plan", "/longstep/progress", "/longstep/world"]
        );
        assert_eq!(latched[3..], ["/longstep/say/response", "/longstep/execute/response"]);
        assert_eq!(of("advertise", "topic").len(), 5);
        assert_eq!(
            of("subscribe", "topic"),
            ["/longstep/say/request", "/longstep/execute/request"]
        );
        assert_eq!(of("advertise_service", "service").len(), services);
        assert_eq!(messages.last().unwrap()["op"], "subscribe");
    }
}

#[test]
fn execute_begins_only_what_a_person_approved_elsewhere() {
    let mut bench = Bench::new("");
    let (session, plan) = bench.planned();
    let shown = bench.shown("/longstep/plan", |content| content["decision"] == "proposed");
    assert_eq!((&shown["plan"], &shown["session"]), (&json!(plan), &json!(session)));
    assert!(!shown["steps"].as_array().unwrap().is_empty());
    let execute = json!({"plan": plan, "session": session, "caller": "cell"});
    check_refused(&bench.ask("execute", execute.clone()), "nobody has approved this plan");
    check_refused(&bench.ask("execute", json!({"plan": "no hash!"})), "no hash of a plan");
    check_refused(
        &bench.ask("execute", json!({"plan": plan, "approval": "nothing"})),
        "no approval `nothing`",
    );
    bench.hub.accept(&session, &plan, "ada").unwrap();
    check_refused(&bench.ask("execute", execute.clone()), "nobody has approved this plan");
    let short = bench
        .hub
        .approve(&session, &plan, "sim", "ada", Duration::from_millis(1))
        .unwrap();
    check_refused(&bench.ask("execute", execute.clone()), "expired");
    let other = json!({"plan": "0000", "approval": short.id});
    check_refused(&bench.ask("execute", other), "another plan");
    assert!(bench.hub.runs().is_empty());

    bench
        .hub
        .approve(&session, &plan, "sim", "ada", APPROVAL_LIFETIME)
        .unwrap();
    let begun = bench.ask("execute", execute.clone());
    assert_eq!(
        (&begun["ok"], &begun["plan"], &begun["robot"]),
        (&json!(true), &json!(plan), &json!("sim"))
    );
    let run = begun["run"].clone();
    let done = bench.shown("/longstep/progress", |content| content["state"] == "done");
    assert_eq!(
        (&done["id"], &done["end"]["done"], done.get("environment")),
        (&run, &json!(true), None)
    );
    assert_eq!(bench.hub.runs()[0].record.by, "ros2:cell");
    // The same hash again moves nothing.
    for request in [
        execute.clone(),
        json!({"plan": plan, "approval": bench.hub.runs()[0].record.approval}),
    ] {
        assert_eq!(bench.ask("execute", request)["ok"], false);
    }
    assert_eq!(bench.hub.runs().len(), 1);
    let refused = bench.hub.audit().last(100).unwrap();
    let refused = refused
        .iter()
        .filter(|entry| matches!(entry.deed, crate::Deed::Refused { .. }));
    assert!(refused.count() >= 3);
}

#[test]
fn execute_approves_in_the_name_of_the_caller_where_it_may() {
    let mut bench = Bench::new("approve = true");
    let (session, plan) = bench.planned();
    let named = |more: Value| {
        let mut request = json!({"plan": plan, "session": session, "caller": "cell \u{202e}7"});
        request
            .as_object_mut()
            .unwrap()
            .extend(more.as_object().unwrap().clone());
        request
    };
    check_refused(
        &bench.ask("execute", json!({"plan": plan, "session": session})),
        "needs the name",
    );
    check_refused(
        &bench.ask("execute", json!({"plan": plan, "caller": "cell"})),
        "needs the session",
    );
    check_refused(
        &bench.ask("execute", named(json!({"plan": "0000"}))),
        "no accepted plan waits",
    );
    check_refused(&bench.ask("execute", named(json!({"robot": "arm"}))), "no robot `arm`");
    assert!(bench.hub.runs().is_empty());
    assert_eq!(bench.ask("execute", named(json!({})))["ok"], true);
    bench.shown("/longstep/progress", |content| content["state"] == "done");
    let world = bench.hub.session(&session).unwrap().view.environment.clone();
    assert_eq!(world.object_states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
    check_refused(&bench.ask("execute", named(json!({}))), "no accepted plan waits");
    let deeds = bench.hub.audit().last(100).unwrap();
    let approved = deeds
        .iter()
        .find(|entry| matches!(entry.deed, crate::Deed::Approved { .. }));
    assert_eq!(approved.unwrap().by, "ros2:cell \\u{202e}7");
}

#[test]
fn say_continues_a_session_by_its_state() {
    let mut bench = Bench::new("");
    let asked = bench.ask("say", json!({"text": "Put something away", "scene": "desk"}));
    assert_eq!(
        (&asked["state"], &asked["question"]),
        (&json!("question"), &json!("Which one?"))
    );
    let answer = bench.ask(
        "say",
        json!({"text": "the cup on the shelf", "session": asked["session"]}),
    );
    assert_eq!(
        (&answer["state"], &answer["session"]),
        (&json!("plan"), &asked["session"]),
        "{answer}"
    );
    check_refused(
        &bench.ask("say", json!({"text": "x", "session": "nothing"})),
        "no session `nothing`",
    );
    check_refused(
        &bench.ask("say", json!({"text": "x", "scene": "nothing"})),
        "no scene `nothing`",
    );
    check_refused(
        &bench.ask(
            "say",
            json!({"text": "x", "session": asked["session"], "as": "instruction"}),
        ),
        "",
    );
}

#[test]
fn services_answer_their_caller() {
    let mut bench = Bench::new("services = true\nnamespace = \"/kitchen\"");
    let request = json!({"id": 7, "text": "Put the pen on the shelf"}).to_string();
    bench.send(&json!({"op": "call_service", "service": "/kitchen/say", "id": "call-1", "args": {"request": request}}));
    let response = bench.next(|message| message["op"] == "service_response");
    assert_eq!(
        (&response["id"], &response["service"]),
        (&json!("call-1"), &json!("/kitchen/say"))
    );
    let answer: Value = serde_json::from_str(response["values"]["response"].as_str().unwrap()).unwrap();
    assert_eq!(
        (&answer["id"], &answer["state"]),
        (&json!(7), &json!("plan")),
        "{answer}"
    );
}

#[test]
fn a_bridge_that_comes_back_gets_the_last_messages() {
    let mut bench = Bench::new("");
    let (_, plan) = bench.planned();
    bench.shown("/longstep/plan", |content| content["plan"] == plan);
    for round in 2..5 {
        // Closed in order, or gone without a word.
        if round % 2 == 0 {
            bench.socket.close(None).unwrap();
            drop(bench.socket.flush());
        } else {
            bench.socket.get_ref().shutdown(std::net::Shutdown::Both).unwrap();
        }
        bench.socket = accepted(&bench.listener);
        bench.shown("/longstep/plan", |content| content["plan"] == plan);
        assert_eq!(bench.face.connections(), round);
        bench.planned();
    }
}

#[test]
fn a_silent_bridge_is_left() {
    let mut bench = Bench::new("");
    bench.next(|message| message["op"] == "subscribe");
    // Nobody reads this socket any more, so no ping is answered.
    let old = std::mem::replace(&mut bench.socket, accepted(&bench.listener));
    bench.planned();
    drop(old);
}

#[test]
fn hostile_messages_neither_end_the_face_nor_hold_up_the_hub() {
    let mut bench = Bench::new("");
    let topic = "/longstep/say/request";
    let deep = "[".repeat(100_000);
    for data in [
        "",
        "null",
        "[]",
        "{}",
        "{\"text\": 7}",
        "{\"text\": \"x\", \"more\": 1}",
        &deep,
        "\u{0}\u{202e}",
    ] {
        bench.publish(topic, data);
        std::thread::sleep(Duration::from_millis(210));
        let answer = bench.shown("/longstep/say/response", |_| true);
        assert_eq!(
            (&answer["ok"], &answer["id"]),
            (&json!(false), &Value::Null),
            "{answer}"
        );
    }
    let large = json!({"id": "large", "text": "x".repeat(70 << 10)}).to_string();
    bench.publish(topic, &large);
    check_refused(&bench.shown("/longstep/say/response", |_| true), "at most 64 KiB");
    let long = json!({"text": "x".repeat(5_000)});
    check_refused(&bench.ask("say", long), "the limit is 4000");
    for message in [
        json!("text"),
        json!({"op": "publish", "topic": topic}),
        json!({"op": "publish", "topic": topic, "msg": 7}),
        json!({"op": "publish", "topic": topic, "msg": {"data": {"text": 7}}}),
        json!({"op": "publish", "topic": "/other", "msg": {"data": "x"}}),
        json!({"op": "call_service", "service": "/longstep/say", "id": "x", "args": {}}),
        json!({"op": "call_service"}),
        json!({"op": "status", "level": "error", "id": "x", "msg": deep}),
        json!({"op": "action_result", "id": "x", "values": {}}),
    ] {
        bench.send(&message);
    }
    bench.socket.send(Message::text("no JSON")).unwrap();
    // A flood is refused, and then dropped.
    let began = Instant::now();
    for _ in 0..20_000 {
        bench.publish(
            topic,
            "{\"text\": \"Put the pen on the shelf\", \"session\": \"nothing\"}",
        );
    }
    assert!(bench.hub.sessions().is_ok() && began.elapsed() < LONGEST);
    std::thread::sleep(Duration::from_secs(3));
    bench
        .socket
        .get_ref()
        .set_read_timeout(Some(Duration::from_millis(200)))
        .unwrap();
    let mut answers = 0;
    while let Ok(message) = bench.socket.read() {
        answers += usize::from(message.to_text().is_ok_and(|text| text.contains("/response")));
    }
    assert!((10..400).contains(&answers), "{answers}");
    bench
        .socket
        .get_ref()
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    assert_eq!(bench.face.connections(), 1);
    bench.planned();
    // What is no text ends the connection, and another one follows.
    bench.socket.send(Message::binary(vec![0, 1, 2])).unwrap();
    bench.socket = accepted(&bench.listener);
    bench.planned();
}

#[test]
fn requests_at_a_time_have_a_bound_and_end_with_the_face() {
    let mut bench = Bench::new("");
    for number in 0..9 {
        let wait = json!({"id": number, "text": "wait for me"});
        bench.publish("/longstep/say/request", &wait.to_string());
    }
    let busy = bench.shown("/longstep/say/response", |_| true);
    check_refused(&busy, "too many requests at a time");
    let thinking = |hub: &Hub| {
        let sessions = hub.sessions().unwrap();
        let states = sessions.iter().map(|id| hub.session(id).unwrap().view.state);
        states.filter(|state| *state == "thinking").count()
    };
    let Bench { hub, face, .. } = bench;
    let began = Instant::now();
    while thinking(&hub) < 8 {
        assert!(began.elapsed() < LONGEST);
        std::thread::sleep(Duration::from_millis(5));
    }
    let began = Instant::now();
    drop(face);
    assert!(began.elapsed() < Duration::from_secs(2));
    while thinking(&hub) > 0 {
        assert!(began.elapsed() < LONGEST);
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn bucket_lets_a_burst_through_and_then_a_rate() {
    let now = Instant::now();
    let mut bucket = Bucket::new(3, 2.0, now);
    let taken = (0..10).filter(|_| bucket.take(now)).count();
    assert_eq!(taken, 3);
    let later = now + Duration::from_millis(1_600);
    assert_eq!((0..10).filter(|_| bucket.take(later)).count(), 3);
    assert!(!bucket.take(later) && bucket.take(later + Duration::from_millis(500)));
    assert_eq!(
        (0..10)
            .filter(|_| bucket.take(now + Duration::from_secs(3_600)))
            .count(),
        3
    );
}
