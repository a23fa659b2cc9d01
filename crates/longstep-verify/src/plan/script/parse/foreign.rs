//! Python constructs that plans do not have, with alternatives.

use super::super::token::Kind;
use super::{Parser, STATEMENTS};

impl Parser<'_> {
    /// Names the next token if it is unsupported Python, and suggests an alternative.
    pub(super) fn foreign(&self) -> Option<(String, &'static str)> {
        let (what, instead) = match self.peek() {
            Kind::Name(word) => return foreign_word(word),
            Kind::Text(_) => ("a text", "say what a step does in a comment, `# ...`"),
            Kind::Number(_) => ("a number", "numbers stand in `range(N)` alone"),
            Kind::Sign(sign) => match *sign {
                "=" | ":=" | "+=" | "-=" | "*=" | "/=" | "%=" | "|=" | "**=" | "//=" => (
                    "an assignment",
                    "ask in the condition itself, as in `if not check_date():`",
                ),
                "==" | "!=" | "<" | ">" | "<=" | ">=" => (
                    "a comparison",
                    "ask what holds, as in `if check_date():` or `if not on(\"<cup>\", \"<table>\"):`",
                ),
                "+" | "-" | "*" | "/" | "%" | "**" | "//" | "|" | "&" | "^" | "~" => {
                    ("arithmetic", "numbers stand in `range(N)` alone")
                }
                "." => ("an attribute", "call the action by its name alone"),
                "[" | "]" => ("a list or an index", "name each thing in a call of its own"),
                "{" | "}" => ("a set or a dictionary", STATEMENTS),
                "@" => ("a decorator", STATEMENTS),
                ";" => ("a second statement on a line", "write each call on a line of its own"),
                "->" => ("a function's type", STATEMENTS),
                "..." => ("a gap", "write every step, or `pass`"),
                _ => return None,
            },
            _ => return None,
        };
        Some((what.to_owned(), instead))
    }
}

/// Names a Python keyword that plans do not have, and suggests an alternative.
fn foreign_word(word: &str) -> Option<(String, &'static str)> {
    let (what, instead) = match word {
        "def" | "async" => ("a function", "write its steps where they are done"),
        "class" => ("a class", STATEMENTS),
        "import" | "from" => ("an import", "call the domain's actions, which are known already"),
        "lambda" => ("a function", "write its steps where they are done"),
        "return" | "yield" => ("the end of a function", "put what follows into an `else`"),
        "break" | "continue" => ("a jump", "say in the loop's condition when it ends"),
        "try" | "except" | "finally" | "raise" | "assert" => ("error handling", "branch on what is sensed, with `if`"),
        "match" | "case" => ("a choice of patterns", "write `if`, `elif` and `else`"),
        "del" | "global" | "nonlocal" => ("a variable", STATEMENTS),
        "await" => ("waiting", "calls are waited for anyway"),
        "print" => ("output", "say it in a comment, `# ...`"),
        "in" | "is" => (
            "a comparison",
            "ask what holds, as in `if inside(\"<cup>\", \"<box>\"):`",
        ),
        "if" => ("a conditional expression", "put the `if` on a line of its own"),
        "True" | "False" | "None" => ("a value", STATEMENTS),
        _ => return None,
    };
    Some((what.to_owned(), instead))
}
