//! The lines and cells of a table.

use super::builder::Builder;
use super::{ReadError, shortened};

/// Returns a reader of the lines of a table.
pub(super) fn lines(bytes: &[u8], separator: u8, has_headers: bool) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .delimiter(separator)
        .trim(csv::Trim::All)
        .has_headers(has_headers)
        .flexible(!has_headers)
        .from_reader(bytes)
}

/// Reads the number in a cell; none if it is empty. A comma in a cell is a decimal one.
pub(super) fn cell(line: &csv::ByteRecord, index: usize, builder: &mut Builder) -> Result<Option<f64>, ReadError> {
    let bytes = line.get(index).unwrap_or_default();
    let text = String::from_utf8_lossy(bytes);
    if text.is_empty() {
        return Ok(None);
    }
    let is_comma = text.contains(',') && !text.contains('.');
    let plain = if is_comma {
        text.replacen(',', ".", 1)
    } else {
        text.to_string()
    };
    match plain.parse::<f64>() {
        Ok(number) => {
            if is_comma {
                builder.note("numbers have decimal commas");
            }
            Ok(Some(number))
        }
        Err(_) if text.eq_ignore_ascii_case("true") => Ok(Some(1.0)),
        Err(_) if text.eq_ignore_ascii_case("false") => Ok(Some(0.0)),
        Err(_) => {
            let column = index + 1;
            Err(builder.error(format!("column {column} is `{}`, and not a number", shortened(&text))))
        }
    }
}
