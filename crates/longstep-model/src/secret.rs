//! Removal of passwords from texts that are shown or kept.
//!
//! Addresses that users write may hold a user with a password (`ws://user:password@host`) or a key (`?token=...`). Errors quote
//! what users write, and logs keep it.
//!
//! ```
//! use longstep_model::secret;
//! assert_eq!(secret::redacted("`ws://me:hunter2@arm:9090` is no number"), "`ws://[removed]@arm:9090` is no number");
//! assert_eq!(secret::redacted("me:hunter2@arm has no scheme"), "[removed]@arm has no scheme");
//! assert_eq!(secret::address("ws://me:hunt er2@arm"), "ws://[removed]@arm");
//! assert_eq!(secret::in_addresses("http://arm/?token=hunter2&scene=3"), "http://arm/?token=[removed]&scene=3");
//! assert_eq!(secret::in_addresses("docker run robot:2@sha256:17"), "docker run robot:2@sha256:17");
//! ```

use std::borrow::Cow;

/// Replacement of a secret.
pub const REMOVED: &str = "[removed]";

/// Parts of the names of query parameters whose values are secrets.
const KEYS: [&str; 7] = ["auth", "credential", "key", "pass", "secret", "sig", "token"];

/// Returns a text for a message: without the secrets of its addresses, and without what looks like a user with a password in an
/// address that has no scheme.
pub fn redacted(text: &str) -> Cow<'_, str> {
    each_word(text, |word| {
        in_address(word).or_else(|| {
            let user = word.get(..word.rfind('@')?)?;
            let (name, password) = user.split_once(':')?;
            let start = name.rfind('=').map_or(0, |at| at + 1);
            let is_pair = !word.contains("://") && start < name.len() && !password.is_empty();
            is_pair.then(|| format!("{}{REMOVED}{}", &word[..start], &word[user.len()..]))
        })
    })
}

/// Returns an address for a message: a text that is meant as one, whatever is in it.
pub fn address(text: &str) -> Cow<'_, str> {
    let Some(at) = text.rfind('@') else {
        return in_addresses(text);
    };
    let scheme = text.find("://").map_or(0, |end| end + 3).min(at);
    let end = &text[at..];
    let end = without_keys(end).unwrap_or_else(|| end.to_owned());
    Cow::Owned(format!("{}{REMOVED}{end}", &text[..scheme]))
}

/// Returns a text without the users, passwords and keys of the addresses in it. Everything else stays as it is.
pub fn in_addresses(text: &str) -> Cow<'_, str> {
    each_word(text, in_address)
}

/// Replaces words, which end at white space and at the quotes of messages.
fn each_word(text: &str, replace: impl Fn(&str) -> Option<String>) -> Cow<'_, str> {
    let is_end = |letter: char| letter.is_whitespace() || matches!(letter, '`' | '"');
    let mut shown = String::new();
    let mut kept = 0;
    let mut start = 0;
    for word in text.split(is_end) {
        let end = start + word.len();
        if let Some(replacement) = replace(word) {
            shown.push_str(&text[kept..start]);
            shown.push_str(&replacement);
            kept = end;
        }
        start = end + text[end..].chars().next().map_or(0, char::len_utf8);
    }
    if kept == 0 {
        return Cow::Borrowed(text);
    }
    shown.push_str(&text[kept..]);
    Cow::Owned(shown)
}

/// Returns a word without the secrets of the address in it; none if there are none.
fn in_address(word: &str) -> Option<String> {
    let (scheme, rest) = word.split_once("://")?;
    let user = user(rest);
    let address = without_keys(rest.get(user..)?);
    let is_secret = user > 0 || address.is_some();
    let address = address.unwrap_or_else(|| rest[user..].to_owned());
    let removed = if user > 0 { REMOVED } else { "" };
    is_secret.then(|| format!("{scheme}://{removed}{address}"))
}

/// Returns the length of the user and the password at the beginning of an address without its scheme.
fn user(rest: &str) -> usize {
    let end = rest.find(['/', '?', '#', '\\']).unwrap_or(rest.len());
    let authority = &rest[..end];
    if let Some(at) = authority.rfind('@') {
        return at;
    }
    // A password with such a letter ends the host early: what follows the colon is no port then.
    let has_port = authority.rsplit_once(':').is_none_or(|(host, port)| {
        host.starts_with('[') && !host.ends_with(']') || port.bytes().all(|digit| digit.is_ascii_digit())
    });
    if has_port { 0 } else { rest.rfind('@').unwrap_or(0) }
}

/// Returns the end of an address without the values of parameters that are keys; none if there are none.
fn without_keys(address: &str) -> Option<String> {
    let (place, query) = address.split_once('?')?;
    let (query, fragment) = query.find('#').map_or((query, ""), |at| query.split_at(at));
    let is_secret = |parameter: &&str| {
        let name = parameter.split_once('=').map(|(name, _)| name.to_lowercase());
        name.is_some_and(|name| KEYS.iter().any(|key| name.contains(key)))
    };
    query.split('&').find(is_secret)?;
    let shown = query.split('&').map(|parameter| match parameter.split_once('=') {
        Some((name, _)) if is_secret(&parameter) => format!("{name}={REMOVED}"),
        _ => parameter.to_owned(),
    });
    let shown: Vec<String> = shown.collect();
    Some(format!("{place}?{}{fragment}", shown.join("&")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_are_removed_and_nothing_else() {
        for (text, expected) in [
            ("ws://arm:9090", "ws://arm:9090"),
            ("ws://user:hunter2@arm:9090/x", "ws://[removed]@arm:9090/x"),
            ("ws://hunter2@arm", "ws://[removed]@arm"),
            ("ws://user:hun@ter2@arm", "ws://[removed]@arm"),
            ("ws://user:hun/ter2@arm", "ws://[removed]@arm"),
            ("ws://user:hunt?er2@arm", "ws://[removed]@arm"),
            ("'ws://user:hun'ter<2@arm'", "'ws://[removed]@arm'"),
            ("ws://[::1]:9090/a@b", "ws://[::1]:9090/a@b"),
            ("http://arm:80/@scope/name", "http://arm:80/@scope/name"),
            (
                "a `ws://u:p@b`, \"ws://u:p@c\" é <ws://u:p@d>",
                "a `ws://[removed]@b`, \"ws://[removed]@c\" é <ws://[removed]@d>",
            ),
            ("http://a/?x=1#k", "http://a/?x=1#k"),
            (
                "http://u:p@a/?x=1&api_KEY=hunter2#k",
                "http://[removed]@a/?x=1&api_KEY=[removed]#k",
            ),
            ("", ""),
            ("äöü `ß`", "äöü `ß`"),
        ] {
            assert_eq!(redacted(text), expected);
            assert_eq!(in_addresses(text), expected);
        }
        for (text, expected) in [
            ("user:hunter2@arm:9090", "[removed]@arm:9090"),
            ("--url=user:hunter2@arm", "--url=[removed]@arm"),
            ("virtualhome:user:hunter2@arm", "[removed]@arm"),
            ("user@arm:9090", "user@arm:9090"),
            ("robot.toml:3:7: x @ y", "robot.toml:3:7: x @ y"),
            ("at 10:30 me@arm", "at 10:30 me@arm"),
        ] {
            assert_eq!(redacted(text), expected);
            assert_eq!(in_addresses(text), text);
        }
    }
}
