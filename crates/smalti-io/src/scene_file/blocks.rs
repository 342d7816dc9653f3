//! Images written by blocks of rows.

use smalti::numeric::Planes;

use super::tiles::{Crop, Header};
use crate::raster::Axis;

/// Bytes of samples that are held at once.
const BLOCK_BYTES: u64 = 32 << 20;

/// The image from top to bottom, in parts that fit into memory.
pub(crate) fn row_blocks(header: &Header) -> impl Iterator<Item = Crop> {
    let (rows, cols) = (header.rows, header.cols);
    let row_bytes = (header.decoded_bytes() / rows.max(1) as u64).max(1);
    let count = usize::try_from(BLOCK_BYTES / row_bytes).unwrap_or(usize::MAX).clamp(1, rows.max(1));
    (0..rows).step_by(count).map(move |row| Crop { row, col: 0, rows: count.min(rows - row), cols })
}

/// Samples in an order of axes, slowest first; 32-bit, little-endian.
pub(crate) fn samples(planes: &Planes, order: [Axis; 3]) -> Vec<u8> {
    let (rows, cols) = (planes.rows(), planes.cols());
    let mut out = Vec::with_capacity(planes.data().len() * 4);
    let mut push = |v: f32| out.extend_from_slice(&v.to_le_bytes());
    match order {
        [Axis::Row, Axis::Band, Axis::Col] => {
            for row in 0..rows {
                for plane in planes.planes() {
                    plane.iter().skip(row * cols).take(cols).for_each(|v| push(*v));
                }
            }
        }
        [Axis::Row, Axis::Col, Axis::Band] => {
            for pixel in 0..planes.plane_len() {
                planes.planes().filter_map(|p| p.get(pixel)).for_each(|v| push(*v));
            }
        }
        _ => planes.data().iter().for_each(|v| push(*v)),
    }
    out
}
