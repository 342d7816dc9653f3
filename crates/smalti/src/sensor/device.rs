//! The sensor as a whole.

use super::{Adc, Cfa, DarkCurrentTemperature, Exposure, NonUniformity, Pixel, Sampling, SensorError};
use crate::numeric::Rect;
use crate::spectrum::{Outside, Spectrum, SpectrumError, WavelengthGrid};

/// Largest number of samples of one capture, 2²⁹ (1 GiB of 16-bit numbers): a sensor beyond is an error before
/// anything is allocated. A window of a larger sensor may be captured.
pub const MAX_SAMPLES: usize = 1 << 29;

/// The three ways of seeing colour of Catrysse, Wandell and El Gamal (1999, Proc. SPIE 3650).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorArchitecture {
    /// One channel per pixel, as the mosaic tells.
    #[default]
    Mosaic,
    /// One sensor per channel behind a beam splitter: every channel at every pixel, each with the whole exposure
    /// time, and each sensor with a fixed pattern of its own. The channels' filters are those of the prism.
    Prism,
    /// One sensor, one capture per channel behind changing filters: every channel at every pixel, all with the
    /// same fixed pattern. The captures share the exposure time: each has 1/N of it.
    FieldSequential,
}

/// How light is gathered over a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Aperture {
    /// Irradiance integrated over the photodetector, a square of `fill_factor · pitch²` in the middle of the pixel.
    /// The optical image is what its type says: constant over the square of each sample.
    #[default]
    Area,
    /// Irradiance at the pixel's centre, linear between samples, times the photodetector's area. It has no pixel MTF;
    /// for comparison with ISETCam.
    ///
    /// ISETCam does only this where the samples are coarser than the pixel. Where they are finer, it first blurs the
    /// image: with n = ⌈pitch / spacing⌉, by a Gaussian of standard deviation n/4 samples, cut off at n × n samples.
    /// So its aperture is about the whole pixel, whatever the fill factor, which is a factor on the signal alone.
    Point,
}

/// An image sensor, centred on the optical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Rows of pixels.
    pub rows: usize,
    /// Columns of pixels.
    pub cols: usize,
    /// The part that is read out; all when `None`. A windowed capture has the same bits as that part of the whole.
    pub window: Option<Rect>,
    /// Every pixel.
    pub pixel: Pixel,
    /// How light is gathered over a pixel.
    pub aperture: Aperture,
    /// Filters and their places.
    pub cfa: Cfa,
    /// Electrons per photon that enters the photodetector, 0–1.
    pub quantum_efficiency: Spectrum,
    /// Transmittance of a filter over the whole sensor, 0–1.
    pub ir_cut: Option<Spectrum>,
    /// Optical and electrical crosstalk: entry `[1 + i][1 + j]` is the fraction of a pixel's photoelectrons that
    /// arrive in the pixel `i` rows below and `j` columns right of it; the entries sum to 1. Beyond its edge the
    /// sensor goes on in dummy pixels, which give as they take.
    ///
    /// Photoelectrons that scatter one by one stay Poisson distributed and independent, so mixing the means
    /// before the draw is exact.
    pub crosstalk: Option<[[f64; 3]; 3]>,
    /// How pixels differ.
    pub nonuniformity: NonUniformity,
    /// The converter.
    pub adc: Adc,
    /// How colour is seen.
    pub architecture: ColorArchitecture,
    /// Temperature of the sensor and its effect; `None` for the reference temperature.
    pub dark_temperature: Option<DarkCurrentTemperature>,
}

impl Sensor {
    /// A sensor of perfectly uniform pixels without converter, window, crosstalk or IR-cut filter.
    #[must_use]
    pub fn new(rows: usize, cols: usize, pixel: Pixel, cfa: Cfa, quantum_efficiency: Spectrum) -> Self {
        Self {
            rows,
            cols,
            window: None,
            pixel,
            aperture: Aperture::Area,
            cfa,
            quantum_efficiency,
            ir_cut: None,
            crosstalk: None,
            nonuniformity: NonUniformity::default(),
            adc: Adc::default(),
            architecture: ColorArchitecture::Mosaic,
            dark_temperature: None,
        }
    }

    /// Checks every field, and that a capture fits in memory ([`MAX_SAMPLES`]).
    ///
    /// # Errors
    /// The first thing that is impossible.
    pub fn validate(&self) -> Result<(), SensorError> {
        let (rows, cols) = (self.rows, self.cols);
        if rows == 0 || cols == 0 {
            return Err(SensorError::Empty { rows, cols });
        }
        let w = self.read_window();
        if !w.fits(rows, cols) {
            let (window_rows, window_cols) = (w.rows, w.cols);
            return Err(SensorError::Window { row: w.row, col: w.col, window_rows, window_cols, rows, cols });
        }
        let planes = self.sampling().planes();
        let samples = w.rows.checked_mul(w.cols).and_then(|n| n.checked_mul(planes));
        // Positions are counters of the random generator, 32 bits with room for a border.
        let countable = rows.max(cols) < (1 << 31);
        if !countable || samples.is_none_or(|n| n > MAX_SAMPLES) {
            return Err(SensorError::TooLarge { rows: w.rows, cols: w.cols, planes, limit: MAX_SAMPLES });
        }
        self.pixel.validate()?;
        self.nonuniformity.validate()?;
        self.adc.validate()?;
        self.dark_voltage_v_per_s()?;
        let curves = [
            ("quantum efficiency", Some(&self.quantum_efficiency)),
            ("the IR-cut filter", self.ir_cut.as_ref()),
        ];
        for (what, curve) in curves.into_iter().filter_map(|(w, c)| c.map(|c| (w, c))) {
            // Measured curves overshoot by rounding; a thousandth is forgiven, as for filters.
            if let Some(i) = curve.values().iter().position(|v| !(-1e-3..=1.001).contains(v)) {
                let wavelength_nm = curve.grid().wavelength_nm(i);
                return Err(SensorError::Fraction { what, wavelength_nm, value: curve.values()[i] });
            }
        }
        if let Some(kernel) = &self.crosstalk {
            let sum: f64 = kernel.iter().flatten().sum();
            let negative = kernel.iter().flatten().any(|&k| !(0.0..=1.0).contains(&k));
            if negative || (sum - 1.0).abs() > 1e-6 {
                return Err(SensorError::Crosstalk { sum });
            }
        }
        Ok(())
    }

    /// The part that is read out.
    #[must_use]
    pub fn read_window(&self) -> Rect {
        self.window.unwrap_or(Rect::whole(self.rows, self.cols))
    }

    /// Which channels a pixel of the read-out part has seen.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        let w = self.read_window();
        match self.architecture {
            ColorArchitecture::Mosaic => Sampling::Mosaic(self.cfa.mosaic().shifted(w.row, w.col)),
            ColorArchitecture::Prism | ColorArchitecture::FieldSequential => {
                Sampling::Full { channels: self.cfa.channels().len() }
            }
        }
    }

    /// Electrons per photon, per channel: filter × quantum efficiency × IR-cut, on the grid of the filters.
    ///
    /// # Errors
    /// When quantum efficiency or IR-cut do not cover that grid.
    pub fn spectral_responsivity(&self) -> Result<Vec<Spectrum>, SensorError> {
        let grid =
            self.cfa.channels().first().map_or(self.quantum_efficiency.grid(), |c| c.transmittance.grid());
        self.spectral_responsivity_on(grid)
    }

    /// As [`Sensor::spectral_responsivity`], on a grid of one's own, each curve linear between its samples.
    ///
    /// # Errors
    /// When a curve does not cover the grid.
    pub fn spectral_responsivity_on(&self, grid: WavelengthGrid) -> Result<Vec<Spectrum>, SensorError> {
        let common = self.bare_responsivity_on(grid)?;
        let channel = |c: &super::Channel| {
            let filter = on_grid(&format!("the filter '{}'", c.name), &c.transmittance, grid)?;
            // What overshoots below zero by rounding must not subtract light.
            Ok(filter.times(&common)?.map(|_, v| v.max(0.0)))
        };
        self.cfa.channels().iter().map(channel).collect()
    }

    /// Electrons per photon where there is no colour filter: quantum efficiency and IR-cut filter, each curve linear between its
    /// samples.
    ///
    /// # Errors
    /// When a curve does not cover the grid.
    pub fn bare_responsivity_on(&self, grid: WavelengthGrid) -> Result<Spectrum, SensorError> {
        let own = on_grid("the quantum efficiency", &self.quantum_efficiency, grid)?;
        match &self.ir_cut {
            Some(cut) => Ok(own.times(&on_grid("the IR-cut filter", cut, grid)?)?),
            None => Ok(own),
        }
    }

    /// Dark signal at the sensor's temperature, V/s.
    ///
    /// # Errors
    /// When the temperature is impossible.
    pub fn dark_voltage_v_per_s(&self) -> Result<f64, SensorError> {
        let factor = self.dark_temperature.map_or(Ok(1.0), |t| t.factor())?;
        Ok(self.pixel.dark_voltage_v_per_s * factor)
    }

    /// Volts at the converter at which a pixel of mean gain and offset saturates: the well is full or the swing
    /// used up.
    #[must_use]
    pub fn saturation_v(&self, exposure: &Exposure) -> f64 {
        let full = self.pixel.full_well_e * self.pixel.conversion_gain_v_per_e;
        ((full + exposure.analog_offset_v) * exposure.analog_gain).min(self.pixel.voltage_swing_v)
    }
}

/// A curve on a grid that it must cover.
fn on_grid(what: &str, curve: &Spectrum, grid: WavelengthGrid) -> Result<Spectrum, SensorError> {
    curve.resampled(grid, Outside::Error).map_err(|e| match e {
        SpectrumError::Coverage { have_start_nm, have_end_nm, need_start_nm, need_end_nm } => {
            SensorError::Coverage {
                what: what.into(),
                have_start_nm,
                have_end_nm,
                need_start_nm,
                need_end_nm,
            }
        }
        other => other.into(),
    })
}
