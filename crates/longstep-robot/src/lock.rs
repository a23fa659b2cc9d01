//! Locks of robots: files that the operating system releases when the program ends, however it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::net::IpAddr;
use std::path::Path;

use crate::error::RobotError;

/// The longest name of a lock's file, in characters.
const LONGEST: usize = 120;

/// Takes the lock of a robot in a folder.
///
/// # Errors
///
/// [`RobotError::InUse`] if another program has it, and [`RobotError::Unreachable`] for a folder in which no file can be made.
pub(crate) fn take(driven: &str, folder: &Path) -> Result<File, RobotError> {
    let path = folder.join(file_name(driven));
    let failed = |error: std::io::Error| RobotError::Unreachable {
        robot: driven.to_owned(),
        reason: format!("its lock {} cannot be taken: {error}", path.display()),
    };
    let file = OpenOptions::new()
        .append(true)
        .create(true)
        .open(&path)
        .map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(RobotError::InUse {
            robot: driven.to_owned(),
        }),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// Returns the name of a lock's file: readable, and different for different robots.
fn file_name(driven: &str) -> String {
    let readable = driven.chars().map(|own| {
        if own.is_ascii_alphanumeric() || own == '.' {
            own
        } else {
            '-'
        }
    });
    let readable: String = readable.take(LONGEST).collect();
    format!("{readable}-{:016x}.lock", hash(driven))
}

/// Returns the name of a computer: this one has several names and addresses of its own.
pub(crate) fn computer(host: &str) -> String {
    let host = host.trim_matches(['[', ']']).trim_end_matches('.').to_ascii_lowercase();
    let address: Option<IpAddr> = host.parse().ok();
    if address.is_some_and(|own| own.is_loopback() || own.is_unspecified()) {
        "localhost".to_owned()
    } else {
        host
    }
}

/// Returns a hash that is the same in every version and on every machine: FNV-1a.
pub(crate) fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lock_uses_one_name_for_the_local_computer() {
        for host in [
            "localhost",
            "LOCALHOST.",
            "127.0.0.1",
            "127.1.2.3",
            "::1",
            "[::1]",
            "0.0.0.0",
        ] {
            assert_eq!(computer(host), "localhost", "{host}");
        }
        assert_eq!(computer("Arm.local"), "arm.local");
        assert_eq!(computer("192.168.1.20"), "192.168.1.20");
    }
}
