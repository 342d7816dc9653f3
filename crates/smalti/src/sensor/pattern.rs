//! The random numbers behind the fixed pattern of a device, which are the same in every capture.

use rayon::prelude::*;

use super::drawn_blocks::{BlockSource, DrawRow, DrawnBlocks};
use super::{ColorArchitecture, Sensor};
use crate::numeric::Rect;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::key;
use crate::numeric::poisson::{LANES, LaneCounter};
use crate::numeric::simd::dispatch;

/// The least number of rows that one task draws.
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
#[derive(Debug, Clone, PartialEq)]
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
        Self {
            serial: key(sensor.nonuniformity.device_serial),
            separate: sensor.architecture == ColorArchitecture::Prism,
        }
    }

    /// Word 3 of the counter.
    pub(super) fn plane(self, plane: u32) -> u32 {
        if self.separate { plane << 16 } else { 0 }
    }
}

impl BlockSource for PatternSource {
    type Block = PatternBlock;

    #[inline(always)]
    fn block(self, (row, col, plane): (u32, u32, u32)) -> PatternBlock {
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
    planes: usize,
    drawn: DrawnBlocks<PatternBlock>,
}

impl Pattern {
    /// The pattern of the window of a sensor without binning; `None` if its pixels are alike.
    pub(super) fn new(sensor: &Sensor) -> Option<Self> {
        if !sensor.nonuniformity.differs() {
            return None;
        }
        let (source, window, planes) = Self::drawn_for(sensor);
        let rows = (0..planes * window.rows).into_par_iter().with_min_len(TASK_ROWS);
        let of_row =
            |i: usize| dispatch(DrawRow { source, window, row: i % window.rows, plane: i / window.rows });
        let blocks = rows.flat_map_iter(of_row).collect();
        Some(Self { source, planes, drawn: DrawnBlocks { window, blocks } })
    }

    /// What the numbers of a sensor depend on.
    fn drawn_for(sensor: &Sensor) -> (PatternSource, Rect, usize) {
        let source = PatternSource::of(sensor);
        (source, sensor.read_window(), if source.separate { sensor.sampling().planes() } else { 1 })
    }

    /// Whether it is the one that [`Pattern::new`] draws for a sensor.
    pub(super) fn suits(&self, sensor: &Sensor) -> bool {
        sensor.nonuniformity.differs()
            && Self::drawn_for(sensor) == (self.source, self.drawn.window, self.planes)
    }

    /// Whether it is the pattern of the source.
    pub(super) fn is_of(&self, source: PatternSource) -> bool {
        self.source == source
    }

    /// The block from `(row, col)` within the window, whose column is a multiple of [`LANES`] from that of the window.
    #[inline(always)]
    pub(super) fn block(&self, (row, col, plane): (u32, u32, u32)) -> &PatternBlock {
        self.drawn.at((row, col, if self.source.separate { plane } else { 0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::clear_sensor::clear_sensor;

    /// A pattern suits exactly the sensors for which the same one would be drawn.
    #[test]
    fn a_pattern_suits_sensors_of_equal_numbers() {
        let mut plain = clear_sensor(8, 140, 2);
        plain.nonuniformity.prnu_fraction = 0.01;
        let changed = |change: &dyn Fn(&mut Sensor)| {
            let mut sensor = plain.clone();
            change(&mut sensor);
            sensor
        };
        let sensors = [
            plain.clone(),
            changed(&|s| s.pixel.full_well_e = 2e4),
            changed(&|s| s.nonuniformity.dsnu_v = 0.1),
            changed(&|s| s.nonuniformity.device_serial = 2),
            changed(&|s| s.nonuniformity.prnu_fraction = 0.0),
            changed(&|s| s.window = Some(Rect { row: 2, col: 3, rows: 4, cols: 130 })),
            changed(&|s| s.architecture = ColorArchitecture::Prism),
            changed(&|s| (s.architecture, s.cfa) = (ColorArchitecture::Prism, clear_sensor(1, 1, 1).cfa)),
            changed(&|s| s.architecture = ColorArchitecture::FieldSequential),
        ];
        for (i, first) in sensors.iter().enumerate() {
            let drawn = Pattern::new(first);
            for (j, second) in sensors.iter().enumerate() {
                let same = drawn.is_some() && drawn == Pattern::new(second);
                assert_eq!(drawn.as_ref().is_some_and(|d| d.suits(second)), same, "{i}, {j}");
            }
        }
    }
}
