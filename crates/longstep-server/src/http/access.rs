//! Who may talk to a server: a token, the names of the host, and pages of the server only.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use axum::http::header::{AUTHORIZATION, COOKIE, HOST, ORIGIN};
use axum::http::{HeaderMap, Method};
use sha2::{Digest, Sha256};

use crate::id::hexadecimal;
use crate::problem::{Problem, ProblemKind};

/// The name of the cookie of the page.
const COOKIE_NAME: &str = "longstep";

/// The number of random bytes of a token.
const TOKEN_LENGTH: usize = 32;

/// The most characters of the name of a person.
const LONGEST_NAME: usize = 100;

/// The header with the name of the person who asks.
pub(crate) const USER: &str = "longstep-user";

/// The secret of a server, which is in a file with mode 600 and in the link to the page.
#[derive(Clone)]
pub struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("Token(...)")
    }
}

/// A token that cannot be read or kept.
#[derive(Debug, thiserror::Error)]
#[error("cannot keep the token in {}: {reason}", path.display())]
#[non_exhaustive]
pub struct TokenError {
    /// The file.
    pub path: PathBuf,
    /// The error.
    pub reason: std::io::Error,
}

impl Token {
    /// Reads the token of a file; a file that does not exist gets a random one.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or written, or with a text that is no token.
    pub fn of_file(path: &Path) -> Result<Self, TokenError> {
        let failed = |reason| TokenError {
            path: path.to_owned(),
            reason,
        };
        match longstep_files::read_text_bounded(path, 1_000) {
            Ok(text) => {
                let text = text.trim();
                if text.len() < TOKEN_LENGTH || !text.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
                    return Err(failed(std::io::Error::other(
                        "it has no token of at least 32 letters and digits",
                    )));
                }
                Ok(Self(text.to_owned()))
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let token = crate::id::random(TOKEN_LENGTH).map_err(|error| failed(error.into()))?;
                longstep_files::write_whole(path, format!("{token}\n").as_bytes()).map_err(failed)?;
                Ok(Self(token))
            }
            Err(error) => Err(failed(error)),
        }
    }

    /// Returns the text, for the link to the page and for clients.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns the value of the cookie, from which the token cannot be computed.
    fn cookie(&self) -> String {
        hexadecimal(&Sha256::digest(format!("the page of longstep {}", self.0)))
    }
}

/// Who may talk to a server.
#[derive(Debug, Clone)]
pub struct Access {
    token: Token,
    /// The names that the header `Host` may have, with the port.
    hosts: Vec<String>,
}

/// Someone who may talk to the server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Person {
    /// The name for the audit log.
    pub(crate) name: String,
}

impl Access {
    /// Creates the access to a server at an address, which is reached as `names` too: host names with their port.
    pub fn new(token: Token, address: SocketAddr, names: &[String]) -> Self {
        let port = address.port();
        let mut hosts: Vec<String> = ["localhost", "127.0.0.1", "[::1]"]
            .into_iter()
            .map(|name| format!("{name}:{port}"))
            .collect();
        hosts.push(address.to_string());
        hosts.extend(names.iter().map(|name| name.to_ascii_lowercase()));
        Self { token, hosts }
    }

    /// Returns the names of the server, with its port.
    pub(crate) fn hosts(&self) -> &[String] {
        &self.hosts
    }

    /// Compares a token, in a time that does not depend on where it differs.
    pub(crate) fn is_token(&self, text: &str) -> bool {
        is_same(text, &self.token.0)
    }

    /// Returns the header that gives a browser the cookie.
    pub(crate) fn set_cookie(&self) -> String {
        format!(
            "{COOKIE_NAME}={}; Path=/; HttpOnly; SameSite=Strict",
            self.token.cookie()
        )
    }

    /// Checks the name of the host, so that no foreign name leads here.
    ///
    /// # Errors
    ///
    /// Another name.
    pub(crate) fn check_host(&self, headers: &HeaderMap) -> Result<(), Problem> {
        let host = text(headers, HOST.as_str()).unwrap_or_default().to_ascii_lowercase();
        if self.hosts.contains(&host) {
            return Ok(());
        }
        Err(
            Problem::new(ProblemKind::Forbidden, "this server does not have that name")
                .hint("use the address that it printed, or start it with `--name HOST:PORT`"),
        )
    }

    /// Returns who asks: a client with the token, or a page of this server.
    ///
    /// # Errors
    ///
    /// There is neither, or a page of another origin asks.
    pub(crate) fn person(&self, method: &Method, headers: &HeaderMap) -> Result<Person, Problem> {
        let bearer = text(headers, AUTHORIZATION.as_str()).and_then(|value| value.strip_prefix("Bearer "));
        let is_client = bearer.is_some_and(|token| self.is_token(token.trim()));
        let cookie = self.token.cookie();
        let is_page = cookies(headers).any(|value| is_same(value, &cookie));
        if !is_client && !is_page {
            return Err(Problem::new(ProblemKind::Unknown, "the token is missing or wrong")
                .hint("open the link that the server printed, or send `Authorization: Bearer TOKEN`"));
        }
        if !matches!(*method, Method::GET | Method::HEAD) {
            self.check_origin(headers, is_client)?;
        }
        let name = text(headers, USER).map(str::trim).filter(|name| !name.is_empty());
        let name: String = name
            .unwrap_or(if is_client { "http" } else { "page" })
            .chars()
            .take(LONGEST_NAME)
            .collect();
        Ok(Person {
            name: longstep_core::visible::line(&name).into_owned(),
        })
    }

    /// A change comes from a page of this server, or from a program, which says no origin.
    fn check_origin(&self, headers: &HeaderMap, is_client: bool) -> Result<(), Problem> {
        let is_own = match text(headers, ORIGIN.as_str()) {
            Some(origin) => {
                let host = origin
                    .strip_prefix("http://")
                    .or_else(|| origin.strip_prefix("https://"));
                host.is_some_and(|host| self.hosts.contains(&host.to_ascii_lowercase()))
            }
            // A browser says the origin of every change.
            None => is_client,
        };
        if is_own {
            Ok(())
        } else {
            Err(Problem::new(
                ProblemKind::Forbidden,
                "a page of another origin asks for a change",
            ))
        }
    }
}

fn text<'h>(headers: &'h HeaderMap, name: &str) -> Option<&'h str> {
    headers.get(name)?.to_str().ok()
}

fn cookies(headers: &HeaderMap) -> impl Iterator<Item = &str> {
    let pairs = headers
        .get_all(COOKIE)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    pairs
        .flat_map(|line| line.split(';'))
        .filter_map(|pair| pair.trim().strip_prefix(COOKIE_NAME)?.strip_prefix('='))
}

/// Compares two texts in a time that depends on their lengths only.
fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (Sha256::digest(one), Sha256::digest(other));
    let differing = one
        .iter()
        .zip(other.iter())
        .fold(0, |all, (one, other)| all | (one ^ other));
    differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::{HeaderName, HeaderValue};

    fn access() -> Access {
        Access::new(
            Token("t".repeat(64)),
            "127.0.0.1:8765".parse().unwrap(),
            &["Robot.lab:443".to_owned()],
        )
    }

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let pairs = pairs
            .iter()
            .map(|(name, value)| (HeaderName::from_static(name), HeaderValue::from_str(value).unwrap()));
        pairs.collect()
    }

    #[test]
    fn only_known_host_names_lead_to_the_server() {
        for (host, is_known) in [
            ("127.0.0.1:8765", true),
            ("LOCALHOST:8765", true),
            ("robot.lab:443", true),
            ("127.0.0.1", false),
            ("evil.example:8765", false),
            ("", false),
        ] {
            assert_eq!(
                access().check_host(&headers(&[("host", host)])).is_ok(),
                is_known,
                "{host}"
            );
        }
        assert!(access().check_host(&HeaderMap::new()).is_err());
    }

    #[test]
    fn changes_need_the_token_or_a_page_of_this_server() {
        let access = access();
        let bearer = format!("Bearer {}", "t".repeat(64));
        let cookie = format!("other=1; {}", access.set_cookie());
        let cookie = cookie.split("; Path").next().unwrap().to_owned();
        let (own, foreign) = ("http://127.0.0.1:8765", "http://evil.example:8765");
        for (method, pairs, is_allowed) in [
            (Method::GET, vec![], false),
            (Method::GET, vec![("authorization", "Bearer wrong")], false),
            (Method::GET, vec![("authorization", bearer.as_str())], true),
            (Method::GET, vec![("cookie", cookie.as_str())], true),
            (Method::GET, vec![("cookie", "longstep=")], false),
            (Method::POST, vec![("authorization", bearer.as_str())], true),
            (
                Method::POST,
                vec![("authorization", bearer.as_str()), ("origin", foreign)],
                false,
            ),
            (Method::POST, vec![("cookie", cookie.as_str())], false),
            (
                Method::POST,
                vec![("cookie", cookie.as_str()), ("origin", "null")],
                false,
            ),
            (
                Method::POST,
                vec![("cookie", cookie.as_str()), ("origin", foreign)],
                false,
            ),
            (Method::POST, vec![("cookie", cookie.as_str()), ("origin", own)], true),
            (
                Method::DELETE,
                vec![("cookie", cookie.as_str()), ("origin", foreign)],
                false,
            ),
        ] {
            let person = access.person(&method, &headers(&pairs));
            assert_eq!(person.is_ok(), is_allowed, "{method} {pairs:?}");
        }
        let named = headers(&[("authorization", &bearer), ("longstep-user", " ada")]);
        assert!(access.person(&Method::GET, &named).is_ok());
    }
}
