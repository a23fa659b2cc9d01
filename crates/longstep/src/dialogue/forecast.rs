//! The tokens that a request of the direct strategy will take, known before it is sent.

use super::PartCost;
use crate::report::ForecastAnswer;

/// Tokens of a correction: the violations of a plan as sentences, with the request for a new one.
const CORRECTION_TOKENS: u64 = 400;

/// Share of the step budget that a usual plan needs: ten steps of the sixty.
const USUAL_SHARE: u64 = 6;

/// The tokens of a request for a whole plan, of its answer, and of a round of correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Forecast {
    /// Tokens of the prompt.
    pub prompt: u64,
    /// Tokens of a usual answer: both environments and ten steps.
    pub usual_answer: u64,
    /// Most tokens of the answer.
    pub answer: u64,
    /// Tokens of prompt and answer together if the plan has to be corrected once: without the history, with the first
    /// answer at its longest.
    pub correction: u64,
    /// The model's context length, if known.
    pub context: Option<u64>,
}

impl Forecast {
    /// Computes the forecast from the parts of the prompt and the budgets of the answer.
    pub(super) fn new(costs: &[PartCost], lists: u64, steps: u64, context: Option<u64>) -> Self {
        let prompt: u64 = costs.iter().map(|cost| cost.tokens).sum();
        let history: u64 = costs
            .iter()
            .filter(|cost| cost.name == "history")
            .map(|cost| cost.tokens)
            .sum();
        let answer = lists + steps;
        Self {
            prompt,
            usual_answer: lists + steps / USUAL_SHARE,
            answer,
            correction: prompt - history + answer + CORRECTION_TOKENS + answer,
            context,
        }
    }

    /// Returns false if a round of correction may exceed the context.
    pub fn correction_fits(&self) -> bool {
        self.context.is_none_or(|context| self.correction <= context)
    }

    /// Returns the forecast with an estimate of the time, as it is printed.
    pub fn answer(&self, seconds: Option<f64>) -> ForecastAnswer {
        ForecastAnswer {
            prompt_tokens: self.prompt,
            answer_tokens: self.usual_answer,
            context: self.context,
            correction_fits: self.correction_fits(),
            seconds,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forecast_of_a_correction_includes_both_answers() {
        let cost = |name, tokens| PartCost { name, tokens };
        let costs = [cost("role", 100), cost("history", 1000), cost("query", 50)];
        for (context, fits) in [(None, true), (Some(2950), true), (Some(2949), false)] {
            let forecast = Forecast::new(&costs, 600, 600, context);
            assert_eq!(
                (forecast.prompt, forecast.usual_answer, forecast.answer),
                (1150, 700, 1200)
            );
            assert_eq!(
                (forecast.correction, forecast.correction_fits()),
                (2950, fits),
                "{context:?}"
            );
        }
    }
}
