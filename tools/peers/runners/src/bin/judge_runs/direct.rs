//! A run without a driver: each need is a question, and every call of the interface of an execution is an answer, wrong ones
//! included.

use longstep_core::execution::{Execution, ExecutionError, Need, ProposalId, StepOrder, Stop};
use longstep_robot::{Observation, StopRequest, order_of};
use serde_json::{Value, json};

use crate::Anyhow;
use crate::driven::{approval, confirming, judging, record};
use crate::pipe::Pipe;

/// Runs an execution to its end; returns the reason of a stop.
pub(crate) fn carry_out(pipe: Pipe, execution: &mut Execution, request: &StopRequest) -> Anyhow<Option<Stop>> {
    let mut orders: Vec<StepOrder> = Vec::new();
    loop {
        let need = execution.next_need();
        let events = execution.take_events();
        if !events.is_empty() {
            pipe.ask(&record(&events)?, request);
        }
        let question = match need {
            Need::Done => return Ok(None),
            Need::Stopped(stop) => return Ok(Some(stop)),
            Need::Perform(order) | Need::Sense(order) => {
                let sent = order_of(execution.world(), &order);
                orders.push(order);
                json!({"start": sent, "need": "order"})
            }
            Need::Observe => json!({"observe": null, "need": "observe"}),
            Need::Wait => json!({"need": "wait"}),
            Need::Approve(proposal) => approval(execution, &proposal),
            Need::Judge(order) => judging(execution, &order),
            Need::Confirm(unseen) => confirming(&unseen),
            other => json!({"need": format!("{other:?}")}),
        };
        let mut answer = pipe.ask(&question, request);
        // A call that is refused leaves the need as it is: the question stands.
        while let Some(call) = answer["call"].as_str() {
            let refused = calling(execution, &orders, call, &answer)
                .err()
                .map(|error| error.to_string());
            answer = pipe.ask(&json!({"called": refused}), request);
        }
        if request.is_requested() {
            execution.stop("stopped at a request");
        }
    }
}

fn calling(execution: &mut Execution, orders: &[StepOrder], call: &str, answer: &Value) -> Result<(), ExecutionError> {
    let number = answer["order"].as_u64().unwrap_or_default();
    match call {
        "performed" => {
            let order = orders.iter().find(|own| own.number == number);
            let index = answer["outcome"].as_u64().and_then(|own| usize::try_from(own).ok());
            let outcome = order
                .zip(index)
                .and_then(|(own, index)| own.outcomes.get(index).copied());
            execution.performed(number, outcome)
        }
        "failed" => execution.failed(number, "said by the judge"),
        "judged" => execution.judged(number, answer["done"] == true),
        "confirmed" => execution.confirmed(answer["holds"] == true),
        "refuse" => execution.refuse(),
        "observed" => {
            let seen: Observation = serde_json::from_value(answer["observation"].clone()).unwrap_or_default();
            execution.observed(&seen)
        }
        "approve" => match serde_json::from_value::<ProposalId>(answer["id"].clone()) {
            Ok(id) => execution.approve(&id),
            Err(_) => execution.refuse(),
        },
        _ => {
            execution.robot_failed("said by the judge");
            Ok(())
        }
    }
}
