//! Resolves a description into optics, sensor and exposure. Every key is checked in its own unit and converted to SI.

use super::CameraError;
use super::description::{
    ArchitectureName, AutoExposureName, BinningDescription, CameraDescription, ConversionGainName,
    FILTER_TABLE, OpticsDescription, OpticsModelName, PatternDescription, SensorDescription,
};
use super::ranges::{checked, checked_as};
use crate::names::steers;
use crate::numeric::Number;
use crate::optics::{
    BirefringentLowPass, ChromaticFocus, Defocus, Optics, OpticsModel, Padding, PsfStack, Transmittance,
    Wavefront, WavefrontUnit, ZernikeMode,
};
use crate::sensor::cfa::{self, WeightedMosaic};
use crate::sensor::{
    Adc, Aperture, AutoExposure, Binning, BinningMode, Cfa, Channel, ColorArchitecture, ConversionGain,
    DarkCurrentTemperature, Filter, LowGain, Mosaic, NonUniformity, Pixel, Sensor, SensorError,
};
use crate::spectrum::{Spectrum, WavelengthGrid};

const ZERO_CELSIUS_K: f64 = 273.15;
/// Temperature at which descriptions state the dark signal.
const REFERENCE_C: f64 = 25.0;

/// A quantity of the low gain without the gain.
const NO_LOW_GAIN: &str = "a second gain needs `sensor.pixel.low_conversion_gain_uv_per_e`";

fn key(key: &str, message: impl std::fmt::Display) -> CameraError {
    CameraError::Key { key: key.into(), message: message.to_string() }
}

fn curve(name: &str, filter: &Filter, grid: WavelengthGrid) -> Result<Spectrum, CameraError> {
    let spectrum = filter.spectrum(grid).map_err(|e| key(name, e))?;
    match spectrum.values().iter().position(|v| !(-1e-3..=1.001).contains(v)) {
        None => Ok(spectrum.map(|_, v| v.clamp(0.0, 1.0))?),
        Some(i) => {
            let (value, nm) = (spectrum.values()[i], grid.wavelength_nm(i));
            Err(key(name, format_args!("{value} at {nm} nm; expected 0 to 1")))
        }
    }
}

/// Checks that a name can be shown in one line.
pub(super) fn name(d: &CameraDescription) -> Result<(), CameraError> {
    match d.name.chars().find(|&c| steers(c)) {
        None => Ok(()),
        Some(c) => Err(key(
            "name",
            format_args!(
                "it contains the control character U+{:04X}; expected a name in one line",
                u32::from(c)
            ),
        )),
    }
}

/// The lens of a description, its curves on a wavelength grid.
pub(super) fn optics(d: &OpticsDescription, grid: WavelengthGrid) -> Result<Optics, CameraError> {
    let focal_length_m = checked("optics.focal_length_mm", d.focal_length_mm)? * 1e-3;
    let f_number = checked("optics.f_number", d.f_number)?;
    let separation_um = checked("optics.low_pass_separation_um", d.low_pass_separation_um)?;
    Ok(Optics {
        model: model(d)?,
        falloff: d.falloff,
        transmittance: Transmittance::Spectral(curve("optics.transmittance", &d.transmittance, grid)?),
        ir_cut: d.ir_cut.as_ref().map(|f| curve("optics.ir_cut", f, grid)).transpose()?,
        olpf: (separation_um > 0.0).then_some(BirefringentLowPass {
            horizontal_separation_m: separation_um * 1e-6,
            vertical_separation_m: separation_um * 1e-6,
        }),
        padding: Padding { boundary: d.surround, ..Padding::default() },
        ..Optics::new(focal_length_m, f_number)
    })
}

fn model(d: &OpticsDescription) -> Result<OpticsModel, CameraError> {
    let defocus = match checked("optics.defocus_dioptres", d.defocus_dioptres)? {
        0.0 => Defocus::None,
        dioptres => Defocus::Dioptres(dioptres),
    };
    let reference_nm = checked("optics.chromatic_reference_nm", d.chromatic_reference_nm)?;
    let slope = checked("optics.chromatic_dioptres_per_um", d.chromatic_dioptres_per_um)?;
    let chromatic = match slope {
        0.0 => ChromaticFocus::None,
        _ => ChromaticFocus::Linear { reference_nm, dioptres_per_nm: slope * 1e-3 },
    };
    if d.model != OpticsModelName::Zernike && !d.zernike_um.is_empty() {
        return Err(key("optics.zernike_um", "coefficients need model = \"zernike\""));
    }
    if d.model != OpticsModelName::Psf && d.psf.is_some() {
        return Err(key("optics.psf", "a point spread function needs model = \"psf\""));
    }
    match d.model {
        OpticsModelName::Pinhole => Ok(OpticsModel::Pinhole),
        OpticsModelName::Diffraction => Ok(OpticsModel::Diffraction { defocus, chromatic }),
        OpticsModelName::Zernike => Ok(OpticsModel::Zernike { wavefront: wavefront(d)?, defocus, chromatic }),
        OpticsModelName::Psf => Ok(OpticsModel::Psf(psf(d)?)),
    }
}

fn wavefront(d: &OpticsDescription) -> Result<Wavefront, CameraError> {
    let term = |(number, &um): (&String, &f64)| {
        let name = format!("optics.zernike_um.{number}");
        let parsed = number.parse().map_err(|_| key(&name, "the key is the number of a Zernike mode"))?;
        let um = checked_as("optics.zernike_um", &name, um)?;
        Ok((ZernikeMode::from_index(d.zernike_ordering, parsed).map_err(|e| key(&name, e))?, um))
    };
    let terms = d.zernike_um.iter().map(term).collect::<Result<Vec<_>, CameraError>>()?;
    Wavefront::new(&terms, WavefrontUnit::Micrometres).map_err(|e| key("optics.zernike_um", e))
}

fn psf(d: &OpticsDescription) -> Result<PsfStack, CameraError> {
    let psf =
        d.psf.as_ref().ok_or_else(|| key("optics.psf", "model = \"psf\" needs a table [optics.psf]"))?;
    let planes = psf
        .planes
        .clone()
        .ok_or_else(|| key("optics.psf.file", format_args!("'{}' has not been read", psf.file)))?;
    let spacing_m = checked("optics.psf.spacing_um", psf.spacing_um)? * 1e-6;
    let start_nm = checked("optics.psf.start_nm", psf.start_nm)?;
    let step_nm = checked("optics.psf.step_nm", psf.step_nm)?;
    let made = if planes.count() == 1 {
        PsfStack::achromatic(planes.rows(), planes.cols(), planes.into_data(), spacing_m)
    } else {
        let grid =
            WavelengthGrid::new(start_nm, step_nm, planes.count()).map_err(|e| key("optics.psf", e))?;
        PsfStack::new(grid.wavelengths_nm().collect(), planes, spacing_m)
    };
    made.map_err(|e| key("optics.psf.file", e))
}

/// The error of a quantity that was stated in electrons and is out of range in volts.
fn in_volts(name: &str, electrons: f64, error: &CameraError) -> CameraError {
    key(name, format_args!("{} electrons are too many: {error}", Number(electrons)))
}

/// Converts quantities in electrons to volts at the pixel, so that equal cameras have equal descriptions.
///
/// # Errors
/// When a quantity or the conversion gain is out of range.
pub(super) fn electrons_to_volts(d: &mut SensorDescription) -> Result<(), CameraError> {
    let p = &mut d.pixel;
    let quantities = [
        ("sensor.dsnu_e", "sensor.dsnu_mv", d.dsnu_e.take(), &mut d.dsnu_mv, 1e-3),
        (
            "sensor.pixel.dark_current_e_per_s",
            "sensor.pixel.dark_voltage_v_per_s",
            p.dark_current_e_per_s.take(),
            &mut p.dark_voltage_v_per_s,
            1e-6,
        ),
        (
            "sensor.pixel.read_noise_e",
            "sensor.pixel.read_noise_mv",
            p.read_noise_e.take(),
            &mut p.read_noise_mv,
            1e-3,
        ),
    ];
    for (name, volts_name, electrons, volts, per_microvolt) in quantities {
        if let Some(electrons) = electrons {
            let gain_uv = checked("sensor.pixel.conversion_gain_uv_per_e", p.conversion_gain_uv_per_e)?;
            let value = checked(name, electrons)? * gain_uv * per_microvolt;
            *volts = checked(volts_name, value).map_err(|e| in_volts(name, electrons, &e))?;
        }
    }
    if let Some(electrons) = p.low_gain_read_noise_e.take() {
        let name = "sensor.pixel.low_gain_read_noise_e";
        let gain_uv = p.low_conversion_gain_uv_per_e.ok_or_else(|| key(name, NO_LOW_GAIN))?;
        let gain_uv = checked("sensor.pixel.low_conversion_gain_uv_per_e", gain_uv)?;
        let mv = checked(name, electrons)? * gain_uv * 1e-3;
        let mv = checked("sensor.pixel.low_gain_read_noise_mv", mv);
        p.low_gain_read_noise_mv = Some(mv.map_err(|e| in_volts(name, electrons, &e))?);
    }
    Ok(())
}

/// The sensor of a description, its curves on a wavelength grid.
pub(super) fn sensor(d: &SensorDescription, grid: WavelengthGrid) -> Result<Sensor, CameraError> {
    let p = &d.pixel;
    let well_v = checked("sensor.pixel.full_well_e", p.full_well_e)?;
    let pixel = Pixel {
        pitch_m: checked("sensor.pixel.pitch_um", p.pitch_um)? * 1e-6,
        fill_factor: checked("sensor.pixel.fill_factor", p.fill_factor)?,
        conversion_gain_v_per_e: checked(
            "sensor.pixel.conversion_gain_uv_per_e",
            p.conversion_gain_uv_per_e,
        )? * 1e-6,
        voltage_swing_v: checked("sensor.pixel.voltage_swing_v", p.voltage_swing_v)?,
        full_well_e: well_v,
        dark_voltage_v_per_s: checked("sensor.pixel.dark_voltage_v_per_s", p.dark_voltage_v_per_s)?,
        read_noise_v: checked("sensor.pixel.read_noise_mv", p.read_noise_mv)? * 1e-3,
    };
    let temperature_c = checked("sensor.pixel.temperature_c", p.temperature_c)?;
    let interval_k = checked("sensor.pixel.dark_doubling_c", p.dark_doubling_c)?;
    let nonuniformity = NonUniformity {
        prnu_fraction: checked("sensor.prnu_percent", d.prnu_percent)? * 1e-2,
        dsnu_v: checked("sensor.dsnu_mv", d.dsnu_mv)? * 1e-3,
        row_noise_v: checked("sensor.row_noise_mv", d.row_noise_mv)? * 1e-3,
        column_noise_v: checked("sensor.column_noise_mv", d.column_noise_mv)? * 1e-3,
        dead_pixel_fraction: checked("sensor.dead_pixels_ppm", d.dead_pixels_ppm)? * 1e-6,
        hot_pixel_fraction: checked("sensor.hot_pixels_ppm", d.hot_pixels_ppm)? * 1e-6,
        hot_pixel_dark_voltage_v_per_s: checked(
            "sensor.hot_pixel_dark_voltage_v_per_s",
            d.hot_pixel_dark_voltage_v_per_s,
        )?,
        device_serial: d.serial,
    };
    checked("sensor.adc_bits", d.adc_bits.into())?;
    let black_level_dn = checked("sensor.black_level_dn", d.black_level_dn)?;
    let adc = Adc { bits: d.adc_bits, black_level_dn };
    adc.validate().map_err(|e| key("sensor.black_level_dn", e))?;
    // A quarter of the crosstalk goes to each of the four neighbours that share an edge.
    let leak = checked("sensor.crosstalk_percent", d.crosstalk_percent)? * 1e-2;
    let side = leak / 4.0;
    let cfa = color_filter_array(d, grid)?;
    let binning = d.binning.map(|binning| self::binning(d, binning, &cfa)).transpose()?;
    let sensor = Sensor {
        aperture: Aperture::Area,
        crosstalk: (leak > 0.0).then_some([[0.0, side, 0.0], [side, 1.0 - leak, side], [0.0, side, 0.0]]),
        nonuniformity,
        adc,
        architecture: match d.architecture {
            ArchitectureName::Mosaic => ColorArchitecture::Mosaic,
            ArchitectureName::Prism => ColorArchitecture::Prism,
            ArchitectureName::FieldSequential => ColorArchitecture::FieldSequential,
        },
        dark_temperature: Some(DarkCurrentTemperature::Doubling {
            temperature_k: temperature_c + ZERO_CELSIUS_K,
            reference_k: REFERENCE_C + ZERO_CELSIUS_K,
            interval_k,
        }),
        ..Sensor::new(
            d.rows,
            d.cols,
            pixel,
            cfa,
            curve("sensor.quantum_efficiency", &d.quantum_efficiency, grid)?,
        )
    };
    let sensor = match binning {
        Some(binning) => binned(sensor, binning)?,
        None => sensor,
    };
    sensor.validate().map_err(|e| match e {
        SensorError::Empty { .. } => key(if d.rows == 0 { "sensor.rows" } else { "sensor.cols" }, e),
        SensorError::TooLarge { .. } => key(if d.cols > d.rows { "sensor.cols" } else { "sensor.rows" }, e),
        other => key("sensor", other),
    })?;
    Ok(sensor)
}

/// The binning of a description, with the side of its blocks.
fn binning(d: &SensorDescription, stated: BinningDescription, cfa: &Cfa) -> Result<Binning, CameraError> {
    let name = "sensor.binning";
    let side = match stated {
        BinningDescription::Blocks(blocks) if (2..=Binning::MAX_SIDE).contains(&blocks.side) => blocks.side,
        BinningDescription::Blocks(blocks) => {
            let expected = format!("expected 2 to {}", Binning::MAX_SIDE);
            return Err(key("sensor.binning.side", format_args!("{} is out of range; {expected}", blocks.side)));
        }
        BinningDescription::Mode(mode) if d.architecture != ArchitectureName::Mosaic => {
            let side = format!("{{ side = 2, mode = \"{}\" }}", mode.name());
            return Err(key(name, format_args!("without a mosaic, the side is to be stated: {side}")));
        }
        BinningDescription::Mode(mode) => cfa.mosaic().block_side(Binning::MAX_SIDE).ok_or_else(|| {
            key(
                name,
                format_args!(
                    "the tile of `sensor.cfa.pattern` has no blocks of one filter; expected a pattern such as quad-bayer or nona, or, \
                     for one filter over the whole sensor, {{ side = 2, mode = \"{}\" }}",
                    mode.name()
                ),
            )
        })?,
    };
    Ok(Binning { side, mode: stated.mode() })
}

/// A sensor of photodiodes with its samples binned.
fn binned(sensor: Sensor, binning: Binning) -> Result<Sensor, CameraError> {
    let side = binning.side;
    let cfa = match (sensor.architecture, sensor.cfa.binned(side)) {
        (_, Some(cfa)) => cfa,
        (ColorArchitecture::Mosaic, None) => {
            let fitting = match sensor.cfa.mosaic().block_side(Binning::MAX_SIDE) {
                Some(other) => format!("expected a side of {other}"),
                None => "expected a pattern such as quad-bayer or nona".into(),
            };
            let message = format!(
                "blocks of {side} × {side} pixels of the tile of `sensor.cfa.pattern` have several filters; {fitting}"
            );
            return Err(key("sensor.binning", message));
        }
        (ColorArchitecture::Prism | ColorArchitecture::FieldSequential, None) => sensor.cfa.clone(),
    };
    for (name, pixels) in [("sensor.rows", sensor.rows), ("sensor.cols", sensor.cols)] {
        if !pixels.is_multiple_of(side) {
            let fits = (pixels / side).max(1) * side;
            let message = format!(
                "`sensor.binning` with a side of {side} needs a multiple of {side}, such as {fits}; got {pixels}"
            );
            return Err(key(name, message));
        }
    }
    let pixel = Pixel { pitch_m: sensor.pixel.pitch_m * side as f64, ..sensor.pixel };
    let (rows, cols) = (sensor.rows / side, sensor.cols / side);
    Ok(Sensor { rows, cols, pixel, cfa, binning: Some(binning), ..sensor })
}

fn color_filter_array(d: &SensorDescription, grid: WavelengthGrid) -> Result<Cfa, CameraError> {
    let mut filters = Vec::new();
    for (letter, filter) in &d.cfa.filters {
        let name = format!("sensor.cfa.filters.{letter}");
        if let (FILTER_TABLE, Filter::File(file)) = (letter.as_str(), filter) {
            return Err(key(&name, format_args!("'{file}' has not been read")));
        }
        filters.push((single_letter(&name, letter)?, curve(&name, filter, grid)?));
    }
    match &d.cfa.pattern {
        PatternDescription::Name(name) => {
            if let Some(letter) = d.cfa.mixtures.keys().next() {
                let name = format!("sensor.cfa.mixtures.{letter}");
                return Err(key(&name, "mixtures need a pattern in letters"));
            }
            let at = if filters.is_empty() { "sensor.cfa.pattern" } else { "sensor.cfa.filters" };
            cfa::builtin_with(name, grid, &filters).map_err(|e| key(at, e))
        }
        PatternDescription::Letters(lines) if d.cfa.mixtures.is_empty() => {
            Cfa::from_pattern(lines.join("/"), lines, &filters).map_err(|e| key("sensor.cfa.pattern", e))
        }
        PatternDescription::Letters(lines) => mixed(d, lines, &filters),
    }
}

/// A pattern with letters for weighted sums of filters.
fn mixed(d: &SensorDescription, lines: &[String], filters: &[(char, Spectrum)]) -> Result<Cfa, CameraError> {
    let (mosaic, letters) = Mosaic::from_letters(lines).map_err(|e| key("sensor.cfa.pattern", e))?;
    let mut of_letter = Vec::new();
    for &letter in &letters {
        let mut weights = vec![0.0; filters.len()];
        match d.cfa.mixtures.get(&letter.to_string()) {
            Some(mixture) => {
                for (part, &weight) in mixture {
                    let name = format!("sensor.cfa.mixtures.{letter}");
                    let part = single_letter(&name, part)?;
                    let at = filters.iter().position(|(f, _)| *f == part);
                    let at = at.ok_or_else(|| key(&name, format_args!("no filter is called '{part}'")))?;
                    weights[at] = checked_as("sensor.cfa.mixtures", &name, weight)?;
                }
            }
            None => match filters.iter().position(|(f, _)| *f == letter) {
                Some(at) => weights[at] = 1.0,
                None => {
                    return Err(key(
                        "sensor.cfa.pattern",
                        format_args!("'{letter}' is neither a filter nor a mixture"),
                    ));
                }
            },
        }
        of_letter.push(weights);
    }
    let weights = mosaic.cells().iter().flat_map(|&c| of_letter[usize::from(c)].clone()).collect();
    let tile = WeightedMosaic::new(mosaic.rows(), mosaic.cols(), filters.len(), weights);
    let channel =
        |(letter, s): &(char, Spectrum)| Channel { name: letter.to_string(), transmittance: s.clone() };
    let primaries: Vec<Channel> = filters.iter().map(channel).collect();
    tile.and_then(|t| t.cfa(lines.join("/"), &primaries)).map_err(|e| key("sensor.cfa.mixtures", e))
}

fn single_letter(name: &str, text: &str) -> Result<char, CameraError> {
    let mut chars = text.chars();
    match (chars.next(), chars.next()) {
        (Some(letter), None) if !steers(letter) => Ok(letter),
        _ => Err(key(name, format_args!("'{text}' is not a single letter"))),
    }
}

impl CameraDescription {
    /// The wavelength grid of the camera, used when a scene does not determine it.
    ///
    /// # Errors
    /// When the key is not a uniform grid of at most 100000 wavelengths.
    pub fn grid(&self) -> Result<WavelengthGrid, CameraError> {
        let Some([start, step, end]) = self.wavelengths_nm else { return Ok(WavelengthGrid::VISIBLE) };
        let is_nm = |nm| checked("wavelengths_nm", nm).is_ok();
        let steps = ((end - start) / step).round();
        if !(is_nm(start) && is_nm(end) && (1.0..=1e5).contains(&steps)) {
            return Err(key(
                "wavelengths_nm",
                format_args!(
                    "[{}, {}, {}]; expected [first, step, last] in nm, such as [400, 10, 700]",
                    Number(start),
                    Number(step),
                    Number(end)
                ),
            ));
        }
        WavelengthGrid::new(start, step, steps as usize + 1).map_err(|e| key("wavelengths_nm", e))
    }
}

/// The stated exposure time, or the rule for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ExposureTime {
    /// The stated time, s.
    Fixed(f64),
    /// The exposure rule.
    Auto(AutoExposure),
}

/// The conversion gain of the exposures of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum GainChoice {
    /// The same for every exposure.
    Fixed(ConversionGain),
    /// The high gain for exposures that fit it, otherwise the low one.
    Auto(LowGain),
}

/// The conversion gain of a description.
pub(super) fn conversion_gain(d: &CameraDescription) -> Result<GainChoice, CameraError> {
    let pixel = &d.sensor.pixel;
    let low = match pixel.low_conversion_gain_uv_per_e {
        None if pixel.low_gain_read_noise_mv.is_some() => {
            return Err(key("sensor.pixel.low_gain_read_noise_mv", NO_LOW_GAIN));
        }
        None => None,
        Some(uv) => {
            let (name, high_uv) =
                ("sensor.pixel.low_conversion_gain_uv_per_e", pixel.conversion_gain_uv_per_e);
            checked(name, uv)?;
            // A ratio of 1024 is ten more bits.
            if uv >= high_uv || uv * LowGain::MAX_RATIO < high_uv {
                let expected =
                    "expected less than `sensor.pixel.conversion_gain_uv_per_e`, and at least 1/1024 of it";
                return Err(key(name, format_args!("{uv} is out of range; {expected}")));
            }
            let noise_mv = pixel.low_gain_read_noise_mv.unwrap_or(pixel.read_noise_mv);
            let noise_mv = checked("sensor.pixel.low_gain_read_noise_mv", noise_mv)?;
            Some(LowGain { conversion_gain_v_per_e: uv * 1e-6, read_noise_v: noise_mv * 1e-3 })
        }
    };
    let name = d.exposure.conversion_gain.unwrap_or(ConversionGainName::High);
    let low = || low.ok_or_else(|| key("exposure.conversion_gain", NO_LOW_GAIN));
    let is_digital = d.sensor.binning.is_some_and(|b| b.mode() == BinningMode::Digital);
    Ok(match name {
        ConversionGainName::High => GainChoice::Fixed(ConversionGain::High),
        ConversionGainName::Low => GainChoice::Fixed(ConversionGain::Low(low()?)),
        ConversionGainName::Auto => GainChoice::Auto(low()?),
        ConversionGainName::Combined if is_digital => {
            return Err(key("exposure.conversion_gain", SensorError::CombinedBinning));
        }
        ConversionGainName::Combined => GainChoice::Fixed(ConversionGain::Combined(low()?)),
    })
}

/// The exposure of a description: time or rule, analog gain, analog offset in V.
pub(super) fn exposure(d: &CameraDescription) -> Result<(ExposureTime, f64, f64), CameraError> {
    let e = &d.exposure;
    let gain = checked("exposure.analog_gain", e.analog_gain)?;
    let offset_v = checked("exposure.analog_offset_mv", e.analog_offset_mv)? * 1e-3;
    // Also where the rule is another: the file would state nonsense.
    let stated = e.auto_target.map(|t| checked("exposure.auto_target", t)).transpose()?;
    let target = |default: f64| stated.unwrap_or(default);
    let percentile = checked("exposure.auto_percentile", e.auto_percentile)?;
    let time = match (e.time_ms, e.auto) {
        (Some(_), Some(_)) => return Err(key("exposure.auto", "give either time_ms or auto, not both")),
        (Some(ms), None) => ExposureTime::Fixed(checked("exposure.time_ms", ms)? * 1e-3),
        (None, None | Some(AutoExposureName::Specular)) => {
            ExposureTime::Auto(AutoExposure::Specular { fraction: target(0.95) })
        }
        (None, Some(AutoExposureName::Mean)) => {
            ExposureTime::Auto(AutoExposure::Mean { target: target(0.18) })
        }
        (None, Some(AutoExposureName::Luminance)) => {
            ExposureTime::Auto(AutoExposure::LuminancePercentile { percentile, target: target(0.95) })
        }
    };
    Ok((time, gain, offset_v))
}

/// The noise that the fit of the colour matrix assumes, relative to the brightest white.
pub(super) fn color_noise(d: &CameraDescription) -> Result<f64, CameraError> {
    Ok(checked("isp.color_noise_percent", d.isp.color_noise_percent)? * 1e-2)
}
