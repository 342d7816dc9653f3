//! Strips and tiles of JPEG XL (ISO/IEC 18181), as DNG has them since 1.7: lossless or lossy.

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

/// Samples in row order, the planes of a pixel side by side, as shares of the largest number (floating point as it is).
/// An error in words where the codestream is damaged or of another size.
pub(super) fn decode(coded: &[u8], size: Size) -> Result<Vec<f32>, String> {
    let samples = size.most_rows.saturating_mul(size.cols).saturating_mul(size.planes);
    // Several copies of the image at different stages, and tables.
    let memory = samples.saturating_mul(64).saturating_add(64 << 20);
    // The tiles are shared out to threads already.
    let builder =
        JxlImage::builder().pool(JxlThreadPool::none()).alloc_tracker(AllocTracker::with_limit(memory));
    let image = builder.read(coded).map_err(|e| e.to_string())?;
    let (rows, cols) = (image.height() as usize, image.width() as usize);
    let planes = image.pixel_format().channels();
    if !(size.least_rows..=size.most_rows).contains(&rows) || (cols, planes) != (size.cols, size.planes) {
        return Err(format!(
            "it has {rows} × {cols} pixels of {planes} samples, expected {} × {} of {}",
            size.most_rows, size.cols, size.planes
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
