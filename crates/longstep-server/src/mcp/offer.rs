//! Plans that were shown, by the short ids with which a client asks to carry them out.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::id::{self, SessionId};
use crate::problem::{Problem, ProblemKind};

/// The most offers that are kept; the oldest leave first.
const KEPT: usize = 4_096;

/// The number of random bytes of an id: short enough for a model to repeat.
const LENGTH: usize = 6;

/// A plan that was shown to a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Offer {
    /// The session of the plan.
    pub(super) session: SessionId,
    /// The hash of the plan.
    pub(super) plan: String,
    /// The hash of the world in which the robot was.
    pub(super) world: String,
}

#[derive(Debug)]
struct Kept {
    id: String,
    offer: Offer,
    expires: Instant,
    is_used: bool,
}

/// The plans that were shown. An id counts once and until a time.
#[derive(Debug)]
pub(super) struct Offers {
    kept: Mutex<VecDeque<Kept>>,
    lifetime: Duration,
}

impl Offers {
    pub(super) fn new(lifetime: Duration) -> Self {
        Self {
            kept: Mutex::default(),
            lifetime,
        }
    }

    fn kept(&self) -> MutexGuard<'_, VecDeque<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the id of a plan: that of an equal offer which still counts, with a new time, or a new one.
    pub(super) fn add(&self, offer: Offer) -> Result<String, Problem> {
        let now = Instant::now();
        let expires = now + self.lifetime;
        let mut kept = self.kept();
        let equal = kept
            .iter_mut()
            .find(|own| own.offer == offer && !own.is_used && now < own.expires);
        if let Some(equal) = equal {
            equal.expires = expires;
            return Ok(equal.id.clone());
        }
        if kept.len() >= KEPT {
            kept.pop_front();
        }
        let id = format!("plan-{}", id::random(LENGTH)?);
        kept.push_back(Kept {
            id: id.clone(),
            offer,
            expires,
            is_used: false,
        });
        Ok(id)
    }

    /// Returns the offer with an id, if it still counts.
    ///
    /// # Errors
    ///
    /// There is none, it was used, or its time is over.
    pub(super) fn find(&self, id: &str) -> Result<Offer, Problem> {
        let kept = self.kept();
        let found = kept.iter().find(|own| own.id == id).ok_or_else(|| unknown(id))?;
        found.refusal().map_or(Ok(found.offer.clone()), Err)
    }

    /// Uses an id: of many callers, one succeeds.
    ///
    /// # Errors
    ///
    /// As [`Offers::find`].
    pub(super) fn take(&self, id: &str) -> Result<(), Problem> {
        let mut kept = self.kept();
        let found = kept.iter_mut().find(|own| own.id == id).ok_or_else(|| unknown(id))?;
        match found.refusal() {
            Some(problem) => Err(problem),
            None => {
                found.is_used = true;
                Ok(())
            }
        }
    }

    /// Gives an id back that was used for nothing.
    pub(super) fn give_back(&self, id: &str) {
        if let Some(found) = self.kept().iter_mut().find(|own| own.id == id) {
            found.is_used = false;
        }
    }
}

impl Kept {
    fn refusal(&self) -> Option<Problem> {
        let (message, hint) = if self.is_used {
            (
                format!("`{}` was used already", self.id),
                "a plan_id starts one run; call `run_status` for that run, or `plan` for another plan",
            )
        } else if Instant::now() >= self.expires {
            (
                format!("`{}` has expired", self.id),
                "call `explain` to look at the plan again; it returns a new plan_id",
            )
        } else {
            return None;
        };
        Some(Problem::conflict(message).hint(hint))
    }
}

fn unknown(id: &str) -> Problem {
    Problem::new(ProblemKind::Missing, format!("there is no plan_id `{id}`"))
        .hint("use the plan_id that `plan`, `revise` or `explain` returned")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(plan: &str) -> Offer {
        Offer {
            session: SessionId::parse("s").unwrap(),
            plan: plan.to_owned(),
            world: "w".to_owned(),
        }
    }

    #[test]
    fn id_counts_once_and_until_a_time() {
        let offers = Offers::new(Duration::from_secs(60));
        let id = offers.add(offer("p")).unwrap();
        assert_eq!(offers.add(offer("p")).unwrap(), id);
        assert_ne!(offers.add(offer("q")).unwrap(), id);
        assert_eq!(offers.find(&id).unwrap(), offer("p"));
        offers.take(&id).unwrap();
        for refused in [offers.find(&id).unwrap_err(), offers.take(&id).unwrap_err()] {
            assert!(refused.message.contains("used already"), "{refused}");
        }
        offers.give_back(&id);
        assert!(offers.find(&id).is_ok());
        let short = Offers::new(Duration::ZERO);
        let id = short.add(offer("p")).unwrap();
        assert!(short.find(&id).unwrap_err().message.contains("expired"));
        assert!(short.find("plan-1").unwrap_err().message.contains("no plan_id"));
    }

    #[test]
    fn id_is_taken_by_one_of_many() {
        let offers = Offers::new(Duration::from_secs(60));
        let id = offers.add(offer("p")).unwrap();
        let taken = std::thread::scope(|scope| {
            let takers: Vec<_> = (0..8).map(|_| scope.spawn(|| offers.take(&id).is_ok())).collect();
            takers
                .into_iter()
                .filter_map(|taker| taker.join().ok())
                .filter(|taken| *taken)
                .count()
        });
        assert_eq!(taken, 1);
    }

    #[test]
    fn oldest_offers_leave_first() {
        let offers = Offers::new(Duration::from_secs(60));
        let first = offers.add(offer("first")).unwrap();
        for number in 0..KEPT {
            offers.add(offer(&number.to_string())).unwrap();
        }
        assert!(offers.find(&first).is_err());
        assert_eq!(offers.kept().len(), KEPT);
    }
}
