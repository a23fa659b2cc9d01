//! Heartbeats that come back: whether the bridge passes messages on while a goal is under way.
//!
//! A rosbridge that performs goals in the thread of its client keeps every later message until the goal has ended. The robot
//! then hears no heartbeat, stands still, and aborts the goal.

use serde_json::Value;

/// The heartbeats after the beginning of a goal of which one should have come back.
const PATIENCE: u64 = 3;

/// The heartbeats that were sent, and that came back.
#[derive(Debug, Default)]
pub(super) struct Echo {
    sent: u64,
    returned: u64,
}

impl Echo {
    /// Returns the number of the next heartbeat.
    pub(super) fn next(&mut self) -> u64 {
        self.sent += 1;
        self.sent
    }

    /// Notes a heartbeat that came back.
    pub(super) fn receive(&mut self, message: &Value) {
        let number = message.get("data").and_then(Value::as_u64).unwrap_or_default();
        // A robot may be driven by another Longstep, whose numbers mean nothing here.
        if number <= self.sent {
            self.returned = self.returned.max(number);
        }
    }

    /// Returns the mark of a goal that is sent now; none before a first heartbeat came back.
    pub(super) fn mark(&self) -> Option<u64> {
        (self.returned > 0).then_some(self.sent)
    }

    /// Returns how many heartbeats were kept back since a mark, if they were.
    pub(super) fn kept_back(&self, mark: Option<u64>) -> Option<u64> {
        let mark = mark.filter(|mark| self.returned <= *mark)?;
        Some(self.sent - mark).filter(|kept| *kept >= PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn heartbeats_that_do_not_come_back_are_counted() {
        let mut echo = Echo::default();
        echo.next();
        // A bridge that returns none at all says nothing.
        assert_eq!(echo.mark(), None);
        echo.receive(&json!({"data": 1}));
        let mark = echo.mark();
        for expected in [None, None, Some(3), Some(4)] {
            echo.next();
            assert_eq!(echo.kept_back(mark), expected);
        }
        // Neither one of another run nor one from before the goal counts.
        for number in [json!(1), json!(900), json!(null)] {
            echo.receive(&json!({"data": number}));
            assert_eq!(echo.kept_back(mark), Some(4));
        }
        echo.receive(&json!({"data": 2}));
        assert_eq!(echo.kept_back(mark), None);
    }
}
