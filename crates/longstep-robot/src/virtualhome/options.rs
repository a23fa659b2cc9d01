//! The options of a VirtualHome simulator: `http://127.0.0.1:8080,room=kitchen`.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use longstep_core::{secret, visible};

use crate::lock;

/// The longest timeout of a line: an hour.
const LONGEST: u64 = 3_600;

/// The address and the options of a simulator.
///
/// ```
/// use longstep_robot::virtualhome::VirtualHomeOptions;
/// let options: VirtualHomeOptions = "http://127.0.0.1:8080,room=kitchen,timeout=120".parse()?;
/// assert_eq!(options.room.as_deref(), Some("kitchen"));
/// assert!("127.0.0.1:8080".parse::<VirtualHomeOptions>().is_err());
/// # Ok::<(), longstep_robot::virtualhome::VirtualHomeOptionsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct VirtualHomeOptions {
    /// The address of the simulator.
    pub url: String,
    /// The model of the character that is added to a scene without one.
    pub character: String,
    /// The room in which this character begins; a random place without one.
    pub room: Option<String>,
    /// The folder for a picture after each step.
    pub pictures: Option<PathBuf>,
    /// The timeout of a line.
    pub timeout: Duration,
}

/// An address or an option that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no address and no option of `virtualhome`; write `virtualhome:URL` or `virtualhome:URL,OPTION=VALUE,...` with room, \
     character, pictures (a folder) or timeout (seconds, 1 to 3600)"
)]
pub struct VirtualHomeOptionsError(String);

impl VirtualHomeOptions {
    /// The simulator by the name of its lock: its computer and port. A simulator has one world for all its clients.
    pub fn drives(&self) -> Vec<String> {
        let place = reqwest::Url::parse(&self.url).ok().and_then(|url| {
            let host = lock::computer(url.host_str()?);
            Some(format!("{host}:{}", url.port_or_known_default()?))
        });
        let place = place.unwrap_or_else(|| secret::in_addresses(&self.url).into_owned());
        vec![format!("virtualhome {place}")]
    }

    /// Returns the options of a simulator at an address.
    pub fn new(url: &str) -> Self {
        Self {
            url: url.to_owned(),
            character: "Chars/Male2".to_owned(),
            room: None,
            pictures: None,
            timeout: Duration::from_secs(60),
        }
    }

    fn set(&mut self, part: &str) -> Option<()> {
        let (name, value) = part.split_once('=')?;
        if value.is_empty() {
            return None;
        }
        match name {
            "room" => self.room = Some(value.to_owned()),
            "character" => value.clone_into(&mut self.character),
            "pictures" => self.pictures = Some(PathBuf::from(value)),
            "timeout" => {
                let seconds = value.parse().ok().filter(|seconds| (1..=LONGEST).contains(seconds))?;
                self.timeout = Duration::from_secs(seconds);
            }
            _ => return None,
        }
        Some(())
    }
}

impl FromStr for VirtualHomeOptions {
    type Err = VirtualHomeOptionsError;

    fn from_str(text: &str) -> Result<Self, VirtualHomeOptionsError> {
        let mut parts = text.split(',').map(str::trim);
        let url = parts.next().unwrap_or_default();
        let refused = |part: &str| VirtualHomeOptionsError(secret::redacted(&visible::line(part)).into_owned());
        let parsed = reqwest::Url::parse(url).map_err(|_| refused(url))?;
        if !matches!(parsed.scheme(), "http" | "https") || parsed.host().is_none() {
            return Err(refused(url));
        }
        let mut options = Self::new(url);
        for part in parts.filter(|part| !part.is_empty()) {
            options.set(part).ok_or_else(|| refused(part))?;
        }
        Ok(options)
    }
}
