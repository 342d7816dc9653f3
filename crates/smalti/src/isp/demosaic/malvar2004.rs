//! Malvar, He and Cutler 2004, "High-quality linear interpolation for demosaicing of Bayer-patterned color images":
//! bilinear interpolation with a correction by the Laplacian of the channel of the pixel.

use super::super::IspError;
use super::bayer::Bayer;
use super::plan::{Border, Plan, Tap};
use crate::sensor::Mosaic;

/// The published 5 × 5 filters in eighths, doubled to be integers (figure 2 of the paper).
const GREEN: [[i8; 5]; 5] =
    [[0, 0, -2, 0, 0], [0, 0, 4, 0, 0], [-2, 4, 8, 4, -2], [0, 0, 4, 0, 0], [0, 0, -2, 0, 0]];
/// A chroma channel at a green pixel with its samples on the left and right.
const CHROMA_BESIDE: [[i8; 5]; 5] =
    [[0, 0, 1, 0, 0], [0, -2, 0, -2, 0], [-2, 8, 10, 8, -2], [0, -2, 0, -2, 0], [0, 0, 1, 0, 0]];
/// A chroma channel at a pixel of the other chroma channel.
const CHROMA_ACROSS: [[i8; 5]; 5] =
    [[0, 0, -3, 0, 0], [0, 4, 0, 4, 0], [-3, 0, 12, 0, -3], [0, 4, 0, 4, 0], [0, 0, -3, 0, 0]];

/// The filters for a Bayer mosaic. At the border the image is mirrored.
pub(super) fn plan(mosaic: &Mosaic) -> Result<Plan, IspError> {
    let bayer = Bayer::required(mosaic, "malvar2004")?;
    Plan::new(mosaic, Border::Mirror, |row, col, channel| {
        if mosaic.channel_at(row, col) == channel {
            return Ok(vec![Tap { row: 0, col: 0, weight: 1.0 }]);
        }
        let beside = bayer.chroma_of_row(row) == channel;
        let (filter, transposed) = match (channel == bayer.green, bayer.is_green(row, col)) {
            (true, _) => (&GREEN, false),
            (false, true) => (&CHROMA_BESIDE, !beside),
            (false, false) => (&CHROMA_ACROSS, false),
        };
        let cells = (0..5).flat_map(|r| (0..5).map(move |c| (r, c)));
        let tap = |(r, c): (usize, usize)| Tap {
            row: r as i32 - 2,
            col: c as i32 - 2,
            weight: f32::from(if transposed { filter[c][r] } else { filter[r][c] }) / 16.0,
        };
        Ok(cells.map(tap).filter(|t| t.weight != 0.0).collect())
    })
}
