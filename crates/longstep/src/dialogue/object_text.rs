//! The JSON object in a server's answer, as servers and models wrap it.

use serde_json::Value;

/// Places at which an object may begin that are tried.
const TRIED: usize = 200;

/// Marks at the end of an answer that belong to a chat template.
const ENDS: [&str; 6] = [
    "<|im_end|>",
    "<|eot_id|>",
    "<|end|>",
    "<|return|>",
    "<end_of_turn>",
    "</s>",
];

/// Returns the one JSON object that an answer contains, without the reasoning before it, marks of a chat template, a code
/// fence and words around it, and out of a string or of a call that stands for it. None if it contains none or several.
///
/// ```
/// use longstep::dialogue::object_text;
/// for answer in [
///     r#"{"goals": []}"#,
///     "<think>The {cup}?</think>\n```json\n{\"goals\": []}\n```",
///     "Thinking aloud.</think>{\"goals\": []}<|im_end|>",
///     "Sure! Here it is: {\"goals\": []} Anything else?",
///     r#""{\"goals\": []}""#,
///     r#"{"name": "answer", "arguments": {"goals": []}}"#,
/// ] {
///     let object: serde_json::Value = serde_json::from_str(&object_text(answer).unwrap()).unwrap();
///     assert_eq!(object, serde_json::json!({"goals": []}), "{answer}");
/// }
/// assert_eq!(object_text("{} or {}"), None);
/// ```
pub fn object_text(answer: &str) -> Option<String> {
    let text = without_marks(without_reasoning(answer));
    match serde_json::from_str(text) {
        Ok(Value::Object(fields)) => {
            return Some(called(Value::Object(fields)).map_or_else(|| text.to_owned(), |own| own.to_string()));
        }
        Ok(Value::String(inner)) => return only_object(inner.trim()),
        _ => {}
    }
    only_object(text)
}

/// Returns what follows the reasoning: the last message of a channel, or what is behind the last end of a thought.
fn without_reasoning(answer: &str) -> &str {
    let answer = answer.rsplit_once("<|message|>").map_or(answer, |(_, message)| message);
    let ends = ["</think>", "</thinking>", "</reasoning>", "[/THINK]"];
    let ends = ends.iter().filter_map(|end| Some(answer.rfind(end)? + end.len()));
    ends.max().map_or(answer, |end| &answer[end..])
}

fn without_marks(text: &str) -> &str {
    let mut text = text.trim();
    while let Some(shorter) = ENDS.iter().find_map(|end| text.strip_suffix(end)) {
        text = shorter.trim_end();
    }
    text
}

/// Returns the only object in a text.
fn only_object(text: &str) -> Option<String> {
    let (mut found, mut at) = (None, 0);
    for _ in 0..TRIED {
        let Some(begin) = text[at..].find('{').map(|place| at + place) else {
            break;
        };
        let mut values = serde_json::Deserializer::from_str(&text[begin..]).into_iter::<Value>();
        match values.next() {
            Some(Ok(value)) => {
                let end = begin + values.byte_offset();
                let object = called(value).map_or_else(|| text[begin..end].to_owned(), |own| own.to_string());
                if found.replace(object).is_some() {
                    return None;
                }
                at = end;
            }
            _ => at = begin + 1,
        }
    }
    found
}

/// Returns the arguments of a call that an answer has in place of the object.
fn called(value: Value) -> Option<Value> {
    let fields = value
        .as_object()
        .filter(|fields| fields.len() <= 3 && fields.get("name").is_some_and(Value::is_string))?;
    let arguments = fields.get("arguments").or(fields.get("parameters"))?;
    match arguments {
        Value::Object(_) => Some(arguments.clone()),
        Value::String(text) => serde_json::from_str(text).ok().filter(Value::is_object),
        _ => None,
    }
}
