//! Reads files up to a limit.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Limit of bytes for a session's log, a recording and the results of a run: 256 MiB.
pub const LOG_LIMIT: u64 = 256 << 20;

/// Reads a file, a pipe or a device to its end. More than `limit` bytes are an error; the read stops one byte behind
/// the limit, because `/dev/zero` has no end.
///
/// # Errors
///
/// [`std::io::ErrorKind::FileTooLarge`] beyond the limit, or the error of the operating system.
///
/// ```
/// # fn main() -> std::io::Result<()> {
/// # #[cfg(target_os = "linux")] {
/// let error = longstep_files::read_bounded("/dev/zero".as_ref(), 1 << 20).unwrap_err();
/// assert_eq!(error.to_string(), "it is larger than 1 MiB");
/// # }
/// # Ok(()) }
/// ```
pub fn read_bounded(path: &Path, limit: u64) -> std::io::Result<Vec<u8>> {
    read_to_limit(&mut File::open(path)?, limit)
}

/// Reads the rest of an open file; see [`read_bounded`].
pub fn read_to_limit(file: &mut File, limit: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let message = format!("it is larger than {} MiB", limit >> 20);
        Err(std::io::Error::new(std::io::ErrorKind::FileTooLarge, message))
    } else {
        Ok(bytes)
    }
}

/// The byte order mark in UTF-8. Some editors write it at the beginning of a text file.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Reads a text file up to a limit; see [`read_bounded`] and [`text_of`].
pub fn read_text_bounded(path: &Path, limit: u64) -> std::io::Result<String> {
    text_of(read_bounded(path, limit)?)
}

/// Returns the text of a file from its bytes, without the byte order mark at its beginning.
///
/// # Errors
///
/// [`std::io::ErrorKind::InvalidData`] for bytes that are not UTF-8.
///
/// ```
/// assert_eq!(longstep_files::text_of(b"\xef\xbb\xbfnever opened(fridge)".to_vec()).unwrap(), "never opened(fridge)");
/// assert!(longstep_files::text_of(vec![0xff]).is_err());
/// ```
pub fn text_of(mut bytes: Vec<u8>) -> std::io::Result<String> {
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    String::from_utf8(bytes)
        .map_err(|_| std::io::Error::new(std::io::ErrorKind::InvalidData, "it is not a text file (not UTF-8)"))
}
