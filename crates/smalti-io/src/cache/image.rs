//! Optical images as entries: the numbers of the header, then the planes.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use blake3::Hash;
use rayon::prelude::*;
use smalti::numeric::Planes;
use smalti::optics::OpticalImage;
use smalti::spectrum::{SpectralCube, WavelengthGrid};

use super::entry::{self, HEADER_LEN};
use crate::scene_file::blocks::little_endian;

/// Rows, columns, wavelengths, the first wavelength, their step, the spacing of the samples: 8 bytes each.
const GEOMETRY_LEN: usize = 6 * 8;

/// Hands over the content of an entry.
pub(super) fn with_pieces(image: &OpticalImage, keep: impl FnOnce(&[&[u8]])) {
    let cube = image.irradiance();
    let grid = cube.grid();
    let mut geometry = Vec::with_capacity(GEOMETRY_LEN);
    for n in [cube.rows(), cube.cols(), grid.len()] {
        geometry.extend((n as u64).to_le_bytes());
    }
    for v in [grid.start_nm(), grid.step_nm(), image.sample_spacing_m()] {
        geometry.extend(v.to_le_bytes());
    }
    let data = little_endian(cube.planes().data());
    keep(&[&geometry, bytemuck::cast_slice(&data)]);
}

/// The image of a key, bit for bit as it was kept; `None` when there is none that is whole.
pub(super) fn read(path: &Path, key: &Hash) -> Option<OpticalImage> {
    let mut opened = entry::open(path, key)?;
    let mut geometry = [0; GEOMETRY_LEN];
    opened.file.read_exact(&mut geometry).ok()?;
    let (numbers, _) = geometry.as_chunks::<8>();
    let [rows, cols, count, start_nm, step_nm, spacing_m] = numbers.first_chunk::<6>()?;
    let size = |b: &[u8; 8]| usize::try_from(u64::from_le_bytes(*b)).ok();
    let float = |b: &[u8; 8]| f64::from_le_bytes(*b);
    let (rows, cols, count) = (size(rows)?, size(cols)?, size(count)?);
    let values = rows.checked_mul(cols)?.checked_mul(count)?;
    if values.checked_mul(4)?.checked_add(GEOMETRY_LEN)? != opened.len {
        return None;
    }
    let mut data = bytemuck::allocation::try_zeroed_vec::<f32>(values).ok()?;
    let mut sum = crc32fast::Hasher::new();
    sum.update(&geometry);
    sum.combine(&read_values(path, &mut data)?);
    if sum.finalize() != opened.checksum {
        return None;
    }
    if cfg!(target_endian = "big") {
        data = little_endian(&data).into_owned();
    }
    let grid = WavelengthGrid::new(float(start_nm), float(step_nm), count).ok()?;
    let planes = Planes::new(rows, cols, count, data).ok()?;
    OpticalImage::new(SpectralCube::new(grid, planes).ok()?, float(spacing_m)).ok()
}

/// Fills `data` with what follows the numbers, and returns its CRC-32. Most of the time goes into the pages the
/// operating system copies and hands out, so several threads share the work.
fn read_values(path: &Path, data: &mut [f32]) -> Option<crc32fast::Hasher> {
    const PER_THREAD: usize = 1 << 21;
    // Small enough to be in the processor's cache still when it is summed up.
    const STEP: usize = 1 << 18;
    let pieces: Vec<crc32fast::Hasher> = data
        .par_chunks_mut(PER_THREAD)
        .enumerate()
        .map(|(i, piece)| {
            let mut file = File::open(path).ok()?;
            file.seek(SeekFrom::Start((HEADER_LEN + GEOMETRY_LEN + 4 * PER_THREAD * i) as u64)).ok()?;
            let mut sum = crc32fast::Hasher::new();
            for bytes in bytemuck::cast_slice_mut::<f32, u8>(piece).chunks_mut(STEP) {
                file.read_exact(bytes).ok()?;
                sum.update(bytes);
            }
            Some(sum)
        })
        .collect::<Option<_>>()?;
    let mut whole = crc32fast::Hasher::new();
    pieces.iter().for_each(|piece| whole.combine(piece));
    Some(whole)
}
