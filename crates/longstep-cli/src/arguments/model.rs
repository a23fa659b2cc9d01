//! The arguments for language models.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use longstep_llm::{AdapterChoice, Reasoning};

/// The language model and its settings.
#[derive(Debug, Clone, Args)]
pub(crate) struct ModelArguments {
    /// Language model: a name of `longstep model list`, a .gguf file, openai:NAME, azure:DEPLOYMENT,
    /// ollama:NAME, anthropic:NAME, gemini:NAME, URL#NAME, longstep:URL or replay:FILE [default: qwen2.5-coder-1.5b]
    #[arg(long, value_name = "MODEL", env = "LONGSTEP_MODEL", hide_env_values = true)]
    pub(crate) model: Option<String>,
    /// Running `longstep serve`, whose model is used if no model is named: the same as `--model longstep:URL`
    #[arg(long = "server", value_name = "URL", env = "LONGSTEP_SERVER", hide_env_values = true, value_parser = lender)]
    pub(crate) lender: Option<String>,
    /// Adapter of an embedded model, a .gguf file, for one of its tasks (repeatable); `off` for none [default: those of the
    /// catalogue]
    #[arg(long, value_name = "FILE")]
    pub(crate) adapter: Vec<PathBuf>,
    /// Threads of an embedded model [default: the number of physical cores]
    #[arg(long, value_name = "N", env = "LONGSTEP_THREADS", hide_env_values = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Sampling temperature, 0 to 2: 0 always takes the most likely token
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = temperature)]
    pub(crate) temperature: f64,
    /// Nucleus sampling: keep the most likely tokens up to this total probability
    #[arg(long, value_name = "P", value_parser = share)]
    pub(crate) top_p: Option<f64>,
    /// Seed of the sampling; some servers ignore it
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// How much a model on a server may reason before its answer: off, low, medium, high or a number of tokens [default: the
    /// server's choice]
    #[arg(long, value_name = "LIMIT", env = "LONGSTEP_REASONING", hide_env_values = true)]
    pub(crate) reasoning: Option<Reasoning>,
    /// Size of the context in tokens, for prompt and answer [default: the server's value, 8192 for an embedded model]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) context: Option<u32>,
    /// Time limit in seconds for one call to a server, including retries
    #[arg(long, value_name = "SECONDS", env = "LONGSTEP_TIMEOUT", default_value = "600", value_parser = seconds)]
    pub(crate) timeout: Duration,
    /// Longest time in seconds in which a server may send nothing
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    pub(crate) silence: Duration,
    /// Also record all requests and replies in a file; --model replay:FILE replays it
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
}

impl ModelArguments {
    /// The name of the model.
    pub(crate) fn name(&self) -> &str {
        let named = self.model.as_deref().or(self.lender.as_deref());
        named.unwrap_or(longstep_llm::catalogue::DEFAULT)
    }

    /// The adapters of an embedded model.
    pub(crate) fn adapters(&self) -> AdapterChoice {
        match &self.adapter[..] {
            [] => AdapterChoice::Catalogue,
            [one] if one.as_os_str() == "off" => AdapterChoice::Off,
            files => AdapterChoice::Files(files.to_vec()),
        }
    }
}

/// Returns the model of the server at an address.
fn lender(text: &str) -> Result<String, String> {
    if text.starts_with("http://") || text.starts_with("https://") {
        Ok(format!("longstep:{text}"))
    } else {
        Err("must be the address that `longstep serve` prints, such as http://127.0.0.1:8765".to_owned())
    }
}

fn temperature(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (0.0..=2.0)
        .contains(&value)
        .then_some(value)
        .ok_or_else(|| "must be from 0 to 2".to_owned())
}

pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    /// Upper limit of a timeout.
    const WEEK: f64 = 604_800.0;
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let duration = (value > 0.0 && value <= WEEK).then(|| Duration::try_from_secs_f64(value));
    match duration {
        Some(Ok(duration)) if !duration.is_zero() => Ok(duration),
        _ => Err("must be above 0 and at most 604800 (one week)".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (value > 0.0 && value <= 1.0)
        .then_some(value)
        .ok_or_else(|| "must be above 0 and at most 1".to_owned())
}

#[derive(Debug, Subcommand)]
pub(crate) enum ModelCommand {
    /// List the models of the catalogue, and which of them are downloaded
    List,
    /// Download a model of the catalogue into the cache
    Pull {
        /// Name in the catalogue
        name: String,
        /// Use this file instead of downloading one
        #[arg(long, value_name = "FILE")]
        from: Option<PathBuf>,
    },
    /// Print the path of a model's file
    Path {
        /// Name in the catalogue
        name: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_positive_and_finite() {
        for (text, expected) in [("600", Some(600.0)), ("0.5", Some(0.5)), ("604800", Some(604_800.0))] {
            assert_eq!(seconds(text).ok().map(|time| time.as_secs_f64()), expected, "{text}");
        }
        for text in ["0", "-1", "1e-30", "604801", "inf", "NaN", "", "soon"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
