//! Reading raw samples as normalised values, row by row.

use crate::sensor::{RawImage, RawSamples};

/// Raw samples that are normalised when they are read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    samples: Samples<'a>,
    black: f32,
    gain: f32,
    rows: usize,
    cols: usize,
}

#[derive(Debug, Clone, Copy)]
enum Samples<'a> {
    Digital(&'a [u16]),
    Analog(&'a [f32]),
}

impl<'a> Source<'a> {
    /// The first plane of a raw image, normalised as by [`RawImage::normalized`].
    pub(crate) fn of(raw: &'a RawImage) -> Self {
        let samples = match raw.samples() {
            RawSamples::Digital(v) => Samples::Digital(v),
            RawSamples::Analog(v) => Samples::Analog(v),
        };
        let gain = (1.0 / (raw.white_level() - raw.black_level())) as f32;
        Self { samples, black: raw.black_level() as f32, gain, rows: raw.rows(), cols: raw.cols() }
    }

    /// 16-bit samples without normalisation.
    pub(crate) fn digital(samples: &'a [u16], rows: usize, cols: usize) -> Self {
        Self { samples: Samples::Digital(samples), black: 0.0, gain: 1.0, rows, cols }
    }

    /// Values that are already normalised.
    pub(crate) fn normalized(values: &'a [f32], rows: usize, cols: usize) -> Self {
        Self { samples: Samples::Analog(values), black: 0.0, gain: 1.0, rows, cols }
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn cols(&self) -> usize {
        self.cols
    }

    pub(crate) fn at(&self, row: usize, col: usize) -> f32 {
        let i = row * self.cols + col;
        let value = match self.samples {
            Samples::Digital(v) => f32::from(v[i]),
            Samples::Analog(v) => v[i],
        };
        (value - self.black) * self.gain
    }

    /// Writes a row to `out`, which has the length of the row.
    #[inline(always)]
    pub(crate) fn read_row(&self, row: usize, out: &mut [f32]) {
        let at = row * self.cols..(row + 1) * self.cols;
        match self.samples {
            Samples::Digital(v) => {
                for (o, &x) in out.iter_mut().zip(&v[at]) {
                    *o = (f32::from(x) - self.black) * self.gain;
                }
            }
            Samples::Analog(v) => {
                for (o, &x) in out.iter_mut().zip(&v[at]) {
                    *o = (x - self.black) * self.gain;
                }
            }
        }
    }
}
