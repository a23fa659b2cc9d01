//! The source of an environment, from files and words.

use std::path::Path;

use anyhow::Result;
use longstep::dialogue::{PICTURE_LIMIT, Picture, PictureError};
use longstep_files::{TextFileError, read_bounded, text_of};

use crate::arguments::SeeArguments;
use crate::failure::Failure;

/// Maximum number of pictures.
const PICTURES: usize = 8;
/// Maximum number of bytes of all pictures.
const ALL_PICTURES: usize = 2 * PICTURE_LIMIT;
/// Maximum number of characters of a description.
const WORDS: usize = 4_000;

/// A scene of boxes, or what a model describes.
pub(super) enum Source {
    Scene { file: String, text: String },
    Described { words: String, pictures: Vec<Picture> },
}

impl Source {
    /// Reads the files. A picture is recognised by its content.
    pub(super) fn read(arguments: &SeeArguments) -> Result<Self> {
        let mut pictures = Vec::new();
        let mut scenes = Vec::new();
        if arguments.files.len() > PICTURES {
            return Err(Failure::unreadable(format!("more than {PICTURES} files"))
                .hint("choose the pictures that show most")
                .into());
        }
        for path in &arguments.files {
            let bytes = bytes(path)?;
            match Picture::new(bytes.clone()) {
                Ok(picture) => pictures.push(picture),
                Err(PictureError::Format) if is_json(&bytes) => scenes.push((path, bytes)),
                Err(error) => {
                    let failure = Failure::unreadable(format!("{}: {error}", path.display()));
                    return Err(failure
                        .hint("give PNG, JPEG or WebP pictures, or one scene file (JSON) with `boxes`")
                        .into());
                }
            }
        }
        let words = arguments.words.as_deref().unwrap_or_default().trim();
        match (scenes.pop(), scenes.is_empty()) {
            (Some((path, bytes)), true) if pictures.is_empty() && words.is_empty() => {
                let text = text_of(bytes).map_err(|error| TextFileError::new(path, error))?;
                let file = path.display().to_string();
                return Ok(Self::Scene { file, text });
            }
            (Some(_), _) => {
                let failure =
                    Failure::unreadable("a scene file stands alone: no pictures, words or other scenes with it");
                return Err(failure.hint("run `longstep see` once for each").into());
            }
            (None, _) => {}
        }
        if words.is_empty() && pictures.is_empty() {
            return Err(Failure::unreadable("the description is empty")
                .hint("say what is there: --words \"a table with two mugs\"")
                .into());
        }
        if words.chars().count() > WORDS {
            let failure = Failure::unreadable(format!("the description has more than {WORDS} characters"));
            return Err(failure.hint("describe one room at a time").into());
        }
        if pictures.iter().map(|picture| picture.bytes().len()).sum::<usize>() > ALL_PICTURES {
            let failure = Failure::unreadable(format!("the pictures are larger than {} MiB", ALL_PICTURES >> 20));
            return Err(failure.hint("scale them down").into());
        }
        let words = words.to_owned();
        Ok(Self::Described { words, pictures })
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    let is_folder = std::fs::metadata(path).is_ok_and(|metadata| metadata.is_dir());
    let read = if is_folder {
        Err(std::io::ErrorKind::IsADirectory.into())
    } else {
        read_bounded(path, PICTURE_LIMIT as u64)
    };
    read.map_err(|error| match error.kind() {
        std::io::ErrorKind::FileTooLarge => {
            let message = format!("{} is larger than {} MiB", path.display(), PICTURE_LIMIT >> 20);
            anyhow::Error::from(Failure::unreadable(message).hint("scale the picture down, or split the scene"))
        }
        _ => TextFileError::new(path, error).into(),
    })
}

/// Returns true for bytes that may be JSON: an object comes first.
fn is_json(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    matches!(first, Some(b'{' | b'['))
}
