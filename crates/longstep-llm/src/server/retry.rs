//! Retries, and the pauses before them.

use std::time::{Duration, SystemTime};

use jiff::Timestamp;
use reqwest::header::{HeaderMap, HeaderValue, RETRY_AFTER};

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
        // Not more than once: most servers that say nothing have nothing to say.
        Failure::Empty(_) if tries == 0 => backoff,
        // Without credit, no wait helps.
        Failure::Rejected { complaint, .. } if complaint.names(&["insufficient_quota"]) => return None,
        Failure::Rejected {
            status: 408 | 429 | 500..,
            wait,
            ..
        } => wait.unwrap_or(backoff),
        Failure::Rejected { .. } | Failure::Empty(_) | Failure::Final(_) => return None,
    };
    (tries < RETRIES && pause <= PATIENCE).then_some(pause)
}

/// The wait that headers name: `Retry-After`, and for too many requests what providers have besides it.
pub(super) fn wait_in_headers(status: u16, headers: &HeaderMap) -> Option<Duration> {
    let text = |name: &str| headers.get(name)?.to_str().ok().map(str::trim);
    if let Some(milliseconds) = text("retry-after-ms").and_then(|text| text.parse::<f64>().ok()) {
        return Duration::try_from_secs_f64(milliseconds / 1000.0).ok();
    }
    if let Some(wait) = headers.get(RETRY_AFTER).and_then(retry_after) {
        return Some(wait);
    }
    let budgets = ["requests", "tokens"].into_iter().filter_map(|budget| {
        let is_left = |name: String| text(&name).is_some_and(|left| left != "0");
        let openai = || {
            let reset = text(&format!("x-ratelimit-reset-{budget}"))?;
            go_duration(reset).filter(|_| !is_left(format!("x-ratelimit-remaining-{budget}")))
        };
        let anthropic = || {
            let reset = text(&format!("anthropic-ratelimit-{budget}-reset"))?
                .parse::<Timestamp>()
                .ok()?;
            let wait = Duration::try_from(reset.duration_since(Timestamp::now())).unwrap_or_default();
            (!is_left(format!("anthropic-ratelimit-{budget}-remaining"))).then_some(wait)
        };
        openai().or_else(anthropic)
    });
    budgets.max().filter(|_| status == 429)
}

/// Reads a duration as OpenAI writes it: `120ms`, `6m0s`, `1h2m3.5s`.
fn go_duration(text: &str) -> Option<Duration> {
    let (mut rest, mut seconds) = (text, 0.0);
    while !rest.is_empty() {
        let end = rest.find(|sign: char| !sign.is_ascii_digit() && sign != '.')?;
        let number: f64 = rest[..end].parse().ok()?;
        let units = [("ms", 0.001), ("h", 3600.0), ("m", 60.0), ("s", 1.0)];
        let (unit, factor) = units.into_iter().find(|(unit, _)| rest[end..].starts_with(unit))?;
        seconds += number * factor;
        rest = &rest[end + unit.len()..];
    }
    Duration::try_from_secs_f64(seconds).ok()
}

/// The wait of a `Retry-After` header: seconds, or a date.
fn retry_after(value: &HeaderValue) -> Option<Duration> {
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
    use super::super::complaint::Complaint;
    use super::*;

    #[test]
    fn retry_wait_is_read_from_provider_headers() {
        for (name, value, status, milliseconds) in [
            ("retry-after-ms", "900", 429, Some(900)),
            ("x-ratelimit-reset-requests", "6m0s", 429, Some(360_000)),
            ("x-ratelimit-reset-tokens", "120ms", 429, Some(120)),
            ("x-ratelimit-reset-tokens", "1h2m3.5s", 429, Some(3_723_500)),
            ("x-ratelimit-reset-tokens", "soon", 429, None),
            ("x-ratelimit-reset-tokens", "120ms", 500, None),
            ("anthropic-ratelimit-tokens-reset", "2024-03-26T20:00:00Z", 429, Some(0)),
            ("anthropic-ratelimit-tokens-reset", "later", 429, None),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(name, HeaderValue::from_static(value));
            let wait = wait_in_headers(status, &headers);
            assert_eq!(wait.map(|wait| wait.as_millis()), milliseconds, "{name}: {value}");
        }
        // The budget that has something left is not the one that is waited for.
        let mut headers = HeaderMap::new();
        for (name, value) in [
            ("x-ratelimit-reset-requests", "6m0s"),
            ("x-ratelimit-remaining-requests", "9"),
            ("x-ratelimit-reset-tokens", "2s"),
            ("x-ratelimit-remaining-tokens", "0"),
        ] {
            headers.insert(name, HeaderValue::from_static(value));
        }
        assert_eq!(wait_in_headers(429, &headers), Some(Duration::from_secs(2)));
    }

    #[test]
    fn retry_wait_is_read_from_the_response_body() {
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
    fn retry_after_accepts_seconds_and_dates() {
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
    fn retry_pauses_double_up_to_a_limit() {
        let rejected = |status, wait| Failure::Rejected {
            status,
            message: String::new(),
            wait,
            complaint: Complaint::default(),
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
