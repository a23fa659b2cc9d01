//! Sentences with holes for entities: `put {item} on {place}`.

/// A sentence with holes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Template {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(String),
    /// The index of a parameter.
    Hole(usize),
    /// The index of a parameter whose name stands there without an article.
    Bare(usize),
}

impl Template {
    /// Reads `text`; `index_of` tells the parameter of a hole's name.
    ///
    /// # Errors
    ///
    /// The name of a hole that is no parameter, or `"{"` when a hole is not closed.
    pub fn read(text: &str, index_of: impl Fn(&str) -> Option<usize>) -> Result<Self, String> {
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some(start) = rest.find('{') {
            let Some(length) = rest[start..].find('}') else {
                return Err("{".to_owned());
            };
            let name = &rest[start + 1..start + length];
            if start > 0 {
                pieces.push(Piece::Text(rest[..start].to_owned()));
            }
            pieces.push(Piece::Hole(index_of(name).ok_or_else(|| name.to_owned())?));
            rest = &rest[start + length + 1..];
        }
        if !rest.is_empty() {
            pieces.push(Piece::Text(rest.to_owned()));
        }
        Ok(Self { pieces })
    }

    /// A fact or a step as PDDL writes it, `(on cup table)`, with a hole for each argument.
    pub(crate) fn pddl(name: &str, arguments: usize) -> Self {
        let mut pieces = vec![Piece::Text(format!("({name}"))];
        for index in 0..arguments {
            pieces.push(Piece::Text(" ".to_owned()));
            pieces.push(Piece::Bare(index));
        }
        pieces.push(Piece::Text(")".to_owned()));
        Self { pieces }
    }

    /// The opposite of a fact as PDDL writes it.
    pub(crate) fn pddl_not(name: &str, arguments: usize) -> Self {
        let mut pieces = vec![Piece::Text("(not ".to_owned())];
        pieces.extend(Self::pddl(name, arguments).pieces);
        pieces.push(Piece::Text(")".to_owned()));
        Self { pieces }
    }

    /// The sentence with `name` called for each hole.
    pub fn fill(&self, mut name: impl FnMut(usize) -> String) -> String {
        self.pieces
            .iter()
            .map(|piece| match piece {
                Piece::Text(text) => text.clone(),
                Piece::Hole(index) => name(*index),
                Piece::Bare(index) => {
                    let name = name(*index);
                    name.strip_prefix(ARTICLE).map(str::to_owned).unwrap_or(name)
                }
            })
            .collect()
    }

    /// Whether there is a hole for the parameter at `index`.
    pub fn mentions(&self, index: usize) -> bool {
        self.pieces.contains(&Piece::Hole(index))
    }

    /// Whether it says nothing.
    pub fn is_blank(&self) -> bool {
        let blank = |piece: &Piece| matches!(piece, Piece::Text(text) if text.trim().is_empty());
        self.pieces.iter().all(blank)
    }
}

const ARTICLE: &str = "the ";

/// A name with its article: "the juice", but "plate 2".
///
/// ```
/// use longstep_core::domain::with_article;
/// assert_eq!(with_article("juice"), "the juice");
/// assert_eq!(with_article("plate 2"), "plate 2");
/// ```
pub fn with_article(name: &str) -> String {
    if name.ends_with(|c: char| c.is_ascii_digit()) {
        name.to_owned()
    } else {
        format!("{ARTICLE}{name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_filled_and_unknown_ones_refused() {
        let index = |name: &str| (name == "item").then_some(0);
        let template = Template::read("put {item} down", index).unwrap();
        assert_eq!(template.fill(|_| "the cup".into()), "put the cup down");
        assert_eq!(Template::read("put {it}", index), Err("it".to_owned()));
        assert_eq!(Template::read("put {item", index), Err("{".to_owned()));
    }
}
