//! The Model Context Protocol over an in-memory transport, in both of its eras.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod support;

use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep_core::execution::{Approval, Settings};
use longstep_server::mcp::{McpOptions, http_service, serve};
use longstep_server::{Body, Deed, Hub, NewSession, RobotEntry, RunId, RunView, SessionId};
use rmcp::ClientHandler;
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, CallToolResult, ClientCapabilities, ClientConfig, ElicitRequestParams,
    ElicitResult, ErrorData, Implementation, InputResponses, ProtocolVersion, ReadResourceRequestParams,
};
use rmcp::service::{ClientLifecycleMode, ClientServiceExt, RequestContext, RoleClient, RunningService};
use serde_json::{Value, json};
use support::{hub, simulated};

const PAGE: &str = "http://127.0.0.1:8734/sessions/{session}";

/// The eras of the protocol.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Era {
    Handshake,
    Stateless,
}

const ERAS: [Era; 2] = [Era::Handshake, Era::Stateless];

/// What a client does with a form.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Person {
    Approves,
    ApprovesAnotherHash,
    LeavesApproveUnset,
    Declines,
    ClientDeclines,
    ClientAcceptsEmpty,
    NoForms,
}

impl Person {
    fn answer(self, hash: &Value) -> Value {
        let accept = |content: Value| json!({"action": "accept", "content": content});
        match self {
            Self::Approves => accept(json!({"approve": true, "plan": hash})),
            Self::ApprovesAnotherHash => accept(json!({"approve": true, "plan": "0123"})),
            Self::LeavesApproveUnset => accept(json!({"approve": false, "plan": hash})),
            Self::ClientAcceptsEmpty => accept(json!({})),
            Self::Declines | Self::ClientDeclines | Self::NoForms => json!({"action": "decline"}),
        }
    }
}

#[derive(Clone)]
struct Client {
    person: Person,
}

impl ClientHandler for Client {
    fn get_info(&self) -> ClientConfig {
        let mut capabilities = ClientCapabilities::default();
        if self.person != Person::NoForms {
            capabilities.elicitation = Some(Default::default());
        }
        ClientConfig::new(capabilities, Implementation::new("tester", "1"))
    }

    async fn create_elicitation(
        &self,
        request: ElicitRequestParams,
        _: RequestContext<RoleClient>,
    ) -> Result<ElicitResult, ErrorData> {
        let form = serde_json::to_value(&request).unwrap();
        let message = form["message"].as_str().unwrap();
        assert!(
            message.contains("Robot: sim") && message.contains("Instruction: Put the"),
            "{message}"
        );
        assert_eq!(
            form["requestedSchema"]["properties"]["approve"]["default"],
            json!(false)
        );
        if self.person == Person::Declines {
            tokio::time::sleep(Duration::from_millis(1_100)).await;
        }
        let hash = &form["requestedSchema"]["properties"]["plan"]["default"];
        Ok(serde_json::from_value(self.person.answer(hash)).unwrap())
    }
}

type Connection = RunningService<RoleClient, Client>;

/// A server with one connection.
struct Served {
    _folder: tempfile::TempDir,
    hub: Arc<Hub>,
    client: Connection,
}

async fn connected(hub: &Arc<Hub>, options: McpOptions, era: Era, person: Person) -> Connection {
    let (here, there) = tokio::io::duplex(1 << 16);
    tokio::spawn(serve(Arc::clone(hub), options, there));
    let lifecycle = match era {
        Era::Handshake => ClientLifecycleMode::Initialize,
        Era::Stateless => ClientLifecycleMode::Discover {
            preferred_versions: vec![ProtocolVersion::V_2026_07_28],
        },
    };
    Client { person }.serve_with_lifecycle(here, lifecycle).await.unwrap()
}

fn options() -> McpOptions {
    McpOptions::new(NewSession::of_scene("desk")).with_page(PAGE.to_owned())
}

async fn served_with(options: McpOptions, sim: &str, era: Era, person: Person) -> Served {
    served_on(
        options,
        simulated("sim", sim.parse().unwrap(), Body::PerSession),
        era,
        person,
    )
    .await
}

async fn served_on(options: McpOptions, robot: RobotEntry, era: Era, person: Person) -> Served {
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, vec![robot]);
    let client = connected(&hub, options, era, person).await;
    Served {
        _folder: folder,
        hub,
        client,
    }
}

async fn served(era: Era, person: Person) -> Served {
    served_with(options(), "", era, person).await
}

fn request(tool: &'static str, arguments: Value) -> CallToolRequestParams {
    let Value::Object(arguments) = arguments else {
        panic!("{arguments}")
    };
    CallToolRequestParams::new(tool).with_arguments(arguments)
}

impl Served {
    async fn call(&self, tool: &'static str, arguments: Value) -> CallToolResult {
        self.client.call_tool(request(tool, arguments)).await.unwrap()
    }

    /// Calls a tool that is to succeed, and returns its data, which its schema accepts.
    async fn done(&self, tool: &'static str, arguments: Value) -> Value {
        let result = self.call(tool, arguments).await;
        assert_eq!(result.is_error, Some(false), "{tool}: {}", text(&result));
        let data = result.structured_content.unwrap();
        let tools = self.client.list_all_tools().await.unwrap();
        let described = tools.iter().find(|own| own.name == tool).unwrap();
        let schema = Value::Object((**described.output_schema.as_ref().unwrap()).clone());
        jsonschema::validate(&schema, &data).unwrap_or_else(|error| panic!("{tool}: {error}"));
        data
    }

    /// Calls a tool that is to be refused, and returns its text, which has a next step.
    async fn refused(&self, tool: &'static str, arguments: Value) -> String {
        let result = self.call(tool, arguments).await;
        assert_eq!(result.is_error, Some(true), "{tool}: {}", text(&result));
        assert_eq!(result.structured_content, None);
        assert!(result.meta.as_ref().unwrap().0["io.github.longstep/error"]["kind"].is_string());
        let text = text(&result);
        assert!(text.contains("Next step: "), "{text}");
        text
    }

    async fn planned(&self, instruction: &str) -> Value {
        let plan = self.done("plan", json!({ "instruction": instruction })).await;
        assert!(plan["state"] == "plan" || plan["state"] == "question", "{plan}");
        plan
    }

    /// Waits until a run has ended.
    async fn ended(&self, run: &Value) -> Value {
        for _ in 0..20 {
            let view = self
                .done("run_status", json!({"run": run["id"], "wait_seconds": 5}))
                .await;
            if !view["end"].is_null() {
                return view;
            }
        }
        panic!("the run does not end");
    }

    /// Returns the numbers of approvals, starts and refusals in the audit log.
    fn counts(&self) -> (usize, usize, usize) {
        let entries = self.hub.audit().last(usize::MAX).unwrap();
        let ours = entries
            .iter()
            .all(|entry| entry.by == "mcp:tester" || entry.by == "page");
        assert!(ours, "{entries:?}");
        let count = |is: fn(&Deed) -> bool| entries.iter().filter(|entry| is(&entry.deed)).count();
        (
            count(|deed| matches!(deed, Deed::Approved { .. })),
            count(|deed| matches!(deed, Deed::Started { .. })),
            count(|deed| matches!(deed, Deed::Refused { .. })),
        )
    }
}

fn text(result: &CallToolResult) -> String {
    let blocks = result.content.iter().filter_map(|block| block.as_text());
    blocks.map(|block| block.text.clone()).collect()
}

fn executing(plan: &Value) -> Value {
    json!({"plan_id": plan["plan_id"], "hash": plan["hash"]})
}

fn session_of(plan: &Value) -> SessionId {
    SessionId::parse(plan["id"].as_str().unwrap()).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn only_a_person_who_approves_moves_the_robot() {
    for era in ERAS {
        for (person, expected) in [
            (Person::ApprovesAnotherHash, "another hash"),
            (Person::LeavesApproveUnset, "did not approve"),
            (Person::Declines, "the person declined"),
            (Person::ClientDeclines, "Nobody was asked"),
            (Person::ClientAcceptsEmpty, "came back empty"),
            (Person::NoForms, "Nobody was asked"),
        ] {
            let served = served(era, person).await;
            let plan = served.planned("Put the pen on the shelf").await;
            let text = served.refused("execute_plan", executing(&plan)).await;
            assert!(text.contains(expected), "{era:?} {person:?}: {text}");
            assert!(served.hub.runs().is_empty(), "{era:?} {person:?}");
            assert_eq!(served.counts(), (0, 0, 1), "{era:?} {person:?}");
            // Nobody was asked: the plan waits for the page, which the text names.
            let waits = served.hub.session(&session_of(&plan)).unwrap().next.is_some();
            assert_eq!(waits, text.contains("Nobody was asked"), "{era:?} {person:?}");
            assert_eq!(waits, text.contains("http://127.0.0.1:8734/sessions/"), "{text}");
        }
        let served = served(era, Person::Approves).await;
        let plan = served.planned("Put the pen on the shelf").await;
        let run = served.done("execute_plan", executing(&plan)).await;
        assert_eq!(run["plan"], plan["hash"]);
        assert_eq!(run["by"], "mcp:tester");
        assert_eq!(served.ended(&run).await["state"], "done");
        let text = served.refused("execute_plan", executing(&plan)).await;
        assert!(text.contains("used already"), "{text}");
        assert_eq!((served.counts(), served.hub.runs().len()), ((1, 1, 0), 1), "{era:?}");
        let world = served.done("describe_world", json!({})).await;
        assert_eq!(world["environment"]["object_states"]["<pen>"], "on_something(<shelf>)");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn plan_that_nobody_was_asked_about_can_be_approved_elsewhere() {
    let served = served(Era::Stateless, Person::NoForms).await;
    let plan = served.planned("Put the pen on the shelf").await;
    served.refused("execute_plan", executing(&plan)).await;
    let (hub, id) = (&served.hub, session_of(&plan));
    let hash = plan["hash"].as_str().unwrap();
    let approval = hub.approve(&id, hash, "sim", "page", Duration::from_secs(60)).unwrap();
    hub.start(&approval.id, false, "page").unwrap();
    let run = served.done("run_status", json!({"wait_seconds": 10})).await;
    assert_eq!((&run["state"], &run["by"]), (&json!("done"), &json!("page")));
}

#[tokio::test(flavor = "multi_thread")]
async fn another_hash_id_world_or_robot_is_refused_before_anybody_is_asked() {
    for era in ERAS {
        let served = served(era, Person::Approves).await;
        let plan = served.planned("Put the pen on the shelf").await;
        let (id, hash) = (&plan["plan_id"], &plan["hash"]);
        for (arguments, expected) in [
            (
                json!({"plan_id": id, "hash": "0123"}),
                "the hash is not that of the plan",
            ),
            (json!({"plan_id": "plan-0123", "hash": hash}), "no plan_id"),
            (
                json!({"plan_id": id, "hash": hash, "robot": "arm"}),
                "there is no robot `arm`",
            ),
            (json!({"plan_id": id}), "the arguments cannot be read"),
        ] {
            let text = served.refused("execute_plan", arguments).await;
            assert!(text.contains(expected), "{text}");
        }
        // The plan of an earlier proposal.
        let other = served.planned("Put the cup on the shelf").await;
        let text = served.refused("execute_plan", executing(&plan)).await;
        assert!(text.contains("not the next one"), "{text}");
        // A world that changed after the plan was shown.
        let id = session_of(&other);
        served.hub.accept(&id, other["hash"].as_str().unwrap(), "page").unwrap();
        let seen = serde_json::from_value(json!({"states": {"<cup>": "on_something(<table>)"}})).unwrap();
        served.hub.observed(&id, &seen).unwrap();
        let text = served.refused("execute_plan", executing(&other)).await;
        assert!(text.contains("the world has changed"), "{text}");
        assert!(served.hub.runs().is_empty());
        assert_eq!((served.counts().0, served.counts().1), (0, 0));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn plan_id_expires() {
    let options = options().with_plan_lifetime(Duration::from_millis(1));
    let served = served_with(options, "", Era::Handshake, Person::Approves).await;
    let plan = served.planned("Put the pen on the shelf").await;
    tokio::time::sleep(Duration::from_millis(5)).await;
    let text = served.refused("execute_plan", executing(&plan)).await;
    assert!(text.contains("has expired"), "{text}");
    assert_eq!(served.counts(), (0, 0, 0));
}

/// Asks to carry a plan out, and returns the form's state and its answer by a person who approves.
async fn form(served: &Served, plan: &Value) -> (String, InputResponses) {
    let asked = served
        .client
        .peer()
        .call_tool_once(request("execute_plan", executing(plan)));
    let CallToolResponse::InputRequired(asked) = asked.await.unwrap() else {
        panic!("nobody is asked");
    };
    let answer = Person::Approves.answer(&plan["hash"]);
    (
        asked.request_state.unwrap(),
        InputResponses::from([("approval".to_owned(), answer)]),
    )
}

async fn answered(served: &Served, plan: &Value, state: &str, responses: InputResponses) -> CallToolResult {
    let again = request("execute_plan", executing(plan))
        .with_input_responses(responses)
        .with_request_state(state);
    match served.client.peer().call_tool_once(again).await.unwrap() {
        CallToolResponse::Complete(result) => result,
        other => panic!("{other:?}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn state_that_is_tampered_foreign_expired_or_replayed_is_refused() {
    let served = served_with(options(), "", Era::Stateless, Person::Approves).await;
    let plan = served.planned("Put the pen on the shelf").await;
    let (state, answer) = form(&served, &plan).await;
    let foreign = served_with(options(), "", Era::Stateless, Person::Approves).await;
    let foreign_plan = foreign.planned("Put the pen on the shelf").await;
    let (foreign, _) = form(&foreign, &foreign_plan).await;
    let mut tampered = state.clone().into_bytes();
    let middle = tampered.len() / 2;
    tampered[middle] = if tampered[middle] == b'A' { b'B' } else { b'A' };
    for wrong in [
        String::from_utf8(tampered).unwrap(),
        foreign,
        String::new(),
        "rs2.a.b".to_owned(),
    ] {
        let text = text(&answered(&served, &plan, &wrong, answer.clone()).await);
        assert!(text.contains("not one of this server"), "{text}");
    }
    let missing = text(&answered(&served, &plan, &state, InputResponses::new()).await);
    assert!(missing.contains("no answer to the form"), "{missing}");
    let replayed = text(&answered(&served, &plan, &state, answer.clone()).await);
    assert!(replayed.contains("answered already"), "{replayed}");
    assert_eq!(served.counts(), (0, 0, 6));

    let (state, answer) = form(&served, &plan).await;
    let run = answered(&served, &plan, &state, answer.clone()).await;
    assert_eq!(run.is_error, Some(false), "{}", text(&run));
    let replayed = text(&answered(&served, &plan, &state, answer).await);
    assert!(replayed.contains("used already"), "{replayed}");
    assert_eq!((served.counts().1, served.hub.runs().len()), (1, 1));

    let options = options().with_form_lifetime(Duration::from_millis(30));
    let served = served_with(options, "", Era::Stateless, Person::Approves).await;
    let plan = served.planned("Put the pen on the shelf").await;
    let (state, answer) = form(&served, &plan).await;
    tokio::time::sleep(Duration::from_millis(60)).await;
    let expired = text(&answered(&served, &plan, &state, answer).await);
    assert!(expired.contains("the time to answer the form is over"), "{expired}");
    assert!(served.hub.runs().is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn answer_for_one_plan_does_not_count_for_another() {
    let served = served(Era::Stateless, Person::Approves).await;
    let pen = served.planned("Put the pen on the shelf").await;
    let (state, answer) = form(&served, &pen).await;
    let cup = served.planned("Put the cup on the shelf").await;
    let text = text(&answered(&served, &cup, &state, answer).await);
    assert!(text.contains("has changed since the person was asked"), "{text}");
    assert!(served.hub.runs().is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn stop_pause_and_status_work_while_a_run_goes_on() {
    for era in ERAS {
        let served = served_with(options(), "ticks=20,pace=50", era, Person::Approves).await;
        let plan = served.planned("Put the pen on the shelf").await;
        let run = served.done("execute_plan", executing(&plan)).await;
        let of_run = json!({"run": run["id"]});
        served.done("pause", of_run.clone()).await;
        let paused = served
            .done("run_status", json!({"run": run["id"], "wait_seconds": 10}))
            .await;
        assert_eq!(paused["state"], "paused");
        served.done("resume", of_run.clone()).await;
        // The pause of a person is theirs.
        let id = RunId::parse(run["id"].as_str().unwrap()).unwrap();
        served.hub.pause(&id, "page").unwrap();
        assert!(served.refused("resume", of_run.clone()).await.contains("somebody else"));
        served.hub.go_on(&id, "page").unwrap();
        let busy = served.refused("execute_plan", executing(&plan)).await;
        assert!(busy.contains("used already"), "{busy}");
        let began = Instant::now();
        let stopped = served.done("stop", json!({})).await;
        assert_eq!(stopped["stopped"], 1);
        assert!(began.elapsed() < Duration::from_secs(1));
        assert_eq!(served.ended(&run).await["state"], "stopped");
        let text = served.refused("pause", of_run).await;
        assert!(text.contains("has ended"), "{text}");
        assert_eq!(served.done("stop", json!({"run": run["id"]})).await["stopped"], 0);
    }
}

/// Begins a run whose steps a person has to approve, and returns it with the first question.
async fn asking(served: &Served) -> RunView {
    let plan = served.planned("Put the pen on the shelf").await;
    let (hub, id, hash) = (&served.hub, session_of(&plan), plan["hash"].as_str().unwrap());
    hub.accept(&id, hash, "page").unwrap();
    let approval = hub.approve(&id, hash, "sim", "page", Duration::from_secs(60)).unwrap();
    let run = hub.start(&approval.id, false, "page").unwrap().record.id.clone();
    (*support::until(hub, &run, |view| view.question.is_some())).clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn question_of_a_run_is_decided_by_a_person() {
    for era in ERAS {
        for (person, expected, is_decided) in [
            (Person::Approves, None, true),
            (Person::LeavesApproveUnset, None, true),
            (Person::Declines, None, true),
            (Person::ApprovesAnotherHash, Some("another hash"), false),
            (Person::ClientAcceptsEmpty, Some("came back empty"), false),
            (Person::ClientDeclines, Some("Nobody was asked"), false),
            (Person::NoForms, Some("Nobody was asked"), false),
        ] {
            let steps = Settings::default().with_approval(Approval::EachStep);
            let robot = simulated("sim", Default::default(), Body::PerSession).with_settings(steps);
            let served = served_on(options(), robot, era, person).await;
            let view = asking(&served).await;
            let question = view.question.unwrap().id;
            let run = view.record.id.as_str();
            let status = served.call("run_status", json!({ "run": run })).await;
            assert!(text(&status).contains(&question), "{}", text(&status));
            let wrong = served.refused("decide", json!({"run": run, "question": "0123"})).await;
            assert!(wrong.contains("asks something else"), "{wrong}");
            let asked = json!({"run": run, "question": question});
            match expected {
                Some(expected) => {
                    let text = served.refused("decide", asked).await;
                    assert!(text.contains(expected), "{era:?} {person:?}: {text}");
                }
                None => drop(served.done("decide", asked).await),
            }
            let entries = served.hub.audit().last(usize::MAX).unwrap();
            let decided = entries.iter().find_map(|entry| match &entry.deed {
                Deed::Decided { yes, .. } => Some(*yes),
                _ => None,
            });
            let yes = is_decided.then_some(person == Person::Approves);
            assert_eq!(decided, yes, "{era:?} {person:?}");
            served.hub.stop_all("page").unwrap();
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn run_ends_with_the_connection_that_began_it() {
    let served = served_with(options(), "ticks=100,pace=50", Era::Handshake, Person::Approves).await;
    let plan = served.planned("Put the pen on the shelf").await;
    let run = served.done("execute_plan", executing(&plan)).await;
    let id = RunId::parse(run["id"].as_str().unwrap()).unwrap();
    served.client.cancel().await.unwrap();
    let view = support::until(&served.hub, &id, |view| view.state.is_ended());
    assert_eq!(view.state.name(), "stopped");
}

#[tokio::test(flavor = "multi_thread")]
async fn session_is_planned_in_asked_about_revised_and_discarded() {
    for era in ERAS {
        let served = served(era, Person::Approves).await;
        for (tool, arguments) in [
            ("explain", json!({})),
            ("answer", json!({"answer": "the pen"})),
            ("revise", json!({"feedback": "slower"})),
            ("discard", json!({})),
            ("run_status", json!({})),
        ] {
            let text = served.refused(tool, arguments).await;
            assert!(text.contains("no session yet"), "{tool}: {text}");
        }
        let start = served.done("describe_world", json!({})).await;
        assert_eq!((&start["session"], &start["robots"]), (&Value::Null, &json!(["sim"])));
        let question = served.planned("Put it somewhere").await;
        assert_eq!(
            (&question["state"], &question["plan_id"]),
            (&json!("question"), &Value::Null)
        );
        let plan = served.done("answer", json!({"answer": "the pen on the shelf"})).await;
        assert_eq!(plan["state"], "plan");
        let out_of_turn = served.refused("answer", json!({"answer": "yes"})).await;
        assert!(out_of_turn.contains("execute_plan"), "{out_of_turn}");
        let explained = served.done("explain", json!({})).await;
        assert_eq!(explained["plan_id"], plan["plan_id"]);
        assert!(!explained["steps"][1]["without_it"].as_array().unwrap().is_empty());
        // Another instruction takes the place of a plan without a decision.
        let other = served.planned("Put the cup on the shelf").await;
        assert_eq!(other["id"], plan["id"]);
        assert_eq!(served.done("discard", json!({})).await["state"], "ready");
        assert!(served.refused("discard", json!({})).await.contains("no plan waits"));
        let foreign = served.refused("explain", json!({"session": "../etc"})).await;
        assert!(foreign.contains("no session"), "{foreign}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn written_plans_are_verified_and_repaired() {
    let served = served(Era::Handshake, Person::NoForms).await;
    let plan = json!({"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}});
    let invalid = served.done("verify", json!({ "plan": plan })).await;
    assert_eq!(invalid["status"], "invalid");
    let repaired = served.done("repair", json!({"plan": plan.to_string()})).await;
    assert_eq!(repaired["status"], "verified");
    assert_eq!(
        served.done("verify", json!({"plan": repaired["plan"]})).await["status"],
        "verified"
    );
    assert!(
        !served
            .call("verify", json!({"plan": "no plan at all"}))
            .await
            .content
            .is_empty()
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn resources_are_the_world_and_the_plan() {
    let served = served(Era::Stateless, Person::NoForms).await;
    assert_eq!(served.client.list_all_resources().await.unwrap().len(), 2);
    let read = async |uri: &str| {
        let read = served.client.read_resource(ReadResourceRequestParams::new(uri)).await;
        read.map(|read| {
            serde_json::to_value(&read.contents[0]).unwrap()["text"]
                .as_str()
                .unwrap()
                .to_owned()
        })
    };
    assert!(read("longstep://plan").await.is_err());
    assert!(read("file:///etc/passwd").await.is_err());
    let plan = served.planned("Put the pen on the shelf").await;
    let uri = format!("longstep://sessions/{}/plan", plan["id"].as_str().unwrap());
    let file: Value = serde_json::from_str(&read(&uri).await.unwrap()).unwrap();
    assert!(file["task_cohesion"].is_object(), "{file}");
    assert!(read("longstep://world").await.unwrap().contains("<pen>"));
}

#[tokio::test(flavor = "multi_thread")]
async fn stop_is_not_held_up_and_a_cancelled_call_ends_its_work() {
    for era in ERAS {
        let served = served_with(options(), "ticks=100,pace=50", era, Person::Approves).await;
        let plan = served.planned("Put the pen on the shelf").await;
        let run = served.done("execute_plan", executing(&plan)).await;
        let peer = served.client.peer().clone();
        // A model that does not answer, and more work than there are workers.
        let begin = |tool, arguments| {
            let peer = peer.clone();
            tokio::spawn(async move { peer.call_tool_once(request(tool, arguments)).await.map(drop) })
        };
        let waiting = begin("plan", json!({"instruction": "wait for me", "session": plan["id"]}));
        let busy: Vec<_> = (0..64)
            .map(|_| begin("explain", json!({"session": plan["id"]})))
            .collect();
        tokio::time::sleep(Duration::from_millis(50)).await;
        let began = Instant::now();
        assert_eq!(served.done("stop", json!({})).await["stopped"], 1);
        assert!(began.elapsed() < Duration::from_millis(500), "{:?}", began.elapsed());
        assert_eq!(served.ended(&run).await["state"], "stopped");
        for call in busy {
            call.await.unwrap().unwrap();
        }
        // The client takes its call back.
        let id = session_of(&plan);
        assert_eq!(served.hub.session(&id).unwrap().view.state, "thinking");
        waiting.abort();
        let mut tries = 0;
        while served.hub.session(&id).unwrap().view.state == "thinking" {
            tokio::time::sleep(Duration::from_millis(10)).await;
            tries += 1;
            assert!(tries < 500, "{era:?}");
        }
    }
}

/// Sends a request over HTTP and returns the status.
async fn status(address: std::net::SocketAddr, headers: &str) -> u16 {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let body = r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"protocolVersion":"2025-11-25","capabilities":{},"clientInfo":{"name":"x","version":"1"}}}"#;
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let head = format!(
        "POST /mcp HTTP/1.1\r\n{headers}Accept: application/json, text/event-stream\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).await.unwrap();
    String::from_utf8_lossy(&answer)[9..].parse().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn other_hosts_and_web_pages_are_refused_over_http() {
    let folder = tempfile::tempdir().unwrap();
    let options = options().with_origins(vec!["http://localhost:8734".to_owned()]);
    let service = http_service(hub(&folder, Vec::new()), options).unwrap();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let router: axum::Router = axum::Router::new().nest_service("/mcp", service);
    tokio::spawn(async move { axum::serve(listener, router).await });
    for (headers, expected) in [
        ("Host: 127.0.0.1\r\n", 200),
        ("Host: localhost:8734\r\nOrigin: http://localhost:8734\r\n", 200),
        ("Host: rebound.example\r\n", 403),
        ("Host: 127.0.0.1\r\nOrigin: http://evil.example\r\n", 403),
        ("Host: 127.0.0.1\r\nOrigin: null\r\n", 403),
    ] {
        assert_eq!(status(address, headers).await, expected, "{headers}");
    }
}
