//! `--explain-prompt`: the request to a model, and the tokens of its parts. `--explain`: how an instruction was understood.

use longstep::dialogue::{Explanation, Message, Reading, Role};

use crate::output::{self, Style, print_line};
use crate::show;

/// Prints a table of the parts, the total, and the messages under their roles. `dropped` exchanges of the history and
/// `left_out` entities are mentioned if there are any.
pub(crate) fn show(explanation: &Explanation, messages: &[Message], dropped: usize, left_out: usize) {
    show::heading("Parts of the prompt");
    let names = explanation.parts.iter().map(|part| part.name.chars().count());
    let width = names.max().unwrap_or(0);
    let digits = explanation.total.to_string().len();
    for part in &explanation.parts {
        let share = format!("{:>3}.{} %", part.per_mille / 10, part.per_mille % 10);
        print_line!(
            "  {:width$}  {:>digits$} tokens  {}",
            part.name,
            part.tokens,
            share.dimmed()
        );
    }
    print_line!("  {}", explanation.summary());
    if dropped > 0 {
        print_line!(
            "  left out, because the context is full: {}",
            count(dropped, "earlier exchange")
        );
    }
    if left_out > 0 {
        let things = if left_out == 1 {
            "1 entity".to_owned()
        } else {
            format!("{left_out} entities")
        };
        print_line!("  left out, because they are not relevant to the instruction: {things}");
    }
    for (number, message) in messages.iter().enumerate() {
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        output::blank();
        show::heading(&format!("{}. {role}", number + 1));
        output::quotation(&message.text);
    }
}

/// Prints the answers of the model that were weighed, with the natural logarithms of their probabilities.
pub(crate) fn readings(readings: &[Reading]) {
    show::heading("How it was understood");
    if readings.is_empty() {
        print_line!("  no model was asked");
    }
    for line in readings.iter().flat_map(Reading::lines) {
        print_line!("  {line}");
    }
}

fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}
