//! The random numbers behind the fixed pattern of a device, which are the same in every capture.

use rayon::prelude::*;

use super::{ColorArchitecture, Sensor};
use crate::numeric::Rect;
use crate::numeric::normal::normal_pair;
use crate::numeric::poisson::{LANES, LaneCounter};
use crate::numeric::simd::{Kernel, dispatch};

/// Rows that one task draws.
const TASK_ROWS: usize = 16;

/// The purpose of the random numbers of gain, offset and defects of a pixel, keyed by the serial number.
const PURPOSE: u32 = 0x5345_4e03;

/// What chooses the pattern of a device: its serial number, and whether planes have separate patterns (the sensors of a prism) or one
/// (sequential captures).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PatternSource {
    pub(super) serial: [u32; 2],
    pub(super) separate: bool,
}

/// The random numbers of a block of photodiodes.
pub(super) struct PatternBlock {
    /// Standard normal deviates of the gain.
    pub(super) gain: [f32; LANES],
    /// Standard normal deviates of the offset.
    pub(super) offset: [f32; LANES],
    /// Random words that choose dead and hot pixels.
    pub(super) defect: [u32; LANES],
}

impl PatternSource {
    pub(super) fn of(sensor: &Sensor) -> Self {
        let serial = sensor.nonuniformity.device_serial;
        Self {
            serial: [serial as u32, (serial >> 32) as u32],
            separate: sensor.architecture == ColorArchitecture::Prism,
        }
    }

    /// Word 3 of the counter.
    pub(super) fn plane(self, plane: u32) -> u32 {
        if self.separate { plane << 16 } else { 0 }
    }

    /// The block from `(row, col)`.
    #[inline(always)]
    pub(super) fn block(self, (row, col, plane): (u32, u32, u32)) -> PatternBlock {
        let counter =
            LaneCounter { key: self.serial, first: col, row, purpose: PURPOSE, attempt: self.plane(plane) };
        let [first, second, defect, _] = counter.block();
        let mut block = PatternBlock { gain: [0.0; LANES], offset: [0.0; LANES], defect };
        for i in 0..LANES {
            (block.gain[i], block.offset[i]) = normal_pair(first[i], second[i]);
        }
        block
    }
}

/// The random numbers of every photodiode of a window.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pattern {
    source: PatternSource,
    window: Rect,
    /// For each plane, row by row: deviates of the gain, of the offset, and random words for defects.
    gain: Vec<f32>,
    offset: Vec<f32>,
    defect: Vec<u32>,
}

impl Pattern {
    /// The pattern of the window of a sensor without binning; `None` if its pixels are alike.
    pub(super) fn new(sensor: &Sensor) -> Option<Self> {
        let non = &sensor.nonuniformity;
        let differs = [non.prnu_fraction, non.dsnu_v, non.dead_pixel_fraction, non.hot_pixel_fraction];
        if differs == [0.0; 4] {
            return None;
        }
        let (source, window) = (PatternSource::of(sensor), sensor.read_window());
        let planes = if source.separate { sensor.sampling().planes() } else { 1 };
        let count = planes * window.rows * window.cols;
        let (mut gain, mut offset, mut defect) = (vec![0.0; count], vec![0.0; count], vec![0; count]);
        let of_task = TASK_ROWS * window.cols;
        let of_plane = window.rows * window.cols;
        for plane in 0..planes {
            let part = plane * of_plane..(plane + 1) * of_plane;
            let tasks = gain[part.clone()]
                .par_chunks_mut(of_task)
                .zip(offset[part.clone()].par_chunks_mut(of_task))
                .zip(defect[part].par_chunks_mut(of_task));
            tasks.enumerate().for_each(|(task, ((gain, offset), defect))| {
                let first = ((window.row + task * TASK_ROWS) as u32, window.col as u32, plane as u32);
                dispatch(Draw { source, first, cols: window.cols, gain, offset, defect });
            });
        }
        Some(Self { source, window, gain, offset, defect })
    }

    /// Whether it is the pattern of the source.
    pub(super) fn is_of(&self, source: PatternSource) -> bool {
        self.source == source
    }

    /// Whether it is the pattern of a window.
    pub(super) fn is_in(&self, window: Rect) -> bool {
        self.window == window
    }

    /// The block from `(row, col)` within the window.
    #[inline(always)]
    pub(super) fn block(&self, (row, col, plane): (u32, u32, u32)) -> PatternBlock {
        let plane = if self.source.separate { plane as usize } else { 0 };
        let (rows, cols) = (self.window.rows, self.window.cols);
        let (row, col) = (row as usize - self.window.row, col as usize - self.window.col);
        let start = (plane * rows + row) * cols + col;
        let places = start..start + LANES.min(cols - col);
        let len = places.len();
        let mut block = PatternBlock { gain: [0.0; LANES], offset: [0.0; LANES], defect: [0; LANES] };
        block.gain[..len].copy_from_slice(&self.gain[places.clone()]);
        block.offset[..len].copy_from_slice(&self.offset[places.clone()]);
        block.defect[..len].copy_from_slice(&self.defect[places]);
        block
    }
}

/// Draws the numbers of some rows.
struct Draw<'a> {
    source: PatternSource,
    /// Row, column and plane of the first photodiode.
    first: (u32, u32, u32),
    cols: usize,
    gain: &'a mut [f32],
    offset: &'a mut [f32],
    defect: &'a mut [u32],
}

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { source, first: (row, col, plane), cols, gain, offset, defect } = self;
        let rows = gain.chunks_mut(cols).zip(offset.chunks_mut(cols)).zip(defect.chunks_mut(cols));
        for (r, ((gain, offset), defect)) in rows.enumerate() {
            let blocks = gain.chunks_mut(LANES).zip(offset.chunks_mut(LANES)).zip(defect.chunks_mut(LANES));
            for (b, ((gain, offset), defect)) in blocks.enumerate() {
                let block = source.block((row + r as u32, col + (b * LANES) as u32, plane));
                gain.copy_from_slice(&block.gain[..gain.len()]);
                offset.copy_from_slice(&block.offset[..offset.len()]);
                defect.copy_from_slice(&block.defect[..defect.len()]);
            }
        }
    }
}
