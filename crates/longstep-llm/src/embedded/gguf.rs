//! The header of a GGUF file: its metadata and the places of its tensors.
//!
//! llama.cpp's loader of projectors trusts these: it ends the program where a value has another type than it expects, and
//! computes with whatever memory holds where a file is cut off. So a projector's header is read here first.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Maximum number of metadata entries, and of tensors.
const ENTRIES: u64 = 100_000;
/// Maximum number of bytes of a text that is kept.
const TEXT: u64 = 65_536;
/// Maximum number of elements of a list that is kept.
const LIST: u64 = 4_096;
/// Maximum number of dimensions of a tensor.
const DIMENSIONS: u32 = 4;
/// The alignment of tensors where the file names none.
const ALIGNMENT: u64 = 32;

/// A value of the metadata.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    U32(u32),
    I32(i32),
    F32(f32),
    Bool(bool),
    Text(String),
    F32List(Vec<f32>),
    I32List(Vec<i32>),
    /// A value of another type, or a list that is too long for a projector.
    Other,
}

/// A tensor of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tensor {
    /// The dimensions, with 1 for those that the file leaves out.
    pub(super) shape: [u64; 4],
    /// True if its numbers are in single precision.
    pub(super) is_f32: bool,
}

/// The header of a file.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) values: HashMap<String, Value>,
    pub(super) tensors: HashMap<String, Tensor>,
}

/// Bytes per block and elements per block of the number formats of tensors, by their number in the file.
const FORMATS: [(u32, u64, u64); 16] = [
    (0, 4, 1),
    (1, 2, 1),
    (2, 18, 32),
    (3, 20, 32),
    (6, 22, 32),
    (7, 24, 32),
    (8, 34, 32),
    (10, 84, 256),
    (11, 110, 256),
    (12, 144, 256),
    (13, 176, 256),
    (14, 210, 256),
    (20, 18, 32),
    (23, 136, 256),
    (30, 2, 1),
    (39, 17, 32),
];

/// Reads the header of a file, and checks that all tensors lie within it.
pub(super) fn read(path: &Path) -> Result<Header, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let metadata = file.metadata().map_err(|error| error.to_string())?;
    if !metadata.is_file() {
        return Err("it is not a file".into());
    }
    let mut source = BoundedFile {
        file: BufReader::new(file),
        length: metadata.len(),
        place: 0,
    };
    header(&mut source)
}

fn header(source: &mut BoundedFile<impl Read + Seek>) -> Result<Header, String> {
    if source.bytes::<4>().ok() != Some(*b"GGUF") {
        return Err("it is not a GGUF file".into());
    }
    let version = source.u32()?;
    if !(2..=3).contains(&version) {
        return Err(format!("its GGUF version {version} is unknown"));
    }
    let (tensors, entries) = (source.u64()?, source.u64()?);
    if tensors > ENTRIES || entries > ENTRIES {
        return Err(DAMAGED.into());
    }
    let mut values = HashMap::new();
    for _ in 0..entries {
        let key = source.text()?;
        let kind = source.u32()?;
        values.insert(key, source.value(kind)?);
    }
    let alignment = match values.get("general.alignment") {
        None => ALIGNMENT,
        Some(Value::U32(own)) if own.is_power_of_two() => u64::from(*own),
        Some(_) => return Err(DAMAGED.into()),
    };
    let mut found = HashMap::new();
    let mut end = 0;
    for _ in 0..tensors {
        let name = source.text()?;
        let (tensor, last) = source.tensor()?;
        end = end.max(last);
        if found.insert(name, tensor).is_some() {
            return Err("it has two tensors of one name".into());
        }
    }
    let data = source.place.next_multiple_of(alignment);
    if data.checked_add(end).is_none_or(|end| end > source.length) {
        return Err("it is incomplete: the file ends within its tensors".into());
    }
    Ok(Header { values, tensors: found })
}

const DAMAGED: &str = "its metadata is damaged or incomplete";

/// A file from which nothing is read behind its end.
struct BoundedFile<R> {
    file: R,
    length: u64,
    place: u64,
}

impl<R: Read + Seek> BoundedFile<R> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes).map_err(|_| DAMAGED)?;
        self.place += N as u64;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.bytes().map(u64::from_le_bytes)
    }

    /// Skips bytes, which must be there.
    fn skip(&mut self, count: u64) -> Result<(), String> {
        let end = self.place.checked_add(count).filter(|end| *end <= self.length);
        let end = end.ok_or(DAMAGED)?;
        let step = i64::try_from(count).map_err(|_| DAMAGED)?;
        self.file.seek_relative(step).map_err(|_| DAMAGED)?;
        self.place = end;
        Ok(())
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.u64()?;
        if length > TEXT || length > self.length - self.place.min(self.length) {
            return Err(DAMAGED.into());
        }
        let mut bytes = vec![0; usize::try_from(length).map_err(|_| DAMAGED)?];
        self.file.read_exact(&mut bytes).map_err(|_| DAMAGED)?;
        self.place += length;
        String::from_utf8(bytes).map_err(|_| DAMAGED.into())
    }

    fn value(&mut self, kind: u32) -> Result<Value, String> {
        Ok(match kind {
            4 => Value::U32(self.u32()?),
            5 => Value::I32(self.bytes().map(i32::from_le_bytes)?),
            6 => Value::F32(self.bytes().map(f32::from_le_bytes)?),
            7 => Value::Bool(self.bytes::<1>()? != [0]),
            8 => {
                let start = self.u64()?;
                if start > TEXT {
                    // A chat template or another long text, which no projector needs.
                    self.skip(start)?;
                    return Ok(Value::Other);
                }
                let mut bytes = vec![0; usize::try_from(start).map_err(|_| DAMAGED)?];
                self.file.read_exact(&mut bytes).map_err(|_| DAMAGED)?;
                self.place += start;
                Value::Text(String::from_utf8_lossy(&bytes).into_owned())
            }
            9 => self.list()?,
            _ => {
                self.skip(size(kind).ok_or(DAMAGED)?)?;
                Value::Other
            }
        })
    }

    fn list(&mut self) -> Result<Value, String> {
        let kind = self.u32()?;
        let count = self.u64()?;
        match kind {
            5 if count <= LIST => {
                let values = (0..count).map(|_| self.bytes().map(i32::from_le_bytes));
                values.collect::<Result<_, _>>().map(Value::I32List)
            }
            6 if count <= LIST => {
                let values = (0..count).map(|_| self.bytes().map(f32::from_le_bytes));
                values.collect::<Result<_, _>>().map(Value::F32List)
            }
            8 => {
                // Each text takes at least the bytes of its length, so this ends within the file.
                for _ in 0..count {
                    let length = self.u64()?;
                    self.skip(length)?;
                }
                Ok(Value::Other)
            }
            _ => {
                let bytes = size(kind).and_then(|size| size.checked_mul(count));
                self.skip(bytes.ok_or(DAMAGED)?)?;
                Ok(Value::Other)
            }
        }
    }

    /// Reads a tensor; returns it with the end of its data, from the beginning of all data.
    fn tensor(&mut self) -> Result<(Tensor, u64), String> {
        let dimensions = self.u32()?;
        if dimensions > DIMENSIONS {
            return Err(DAMAGED.into());
        }
        let mut shape = [1; 4];
        for own in shape.iter_mut().take(dimensions as usize) {
            *own = self.u64()?;
        }
        let elements = shape.iter().try_fold(1_u64, |product, own| product.checked_mul(*own));
        let elements = elements.filter(|count| *count > 0).ok_or(DAMAGED)?;
        let kind = self.u32()?;
        let offset = self.u64()?;
        let format = FORMATS.iter().find(|(number, ..)| *number == kind);
        let (_, bytes, block) = format.ok_or_else(|| format!("its number format {kind} is unknown"))?;
        let bytes = elements.div_ceil(*block).checked_mul(*bytes);
        let end = bytes.and_then(|bytes| offset.checked_add(bytes)).ok_or(DAMAGED)?;
        let is_f32 = kind == FORMATS[0].0;
        Ok((Tensor { shape, is_f32 }, end))
    }
}

/// Returns the bytes of a number in the metadata.
fn size(kind: u32) -> Option<u64> {
    match kind {
        0 | 1 | 7 => Some(1),
        2 | 3 => Some(2),
        4..=6 => Some(4),
        10..=12 => Some(8),
        _ => None,
    }
}
