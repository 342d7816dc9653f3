//! Cameras by name or file: described in TOML, checked, resolved.

use std::path::Path;

use smalti::camera::{Camera, CameraDescription, CameraError};
use smalti::numeric::Planes;
use smalti::sensor::Filter;
use smalti::spectrum::WavelengthGrid;

use crate::camera_toml::Override;
use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, beside, builtin};
use crate::{Limits, npy, spectrum_csv};

static CAMERAS: &[BuiltinFile] = &[
    builtin!("cameras", "bayer", "The L³ slides' camera, Bayer"),
    builtin!("cameras", "rgbw", "The L³ slides' camera, RGBW 2 × 2"),
    builtin!("cameras", "clarity", "The L³ slides' camera, RCCB as in Aptina Clarity+"),
    builtin!("cameras", "kodak", "The L³ slides' camera, Kodak's panchromatic 4 × 4"),
    builtin!("cameras", "wang", "The L³ slides' camera, Wang et al. 2011, 5 × 5"),
    builtin!("cameras", "rgbx", "The L³ slides' camera, RGB and near infrared"),
    builtin!("cameras", "rgbcmy", "The L³ slides' camera, six colours in 3 × 2"),
    builtin!("cameras", "medical", "The L³ slides' camera, RGB and a narrow band for medical imaging"),
    builtin!("cameras", "table1", "\"Resolution in Color Filter Array Images\", table 1"),
    builtin!("cameras", "phone", "A phone of 2020: 1 µm pixels at f/1.8"),
    builtin!("cameras", "phone-quad", "A phone's main camera, type 1/1.31: quad-Bayer, 1.2 µm"),
    builtin!("cameras", "automotive", "Automotive, OmniVision's 2.8 µm pixel: RCCB"),
    builtin!("cameras", "machine-vision", "Machine vision, Sony IMX250: global shutter, 3.45 µm, Bayer"),
    builtin!("cameras", "cmv12000", "Cinema and machine vision, ams CMV12000: global shutter, 5.5 µm, Bayer"),
    builtin!("cameras", "full-frame", "Full-frame stills, Sony A7R II at ISO 100: 4.51 µm, Bayer"),
];

/// The built-in cameras.
#[must_use]
pub fn names() -> &'static [BuiltinFile] {
    CAMERAS
}

/// What a camera file may hold, as JSON Schema.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(CameraDescription)
}

/// A camera by name or file, with overrides applied and the files that it names read; on the given wavelengths, else on its own.
///
/// # Errors
/// When there is none of that name, or a key, a value or a file does not fit; with the line where there is one.
pub fn load(
    name: &str,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    from_source(&TomlSource::find("camera", CAMERAS, name)?, overrides, grid)
}

/// As [`load`], from a text that is not a file's; files that it names are looked for in the source's folder.
pub fn from_source(
    source: &TomlSource,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    let mut description = source.describe(overrides)?;
    // A file that gives no name is called by its own.
    let unnamed = description.name == CameraDescription::default().name;
    if let Some(stem) = Path::new(&source.name).file_stem().filter(|_| unnamed) {
        description.name = stem.to_string_lossy().into_owned();
    }
    let wrong = |key: &str, message: &str| Box::new(about(source, overrides, key, message));
    read_files(&mut description, &source.folder, &wrong)?;
    let made = grid.map_or_else(|| description.grid(), Ok).and_then(|grid| Camera::new(description, grid));
    made.map_err(|e| match e {
        CameraError::Key { key, message } => wrong(&key, &message),
        other => Box::new(Diagnostic::new(source.name.clone(), other.to_string())),
    })
}

/// Shows an impossible value where it is stated: on the command line, in the file, or without a place if it is a default.
fn about(source: &TomlSource, overrides: &[Override], key: &str, message: &str) -> Diagnostic {
    // An override of the key itself, of the table around it, or of a key within it.
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|r| r.is_empty() || r.starts_with('.'))
    };
    match overrides.iter().rev().find(|o| within(key, &o.key) || within(&o.key, key)) {
        Some(o) => o.wrong(format!("`{key}`: {message}")),
        None => source.about_key(key, message),
    }
}

/// Replaces the name of every file by its content, so that the description is complete.
fn read_files(
    d: &mut CameraDescription,
    folder: &Path,
    wrong: &dyn Fn(&str, &str) -> Box<Diagnostic>,
) -> Result<(), Box<Diagnostic>> {
    let lens = [
        ("optics.transmittance".to_owned(), Some(&mut d.optics.transmittance)),
        ("optics.ir_cut".to_owned(), d.optics.ir_cut.as_mut()),
    ];
    let sensor = [("sensor.quantum_efficiency".to_owned(), Some(&mut d.sensor.quantum_efficiency))];
    let filters =
        d.sensor.cfa.filters.iter_mut().map(|(letter, f)| (format!("sensor.cfa.filters.{letter}"), Some(f)));
    for (key, filter) in lens.into_iter().chain(sensor).chain(filters) {
        if let Some(filter) = filter {
            read_curve(filter, folder).map_err(|e| wrong(&key, &e))?;
        }
    }
    if let Some(psf) = &mut d.optics.psf {
        let path = beside(folder, &psf.file);
        let read = || -> Result<(Planes, String), String> {
            let array = npy::read(&path, Limits::default()).map_err(|e| e.to_string())?;
            let (count, rows, cols) = match array.shape[..] {
                [rows, cols] => (1, rows, cols),
                [count, rows, cols] => (count, rows, cols),
                _ => {
                    let (path, got) = (path.display(), array.shape.len());
                    return Err(format!("{path}: expected 2 or 3 dimensions, got {got}"));
                }
            };
            let planes = Planes::new(rows, cols, count, array.to_f32()).map_err(|e| e.to_string())?;
            let bytes: Vec<u8> = planes.data().iter().flat_map(|v| v.to_le_bytes()).collect();
            Ok((planes, blake3::hash(&bytes).to_hex().to_string()))
        };
        let (planes, hash) = read().map_err(|e| wrong("optics.psf.file", &e))?;
        if !psf.hash.is_empty() && psf.hash != hash {
            let message = format!("the file has the hash {hash}, not that of the description");
            return Err(wrong("optics.psf.hash", &message));
        }
        (psf.planes, psf.hash) = (Some(planes), hash);
    }
    Ok(())
}

/// Replaces a named file by the samples in it.
pub(crate) fn read_curve(filter: &mut Filter, folder: &Path) -> Result<(), String> {
    if let Filter::File(name) = filter {
        let path = beside(folder, name);
        let spectrum = spectrum_csv::read_spectrum(&path.to_string_lossy()).map_err(|e| e.to_string())?;
        let grid = spectrum.grid();
        *filter = Filter::Samples {
            start_nm: grid.start_nm(),
            step_nm: grid.step_nm(),
            values: spectrum.values().to_vec(),
        };
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use smalti::sensor::Exposure;

    use super::*;

    fn camera(name: &str) -> Camera {
        load(name, &[], None).unwrap()
    }

    fn within_2_percent(what: &str, got: f64, published: f64) {
        assert!((got / published - 1.0).abs() <= 0.02, "{what}: {got}, published {published}");
    }

    /// Electrons between the black level and the largest sample.
    fn saturation_e(camera: &Camera) -> f64 {
        let levels = camera.sensor.raw_levels(&Exposure::new(0.01)).unwrap();
        (levels.white_v - levels.black_v) / camera.sensor.pixel.conversion_gain_v_per_e
    }

    /// Read noise, and the temporal dark noise of samples, which includes quantisation; electrons.
    fn dark_noise_e(camera: &Camera) -> (f64, f64) {
        let bias = camera.sensor.noise_variance(0.0, &Exposure::new(0.0)).unwrap();
        let gain = camera.sensor.pixel.conversion_gain_v_per_e;
        (bias.read.sqrt() / gain, bias.temporal().sqrt() / gain)
    }

    /// Dark current at the sensor's temperature, electrons per second.
    fn dark_current_e_per_s(camera: &Camera) -> f64 {
        let dark = camera.sensor.noise_variance(0.0, &Exposure::new(1.0)).unwrap().dark;
        let gain = camera.sensor.pixel.conversion_gain_v_per_e;
        // The dark shot noise is Poisson; PRNU changes its variance by less than 2e-4.
        dark / (gain * gain)
    }

    /// Largest electrons per photon on the pixel in red, green (or clear) and blue, without the infrared cut.
    fn peaks(camera: &Camera) -> Vec<f64> {
        let mut sensor = camera.sensor.clone();
        sensor.ir_cut = None;
        let curves = sensor.spectral_responsivity_on(camera.grid()).unwrap();
        curves.iter().map(|c| c.max() * sensor.pixel.fill_factor).collect()
    }

    #[test]
    fn machine_vision_has_the_emva_figures_of_the_imx250() {
        // MATRIX VISION, mvBlueFOX3-2051: SNRmax 40.3 dB, dynamic range 71.2 dB (EMVA 1288). Teledyne DALSA, Genie Nano: 10.7 ke⁻.
        let camera = camera("machine-vision");
        let saturation = saturation_e(&camera);
        within_2_percent("saturation capacity", saturation, 10_700.0);
        within_2_percent("SNRmax, dB", 10.0 * saturation.log10(), 40.3);
        // The absolute sensitivity threshold of EMVA 1288: temporal dark noise plus half an electron.
        let (_, dark) = dark_noise_e(&camera);
        within_2_percent("dynamic range, dB", 20.0 * (saturation / (dark + 0.5)).log10(), 71.2);
        within_2_percent("dynamic range", saturation / (dark + 0.5), 10f64.powf(71.2 / 20.0));
    }

    #[test]
    fn cmv12000_has_the_figures_of_its_datasheet() {
        // ams, CMV12000, DS000603, v5-00, figures 7 and 8.
        let camera = camera("cmv12000");
        let (saturation, (_, dark)) = (saturation_e(&camera), dark_noise_e(&camera));
        within_2_percent("full well", saturation, 13_500.0);
        within_2_percent("SNRmax, dB", 10.0 * saturation.log10(), 41.3);
        within_2_percent("temporal noise", dark, 13.0);
        within_2_percent("dynamic range, dB", 20.0 * (saturation / dark).log10(), 60.0);
        within_2_percent("dark current", dark_current_e_per_s(&camera), 70.0);
        // Maxima of the curves: red at 605, green at 530 (mean of both rows), blue at 460 nm.
        for (got, published) in peaks(&camera).into_iter().zip([0.392, 0.408, 0.390]) {
            within_2_percent("peak quantum efficiency", got, published);
        }
    }

    #[test]
    fn automotive_has_the_figures_of_the_split_pixel() {
        // Solhusvik et al. (2019), large photodiode at low conversion gain, as in ISETCam.
        let camera = camera("automotive");
        within_2_percent("full well", saturation_e(&camera), 22_000.0);
        within_2_percent("conversion gain", camera.sensor.pixel.conversion_gain_v_per_e, 49e-6);
        within_2_percent("read noise", dark_noise_e(&camera).0, 3.05);
        within_2_percent("dark current", dark_current_e_per_s(&camera), 25.6);
    }

    #[test]
    fn full_frame_has_the_gain_and_noise_of_the_a7r_ii() {
        // Claff (2015): 0.315 DN/e⁻ and 1.413 DN at ISO 100; 14 bits above a black level of 512.
        let camera = camera("full-frame");
        let sensor = &camera.sensor;
        let dn_per_e =
            sensor.adc.levels() / sensor.pixel.voltage_swing_v * sensor.pixel.conversion_gain_v_per_e;
        within_2_percent("gain, DN/e⁻", dn_per_e, 0.315);
        within_2_percent("read noise, DN", dark_noise_e(&camera).1 * dn_per_e, 1.413);
        within_2_percent("saturation, DN", saturation_e(&camera) * dn_per_e, 16_383.0 - 512.0);
        within_2_percent("dynamic range", saturation_e(&camera) / dark_noise_e(&camera).1, 15_871.0 / 1.413);
        // The camera's curves, without a cut of their own.
        assert!(sensor.ir_cut.is_none());
        within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.6);
    }

    #[test]
    fn phone_quad_has_the_figures_scaled_from_the_imx477() {
        // Hogan: 3400 e⁻/µm² and 3 e⁻ at base gain.
        let camera = camera("phone-quad");
        within_2_percent("full well", saturation_e(&camera), 3400.0 * 1.2 * 1.2);
        within_2_percent("read noise", dark_noise_e(&camera).1, 3.0);
        within_2_percent("dynamic range", saturation_e(&camera) / dark_noise_e(&camera).1, 4896.0 / 3.0);
        within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.75);
    }

    #[test]
    fn estimates_state_themselves() {
        for name in ["phone-quad", "automotive", "machine-vision", "full-frame"] {
            let file = names().iter().find(|c| c.name == name).unwrap();
            let mut comment = file.toml.lines().take_while(|l| l.starts_with('#'));
            assert!(comment.any(|l| l.contains("stimates")), "{name}");
        }
    }
}
