//! The thread that owns a model and answers requests.

mod see;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use llama_cpp_2::model::params::LlamaModelParams;
use llama_cpp_2::model::{LlamaLoraAdapter, LlamaModel};
use llama_cpp_2::token::LlamaToken;
use llguidance::Matcher;
use longstep::dialogue::{ChatRequest, Constraint, Finish, Likelihood, Message, Reply, Role, Task, Usage};

use super::adapter::Adapter;
use super::blocks::Blocks;
use super::contexts::{Adapted, Contexts};
use super::engine::backend;
use super::file::not_loaded;
use super::grammar::Grammars;
use super::prompt::{PromptTokens, Template};
use super::sample::{Sampler, Score};
use super::state::States;
use super::vision::{PictureTokens, Vision};
use super::{Count, Job, WorkerReport};
use crate::{ModelError, Progress, Sampling};

/// A state is saved if at least this many tokens were computed: computing fewer is faster than saving.
const WORTH_SAVING: usize = 64;

/// Settings of a worker.
pub(super) struct Setting {
    pub(super) name: String,
    pub(super) path: PathBuf,
    pub(super) identity: String,
    pub(super) threads: usize,
    pub(super) context_tokens: u32,
    pub(super) sampling: Sampling,
    pub(super) states: PathBuf,
    /// The file of the model's projector.
    pub(super) projector: Option<PathBuf>,
    /// The adapters, at most one for a task.
    pub(super) adapters: Vec<Adapter>,
}

/// Loads the model, sends the result to `ready`, and processes jobs until all senders are gone.
pub(super) fn run(setting: &Setting, ready: &Sender<Result<(), ModelError>>, jobs: &Receiver<Job>) {
    let refuse = |error: ModelError| {
        // The receiver may be gone already.
        let _ = ready.send(Err(error));
    };
    let mut model = match load(setting) {
        Ok(model) => model,
        Err(reason) => return refuse(not_loaded(&setting.path, &reason)),
    };
    let loaded = setting.adapters.iter().map(|adapter| adapter.load(&mut model));
    let adapters: Vec<LlamaLoraAdapter> = match loaded.collect() {
        Ok(adapters) => adapters,
        Err(error) => return refuse(error),
    };
    let model = Arc::new(model);
    let vision = setting.projector.as_deref();
    let vision = match vision
        .map(|path| Vision::load(path, &model, setting.threads))
        .transpose()
    {
        Ok(vision) => vision,
        Err(error) => return refuse(error),
    };
    let mut worker = match Worker::new(setting, &model, vision, adapters) {
        Ok(worker) => worker,
        Err(reason) => return refuse(not_loaded(&setting.path, &reason)),
    };
    if ready.send(Ok(())).is_err() {
        return;
    }
    while let Ok(job) = jobs.recv() {
        // The caller may have given up; the worker goes on with the next job.
        match job {
            Job::Chat(request, events) => {
                let mut tell = |progress| events.send(WorkerReport::Progress(progress)).is_ok();
                let answer = worker.answer(&request, &mut tell);
                let _ = events.send(WorkerReport::Done(answer));
            }
            Job::Count(message, answer) => {
                if let Ok(count) = worker.count(&message) {
                    let _ = answer.send(count);
                }
            }
        }
    }
}

fn load(setting: &Setting) -> Result<LlamaModel, String> {
    let parameters = LlamaModelParams::default().with_use_mmap(true);
    LlamaModel::load_from_file(backend()?, &setting.path, &parameters)
        .map_err(|_| "it is damaged, incomplete, or of an unknown kind".into())
}

/// The last answer, which the next request may continue.
struct Turn {
    task: Task,
    messages: Vec<Message>,
    /// The text of the answer so far.
    answer: String,
    /// Prompt and answer in the tokens that the engine holds.
    prompt: PromptTokens,
}

struct Worker<'model> {
    name: &'model str,
    model: &'model LlamaModel,
    /// The model's eyes, if the user has named a projector.
    vision: Option<Vision>,
    contexts: Contexts<'model>,
    template: Template,
    grammars: Grammars,
    sampler: Sampler,
    limit: usize,
    last: Option<Turn>,
}

/// Receives progress; returns `false` if the caller is gone.
type Tell<'a> = dyn FnMut(Progress) -> bool + 'a;

impl<'model> Worker<'model> {
    fn new(
        setting: &'model Setting,
        model: &'model Arc<LlamaModel>,
        vision: Option<Vision>,
        adapters: Vec<LlamaLoraAdapter>,
    ) -> Result<Self, String> {
        let size = setting.context_tokens.min(model.n_ctx_train()).max(1);
        let states = |identity: String| States::new(setting.states.clone(), identity, size);
        let adapted = setting.adapters.iter().zip(adapters).map(|(own, adapter)| Adapted {
            task: own.task,
            adapter,
            states: states(format!("{} {}", setting.identity, own.identity)),
        });
        let plain = states(setting.identity.clone());
        Ok(Self {
            name: &setting.name,
            model,
            vision,
            contexts: Contexts::new(model, size, setting.threads, adapted.collect(), plain)?,
            template: Template::of(model)?,
            grammars: Grammars::new(model)?,
            sampler: Sampler::new(&setting.sampling),
            limit: size as usize,
            last: None,
        })
    }

    /// Tokens of a message inside a conversation, and of the conversation around it.
    fn count(&self, message: &Message) -> Result<Count, String> {
        let tokens = |messages: Vec<Message>| -> Result<u64, String> {
            let request = ChatRequest {
                task: Task::Other,
                messages,
                fixed: 0,
                answer_so_far: String::new(),
                constraint: Constraint::Free,
                max_tokens: 0,
            };
            Ok(self.template.tokens(self.model, &request)?.tokens.len() as u64)
        };
        let empty = || Message::new(Role::User, "");
        let (one, two) = (tokens(vec![empty()])?, tokens(vec![empty(), empty()])?);
        let with = match message.role {
            Role::System => tokens(vec![message.clone(), empty()])?,
            Role::User | Role::Assistant => tokens(vec![empty(), message.clone()])?,
        };
        let pictures = self.pictures(std::slice::from_ref(message));
        let pictures = pictures.map_err(|error| error.to_string())?;
        Ok(Count {
            message: with.saturating_sub(one) + pictures.iter().map(|own| own.tokens() as u64).sum::<u64>(),
            frame: (2 * one).saturating_sub(two),
        })
    }

    fn answer(&mut self, request: &ChatRequest, tell: &mut Tell<'_>) -> Result<Reply, ModelError> {
        let pictures = self.pictures(&request.messages)?;
        let (prompt, continued) = self.prompt(request)?;
        let total = prompt.tokens.len() + pictures.iter().map(PictureTokens::tokens).sum::<usize>();
        if prompt.tokens.is_empty() {
            return Err(self.unsupported("it contains no message".into()));
        }
        let tokens = total + request.max_tokens as usize;
        if tokens > self.limit {
            let limit = self.limit;
            return Err(ModelError::TooLong { tokens, limit });
        }
        let matcher = self.grammars.matcher(&request.constraint)?;
        let chosen = self.contexts.choose(request.task, &prompt.tokens, prompt.fixed);
        chosen.map_err(|reason| self.failed(reason))?;
        let cached = if !pictures.is_empty() {
            self.see(&prompt, &pictures, total, tell)?
        } else if continued {
            self.go_on(&prompt.tokens)?
        } else {
            self.read(&prompt, prompt.tokens.len(), total, tell)?
        };
        self.sampler.begin();
        let mut written = Written::default();
        let is_scored = matches!(request.constraint, Constraint::Lark(_));
        let most = request.max_tokens as usize;
        let mut forks = Vec::new();
        let mut matcher = matcher;
        let mut finish = self.write(matcher.as_mut(), most, &mut written, &mut forks, tell)?;
        let mut generated = written.tokens.len();
        let mut ahead = None;
        if let Some(matcher) = matcher
            .as_mut()
            .filter(|_| request.task == Task::Goals && pictures.is_empty())
        {
            let mut search = Search {
                matcher,
                most,
                forks,
                begin: prompt.tokens.len(),
            };
            let found = self.search(&mut search, &mut written, &mut finish, tell)?;
            (generated, ahead) = (generated + found.generated, found.ahead);
        }
        let text = String::from_utf8_lossy(&written.bytes).into_owned();
        let usage = Usage {
            calls: 1,
            prompt_tokens: total as u64,
            cached_tokens: cached as u64,
            completion_tokens: generated as u64,
        };
        // Behind pictures the engine holds more than tokens; such an answer is computed again to go on.
        self.last = pictures.is_empty().then(|| Turn {
            task: request.task,
            messages: request.messages.clone(),
            answer: request.answer_so_far.clone() + &text,
            prompt: PromptTokens {
                tokens: [prompt.tokens, written.tokens].concat(),
                fixed: prompt.fixed,
                shared: prompt.shared,
                pictures: Vec::new(),
            },
        });
        Ok(Reply {
            text,
            finish,
            usage,
            likelihood: is_scored.then(|| Likelihood {
                is_trained: self.contexts.is_adapted(),
                ahead,
                ..written.score.likelihood()
            }),
        })
    }

    /// Returns the tokens of a request and whether it continues the last answer. Such a request keeps the tokens of
    /// that answer: a new tokenization of its text may cut it differently, and the model would continue from tokens
    /// that it never wrote.
    fn prompt(&mut self, request: &ChatRequest) -> Result<(PromptTokens, bool), ModelError> {
        if let Some(turn) = self.last.take()
            && !request.answer_so_far.is_empty()
            && turn.task == request.task
            && turn.answer == request.answer_so_far
            && turn.messages == request.messages
        {
            return Ok((turn.prompt, true));
        }
        let prompt = self
            .template
            .tokens(self.model, request)
            .map_err(|reason| self.unsupported(reason))?;
        Ok((prompt, false))
    }

    /// Computes the tokens of its own answer that are not in the cache; returns how many came from the cache.
    fn go_on(&mut self, tokens: &[LlamaToken]) -> Result<usize, ModelError> {
        let engine = self.contexts.engine_mut();
        let known = engine.known(tokens).min(tokens.len().saturating_sub(1));
        let known = engine.keep(known);
        let new = tokens.get(known..).unwrap_or_default();
        let appended = engine.append(new, &mut |_, _| {});
        appended.map_err(|reason| self.failed(reason))?;
        Ok(known)
    }

    /// Computes what is not in the cache of the first `until` tokens of a prompt; returns how many came from the cache.
    /// The whole prompt has `total` tokens, with its pictures.
    fn read(
        &mut self,
        prompt: &PromptTokens,
        until: usize,
        total: usize,
        tell: &mut Tell<'_>,
    ) -> Result<usize, ModelError> {
        let tokens = prompt.tokens.get(..until).unwrap_or(&prompt.tokens);
        let fixed = prompt.fixed.min(tokens.len());
        let shared = prompt.shared.min(tokens.len());
        let state = tokens.get(..fixed).filter(|fixed| !fixed.is_empty());
        let state = state.map(|fixed| self.contexts.states().file(fixed));
        let engine = self.contexts.engine_mut();
        if let Some(state) = &state
            && engine.known(tokens) < fixed
        {
            engine.restore(fixed, |context| state.load(context));
        }
        let blocks = Blocks::of(tokens.len(), fixed, shared);
        let blocks = if until < total { blocks.followed() } else { blocks };
        let known = engine.begin(tokens, &blocks);
        let mut tell_done = |done| tell(Progress::ReadingPrompt { done, total });
        let outcome = engine.read(tokens, &blocks, shared, &mut tell_done);
        outcome.map_err(|reason| failed(self.name, reason))?;
        // The last line, an instruction, is not saved.
        if let Some(state) = state
            && shared.saturating_sub(known) > WORTH_SAVING
        {
            let (context, tokens) = engine.saved();
            if let Err(reason) = state.save(context, tokens) {
                tell(Progress::Warning(format!(
                    "the state of the model could not be saved; the next start will be slower: {reason}"
                )));
            }
        }
        let mut tell_done = |done| tell(Progress::ReadingPrompt { done, total });
        let outcome = engine.read(tokens, &blocks, tokens.len(), &mut tell_done);
        outcome.map_err(|reason| failed(self.name, reason))?;
        Ok(known)
    }

    /// Generates an answer, or the rest of one, of tokens that the grammar allows. Notes what else could have been chosen.
    fn write(
        &mut self,
        mut matcher: Option<&mut Matcher>,
        most: usize,
        written: &mut Written,
        forks: &mut Vec<Fork>,
        tell: &mut Tell<'_>,
    ) -> Result<Finish, ModelError> {
        loop {
            if written.tokens.len() >= most {
                return Ok(Finish::Length);
            }
            let (next, fork) = self.next(matcher.as_deref_mut(), written)?;
            forks.extend(fork);
            if let Some(finish) = self.put(matcher.as_deref_mut(), next, most, written, tell)? {
                return Ok(finish);
            }
        }
    }

    /// Adds a token and those that the grammar forces behind it; returns how the answer ended, if it did.
    fn put(
        &mut self,
        matcher: Option<&mut Matcher>,
        next: LlamaToken,
        most: usize,
        written: &mut Written,
        tell: &mut Tell<'_>,
    ) -> Result<Option<Finish>, ModelError> {
        if self.model.vocab().is_eog(next) {
            return Ok(Some(Finish::Stop));
        }
        let before = written.tokens.len();
        written.push(self.model, next);
        let mut complete = false;
        if let Some(matcher) = matcher {
            let forced = follow(matcher, next).map_err(|reason| self.failed(reason))?;
            complete = matcher.is_stopped();
            for token in forced {
                if self.model.vocab().is_eog(token) {
                    complete = true;
                    break;
                }
                if written.tokens.len() >= most {
                    return Ok(Some(Finish::Length));
                }
                written.push(self.model, token);
            }
        }
        let tokens = written.tokens.len();
        if !tell(Progress::Writing { tokens }) {
            return Err(self.failed("it was stopped".into()));
        }
        let new = written.tokens.get(before..).unwrap_or_default();
        // The last token needs no computation, unless forced tokens are to be scored.
        if !complete || new.len() > 1 {
            let score = &mut written.score;
            let engine = self.contexts.engine_mut();
            let appended = engine.append(new, &mut |token, logits| score.force(logits, token));
            appended.map_err(|reason| self.failed(reason))?;
        }
        Ok(complete.then_some(Finish::Stop))
    }

    /// Looks for an answer that is likelier than the one that was written token by token: under a grammar, the likeliest next token can
    /// begin what the model would never have said. An answer that is likely by itself is left as it is.
    ///
    /// An answer is no likelier than its beginning, so the search goes on from the likeliest other beginning, as long as that is likelier
    /// than the answer so far.
    fn search(
        &mut self,
        search: &mut Search<'_>,
        best: &mut Written,
        finish: &mut Finish,
        tell: &mut Tell<'_>,
    ) -> Result<Found, ModelError> {
        let mut found = Found::default();
        // The likelihood of the likeliest other answer.
        let mut other = f64::NEG_INFINITY;
        if best.score.total() > SURE || *finish != Finish::Stop {
            return Ok(found);
        }
        for _ in 0..TRIES {
            let least = best.score.total();
            let likeliest = search.forks.iter().enumerate();
            let likeliest = likeliest.max_by(|(_, one), (_, other)| one.likelihood.total_cmp(&other.likelihood));
            let Some(place) = likeliest
                .filter(|(_, fork)| fork.likelihood > least)
                .map(|(place, _)| place)
            else {
                break;
            };
            let fork = search.forks.swap_remove(place);
            let engine = self.contexts.engine_mut();
            let begin = search.begin + fork.written.tokens.len();
            if engine.keep(begin.min(engine.length())) != begin {
                // A model whose memory cannot be cut.
                break;
            }
            let taken: Vec<u32> = fork
                .written
                .tokens
                .iter()
                .map(|token| token.0.cast_unsigned())
                .collect();
            let reset = search
                .matcher
                .reset()
                .and_then(|()| search.matcher.try_consume_tokens(&taken));
            if !reset.is_ok_and(|count| count == taken.len()) {
                break;
            }
            let mut written = fork.written;
            written.score = fork.score;
            let most = search.most;
            let ended = match self.put(Some(search.matcher), fork.token, most, &mut written, tell)? {
                Some(ended) => ended,
                None => self.write(Some(search.matcher), most, &mut written, &mut search.forks, tell)?,
            };
            found.generated += written.tokens.len() - taken.len();
            if ended == Finish::Stop {
                let (one, two) = (written.score.total(), best.score.total());
                other = other.max(one.min(two));
                if one > two {
                    *best = written;
                }
            }
        }
        // What was not looked at is no likelier than its beginning.
        let rest = search.forks.iter().map(|fork| fork.likelihood);
        let other = rest.fold(other, f64::max);
        #[expect(clippy::cast_possible_truncation, reason = "far from the bounds")]
        let ahead = ((best.score.total() - other) * 1000.0).round() as i64;
        found.ahead = Some(ahead);
        Ok(found)
    }

    /// Samples the next token, and counts it in the score if there is a grammar. Returns what else could have been chosen.
    fn next(
        &mut self,
        matcher: Option<&mut Matcher>,
        written: &mut Written,
    ) -> Result<(LlamaToken, Option<Fork>), ModelError> {
        let logits = self.contexts.engine().logits();
        let mut fork = None;
        let chosen = match matcher {
            None => self
                .sampler
                .choose(logits, |consider| (0..logits.len()).for_each(consider)),
            Some(matcher) => {
                let allowed = matcher.compute_mask_or_eos();
                let allowed = allowed.map_err(|error| failed(self.name, error.to_string()))?;
                let chosen = self
                    .sampler
                    .choose(logits, |consider| allowed.iter_set_entries(consider));
                let mut other: Option<usize> = None;
                allowed.iter_set_entries(|index| {
                    let is_likelier = |known: usize| logits.get(index) > logits.get(known);
                    if Some(index) != chosen && index < logits.len() && other.is_none_or(is_likelier) {
                        other = Some(index);
                    }
                });
                fork = other.and_then(|other| Fork::new(written, logits, other));
                written.score.count(logits, chosen);
                chosen
            }
        };
        let chosen = chosen.and_then(|index| i32::try_from(index).ok()).map(LlamaToken);
        let chosen = chosen.ok_or_else(|| self.failed("the grammar allows no token".into()))?;
        Ok((chosen, fork))
    }

    fn unsupported(&self, reason: String) -> ModelError {
        ModelError::Unsupported {
            model: self.name.to_owned(),
            reason,
        }
    }

    fn failed(&self, reason: String) -> ModelError {
        failed(self.name, reason)
    }
}

fn failed(name: &str, reason: String) -> ModelError {
    ModelError::Engine {
        model: name.to_owned(),
        reason,
    }
}

/// Advances the matcher by a token; returns the tokens that the grammar forces next.
fn follow(matcher: &mut Matcher, token: LlamaToken) -> Result<Vec<LlamaToken>, String> {
    matcher
        .consume_token(token.0.cast_unsigned())
        .map_err(|error| error.to_string())?;
    if matcher.is_stopped() {
        return Ok(Vec::new());
    }
    let forced = matcher.consume_ff_tokens();
    // A matcher that failed counts as stopped, too.
    if let Some(error) = matcher.get_error() {
        return Err(error);
    }
    Ok(forced
        .into_iter()
        .map(|token| LlamaToken(token.cast_signed()))
        .collect())
}

/// Maximum number of further answers that are looked for.
const TRIES: usize = 6;

/// The likelihood of an answer, in nats, above which no other one is looked for.
const SURE: f64 = -0.5;

/// The result of a search.
#[derive(Default)]
struct Found {
    /// The number of tokens that it took.
    generated: usize,
    /// By how many thousandths of a nat the answer is likelier than every other one, at least.
    ahead: Option<i64>,
}

/// The search for a likelier answer.
struct Search<'a> {
    matcher: &'a mut Matcher,
    most: usize,
    /// The choices that were not made.
    forks: Vec<Fork>,
    /// The number of tokens of the prompt.
    begin: usize,
}

/// A place at which an answer could have gone on with another token.
struct Fork {
    /// The answer before the token.
    written: Written,
    token: LlamaToken,
    /// The score with the token.
    score: Score,
    /// The likelihood of the answer up to the token.
    likelihood: f64,
}

impl Fork {
    fn new(written: &Written, logits: &[f32], token: usize) -> Option<Self> {
        let mut score = written.score.clone();
        score.count(logits, Some(token));
        Some(Self {
            written: written.clone(),
            token: LlamaToken(i32::try_from(token).ok()?),
            likelihood: score.total(),
            score,
        })
    }
}

/// The generated part of an answer.
#[derive(Clone, Default)]
struct Written {
    tokens: Vec<LlamaToken>,
    bytes: Vec<u8>,
    score: Score,
}

impl Written {
    fn push(&mut self, model: &LlamaModel, token: LlamaToken) {
        self.tokens.push(token);
        self.bytes.extend(model.vocab().token_to_piece(token, false, None));
    }
}
