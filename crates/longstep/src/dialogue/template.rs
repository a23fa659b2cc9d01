//! Rendering of untrusted prompt templates within bounds.
//!
//! A domain's `prompt/` folder may come from a third party. Rendering has a bounded number of steps ([`STEPS`]) and a
//! bounded output ([`GROWTH`]). A step limit alone does not bound memory: each `{% set s = s ~ s %}` doubles a text.
//! Operations that build texts or lists are therefore rejected before rendering, and filters that build texts count
//! their bytes. Variables, conditions, loops over given lists and a few filters remain, which suffices for prompts.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use minijinja::machinery::{Token, tokenize};
use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, Error, ErrorKind, UndefinedBehavior, Value, tests};

use crate::effort;

/// Maximum steps of one rendering. The longest shipped template takes about 1,000.
const STEPS: u64 = 200_000;

/// Maximum size of the output and of all texts that filters build, in bytes beyond four times the input.
const GROWTH: usize = 1 << 20;

/// Maximum size of a template's source, in bytes.
const SOURCE: usize = 256 << 10;

/// The line of an error, from 1, and its reason.
pub(super) type Broken = (u32, String);

/// Renders a template; `given` is the size of the variables' texts in bytes.
///
/// # Errors
///
/// The template is invalid or exceeds a bound.
pub(super) fn render(source: &str, variables: Value, given: usize) -> Result<String, Broken> {
    if source.len() > SOURCE {
        return Err((1, format!("the template is longer than {} KiB", SOURCE >> 10)));
    }
    effort::spend(source.len());
    refuse_growth(source)?;
    let room = GROWTH.saturating_add(given.saturating_mul(4));
    let environment = environment(room);
    let template = environment
        .template_from_str(source)
        .map_err(|error| broken(&error, room))?;
    let mut text = Bounded {
        bytes: Vec::new(),
        room,
    };
    let rendered = template.render_captured_to(variables, &mut text).map(drop);
    effort::spend(text.bytes.len());
    rendered.map_err(|error| broken(&error, room))?;
    String::from_utf8(text.bytes).map_err(|_| (1, "the rendered text is not UTF-8".to_owned()))
}

/// Rejects constructs that build values: operators on texts and lists, list and map literals, slices, `set` and
/// `filter` blocks, and recursive loops.
fn refuse_growth(source: &str) -> Result<(), Broken> {
    let mut before_block = false;
    for token in tokenize(source, false, SyntaxConfig::default()) {
        // The parser reports an invalid token with its position.
        let Ok((token, span)) = token else { return Ok(()) };
        let refused = match &token {
            Token::Tilde => Some("`~`"),
            Token::Plus => Some("`+`"),
            Token::Mul | Token::Pow => Some("`*`"),
            Token::Comma => Some("`,`"),
            Token::Colon => Some("`:`"),
            Token::BraceOpen => Some("`{`"),
            Token::Ident("recursive") => Some("`recursive`"),
            Token::Ident("endset") if before_block => Some("a `set` block"),
            Token::Ident("filter") if before_block => Some("a `filter` block"),
            _ => None,
        };
        if let Some(refused) = refused {
            let allowed = "variables, `if`, `for`, `set name = value` and filters are allowed";
            return Err((
                span.start_line.into(),
                format!("a prompt template cannot have {refused}: {allowed}"),
            ));
        }
        before_block = matches!(token, Token::BlockStart);
    }
    Ok(())
}

/// Describes an error of the template engine.
fn broken(error: &Error, room: usize) -> Broken {
    let message = match error.kind() {
        ErrorKind::OutOfFuel => format!("the template takes more than {STEPS} steps to render"),
        ErrorKind::WriteFailure => format!("the rendered text is longer than {room} bytes"),
        _ => error.detail().map_or_else(|| error.to_string(), str::to_owned),
    };
    (error.line().unwrap_or(1) as u32, message)
}

/// A buffer with a maximum size in bytes.
struct Bounded {
    bytes: Vec<u8>,
    room: usize,
}

impl io::Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.bytes.len() + bytes.len() > self.room {
            return Err(io::Error::other("the text is too long"));
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Creates the environment of one rendering. Its filters share `room` for the texts that they build.
fn environment(room: usize) -> Environment<'static> {
    let mut environment = Environment::empty();
    // Without it, an error names the undefined variable in builds with debug assertions only.
    environment.set_debug(true);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_fuel(Some(STEPS));
    environment.add_test("defined", tests::is_defined);
    environment.add_test("undefined", tests::is_undefined);
    environment.add_filter("length", minijinja::filters::length);
    environment.add_filter("first", minijinja::filters::first);
    environment.add_filter("last", minijinja::filters::last);
    environment.add_filter("default", |value: Value, other: Option<Value>| {
        if value.is_undefined() {
            other.unwrap_or_else(|| Value::from(""))
        } else {
            value
        }
    });
    let left = Arc::new(AtomicUsize::new(room));
    let built: [(&'static str, Built); 4] = [
        ("lower", |text| text.to_lowercase()),
        ("upper", |text| text.to_uppercase()),
        ("trim", |text| text.trim().to_owned()),
        ("capitalize", capitalized),
    ];
    for (name, build) in built {
        let left = Arc::clone(&left);
        environment.add_filter(name, move |text: &str| {
            take(&left, text.len())?;
            Ok::<_, Error>(build(text))
        });
    }
    environment.add_filter("join", move |list: Value, between: Option<&str>| {
        joined(&left, &list, between)
    });
    environment
}

/// A filter that builds a text from another one.
type Built = fn(&str) -> String;

/// Joins the entries of a list of texts or numbers.
fn joined(left: &AtomicUsize, list: &Value, between: Option<&str>) -> Result<String, Error> {
    let mut text = String::new();
    for (number, entry) in list.try_iter()?.enumerate() {
        let entry = entry
            .as_str()
            .map_or_else(|| Value::from(&entry).to_string(), str::to_owned);
        let between = between.filter(|_| number > 0).unwrap_or_default();
        take(left, between.len() + entry.len() + 1)?;
        text.push_str(between);
        text.push_str(&entry);
    }
    Ok(text)
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map(|first| {
            first
                .to_uppercase()
                .chain(letters.flat_map(char::to_lowercase))
                .collect()
        })
        .unwrap_or_default()
}

/// Takes bytes from the remaining room of the filters.
fn take(left: &AtomicUsize, bytes: usize) -> Result<(), Error> {
    let enough = left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
    enough
        .map(drop)
        .map_err(|_| Error::new(ErrorKind::WriteFailure, "the texts are too long"))
}

#[cfg(test)]
mod unit_tests {
    use minijinja::context;

    use super::*;

    fn rendered(source: &str) -> Result<String, Broken> {
        let actions: Vec<String> = (0..100).map(|number| format!("action {number}")).collect();
        render(source, context! { name => "kitchen", actions }, 1_000)
    }

    #[test]
    fn template_renders_the_constructs_that_prompts_use() {
        for (source, expected) in [
            (
                "{{ name }}: {% if actions %}{{ actions | length }}{% endif %}",
                "kitchen: 100",
            ),
            (
                "{% for action in actions %}{% if loop.first %}{{ action }}{% endif %}{% endfor %}",
                "action 0",
            ),
            (
                "{{ name | upper }} {{ name | capitalize }} {{ other | default(\"none\") }}",
                "KITCHEN Kitchen none",
            ),
            (
                "{% set word = name %}{{ word }}{% raw %} {{ a ~ b }}{% endraw %}{# ~ #} ~ + *",
                "kitchen {{ a ~ b }} ~ + *",
            ),
            (
                "{% if name == \"kitchen\" and actions is defined %}yes{% endif %}",
                "yes",
            ),
        ] {
            assert_eq!(rendered(source).as_deref(), Ok(expected), "{source}");
        }
        let joined = rendered("{{ actions | join(\" or \") }}").unwrap();
        assert!(joined.starts_with("action 0 or action 1 or "), "{joined}");
    }

    #[test]
    fn template_rejects_unbounded_output_with_its_line() {
        let loops = "{% for a in actions %}".repeat(8) + &"{% endfor %}".repeat(8);
        let long = "{% for a in actions %}".repeat(3) + &"x".repeat(500) + &"{% endfor %}".repeat(3);
        let joins = "\n{% set a = name | join(name) %}".to_owned() + &"{% set a = a | join(a) %}".repeat(30);
        for (source, line, message) in [
            ("\n{% set s = name ~ name %}", 2, "cannot have `~`"),
            ("{% set s = name * 1000 %}", 1, "cannot have `*`"),
            ("{% set s %}{{ name }}{% endset %}", 1, "cannot have a `set` block"),
            ("{% filter upper %}{% endfilter %}", 1, "cannot have a `filter` block"),
            (
                "{% for a in actions recursive %}{{ loop(actions) }}{% endfor %}",
                1,
                "`recursive`",
            ),
            ("{% set a = [name, name] %}", 1, "cannot have `,`"),
            ("{% for a in range(1000) %}{% endfor %}", 1, "range"),
            (&loops, 1, "takes more than 200000 steps"),
            (&long, 1, "longer than 1052576 bytes"),
            (&joins, 2, "longer than 1052576 bytes"),
        ] {
            let (at, found) = rendered(source).unwrap_err();
            assert!(at == line && found.contains(message), "{source}: {at} {found}");
        }
    }

    #[test]
    fn deep_templates_overflow_no_stack() {
        for (open, close) in [
            ("{% if name %}", "{% endif %}"),
            ("{% for a in actions %}", "{% endfor %}"),
            ("{{ (", ") }}"),
            ("{{ [", "] }}"),
            ("{{ not ", "}}"),
            ("{{ - ", "}}"),
            ("{{ name.a", "}}"),
            ("{{ name|upper", "}}"),
        ] {
            let inner = open.trim_start_matches("{{ ");
            let source = if open.starts_with("{{") {
                format!(
                    "{{{{ {}name{}",
                    inner.repeat(4_000),
                    close.trim_end_matches("}}").repeat(4_000)
                ) + "}}"
            } else {
                open.repeat(4_000) + &close.repeat(4_000)
            };
            // The parser handles a chain of `not` without recursion; all others exceed its depth limit.
            let refused = rendered(&source).is_err();
            assert_eq!(refused, open != "{{ not ", "{open}");
        }
    }
}
