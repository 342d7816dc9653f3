//! The camera as its user describes it: one struct per table of `camera.toml`, keys in the user's units.
//!
//! Every key has a default, so that a file names only what differs; the resolved description names all.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::numeric::Planes;
use crate::sensor::Filter;

/// A camera file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct CameraDescription {
    /// What the camera is called.
    pub name: String,
    /// First, step and last of the wavelengths it is simulated on, nm, where scenes do not say; absent: 400, 10, 700.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelengths_nm: Option<[f64; 3]>,
    /// The lens.
    pub optics: OpticsDescription,
    /// The image sensor.
    pub sensor: SensorDescription,
    /// Exposure time and gain.
    pub exposure: ExposureDescription,
    /// Processing from raw to picture.
    pub isp: IspDescription,
}

impl Default for CameraDescription {
    fn default() -> Self {
        Self {
            name: "camera".into(),
            wavelengths_nm: None,
            optics: OpticsDescription::default(),
            sensor: SensorDescription::default(),
            exposure: ExposureDescription::default(),
            isp: IspDescription::default(),
        }
    }
}

/// How the lens forms the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OpticsModelName {
    /// No blur, for tests.
    Pinhole,
    /// Limited by diffraction alone, with defocus if stated.
    #[default]
    Diffraction,
    /// Wavefront aberrations by Zernike coefficients.
    Zernike,
    /// A point spread function from a file.
    Psf,
}

/// Fall-off of illumination towards the edge of the field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FalloffName {
    /// None.
    None,
    /// Fourth power of the cosine of the field angle.
    #[default]
    Cos4,
}

/// What lies beyond the border of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SurroundName {
    /// Nothing, as in ISETCam: the border of the picture darkens.
    Dark,
    /// The outermost samples go on.
    Edge,
    /// The scene mirrored at its border.
    #[default]
    Mirror,
}

/// Order of the Zernike polynomials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ZernikeOrdering {
    /// Noll 1976, counted from 1 (piston).
    #[default]
    Noll,
    /// OSA/ANSI Z80.28, counted from 0 (piston).
    Osa,
}

/// `[optics]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct OpticsDescription {
    /// How the image is formed.
    pub model: OpticsModelName,
    /// Focal length divided by the diameter of the entrance pupil.
    pub f_number: f64,
    /// Focal length, mm.
    pub focal_length_mm: f64,
    /// Fall-off towards the edge.
    pub falloff: FalloffName,
    /// What the lens sees beyond the border of the scene.
    pub surround: SurroundName,
    /// Transmittance of the lens.
    pub transmittance: Filter,
    /// Infrared-cut filter in front of the sensor; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ir_cut: Option<Filter>,
    /// Separation of the four spots of a birefringent low-pass filter on the sensor, µm in both directions; 0: none.
    pub low_pass_separation_um: f64,
    /// Error of the lens' power, dioptres.
    pub defocus_dioptres: f64,
    /// Wavelength at which the lens is in focus, nm; only with `chromatic_dioptres_per_um`.
    pub chromatic_reference_nm: f64,
    /// Longitudinal chromatic focus: change of focus per µm of wavelength, dioptres/µm; 0: none.
    pub chromatic_dioptres_per_um: f64,
    /// Wavefront coefficients, µm RMS, by index (`model = "zernike"`).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub zernike_um: BTreeMap<String, f64>,
    /// What the indices of `zernike_um` mean.
    pub zernike_ordering: ZernikeOrdering,
    /// Point spread function, a `.npy` of shape (wavelengths, rows, cols) (`model = "psf"`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psf: Option<PsfDescription>,
}

impl Default for OpticsDescription {
    fn default() -> Self {
        Self {
            model: OpticsModelName::Diffraction,
            f_number: 4.0,
            focal_length_mm: 3.863,
            falloff: FalloffName::Cos4,
            surround: SurroundName::Mirror,
            transmittance: Filter::Flat(1.0),
            ir_cut: None,
            low_pass_separation_um: 0.0,
            defocus_dioptres: 0.0,
            chromatic_reference_nm: 550.0,
            chromatic_dioptres_per_um: 0.0,
            zernike_um: BTreeMap::new(),
            zernike_ordering: ZernikeOrdering::Noll,
            psf: None,
        }
    }
}

/// `[optics.psf]`: a measured or computed point spread function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PsfDescription {
    /// A `.npy` of shape (wavelengths, rows, cols), or (rows, cols) for all wavelengths; each plane is scaled to
    /// unit sum, its centre at (rows / 2, cols / 2).
    pub file: String,
    /// Distance between samples on the sensor, µm.
    pub spacing_um: f64,
    /// First wavelength, nm.
    #[serde(default = "first_nm")]
    pub start_nm: f64,
    /// Step between the planes, nm.
    #[serde(default = "step_nm")]
    pub step_nm: f64,
    /// What is in the file: filled in when it is read.
    #[serde(skip)]
    pub planes: Option<Planes>,
    /// BLAKE3 hash of the file, so that a resolved description names its data: filled in when it is read.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub hash: String,
}

fn first_nm() -> f64 {
    400.0
}

fn step_nm() -> f64 {
    10.0
}

/// How a sensor sees colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ArchitectureName {
    /// A colour filter array.
    #[default]
    Mosaic,
    /// A prism with one sensor per channel.
    Prism,
    /// One capture per channel; they share the exposure time.
    FieldSequential,
}

/// `[sensor]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SensorDescription {
    /// Rows of pixels.
    pub rows: usize,
    /// Columns of pixels.
    pub cols: usize,
    /// How it sees colour.
    pub architecture: ArchitectureName,
    /// Bits of the converter; 0: no quantisation, the raw samples are volts.
    pub adc_bits: u32,
    /// Digital number without light.
    pub black_level_dn: f64,
    /// Gain differences between pixels, standard deviation in percent.
    pub prnu_percent: f64,
    /// Offset differences between pixels, standard deviation in mV.
    pub dsnu_mv: f64,
    /// Noise common to a row, drawn anew for each capture, mV.
    pub row_noise_mv: f64,
    /// Offset common to a column, fixed for the device, standard deviation in mV.
    pub column_noise_mv: f64,
    /// Pixels that give no signal, per million.
    pub dead_pixels_ppm: f64,
    /// Pixels with a large dark signal, per million.
    pub hot_pixels_ppm: f64,
    /// Dark signal of a hot pixel, V/s.
    pub hot_pixel_dark_voltage_v_per_s: f64,
    /// Which device: pixels differ from device to device, not from capture to capture.
    pub serial: u64,
    /// Electrons per photon that reaches the photodetector.
    pub quantum_efficiency: Filter,
    /// Share of a pixel's signal that its neighbours receive, percent in all; 0: none.
    pub crosstalk_percent: f64,
    /// The pixel.
    pub pixel: PixelDescription,
    /// The colour filter array.
    pub cfa: CfaDescription,
}

impl Default for SensorDescription {
    fn default() -> Self {
        Self {
            rows: 480,
            cols: 640,
            architecture: ArchitectureName::Mosaic,
            adc_bits: 12,
            black_level_dn: 0.0,
            prnu_percent: 0.0,
            dsnu_mv: 0.0,
            row_noise_mv: 0.0,
            column_noise_mv: 0.0,
            dead_pixels_ppm: 0.0,
            hot_pixels_ppm: 0.0,
            hot_pixel_dark_voltage_v_per_s: 1.0,
            serial: 1,
            quantum_efficiency: Filter::Flat(1.0),
            crosstalk_percent: 0.0,
            pixel: PixelDescription::default(),
            cfa: CfaDescription::default(),
        }
    }
}

/// `[sensor.pixel]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PixelDescription {
    /// Distance between pixels, µm.
    pub pitch_um: f64,
    /// Photodetector area divided by pixel area, above 0, at most 1.
    pub fill_factor: f64,
    /// Volts per electron, µV.
    pub conversion_gain_uv_per_e: f64,
    /// Largest output, V.
    pub voltage_swing_v: f64,
    /// Electrons a pixel holds.
    pub full_well_e: f64,
    /// Dark signal at 25 °C, V/s.
    pub dark_voltage_v_per_s: f64,
    /// Temperature of the sensor, °C; the dark signal doubles with every `dark_doubling_c` above 25.
    pub temperature_c: f64,
    /// Temperature step that doubles the dark signal, °C.
    pub dark_doubling_c: f64,
    /// Noise of one reading, mV RMS.
    pub read_noise_mv: f64,
}

impl Default for PixelDescription {
    fn default() -> Self {
        Self {
            pitch_um: 2.2,
            fill_factor: 0.45,
            conversion_gain_uv_per_e: 200.0,
            voltage_swing_v: 1.8,
            full_well_e: 9000.0,
            dark_voltage_v_per_s: 1e-5,
            temperature_c: 25.0,
            dark_doubling_c: 6.0,
            read_noise_mv: 1.34,
        }
    }
}

/// The tile: the name of a built-in, or its lines in letters.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum PatternDescription {
    /// A built-in (`smalti list cfas`).
    Name(String),
    /// One string per row, one letter per cell.
    Letters(Vec<String>),
}

// By hand: the derived error of an untagged enum does not say what was expected.
impl<'de> Deserialize<'de> for PatternDescription {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = PatternDescription;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a CFA, or its lines such as [\"RG\", \"GB\"]")
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(PatternDescription::Name(name.into()))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut lines = Vec::new();
                while let Some(line) = seq.next_element()? {
                    lines.push(line);
                }
                Ok(PatternDescription::Letters(lines))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// `[sensor.cfa]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct CfaDescription {
    /// The tile.
    pub pattern: PatternDescription,
    /// One filter per letter; with the name of a built-in, those named here replace its own.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub filters: BTreeMap<String, Filter>,
    /// Letters that stand for weighted sums of filters: `a = { R = 0.5, G = 0.5 }`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub mixtures: BTreeMap<String, BTreeMap<String, f64>>,
}

impl Default for CfaDescription {
    fn default() -> Self {
        Self {
            pattern: PatternDescription::Name("bayer".into()),
            filters: BTreeMap::new(),
            mixtures: BTreeMap::new(),
        }
    }
}

/// How the exposure time is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AutoExposureName {
    /// The brightest point of the image reaches 95 % of saturation.
    Specular,
    /// The mean of the image reaches `auto_target`.
    Mean,
    /// The `auto_percentile` of illuminance reaches `auto_target`.
    Luminance,
}

/// `[exposure]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ExposureDescription {
    /// Exposure time, ms; absent: `auto`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_ms: Option<f64>,
    /// How the time is found where `time_ms` is absent (then `specular` by default).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto: Option<AutoExposureName>,
    /// Share of saturation to reach; absent: 0.95 for specular and luminance, 0.18 for mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto_target: Option<f64>,
    /// Percentile of illuminance for `auto = "luminance"`.
    pub auto_percentile: f64,
    /// Multiplies the voltage. ISETCam's gain of the same name divides.
    pub analog_gain: f64,
    /// Added to the voltage before the gain, mV.
    pub analog_offset_mv: f64,
}

impl Default for ExposureDescription {
    fn default() -> Self {
        Self {
            time_ms: None,
            auto: None,
            auto_target: None,
            auto_percentile: 99.0,
            analog_gain: 1.0,
            analog_offset_mv: 0.0,
        }
    }
}

/// Which image pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PipelineName {
    /// Demosaic, white balance, colour matrix.
    #[default]
    Classic,
}

/// How missing channels are filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DemosaicName {
    /// Linear interpolation, any mosaic.
    #[default]
    Bilinear,
    /// Malvar, He, Cutler 2004; Bayer only.
    Malvar2004,
    /// Along edges, in the manner of Adams and Hamilton 1997; Bayer only.
    Adaptive,
}

/// White balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum WhiteBalanceName {
    /// None: colours as they are under the scene's light.
    None,
    /// The mean of the picture is made grey.
    GrayWorld,
    /// The scene's illuminant is made white.
    #[default]
    Illuminant,
}

/// The surfaces a colour matrix is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ColorCorrectionName {
    /// The 24 patches of the ColorChecker.
    #[default]
    Macbeth,
    /// The natural reflectances.
    Natural,
}

/// Colour space of the pictures written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OutputName {
    /// sRGB (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Display P3.
    DisplayP3,
}

/// `[isp]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct IspDescription {
    /// Which pipeline.
    pub pipeline: PipelineName,
    /// How missing channels are filled in.
    pub demosaic: DemosaicName,
    /// White balance.
    pub white_balance: WhiteBalanceName,
    /// The surfaces the colour matrix is fitted to by least squares, under the scene's illuminant.
    pub color_correction: ColorCorrectionName,
    /// Whether the matrix is constrained to render the illuminant's white exactly.
    pub preserve_white: bool,
    /// Noise that the matrix is fitted for, percent of the brightest white; 0: plain least squares.
    pub color_noise_percent: f64,
    /// Colour space of the pictures written.
    pub output: OutputName,
}

impl Default for IspDescription {
    fn default() -> Self {
        Self {
            pipeline: PipelineName::Classic,
            demosaic: DemosaicName::Bilinear,
            white_balance: WhiteBalanceName::Illuminant,
            color_correction: ColorCorrectionName::Macbeth,
            preserve_white: false,
            color_noise_percent: 0.3,
            output: OutputName::Srgb,
        }
    }
}
