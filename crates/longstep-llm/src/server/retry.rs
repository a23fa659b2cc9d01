//! Retries, and the pauses before them.

use std::time::{Duration, SystemTime};

use reqwest::header::HeaderValue;

use super::failure::Failure;

/// Number of retries of a request.
const RETRIES: u32 = 2;

/// Longest wait that a server may ask for; beyond it the call fails at once.
const PATIENCE: Duration = Duration::from_secs(60);

/// The pause before the next attempt; `None` if there is none. `tries` is the number of failed attempts before.
pub(super) fn pause(failure: &Failure, tries: u32) -> Option<Duration> {
    let backoff = Duration::from_millis(500) * 2_u32.pow(tries.min(RETRIES));
    let pause = match failure {
        Failure::Unreachable(_) => backoff,
        Failure::Rejected {
            status: 408 | 429 | 500..,
            wait,
            ..
        } => wait.unwrap_or(backoff),
        Failure::Rejected { .. } | Failure::Final(_) => return None,
    };
    (tries < RETRIES && pause <= PATIENCE).then_some(pause)
}

/// The wait of a `Retry-After` header: seconds, or a date.
pub(super) fn retry_after(value: &HeaderValue) -> Option<Duration> {
    let text = value.to_str().ok()?.trim();
    if let Ok(seconds) = text.parse::<f64>() {
        return Duration::try_from_secs_f64(seconds).ok();
    }
    let date = httpdate::parse_http_date(text).ok()?;
    Some(date.duration_since(SystemTime::now()).unwrap_or_default())
}

/// The wait that an error body names: Gemini's `retryDelay`, or words such as "try again in 2.77s".
pub(super) fn wait_in_body(body: &str) -> Option<Duration> {
    let body = body.to_lowercase();
    let after = ["\"retrydelay\"", "try again in", "retry in", "retry after"];
    let found = after
        .into_iter()
        .find_map(|words| Some(&body[body.find(words)? + words.len()..]))?;
    let number = found.trim_start_matches([':', ' ', '"']);
    let end = number
        .find(|own: char| !own.is_ascii_digit() && own != '.')
        .unwrap_or(number.len());
    let (number, unit) = number.split_at(end);
    let factor = match unit.trim_start() {
        unit if unit.starts_with("ms") || unit.starts_with("millisecond") => 0.001,
        unit if unit.starts_with('s') => 1.0,
        unit if unit.starts_with('m') => 60.0,
        _ => return None,
    };
    Duration::try_from_secs_f64(number.trim_end_matches('.').parse::<f64>().ok()? * factor).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_says_how_long() {
        for (body, milliseconds) in [
            (r#"{"details": [{"retryDelay": "3.016342224s"}]}"#, Some(3016)),
            ("Rate limit reached. Please try again in 2.77s. Visit", Some(2770)),
            ("Please retry in 120ms.", Some(120)),
            ("try again in 20 seconds", Some(20_000)),
            ("try again in 1m", Some(60_000)),
            ("try again in a while", None),
            ("try again later", None),
            ("", None),
        ] {
            assert_eq!(wait_in_body(body).map(|own| own.as_millis()), milliseconds, "{body}");
        }
    }

    #[test]
    fn a_server_says_how_long_in_seconds_or_by_a_date() {
        let read = |text: &str| retry_after(&HeaderValue::from_str(text).unwrap());
        assert_eq!(read("3"), Some(Duration::from_secs(3)));
        assert_eq!(read(" 0.5 "), Some(Duration::from_millis(500)));
        assert_eq!(read("-1"), None);
        assert_eq!(read("soon"), None);
        assert_eq!(read("Wed, 21 Oct 2015 07:28:00 GMT"), Some(Duration::ZERO));
        let date = httpdate::fmt_http_date(SystemTime::now() + Duration::from_secs(30));
        let wait = read(&date).unwrap();
        assert!(
            wait > Duration::from_secs(27) && wait <= Duration::from_secs(30),
            "{wait:?}"
        );
    }

    #[test]
    fn pauses_double_and_have_an_end() {
        let rejected = |status, wait| Failure::Rejected {
            status,
            message: String::new(),
            wait,
            body: String::new(),
        };
        let milliseconds = |failure: &Failure, tries| pause(failure, tries).map(|pause| pause.as_millis());
        for status in [408, 429, 500, 503] {
            let failure = rejected(status, None);
            let pauses: Vec<_> = (0..4).map(|tries| milliseconds(&failure, tries)).collect();
            assert_eq!(pauses, [Some(500), Some(1000), None, None]);
        }
        for status in [307, 400, 401, 404, 422] {
            assert_eq!(pause(&rejected(status, Some(Duration::ZERO)), 0), None);
        }
        let delay = |seconds| milliseconds(&rejected(429, Some(Duration::from_secs(seconds))), 0);
        assert_eq!((delay(7), delay(60), delay(61)), (Some(7000), Some(60_000), None));
    }
}
