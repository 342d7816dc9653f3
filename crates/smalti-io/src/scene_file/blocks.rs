//! Images written by blocks of rows.

use std::borrow::Cow;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use rayon::prelude::*;
use smalti::numeric::Planes;

use super::crop::Crop;
use super::tiles::Tiles;
use crate::{IoError, write};

/// Bytes of samples that are held at once.
const BLOCK_BYTES: u64 = 32 << 20;
/// The same where rows are unpacked together: rows that are cut off would be unpacked again.
const PACKED_BYTES: u64 = 512 << 20;

/// The image from top to bottom, in parts that fit into memory.
pub(crate) fn row_blocks(image: &dyn Tiles) -> impl Iterator<Item = Crop> {
    let header = image.header();
    let (rows, cols) = (header.rows, header.cols);
    let row_bytes = (header.decoded_bytes() / rows.max(1) as u64).max(1);
    let within = |bytes: u64| usize::try_from(bytes / row_bytes).unwrap_or(usize::MAX).clamp(1, rows.max(1));
    let (count, together) = (within(BLOCK_BYTES), image.rows_at_once().max(1));
    let count =
        if together <= count { count / together * together } else { within(PACKED_BYTES).min(together) };
    (0..rows).step_by(count).map(move |row| Crop { row, col: 0, rows: count.min(rows - row), cols })
}

/// Writes one plane after another from an offset of a file on, 32-bit, little-endian. The position is then at their end. `seen` is
/// given the bytes of each band in their order.
pub(crate) fn write_planes(
    out: &mut write::Target,
    base: u64,
    image: &dyn Tiles,
    path: &Path,
    mut seen: impl FnMut(usize, &[u8]),
) -> Result<(), IoError> {
    let io = IoError::writing(path);
    let header = image.header();
    let row_bytes = header.cols as u64 * 4;
    let plane_bytes = header.rows as u64 * row_bytes;
    for block in row_blocks(image) {
        let planes = image.read(block)?;
        for (i, plane) in planes.planes().enumerate() {
            let place = base + i as u64 * plane_bytes + block.row as u64 * row_bytes;
            let plane = little_endian(plane);
            let bytes: &[u8] = bytemuck::cast_slice(&plane);
            out.seek(SeekFrom::Start(place)).map_err(io)?;
            out.write_all(bytes).map_err(io)?;
            seen(i, bytes);
        }
    }
    let end = base + header.wavelengths_nm.len() as u64 * plane_bytes;
    out.seek(SeekFrom::Start(end)).map_err(io)?;
    Ok(())
}

/// Samples as they lie in files.
pub(crate) fn little_endian(samples: &[f32]) -> Cow<'_, [f32]> {
    if cfg!(target_endian = "little") {
        return samples.into();
    }
    samples.iter().map(|v| f32::from_bits(v.to_bits().to_le())).collect()
}

/// Samples by row, column, band; 32-bit, little-endian.
pub(crate) fn by_pixel(planes: &Planes) -> Vec<f32> {
    const PIXELS: usize = 64;
    let bands = planes.count().max(1);
    let mut out = vec![0f32; planes.data().len()];
    out.par_chunks_mut(PIXELS * bands).enumerate().for_each(|(i, out)| {
        for (band, plane) in planes.planes().enumerate() {
            let from = plane.iter().skip(i * PIXELS);
            out.iter_mut()
                .skip(band)
                .step_by(bands)
                .zip(from)
                .for_each(|(t, v)| *t = f32::from_bits(v.to_bits().to_le()));
        }
    });
    out
}

/// Samples by row, band, column; 32-bit, little-endian.
pub(crate) fn by_line(planes: &Planes) -> Vec<f32> {
    let cols = planes.cols().max(1);
    let mut out = Vec::with_capacity(planes.data().len());
    for row in 0..planes.rows() {
        for plane in planes.planes() {
            let row = plane.iter().skip(row * cols).take(cols);
            out.extend(row.map(|v| f32::from_bits(v.to_bits().to_le())));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use smalti::spectrum::WavelengthGrid;

    use super::*;
    use crate::Quantity;
    use crate::scene_file::stated::Bands;
    use crate::scene_file::tiles::Header;
    use crate::{ReadOptions, scene_file};

    /// An image whose rows are unpacked so many at once.
    struct Packed(Header, usize);

    impl Tiles for Packed {
        fn header(&self) -> &Header {
            &self.0
        }

        fn read(&self, part: Crop) -> Result<Planes, IoError> {
            Ok(Planes::zeros(part.rows, part.cols, self.0.wavelengths_nm.len()))
        }

        fn rows_at_once(&self) -> usize {
            self.1
        }
    }

    /// The heights of the parts of an image of `rows` rows of a mebibyte each.
    fn heights(rows: usize, at_once: usize) -> Vec<usize> {
        let options =
            ReadOptions { grid: WavelengthGrid::new(400.0, 10.0, 32).ok(), ..ReadOptions::default() };
        let bands = Bands::given(Path::new("f"), 32, &options).unwrap();
        let header = Header::plain("f".into(), (rows, 8192), bands, Quantity::Photons);
        let image = scene_file::Restated::new(Packed(header, at_once), None, None);
        let blocks: Vec<Crop> = row_blocks(&image).collect();
        assert!(
            blocks.iter().scan(0, |row, b| Some(std::mem::replace(row, *row + b.rows) == b.row)).all(|b| b)
        );
        blocks.iter().map(|b| b.rows).collect()
    }

    #[test]
    fn parts_end_where_rows_that_are_unpacked_together_do() {
        assert_eq!(heights(80, 1), [32, 32, 16]);
        assert_eq!(heights(80, 10), [30, 30, 20]);
        assert_eq!(heights(80, 33), [33, 33, 14]);
        assert_eq!(heights(700, 300), [300, 300, 100]);
        // Larger than is held at once.
        assert_eq!(heights(1100, 1100), [512, 512, 76]);
    }
}
