//! No list of English words decides what a goal, a change of a plan or a composition may be: the folders that understand what
//! people say have none.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Folders of the code that understands instructions, and what people say about plans.
const UNDERSTANDING: [&str; 6] = ["instruction", "dialogue", "session", "coverage", "feedback", "compose"];

/// Words of which a list that reads English would consist: what people use to point, deny, order, condition and move.
const WORDS: &str = "a an the this that these those some any another either all both each every my your our it its them they one ones
    not no never neither nor dont without except nothing none isnt wont avoid keep leave
    if unless when whenever while until before beforehand after afterwards first last then earlier later sooner finally end
    otherwise else once whether because since depending depends provided case
    in into on onto at to from under over beside behind inside off out of with for by near next
    put place move take bring get give throw open close shut turn switch pick drop set carry fetch hand
    please could would can will should may might do does did is are was were be been have has had
    i me you we us he she who which what where how why and or but also again only just too";

/// The string literals of a source, in lists: what stands between them is blank or a comma. A single one counts only as the
/// value of a name, for most others are messages. Tests are left out.
fn lists(source: &str) -> Vec<Vec<String>> {
    let source = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut lists: Vec<Vec<String>> = vec![Vec::new()];
    let (mut rest, mut before) = (source, ' ');
    while let Some(sign) = rest.chars().next() {
        if rest.starts_with("//") {
            rest = rest.find('\n').map_or("", |end| &rest[end..]);
        } else if rest.starts_with("'\"'") {
            rest = &rest[3..];
        } else if sign == '"' {
            let mut is_escaped = false;
            let end = rest[1..]
                .find(|c| {
                    let ends = c == '"' && !is_escaped;
                    is_escaped = c == '\\' && !is_escaped;
                    ends
                })
                .unwrap_or(rest.len() - 1);
            if before == '=' || before == '[' {
                lists.last_mut().unwrap().push(rest[1..=end].to_owned());
            }
            rest = rest.get(end + 2..).unwrap_or_default();
        } else {
            if !sign.is_whitespace() && sign != ',' {
                lists.push(Vec::new());
                before = sign;
            }
            rest = &rest[sign.len_utf8()..];
        }
    }
    lists.retain(|list| !list.is_empty());
    lists
}

/// True if these texts are a list of English words: at least four words, most of them of the kinds above.
fn reads_english(texts: &[String]) -> bool {
    let words: Vec<&str> = texts.iter().flat_map(|text| text.split_whitespace()).collect();
    let known = |word: &&&str| WORDS.split_whitespace().any(|one| one == **word);
    words.len() >= 4 && words.iter().filter(known).count() * 10 >= words.len() * 7
}

/// The lists of English words below a folder of the sources, each with its file.
fn found(folder: &str) -> Vec<String> {
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        let mut entries: Vec<PathBuf> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        entries.sort();
        for path in entries {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                open.extend((name != "tests").then_some(path));
            } else if path.extension().is_some_and(|end| end == "rs") && !name.ends_with("tests") && name != "injected"
            {
                let source = fs::read_to_string(&path).unwrap();
                let lists = lists(&source).into_iter().filter(|list| reads_english(list));
                found.extend(lists.map(|list| format!("{}: {}", path.display(), list.join(" "))));
            }
        }
    }
    found
}

#[test]
fn no_list_of_english_words_decides_what_is_understood() {
    for folder in UNDERSTANDING {
        assert!(found(folder).is_empty(), "{}", found(folder).join("\n"));
    }
}

#[test]
fn word_list_search_finds_english_lists() {
    assert!(
        lists("let x = [\"put\", \"move\", // \"of\"\n \"take\", \"to\"];")
            .iter()
            .any(|list| reads_english(list))
    );
    assert!(
        lists("let x = \"not never no without\";")
            .iter()
            .any(|list| reads_english(list))
    );
    assert!(
        !lists("say(\"it would need that the door is open\");")
            .iter()
            .any(|list| reads_english(list))
    );
}
