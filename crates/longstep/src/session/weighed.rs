//! The choice between the answers to an instruction and to its retelling.
//!
//! Two readings of one wish rarely go wrong in the same way. When an instruction has been retold, the answers to both are
//! weighed for both, and only an answer that is likely for both and ahead of the others is acted on.

use super::pending::{Asking, Weighed, What};
use super::retold::Open;
use super::{Session, Stage, Turn};
use crate::dialogue::{GoalDialogue, Prepared, PromptError, ReadingOf, TokenCounter, Weighing, plain_line};
use crate::goal::{self, Mentions, Understanding};

impl Session {
    /// Weighs the answers to an instruction and to its retelling. If that is not possible, what was open before is open again. The
    /// parts of an instruction that was split have no wordings to compare.
    pub(super) fn weigh(&mut self, turn: Turn) {
        let is_weighed = turn.readings.iter().any(|own| own.of == ReadingOf::Weighing);
        let may_weigh = self.settings.weighing && turn.is_whole() && !is_weighed;
        let retelling = turn.retelling().filter(|_| may_weigh);
        let wordings = retelling.map(|retelling| [plain_line(&turn.instruction), plain_line(retelling)]);
        match wordings.and_then(|wordings| Weighing::new(&self.world, wordings, turn.wishes())) {
            Some(weighing) => {
                let weighed = Weighed {
                    weighing,
                    dialogue: None,
                };
                self.stage = Stage::Asking(turn, Asking::new(What::Weighing(Box::new(weighed))));
            }
            None => self.take_back(turn),
        }
    }

    /// Returns the request for the likelihood of the next answer.
    pub(super) fn weighing_request(
        &self,
        turn: &Turn,
        weighed: &mut Weighed,
        counter: &mut dyn TokenCounter,
    ) -> Result<Prepared, PromptError> {
        let (wording, answer) = weighed.weighing.next();
        let known = weighed.dialogue.take().filter(|(own, _)| own == wording);
        let dialogue = match known {
            Some((_, dialogue)) => dialogue,
            None => {
                let input = self.goal_input(turn, &self.world, wording);
                Box::new(GoalDialogue::fitted(input, self.model.context, counter)?.dialogue)
            }
        };
        let prepared = self.short_request(dialogue.weighing(answer), counter);
        weighed.dialogue = Some((wording.to_owned(), dialogue));
        prepared
    }

    /// Goes on after an answer was weighed: with the next one, or with the likeliest of all.
    pub(super) fn weighed(&mut self, mut turn: Turn, weighed: Box<Weighed>) {
        if !weighed.weighing.is_done() {
            self.stage = Stage::Asking(turn, Asking::new(What::Weighing(weighed)));
            return;
        }
        let reading = weighed.weighing.reading();
        let is_guess = reading.doubt.is_some();
        let goal = reading
            .candidates
            .first()
            .and_then(|best| goal::parse(&self.world, &best.text).ok());
        turn.readings.push(reading);
        let Some(goal) = goal else {
            return self.take_back(turn);
        };
        if is_guess {
            turn.ask_instead(goal::guess(&self.world, &goal));
            return self.take_back(turn);
        }
        let mentions = Mentions::of(&self.world, turn.words());
        match goal::understand_mentions(&self.world, &mentions, goal) {
            Understanding::Goal(goal) | Understanding::Doubtful(goal) => self.pursue_within(turn, goal),
            Understanding::Which(question) | Understanding::Question(question) => {
                self.leave_open(turn, Open::Which(question));
            }
        }
    }
}
