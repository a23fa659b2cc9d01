//! Pictures in requests to a model.

use std::fmt;
use std::sync::Arc;

/// Maximum number of bytes of one picture.
pub const PICTURE_LIMIT: usize = 20 * 1024 * 1024;

/// A picture for a model that sees. Copies share the bytes.
///
/// ```
/// use longstep::dialogue::Picture;
/// let picture = Picture::new(b"\x89PNG\r\n\x1a\n...".to_vec())?;
/// assert_eq!(picture.media_type(), "image/png");
/// assert!(Picture::new(b"GIF89a".to_vec()).is_err());
/// # Ok::<(), longstep::dialogue::PictureError>(())
/// ```
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Picture {
    bytes: Arc<[u8]>,
    media_type: &'static str,
}

/// The reason why bytes are no picture for a model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The bytes have no known format.
    #[error("not a PNG, JPEG or WebP picture")]
    Format,
    /// The picture is too large.
    #[error("larger than {} MiB", PICTURE_LIMIT / (1024 * 1024))]
    TooLarge,
}

impl Picture {
    /// Recognises the format of a picture by its first bytes. The picture is not decoded.
    ///
    /// # Errors
    ///
    /// Another format than PNG, JPEG and WebP, and more than 20 MiB.
    pub fn new(bytes: Vec<u8>) -> Result<Self, PictureError> {
        if bytes.len() > PICTURE_LIMIT {
            return Err(PictureError::TooLarge);
        }
        let media_type = match &bytes[..] {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => "image/png",
            [0xff, 0xd8, 0xff, ..] => "image/jpeg",
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "image/webp",
            _ => return Err(PictureError::Format),
        };
        Ok(Self {
            bytes: bytes.into(),
            media_type,
        })
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The media type: `image/png`, `image/jpeg` or `image/webp`.
    pub fn media_type(&self) -> &'static str {
        self.media_type
    }
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Picture({}, {} bytes)", self.media_type, self.bytes.len())
    }
}
