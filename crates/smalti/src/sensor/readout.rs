//! From the mean number of photoelectrons of a pixel to its voltage at the converter. Every noise term is
//! added in the order of the signal chain, on blocks of lanes.

use super::drawn_blocks::BlockSource as _;
use super::pattern::{Pattern, PatternSource};
use super::temporal_noise::{NoiseBlock, TemporalNoise, normals};
use super::{Exposure, LowGain, NoiseMode, Sensor, SensorError};
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::{key, philox4x32};
use crate::numeric::poisson::{LANES, LaneCounter, poisson_lanes};

/// Word 2 of the generator's counter, which identifies the purpose of the random numbers. Word 0 is the
/// column, word 1 the row, word 3 the plane (upper half) and the attempt (lower half). The [`pattern`](super::pattern) and the
/// [noise of an exposure](super::temporal_noise) have purposes of their own.
mod purpose {
    /// Row noise, keyed by the seed.
    pub(super) const ROW: u32 = 0x5345_4e02;
    /// Offset of a column, keyed by the serial number.
    pub(super) const COLUMN: u32 = 0x5345_4e04;
    /// Read noise of a sample of several photodiodes, keyed by the seed.
    pub(super) const SAMPLE: u32 = 0x5345_4e05;
    /// Read noise of the second reading of a capture, keyed by the seed.
    pub(super) const SECOND: u32 = 0x5345_4e06;
}

/// Photodiodes after the exposure, before they are read.
struct Exposed {
    /// Electrons, light and dark, with shot noise; not limited by the full well.
    electrons: [f64; LANES],
    /// Gain of each photodiode relative to the mean.
    response: [f32; LANES],
    /// Offset of each photodiode, V.
    offset: [f32; LANES],
    /// Standard normal deviates of the read noise.
    reading: [f32; LANES],
}

/// Random numbers that were drawn before. A pattern of another device and noise of another window or seed are not used.
#[derive(Clone, Copy)]
pub(super) struct Drawn<'a> {
    pub(super) pattern: Option<&'a Pattern>,
    pub(super) noise: Option<&'a TemporalNoise>,
}

/// The parameters of a block.
#[derive(Clone, Copy)]
pub(super) struct Readout<'a> {
    mode: NoiseMode,
    seed: [u32; 2],
    source: PatternSource,
    /// The pattern of the source and the noise of the seed, if they were drawn before.
    drawn: Drawn<'a>,
    /// Exposure time of one plane, s.
    time_s: f32,
    dark_e: f64,
    hot_dark_e: f64,
    full_well_e: f64,
    conversion_gain: f32,
    prnu: f32,
    dsnu_v: f32,
    read_noise_v: f32,
    row_noise_v: f32,
    column_noise_v: f32,
    /// Thresholds of a random word: dead below the first, hot below the second. They have 33 bits, so that
    /// all pixels can be defective.
    dead_below: u64,
    hot_below: u64,
    gain: f32,
    offset_v: f32,
    swing_v: f32,
    /// Whether this is the second reading of the same electrons, with noise of its own.
    is_second: bool,
}

impl<'a> Readout<'a> {
    pub(super) fn new(
        sensor: &Sensor,
        drawn: Drawn<'a>,
        exposure: &Exposure,
        time_s: f64,
        (mode, seed): (NoiseMode, u64),
    ) -> Result<Self, SensorError> {
        let source = PatternSource::of(sensor);
        let (pixel, non) = (&sensor.pixel, &sensor.nonuniformity);
        let temperature = sensor.dark_temperature.map_or(Ok(1.0), |t| t.factor())?;
        let dark_e = |v_per_s: f64| v_per_s * temperature * time_s / pixel.conversion_gain_v_per_e;
        let words = |fraction: f64| (fraction * 4_294_967_296.0).round() as u64;
        let dead_below = words(non.dead_pixel_fraction);
        Ok(Self {
            mode,
            seed: key(seed),
            source,
            drawn: Drawn {
                pattern: drawn.pattern.filter(|pattern| pattern.is_of(source)),
                noise: drawn.noise.filter(|noise| noise.suits(sensor, seed)),
            },
            time_s: time_s as f32,
            dark_e: dark_e(pixel.dark_voltage_v_per_s),
            hot_dark_e: dark_e(non.hot_pixel_dark_voltage_v_per_s),
            full_well_e: pixel.full_well_e,
            conversion_gain: pixel.conversion_gain_v_per_e as f32,
            prnu: non.prnu_fraction as f32,
            dsnu_v: non.dsnu_v as f32,
            read_noise_v: pixel.read_noise_v as f32,
            row_noise_v: non.row_noise_v as f32,
            column_noise_v: non.column_noise_v as f32,
            dead_below,
            hot_below: dead_below + words(non.hot_pixel_fraction),
            gain: exposure.analog_gain as f32,
            offset_v: exposure.analog_offset_v as f32,
            swing_v: pixel.voltage_swing_v as f32,
            is_second: false,
        })
    }

    /// The reading of the same electrons with a low conversion gain, which is `share` of the high one.
    pub(super) fn at_low_gain(&self, low: LowGain, share: f64, is_second: bool) -> Self {
        Self {
            conversion_gain: low.conversion_gain_v_per_e as f32,
            dsnu_v: (f64::from(self.dsnu_v) * share) as f32,
            read_noise_v: low.read_noise_v as f32,
            is_second,
            ..*self
        }
    }

    /// Fixed offsets of the columns from `first`, V.
    pub(super) fn column_offsets(&self, first: u32, plane: u32, out: &mut [f32]) {
        if self.mode != NoiseMode::All {
            return out.fill(0.0);
        }
        for (i, o) in out.iter_mut().enumerate() {
            let counter = [first.wrapping_add(i as u32), 0, purpose::COLUMN, self.source.plane(plane)];
            let w = philox4x32(counter, self.source.serial);
            *o = self.column_noise_v * normal_pair(w[0], w[1]).0;
        }
    }

    /// The offset of a row in this capture, V.
    #[inline(always)]
    pub(super) fn row_offset(&self, row: u32, plane: u32) -> f32 {
        let w = philox4x32([u32::from(self.is_second), row, purpose::ROW, plane << 16], self.seed);
        self.row_noise_v * normal_pair(w[0], w[1]).0
    }

    /// Volts at the converter of the pixels from `(row, col)`, clipped to the swing. `light` is in
    /// photoelectrons per second.
    #[inline(always)]
    pub(super) fn block(
        &self,
        (row, col, plane): (u32, u32, u32),
        light: &[f32; LANES],
        fixed_offset_v: &[f32; LANES],
        volts: &mut [f32; LANES],
    ) {
        let Exposed { electrons, response, mut offset, mut reading } =
            self.exposed((row, col, plane), light, self.has_read_noise() && !self.is_second);
        if self.is_second {
            reading = self.reading_deviates((row, col, plane));
        }
        self.add_reading_noise((row, plane), &reading, fixed_offset_v, &mut offset);
        for i in 0..LANES {
            let v = electrons[i].min(self.full_well_e) as f32 * self.conversion_gain;
            let v = v * response[i] + offset[i];
            volts[i] = ((v + self.offset_v) * self.gain).min(self.swing_v);
        }
    }

    /// Volts that the electrons of the photodiodes from `(row, col)` cause on a floating diffusion, each limited
    /// by its own full well, with its gain and offset, before they are read.
    #[inline(always)]
    pub(super) fn charge(&self, at: (u32, u32, u32), light: &[f32; LANES], volts: &mut [f32; LANES]) {
        let Exposed { electrons, response, offset, .. } = self.exposed(at, light, false);
        for i in 0..LANES {
            let v = electrons[i].min(self.full_well_e) as f32 * self.conversion_gain;
            volts[i] = v * response[i] + offset[i];
        }
    }

    /// Volts at the converter of the samples from `(row, col)`, clipped to the swing, from those of the charge
    /// on their floating diffusions.
    #[inline(always)]
    pub(super) fn reading(
        &self,
        (row, col, plane): (u32, u32, u32),
        charge_v: &[f32; LANES],
        fixed_offset_v: &[f32; LANES],
        volts: &mut [f32; LANES],
    ) {
        let reading = self.reading_deviates((row, col, plane));
        let mut offset = [0.0f32; LANES];
        self.add_reading_noise((row, plane), &reading, fixed_offset_v, &mut offset);
        for i in 0..LANES {
            let v = charge_v[i] + offset[i];
            volts[i] = ((v + self.offset_v) * self.gain).min(self.swing_v);
        }
    }

    /// Whether samples have read noise.
    #[inline(always)]
    fn has_read_noise(&self) -> bool {
        self.mode == NoiseMode::All && self.read_noise_v > 0.0
    }

    /// Standard normal deviates of the read noise of samples from `(row, col)` that are not those of the exposure.
    #[inline(always)]
    fn reading_deviates(&self, (row, col, plane): (u32, u32, u32)) -> [f32; LANES] {
        if !self.has_read_noise() {
            return [0.0; LANES];
        }
        let purpose = if self.is_second { purpose::SECOND } else { purpose::SAMPLE };
        let counter = LaneCounter { key: self.seed, first: col, row, purpose, attempt: plane << 16 };
        let [radius, angle, ..] = counter.block();
        normals(&radius, &angle)
    }

    /// Photodiodes from `(row, col)` after the exposure. `light` is in photoelectrons per second. Unless `is_read`, there are no deviates of the
    /// read noise.
    #[inline(always)]
    fn exposed(&self, (row, col, plane): (u32, u32, u32), light: &[f32; LANES], is_read: bool) -> Exposed {
        let mut electrons = [0.0f64; LANES];
        for i in 0..LANES {
            electrons[i] = f64::from(light[i] * self.time_s);
        }
        let mut response = [1.0f32; LANES];
        let mut offset = [0.0f32; LANES];
        let mut reading = [0.0f32; LANES];
        if self.mode == NoiseMode::All {
            self.pattern((row, col, plane), &mut electrons, &mut response, &mut offset);
        }
        if self.mode != NoiseMode::None {
            let counter = NoiseBlock::counter(self.seed, (row, col, plane));
            let own;
            let block = match self.drawn.noise {
                Some(noise) => noise.block((row, col, plane)),
                None => {
                    own = NoiseBlock::draw(&counter, is_read);
                    &own
                }
            };
            poisson_lanes(&counter, block.photons.each_ref(), &mut electrons);
            reading = block.reading;
        }
        Exposed { electrons, response, offset, reading }
    }

    /// Adds the noise of one reading: read noise from standard normal deviates, row and column noise.
    #[inline(always)]
    fn add_reading_noise(
        &self,
        (row, plane): (u32, u32),
        reading: &[f32; LANES],
        fixed_offset_v: &[f32; LANES],
        offset: &mut [f32; LANES],
    ) {
        if self.mode != NoiseMode::All {
            return;
        }
        if self.read_noise_v > 0.0 {
            for i in 0..LANES {
                offset[i] += self.read_noise_v * reading[i];
            }
        }
        let row_offset = if self.row_noise_v > 0.0 { self.row_offset(row, plane) } else { 0.0 };
        for i in 0..LANES {
            offset[i] += row_offset + fixed_offset_v[i];
        }
    }

    /// Adds dark current, applies dead pixels, and gives each pixel its gain and offset.
    #[inline(always)]
    fn pattern(
        &self,
        at: (u32, u32, u32),
        electrons: &mut [f64; LANES],
        response: &mut [f32; LANES],
        offset: &mut [f32; LANES],
    ) {
        let defects = self.hot_below > 0;
        if !defects {
            for e in electrons.iter_mut() {
                *e += self.dark_e;
            }
        }
        if !defects && self.prnu == 0.0 && self.dsnu_v == 0.0 {
            return;
        }
        let drawn;
        let block = match self.drawn.pattern {
            Some(pattern) => pattern.block(at),
            None => {
                drawn = self.source.block(at);
                &drawn
            }
        };
        for i in 0..LANES {
            response[i] = (1.0 + self.prnu * block.gain[i]).max(0.0);
            offset[i] = self.dsnu_v * block.offset[i];
        }
        if defects {
            for (e, word) in electrons.iter_mut().zip(&block.defect) {
                let w = u64::from(*word);
                let dark = if w < self.hot_below { self.hot_dark_e } else { self.dark_e };
                *e = if w < self.dead_below { 0.0 } else { *e + dark };
            }
        }
    }
}
