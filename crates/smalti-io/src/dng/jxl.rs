//! Strips and tiles of JPEG XL \[iso18181\], as DNG has them since 1.7 \[dng17\]: lossless or lossy.

use jxl_oxide::{AllocTracker, JxlImage, JxlThreadPool};

/// The samples that a strip or tile has.
#[derive(Debug, Clone, Copy)]
pub(super) struct Size {
    /// The last strip ends with the image, so that it may have fewer rows than the others.
    pub(super) least_rows: usize,
    pub(super) most_rows: usize,
    pub(super) cols: usize,
    pub(super) planes: usize,
}

/// Bytes that unpacking takes: the image at several stages, and tables.
pub(super) fn memory(size: Size) -> u64 {
    const STAGES: u64 = 48;
    const TABLES: u64 = 32 << 20;
    let samples =
        [size.most_rows, size.cols, size.planes].iter().fold(1u64, |n, &d| n.saturating_mul(d as u64));
    samples.saturating_mul(STAGES).saturating_add(TABLES)
}

/// Samples in row order, the planes of a pixel side by side, as shares of the largest number (floating point as it is).
/// An error in words where the codestream is damaged or of another size.
pub(super) fn decode(coded: &[u8], size: Size) -> Result<Vec<f32>, String> {
    let memory = usize::try_from(memory(size)).unwrap_or(usize::MAX);
    // The tiles are shared out to threads already.
    let builder =
        JxlImage::builder().pool(JxlThreadPool::none()).alloc_tracker(AllocTracker::with_limit(memory));
    let image = builder.read(coded).map_err(|e| e.to_string())?;
    let (rows, cols) = (image.height() as usize, image.width() as usize);
    let planes = image.pixel_format().channels();
    if !(size.least_rows..=size.most_rows).contains(&rows) || (cols, planes) != (size.cols, size.planes) {
        return Err(format!(
            "it has {rows} × {cols} pixels of {planes} samples, expected {} to {} × {} of {}",
            size.least_rows, size.most_rows, size.cols, size.planes
        ));
    }
    let picture = image.render_frame(0).map_err(|e| e.to_string())?;
    let mut stream = picture.stream();
    let mut shares = vec![0f32; rows * cols * planes];
    match stream.write_to_buffer(&mut shares) == shares.len() {
        true => Ok(shares),
        false => Err("its picture ends too early".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // 4 × 6 samples of 16 bits, 1000 · row + column, lossless; of libjxl 0.11 through imagecodecs.
    const CODED: &str = "0000000c4a584c200d0a870a00000014667479706a786c20000000006a786c20000000096a786c6c0a000000326a786c63ff0a1840fc00458b0804010070004b188b150a2542dcdd0050c927a0e83fe5c742cf2f7618f4fc28070f";

    #[test]
    fn a_codestream_is_unpacked_or_refused_by_its_size() {
        let coded: Vec<u8> =
            (0..CODED.len()).step_by(2).map(|i| u8::from_str_radix(&CODED[i..i + 2], 16).unwrap()).collect();
        let size = Size { least_rows: 4, most_rows: 4, cols: 6, planes: 1 };
        let samples: Vec<f32> = decode(&coded, size).unwrap().iter().map(|v| (v * 65535.0).round()).collect();
        assert!(
            samples.iter().enumerate().all(|(i, v)| *v == (1000 * (i / 6) + i % 6) as f32),
            "{samples:?}"
        );
        for other in [
            Size { cols: 5, ..size },
            Size { planes: 3, ..size },
            Size { least_rows: 5, most_rows: 9, ..size },
        ] {
            assert!(decode(&coded, other).unwrap_err().starts_with("it has 4 × 6 pixels of 1 samples"));
        }
        for end in 0..coded.len() {
            assert!(decode(&coded[..end], size).is_err(), "cut at {end}");
        }
    }
}
