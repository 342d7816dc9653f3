//! The sensor as a whole.

use super::{
    Adc, Binning, Cfa, ConversionGain, DarkCurrentTemperature, Exposure, NonUniformity, Pixel, Sampling,
    SensorError,
};
use crate::numeric::Rect;
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// Maximum number of samples of a capture, 2²⁹ (1 GiB of 16-bit numbers). A larger sensor is an error before
/// any allocation; a window of it can be captured.
pub const MAX_SAMPLES: usize = 1 << 29;

/// The three colour architectures of Catrysse, Wandell and El Gamal (1999, Proc. SPIE 3650).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorArchitecture {
    /// One channel per pixel, given by the mosaic.
    #[default]
    Mosaic,
    /// One sensor per channel behind a beam splitter. Every pixel has every channel, each with the full
    /// exposure time, and each sensor has its own fixed-pattern noise. The channels' filters are those of the
    /// prism.
    Prism,
    /// One sensor with exchangeable filters and one capture per channel. Every pixel has every channel, all
    /// with the same fixed-pattern noise. The captures share the exposure time: each takes 1/N of it.
    FieldSequential,
}

/// The aperture of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Aperture {
    /// Irradiance is integrated over the photodetector, a square of `fill_factor · pitch²` at the centre of
    /// the pixel. The optical image is constant over the square of each sample.
    #[default]
    Area,
    /// Irradiance at the pixel's centre, interpolated linearly between samples, times the photodetector's
    /// area. There is no pixel MTF. For comparison with ISETCam.
    ///
    /// ISETCam does only this where the sample spacing exceeds the pixel pitch. Where it is finer, ISETCam
    /// first blurs the image with a Gaussian of standard deviation n/4 samples, truncated to n × n samples,
    /// where n = ⌈pitch / spacing⌉. Its aperture is therefore about the whole pixel for any fill factor,
    /// which only scales the signal.
    Point,
}

/// An image sensor, centred on the optical axis.
///
/// With [`Binning`], "pixels" in the geometry are the samples that are read: `rows`, `cols`, `window`, the pitch
/// of `pixel` and the mosaic of `cfa` are those of the samples, and the photodiodes are `side` times as fine
/// ([`Sensor::unbinned`]). Fill factor, full well, dark signal, non-uniformity and crosstalk remain those of
/// single photodiodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Rows of pixels.
    pub rows: usize,
    /// Columns of pixels.
    pub cols: usize,
    /// The window that is read out; `None` for the whole sensor. A windowed capture has the same bits as that
    /// part of a full capture.
    pub window: Option<Rect>,
    /// The pixel, equal over the sensor.
    pub pixel: Pixel,
    /// The aperture of a pixel.
    pub aperture: Aperture,
    /// The colour filter array.
    pub cfa: Cfa,
    /// Electrons per photon that enters the photodetector, 0–1.
    pub quantum_efficiency: Spectrum,
    /// Transmittance of a filter over the whole sensor, 0–1.
    pub ir_cut: Option<Spectrum>,
    /// Optical and electrical crosstalk. Entry `[1 + i][1 + j]` is the fraction of a pixel's photoelectrons
    /// that arrive in the pixel `i` rows below and `j` columns to the right; the entries sum to 1. Dummy
    /// pixels continue the sensor beyond its edges and exchange electrons in the same way.
    ///
    /// Photoelectrons that scatter independently remain Poisson distributed and independent, so mixing the
    /// means before the draw is exact.
    pub crosstalk: Option<[[f64; 3]; 3]>,
    /// Non-uniformity of the pixels.
    pub nonuniformity: NonUniformity,
    /// The converter.
    pub adc: Adc,
    /// The colour architecture.
    pub architecture: ColorArchitecture,
    /// Temperature dependence of the dark current; `None` for the reference temperature.
    pub dark_temperature: Option<DarkCurrentTemperature>,
    /// Binning of photodiodes to samples; `None`: each photodiode is a sample.
    pub binning: Option<Binning>,
}

impl Sensor {
    /// A sensor of uniform pixels without converter, window, crosstalk or IR-cut filter.
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
            binning: None,
        }
    }

    /// Checks every field, and that a capture fits in memory ([`MAX_SAMPLES`]).
    ///
    /// # Errors
    /// The first field that is invalid.
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
        self.binning.map_or(Ok(()), |b| b.validate())?;
        let planes = self.sampling().planes();
        let side = self.binning_side();
        let each = planes.saturating_mul(side * side);
        let samples = w.rows.checked_mul(w.cols).and_then(|n| n.checked_mul(each));
        // Positions are counters of the random number generator: 32 bits, with room for a border.
        let countable = rows.max(cols) < (1 << 31) / side;
        if !countable || samples.is_none_or(|n| n > MAX_SAMPLES) {
            return Err(SensorError::TooLarge { rows: w.rows, cols: w.cols, planes, limit: MAX_SAMPLES });
        }
        self.pixel.validate()?;
        self.nonuniformity.validate()?;
        self.adc.validate()?;
        self.dark_voltage_v_per_s()?;
        self.quantum_efficiency.check_fraction("quantum efficiency")?;
        self.ir_cut.as_ref().map_or(Ok(()), |cut| cut.check_fraction("the IR-cut filter"))?;
        if let Some(kernel) = &self.crosstalk {
            let sum: f64 = kernel.iter().flatten().sum();
            let negative = kernel.iter().flatten().any(|&k| !(0.0..=1.0).contains(&k));
            if negative || (sum - 1.0).abs() > 1e-6 {
                return Err(SensorError::Crosstalk { sum });
            }
        }
        Ok(())
    }

    /// The window that is read out.
    #[must_use]
    pub fn read_window(&self) -> Rect {
        self.window.unwrap_or(Rect::whole(self.rows, self.cols))
    }

    /// The channels that each pixel of the window samples.
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

    /// Electrons per photon, per channel, on a grid: filter × quantum efficiency × IR-cut, with linear interpolation of
    /// each curve.
    ///
    /// # Errors
    /// When a curve does not cover the grid.
    pub fn spectral_responsivity_on(&self, grid: WavelengthGrid) -> Result<Vec<Spectrum>, SensorError> {
        let common = self.bare_responsivity_on(grid)?;
        let channel = |c: &super::Channel| {
            let filter = on_grid(&format!("the filter '{}'", c.name), &c.transmittance, grid)?;
            // Negative rounding errors of measured curves must not subtract light.
            Ok(filter.times(&common)?.map(|_, v| v.max(0.0))?)
        };
        self.cfa.channels().iter().map(channel).collect()
    }

    /// Electrons per photon without a colour filter: quantum efficiency times IR-cut filter, with linear
    /// interpolation of each curve.
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

    /// Number of captures that share the exposure time.
    pub(crate) fn captures(&self) -> f64 {
        match self.architecture {
            ColorArchitecture::FieldSequential => self.cfa.channels().len() as f64,
            ColorArchitecture::Mosaic | ColorArchitecture::Prism => 1.0,
        }
    }

    /// Dark signal of a photodiode at the sensor's temperature, V/s.
    ///
    /// # Errors
    /// When the temperature is out of range.
    pub fn dark_voltage_v_per_s(&self) -> Result<f64, SensorError> {
        let factor = self.dark_temperature.map_or(Ok(1.0), |t| t.factor())?;
        Ok(self.pixel.dark_voltage_v_per_s * factor)
    }

    /// Volts at the converter at which a pixel of mean gain and offset saturates: by full well (with charge
    /// binning, those of all its photodiodes), by the swing, or at the last number of the converter, which lies below
    /// the swing by the black level. For combined gains, that of the low gain on the scale of the high one.
    #[must_use]
    pub fn saturation_v(&self, exposure: &Exposure) -> f64 {
        if let ConversionGain::Combined(low) = exposure.conversion_gain {
            let low = Exposure { conversion_gain: ConversionGain::Low(low), ..*exposure };
            let zero_v = exposure.zero_v();
            return zero_v + (self.saturation_v(&low) - zero_v) * self.gain_ratio(exposure);
        }
        let well_e = self.pixel.full_well_e * self.photodiodes_per_reading();
        let full = well_e * self.conversion_gain_v_per_e(exposure);
        let swing_v = self.pixel.voltage_swing_v;
        let end_v =
            if self.adc.bits == 0 { swing_v } else { self.adc.volts(self.adc.levels() - 1.0, swing_v) };
        ((full + exposure.analog_offset_v) * exposure.analog_gain).min(swing_v).min(end_v)
    }
}

/// A curve on a grid that it must cover.
fn on_grid(what: &str, curve: &Spectrum, grid: WavelengthGrid) -> Result<Spectrum, SensorError> {
    Ok(curve.resampled(grid, Extrapolation::Error).map_err(|e| e.of(what))?)
}
