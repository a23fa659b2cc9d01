//! Templates: JSON values with holes, `"{item}"` or `"pick up {item|bare}"`.
//!
//! A text that is one hole becomes the value of the hole, of any type. Holes within a longer text are written into it.
//! `{{` and `}}` are braces.

use indexmap::IndexMap;
use serde_json::{Map, Value};

/// Values by the text that a filter looks up.
pub(super) type Table = IndexMap<String, Value>;

/// The deepest nesting of a template.
const DEEPEST: usize = 32;

/// A JSON value with holes.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Template {
    Constant(Value),
    Text(Vec<Piece>),
    List(Vec<Template>),
    Object(Vec<(String, Template)>),
}

/// A part of a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Piece {
    Literal(String),
    Hole(Hole),
}

/// A hole: a name, and the filters that its value goes through.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Hole {
    pub(super) name: String,
    pub(super) filters: Vec<Filter>,
    /// The text between the braces.
    pub(super) written: String,
}

/// A change of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Filter {
    /// An identifier without its angle brackets.
    Bare,
    /// An identifier with angle brackets.
    Entity,
    /// The number of a quantity.
    Number,
    /// The unit of a quantity.
    Unit,
    /// The text of a text value, without quotes.
    Text,
    /// The value as JSON in a text.
    Json,
    /// The value in a table of `robot.toml`.
    Table(String),
}

impl Filter {
    /// The filters that are no tables.
    pub(super) const NAMES: [&'static str; 6] = ["bare", "entity", "number", "unit", "text", "json"];

    fn of(name: &str) -> Self {
        match name {
            "bare" => Self::Bare,
            "entity" => Self::Entity,
            "number" => Self::Number,
            "unit" => Self::Unit,
            "text" => Self::Text,
            "json" => Self::Json,
            table => Self::Table(table.to_owned()),
        }
    }
}

/// A text with a brace that is not closed, or a hole without a name; with the part of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TemplateError {
    pub(super) part: String,
    pub(super) reason: &'static str,
}

/// The values of holes.
pub(super) trait HoleValues {
    /// Returns the value of a hole's name, and the filters that are left to apply.
    ///
    /// # Errors
    ///
    /// The reason why there is none.
    fn value<'h>(&self, hole: &'h Hole) -> Result<(Value, &'h [Filter]), String>;

    /// Returns a table of `robot.toml`.
    fn table(&self, name: &str) -> Option<&Table>;
}

impl Template {
    /// Reads a template from JSON.
    pub(super) fn read(value: &Value) -> Result<Self, TemplateError> {
        Self::nested(value, 0)
    }

    fn nested(value: &Value, depth: usize) -> Result<Self, TemplateError> {
        if depth > DEEPEST {
            let part = "{".to_owned();
            let reason = "is nested too deep";
            return Err(TemplateError { part, reason });
        }
        Ok(match value {
            Value::String(text) => Self::text(text)?,
            Value::Array(items) => Self::List(
                items
                    .iter()
                    .map(|item| Self::nested(item, depth + 1))
                    .collect::<Result<_, _>>()?,
            ),
            Value::Object(fields) => {
                let field = |(name, value): (&String, &Value)| Ok((name.clone(), Self::nested(value, depth + 1)?));
                Self::Object(fields.iter().map(field).collect::<Result<_, _>>()?)
            }
            other => Self::Constant(other.clone()),
        })
    }

    /// Reads the template of a text.
    pub(super) fn text(text: &str) -> Result<Self, TemplateError> {
        let pieces = pieces(text)?;
        let is_hole = |piece: &Piece| matches!(piece, Piece::Hole(_));
        if pieces.iter().any(is_hole) {
            return Ok(Self::Text(pieces));
        }
        let literal = |piece: Piece| match piece {
            Piece::Literal(text) => text,
            Piece::Hole(_) => String::new(),
        };
        Ok(Self::Constant(Value::String(pieces.into_iter().map(literal).collect())))
    }

    /// All holes, in order.
    pub(super) fn holes(&self) -> Vec<&Hole> {
        match self {
            Self::Constant(_) => Vec::new(),
            Self::Text(pieces) => pieces
                .iter()
                .filter_map(|piece| match piece {
                    Piece::Hole(hole) => Some(hole),
                    Piece::Literal(_) => None,
                })
                .collect(),
            Self::List(items) => items.iter().flat_map(Self::holes).collect(),
            Self::Object(fields) => fields.iter().flat_map(|(_, own)| own.holes()).collect(),
        }
    }

    /// Fills the holes.
    ///
    /// # Errors
    ///
    /// The reason why a hole has no value.
    pub(super) fn fill(&self, scope: &dyn HoleValues) -> Result<Value, String> {
        Ok(match self {
            Self::Constant(value) => value.clone(),
            Self::Text(pieces) => match &pieces[..] {
                [Piece::Hole(hole)] => filled(hole, scope)?,
                pieces => {
                    let written = pieces.iter().map(|piece| match piece {
                        Piece::Literal(text) => Ok(text.clone()),
                        Piece::Hole(hole) => filled(hole, scope).map(|value| plain(&value)),
                    });
                    Value::String(written.collect::<Result<_, String>>()?)
                }
            },
            Self::List(items) => {
                let items = items.iter().map(|item| item.fill(scope));
                Value::Array(items.collect::<Result<_, _>>()?)
            }
            Self::Object(fields) => {
                let mut object = Map::new();
                for (name, template) in fields {
                    object.insert(name.clone(), template.fill(scope)?);
                }
                Value::Object(object)
            }
        })
    }

    /// Fills the holes of a text; other values are written as text.
    pub(super) fn fill_text(&self, scope: &dyn HoleValues) -> Result<String, String> {
        self.fill(scope).map(|value| plain(&value))
    }
}

/// Writes a value within a text: texts without quotes, everything else as JSON.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn pieces(text: &str) -> Result<Vec<Piece>, TemplateError> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut literal = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(['{', '}']) {
        literal.push_str(&rest[..at]);
        let tail = &rest[at..];
        if tail.starts_with("{{") || tail.starts_with("}}") {
            literal.push_str(&tail[..1]);
            rest = &tail[2..];
            continue;
        }
        let wrong = |reason| TemplateError {
            part: tail.chars().take(40).collect(),
            reason,
        };
        let inner = tail.strip_prefix('{').ok_or_else(|| wrong("closes no brace"))?;
        let end = inner.find('}').ok_or_else(|| wrong("is not closed"))?;
        let written = &inner[..end];
        let mut words = written.split('|').map(str::trim);
        let name = words.next().unwrap_or_default().to_owned();
        let filters: Vec<Filter> = words.clone().map(Filter::of).collect();
        if name.is_empty() || words.any(str::is_empty) || written.contains('{') {
            return Err(wrong("has no name between the braces"));
        }
        if !literal.is_empty() {
            pieces.push(Piece::Literal(std::mem::take(&mut literal)));
        }
        pieces.push(Piece::Hole(Hole {
            name,
            filters,
            written: written.to_owned(),
        }));
        rest = &inner[end + 1..];
    }
    literal.push_str(rest);
    if !literal.is_empty() || pieces.is_empty() {
        pieces.push(Piece::Literal(literal));
    }
    Ok(pieces)
}

fn filled(hole: &Hole, scope: &dyn HoleValues) -> Result<Value, String> {
    let (mut value, filters) = scope.value(hole)?;
    for filter in filters {
        value = match filter {
            Filter::Bare => Value::String(bare(&plain(&value)).to_owned()),
            Filter::Entity => Value::String(format!("<{}>", bare(&plain(&value)))),
            Filter::Json => Value::String(value.to_string()),
            Filter::Table(name) => {
                let key = plain(&value);
                let table = scope.table(name);
                let found = table.and_then(|table| table.get(&key));
                found
                    .cloned()
                    .ok_or_else(|| format!("the table `{name}` has no `{key}`"))?
            }
            Filter::Text | Filter::Number | Filter::Unit => {
                return Err(format!("`{}` is no value of the plan", hole.written));
            }
        };
    }
    Ok(value)
}

fn bare(identifier: &str) -> &str {
    let inner = identifier.strip_prefix('<').and_then(|own| own.strip_suffix('>'));
    inner.unwrap_or(identifier)
}

/// Returns the value at a path of names and indices, `position.x` or `poses.0`; the value itself for an empty path.
pub(super) fn at<'v>(value: &'v Value, path: &str) -> Option<&'v Value> {
    if path.is_empty() {
        return Some(value);
    }
    path.split('.').try_fold(value, |value, name| match value {
        Value::Object(fields) => fields.get(name),
        Value::Array(items) => items.get(name.parse::<usize>().ok()?),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    struct Words(Value, Table);

    impl HoleValues for Words {
        fn value<'h>(&self, hole: &'h Hole) -> Result<(Value, &'h [Filter]), String> {
            let value = at(&self.0, &hole.name).cloned();
            value
                .map(|value| (value, &hole.filters[..]))
                .ok_or_else(|| format!("no `{}`", hole.name))
        }

        fn table(&self, name: &str) -> Option<&Table> {
            (name == "pose").then_some(&self.1)
        }
    }

    #[test]
    fn message_template_fills_its_placeholders() {
        let table = Table::from([("<cup>".to_owned(), json!({"x": 1.5}))]);
        let words = Words(
            json!({"item": "<cup>", "step": 3, "list": ["a", 2], "deep": {"x": [7]}}),
            table,
        );
        for (template, expected) in [
            (json!("{item}"), json!("<cup>")),
            (json!("{step}"), json!(3)),
            (json!("step {step}: {item|bare}"), json!("step 3: cup")),
            (
                json!({"goal": ["{list}", 1, true, null]}),
                json!({"goal": [["a", 2], 1, true, null]}),
            ),
            (json!("{item|pose}"), json!({"x": 1.5})),
            (json!("{item|bare|entity}"), json!("<cup>")),
            (json!("{list|json}"), json!("[\"a\",2]")),
            (json!("{deep.x.0}"), json!(7)),
            (json!("{{{step}}}"), json!("{3}")),
            (json!(""), json!("")),
            (json!("a } b".replace('}', "}}")), json!("a } b")),
        ] {
            let read = Template::read(&template).unwrap();
            assert_eq!(read.fill(&words), Ok(expected), "{template}");
        }
        for (template, expected) in [
            ("{cup}", "no `cup`"),
            ("{step|pose}", "the table `pose` has no `3`"),
            ("{step|number}", "`step|number` is no value of the plan"),
        ] {
            let read = Template::text(template).unwrap();
            assert_eq!(read.fill(&words), Err(expected.to_owned()));
        }
    }

    #[test]
    fn broken_templates_are_errors() {
        for (text, part, reason) in [
            ("a {item", "{item", "is not closed"),
            ("a } b", "} b", "closes no brace"),
            ("{}", "{}", "has no name between the braces"),
            ("{item|}", "{item|}", "has no name between the braces"),
            ("{a{b}", "{a{b}", "has no name between the braces"),
        ] {
            let part = part.to_owned();
            assert_eq!(Template::text(text), Err(TemplateError { part, reason }));
        }
    }
}
