//! Pictures as pixels, within bounds.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use longstep::dialogue::Picture;

/// Maximum number of pixels: 3 bytes each, once as decoded and once in the engine.
const PIXELS: u64 = 50_000_000;
/// Maximum number of bytes that a decoder may allocate.
const MEMORY: u64 = 512 * 1024 * 1024;
/// Minimum length of a side. Models scale pictures to whole patches, of which thinner ones have none.
const SHORTEST: u32 = 16;
/// Maximum ratio of the sides, for the same reason.
const RATIO: u32 = 32;

/// A picture in rows of red, green and blue bytes.
pub(super) struct Pixels {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) bytes: Vec<u8>,
}

/// Decodes a picture. Its size is checked before any pixel is decoded, and it is turned upright if it says how. Pixels that
/// can be seen through are put on white.
pub(super) fn decode(picture: &Picture) -> Result<Pixels, String> {
    let format = ImageFormat::from_mime_type(picture.media_type()).ok_or("its format is unknown")?;
    let mut reader = ImageReader::with_format(Cursor::new(picture.bytes()), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MEMORY);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|error| reason(&error))?;
    let (width, height) = decoder.dimensions();
    check_size(width, height)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(|error| reason(&error))?;
    image.apply_orientation(orientation);
    Ok(Pixels {
        width: image.width(),
        height: image.height(),
        bytes: opaque(image),
    })
}

fn check_size(width: u32, height: u32) -> Result<(), String> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > PIXELS {
        let most = PIXELS / 1_000_000;
        return Err(format!(
            "it has {width} x {height} pixels, more than {most} million; scale it down"
        ));
    }
    let (short, long) = (width.min(height), width.max(height));
    if short < SHORTEST {
        return Err(format!(
            "it has {width} x {height} pixels; each side needs at least {SHORTEST}"
        ));
    }
    if long > short.saturating_mul(RATIO) {
        return Err(format!(
            "it has {width} x {height} pixels; no side can be more than {RATIO} times the other"
        ));
    }
    Ok(())
}

/// Returns the red, green and blue bytes of a picture on white, so that what cannot be seen shows no colour of its own.
fn opaque(image: DynamicImage) -> Vec<u8> {
    if !image.color().has_alpha() {
        return image.into_rgb8().into_raw();
    }
    let image = image.into_rgba8();
    let on_white = image.pixels().flat_map(|pixel| {
        let [red, green, blue, alpha] = pixel.0.map(u16::from);
        let mixed = [red, green, blue].map(|colour| (colour * alpha + 255 * (255 - alpha)) / 255);
        mixed.map(|colour| u8::try_from(colour).unwrap_or(u8::MAX))
    });
    on_white.collect()
}

fn reason(error: &ImageError) -> String {
    let text = match error {
        ImageError::Limits(_) => format!("decoding it takes more than {} MiB", MEMORY >> 20),
        _ => error.to_string(),
    };
    text.lines().next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn decoded(bytes: Vec<u8>) -> Result<Pixels, String> {
        decode(&Picture::new(bytes).unwrap())
    }

    #[test]
    fn every_format_gives_its_pixels() {
        let image = image::RgbImage::from_fn(40, 20, |x, _| image::Rgb([if x < 20 { 200 } else { 20 }, 90, 90]));
        let image = DynamicImage::ImageRgb8(image);
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP] {
            let pixels = decoded(encoded(&image, format)).unwrap();
            assert_eq!((pixels.width, pixels.height), (40, 20), "{format:?}");
            assert_eq!(pixels.bytes.len(), 40 * 20 * 3);
            assert!(pixels.bytes[0] > 180 && pixels.bytes[39 * 3] < 40, "{format:?}");
        }
        let clear = image::RgbaImage::from_pixel(16, 16, image::Rgba([0, 0, 0, 0]));
        let pixels = decoded(encoded(&DynamicImage::ImageRgba8(clear), ImageFormat::Png)).unwrap();
        assert!(pixels.bytes.iter().all(|byte| *byte == 255));
    }

    #[test]
    fn sizes_out_of_bounds_are_refused() {
        for (width, height, expected) in [
            (15, 100, "at least 16"),
            (16, 513, "more than 32 times"),
            (10_000, 5_001, "more than 50 million"),
            (u32::MAX, u32::MAX, "more than 50 million"),
            (0, 0, "at least 16"),
        ] {
            let error = check_size(width, height).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        for (width, height) in [(16, 512), (512, 16), (10_000, 5_000)] {
            check_size(width, height).unwrap();
        }
    }

    #[test]
    fn a_damaged_picture_is_an_error_or_still_a_picture() {
        let image = DynamicImage::ImageRgb8(image::RgbImage::from_fn(64, 48, |x, y| {
            image::Rgb([(x * 3) as u8, (y * 5) as u8, (x * y) as u8])
        }));
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP] {
            let whole = encoded(&image, format);
            for cut in 0..whole.len() {
                let Ok(picture) = Picture::new(whole[..cut].to_vec()) else {
                    continue;
                };
                if let Ok(pixels) = decode(&picture) {
                    assert_eq!(
                        pixels.bytes.len() as u64,
                        u64::from(pixels.width) * u64::from(pixels.height) * 3
                    );
                }
            }
            for place in (12..whole.len()).step_by(7) {
                let mut bytes = whole.clone();
                bytes[place] ^= 0xff;
                let Ok(picture) = Picture::new(bytes) else { continue };
                if let Ok(pixels) = decode(&picture) {
                    assert_eq!(
                        pixels.bytes.len() as u64,
                        u64::from(pixels.width) * u64::from(pixels.height) * 3
                    );
                }
            }
        }
    }
}
