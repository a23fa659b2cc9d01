//! Sentence templates with holes for entities: `put {item} on {place}`.

/// Returns a sentence without its full stop, as it stands within another sentence.
///
/// ```
/// use longstep_model::domain::phrase;
/// assert_eq!(phrase("Draw water from the well. "), "Draw water from the well");
/// assert_eq!(phrase("and so on ..."), "and so on ...");
/// ```
pub fn phrase(sentence: &str) -> &str {
    let sentence = sentence.trim_end();
    match sentence.strip_suffix('.') {
        Some(phrase) if !phrase.ends_with('.') => phrase.trim_end(),
        _ => sentence,
    }
}

/// A sentence template.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Template {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(String),
    /// The index of a parameter.
    Hole(usize),
}

impl Template {
    /// Parses `text`; `index_of` maps the name of a hole to a parameter.
    ///
    /// # Errors
    ///
    /// The name of an unknown hole, or `"{"` for a hole that is not closed.
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

    /// Returns a template in PDDL notation, `(on cup table)`, with one hole per argument.
    pub(crate) fn pddl(name: &str, arguments: usize) -> Self {
        let mut pieces = vec![Piece::Text(format!("({name}"))];
        for index in 0..arguments {
            pieces.push(Piece::Text(" ".to_owned()));
            pieces.push(Piece::Hole(index));
        }
        pieces.push(Piece::Text(")".to_owned()));
        Self { pieces }
    }

    /// Returns a template for a negated fact in PDDL notation, with one hole per argument.
    pub(crate) fn pddl_not(name: &str, arguments: usize) -> Self {
        let mut pieces = vec![Piece::Text("(not ".to_owned())];
        pieces.extend(Self::pddl(name, arguments).pieces);
        pieces.push(Piece::Text(")".to_owned()));
        Self { pieces }
    }

    /// Returns the template with a text after it.
    pub(crate) fn followed_by(&self, text: &str) -> Self {
        let mut pieces = self.pieces.clone();
        pieces.push(Piece::Text(text.to_owned()));
        Self { pieces }
    }

    /// Fills every hole with the text that `name` returns for its parameter.
    pub fn fill(&self, mut name: impl FnMut(usize) -> String) -> String {
        self.pieces
            .iter()
            .map(|piece| match piece {
                Piece::Text(text) => text.clone(),
                Piece::Hole(index) => name(*index),
            })
            .collect()
    }

    /// Like [`fill`](Self::fill), without the first parameter if the sentence begins with it: "is red".
    pub(crate) fn fill_after_subject(&self, name: impl FnMut(usize) -> String) -> String {
        let pieces = match &self.pieces[..] {
            [Piece::Hole(0), rest @ ..] if !rest.is_empty() => rest.to_vec(),
            all => all.to_vec(),
        };
        Self { pieces }.fill(name).trim().to_owned()
    }

    /// Returns true if the template has a hole for the parameter at `index`.
    pub fn mentions(&self, index: usize) -> bool {
        self.pieces.contains(&Piece::Hole(index))
    }

    /// Returns true if the template is empty or white space.
    pub fn is_blank(&self) -> bool {
        let blank = |piece: &Piece| matches!(piece, Piece::Text(text) if text.trim().is_empty());
        self.pieces.iter().all(blank)
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
