//! The random numbers behind the temporal noise of a capture, which are the same for all sensors with the same window and seed.

use super::Sensor;
use super::drawn_blocks::{BlockSource, DrawRow, DrawnBlocks};
use crate::numeric::Rect;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::key;
use crate::numeric::poisson::{LANES, LaneCounter};
use crate::numeric::simd::dispatch;

/// The purpose of the random numbers of photon and read noise, keyed by the seed. Word 3 of the counter holds the plane in its upper half, and
/// the attempt in its lower one.
const PURPOSE: u32 = 0x5345_4e01;

/// The random numbers of a block of photodiodes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NoiseBlock {
    /// Random words of the first attempt at a Poisson deviate.
    pub(super) photons: [[u32; LANES]; 2],
    /// Standard normal deviates of the read noise; 0 unless they are asked for.
    pub(super) reading: [f32; LANES],
}

impl NoiseBlock {
    /// The counter of the photodiodes from `(row, col)` of a plane.
    #[inline(always)]
    pub(super) fn counter(key: [u32; 2], (row, col, plane): (u32, u32, u32)) -> LaneCounter {
        LaneCounter { key, first: col, row, purpose: PURPOSE, attempt: plane << 16 }
    }

    #[inline(always)]
    pub(super) fn draw(counter: &LaneCounter, is_read: bool) -> Self {
        let [first, second, radius, angle] = counter.block();
        let reading = if is_read { normals(&radius, &angle) } else { [0.0; LANES] };
        Self { photons: [first, second], reading }
    }
}

/// A standard normal deviate from each pair of random words.
#[inline(always)]
pub(super) fn normals(radius: &[u32; LANES], angle: &[u32; LANES]) -> [f32; LANES] {
    let mut deviates = [0.0; LANES];
    for i in 0..LANES {
        deviates[i] = normal_pair(radius[i], angle[i]).0;
    }
    deviates
}

/// What chooses the noise of a capture: its seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NoiseSource([u32; 2]);

impl BlockSource for NoiseSource {
    type Block = NoiseBlock;

    #[inline(always)]
    fn block(self, at: (u32, u32, u32)) -> NoiseBlock {
        NoiseBlock::draw(&NoiseBlock::counter(self.0, at), true)
    }
}

/// The random numbers of every photodiode of a window for one capture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TemporalNoise {
    source: NoiseSource,
    drawn: DrawnBlocks<NoiseBlock>,
}

impl TemporalNoise {
    /// Draws the numbers, or `None` for a sensor with several planes. All are drawn on the calling thread: it may hold a lock, for which a task
    /// that ran here meanwhile could wait.
    pub(crate) fn new(sensor: &Sensor, seed: u64) -> Option<Self> {
        let (source, window) = Self::drawn_for(sensor, seed)?;
        let mut blocks = Vec::with_capacity(window.rows * window.cols.div_ceil(LANES));
        (0..window.rows).for_each(|row| blocks.extend(dispatch(DrawRow { source, window, row, plane: 0 })));
        Some(Self { source, drawn: DrawnBlocks { window, blocks } })
    }

    /// What the numbers depend on.
    fn drawn_for(sensor: &Sensor, seed: u64) -> Option<(NoiseSource, Rect)> {
        (sensor.sampling().planes() == 1).then(|| (NoiseSource(key(seed)), sensor.unbinned().read_window()))
    }

    /// Whether these are the numbers that [`TemporalNoise::new`] draws.
    pub(super) fn suits(&self, sensor: &Sensor, seed: u64) -> bool {
        Self::drawn_for(sensor, seed) == Some((self.source, self.drawn.window))
    }

    /// The block from row, column and plane within the window, whose column is a multiple of [`LANES`] from that of the window.
    #[inline(always)]
    pub(super) fn block(&self, at: (u32, u32, u32)) -> &NoiseBlock {
        self.drawn.at(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Planes;
    use crate::optics::OpticalImage;
    use crate::sensor::clear_sensor::clear_sensor;
    use crate::sensor::{Binning, BinningMode, ColorArchitecture, ElectronRates, Exposure, NoiseMode};
    use crate::spectrum::{SpectralCube, WavelengthGrid};

    /// Captures with numbers that were drawn before have the bits of those that draw them, on windows, with binning, and with numbers of another seed,
    /// which are not used.
    #[test]
    fn captures_have_the_bits_of_their_seed() {
        let grid = WavelengthGrid::VISIBLE;
        let light = (0..40 * 300 * grid.len()).map(|i| 3e16 * ((i * 7919) % 113) as f32).collect();
        let cube = SpectralCube::new(grid, Planes::new(40, 300, grid.len(), light).unwrap()).unwrap();
        let image = OpticalImage::new(cube, 2e-6).unwrap();
        let plain = {
            let mut sensor = clear_sensor(40, 300, 2);
            (sensor.pixel.read_noise_v, sensor.nonuniformity.row_noise_v) = (1e-3, 1e-4);
            sensor.adc.bits = 12;
            sensor
        };
        let changed = |change: &dyn Fn(&mut Sensor)| {
            let mut sensor = plain.clone();
            change(&mut sensor);
            sensor
        };
        let binned = |mode| {
            changed(&|s| {
                (s.rows, s.cols) = (20, 150);
                s.pixel.pitch_m *= 2.0;
                s.binning = Some(Binning { side: 2, mode });
            })
        };
        let sensors = [
            plain.clone(),
            changed(&|s| s.window = Some(Rect { row: 3, col: 5, rows: 20, cols: 131 })),
            changed(&|s| s.pixel.read_noise_v = 0.0),
            changed(&|s| s.adc.bits = 0),
            binned(BinningMode::Charge),
            binned(BinningMode::Digital),
        ];
        let exposure = Exposure::new(0.01);
        for sensor in &sensors {
            let rates = ElectronRates::new(&sensor.unbinned(), &image).unwrap();
            for mode in [NoiseMode::All, NoiseMode::PhotonOnly, NoiseMode::None] {
                let expected = sensor.capture((&rates, 1.0), &exposure, mode, 9).unwrap();
                for seed in [9, 10] {
                    let noise = TemporalNoise::new(sensor, seed).unwrap();
                    assert_eq!(noise.suits(sensor, 9), seed == 9);
                    let found =
                        sensor.capture_with((&rates, 1.0), &exposure, (mode, 9), Some(&noise)).unwrap();
                    assert_eq!(found, expected, "{mode:?}, {seed}");
                }
            }
        }
        let of_others = TemporalNoise::new(&sensors[1], 9).unwrap();
        assert!(!of_others.suits(&plain, 9));
        let separate = [ColorArchitecture::Prism, ColorArchitecture::FieldSequential];
        for architecture in separate {
            assert_eq!(TemporalNoise::new(&changed(&|s| s.architecture = architecture), 9), None);
        }
    }
}
