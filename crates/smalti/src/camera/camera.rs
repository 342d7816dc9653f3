//! The camera: optics, sensor, exposure and processing, resolved from a description.

use super::CameraError;
use super::description::{CameraDescription, ColorCorrectionName, OutputName};
use super::resolve::{self, ExposureTime, GainChoice};
use crate::color::ColorSpace;
use crate::isp::{self, Classic, ColorConstraint, ColorFit, WhiteBalance};
use crate::optics::{OpticalImage, Optics};
use crate::scene::{MAX_FOV_DEG, Scene};
use crate::sensor::{
    AutoExposure, Cfa, ConversionGain, Exposure, Light, PixelSpectra, Sensor, SensorError, Window,
};
use crate::spectrum::{Observer, Spectrum, WavelengthGrid, reflectance};

/// Share of the samples that may saturate at the high conversion gain where the gain is chosen for each exposure.
const SATURATED_AT_HIGH_GAIN: f64 = 0.005;

/// A camera, with its curves sampled on one wavelength grid.
#[derive(Debug, Clone)]
pub struct Camera {
    description: CameraDescription,
    grid: WavelengthGrid,
    /// The lens.
    pub optics: Optics,
    /// The image sensor.
    pub sensor: Sensor,
    pub(super) exposure_time: ExposureTime,
    analog_gain: f64,
    analog_offset_v: f64,
    gain: GainChoice,
    color_noise: f64,
    /// The colour filter array differs from the description.
    has_other_cfa: bool,
}

impl Camera {
    /// A camera from its description, its curves sampled on a wavelength grid. The description of the camera states quantities that
    /// were given in electrons in volts.
    ///
    /// # Errors
    /// For the first invalid key, with its name, its value and the expected range.
    pub fn new(mut description: CameraDescription, grid: WavelengthGrid) -> Result<Self, CameraError> {
        resolve::name(&description)?;
        resolve::electrons_to_volts(&mut description.sensor)?;
        let (exposure_time, analog_gain, analog_offset_v) = resolve::exposure(&description)?;
        Ok(Self {
            optics: resolve::optics(&description.optics, grid)?,
            sensor: resolve::sensor(&description.sensor, grid)?,
            color_noise: resolve::color_noise(&description)?,
            exposure_time,
            analog_gain,
            analog_offset_v,
            gain: resolve::conversion_gain(&description)?,
            has_other_cfa: false,
            description,
            grid,
        })
    }

    /// The description of the camera.
    #[must_use]
    pub fn description(&self) -> &CameraDescription {
        &self.description
    }

    /// The wavelength grid of its curves.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// The same camera with another number of pixels (with binning, of samples), all of them read.
    #[must_use]
    pub fn with_size(&self, rows: usize, cols: usize) -> Self {
        let sensor = Sensor { rows, cols, window: None, ..self.sensor.clone() };
        Self { sensor, ..self.clone() }
    }

    /// The same camera with as many pixels as `rows` × `cols` photodiodes give: [`Camera::with_size`] without binning.
    pub(crate) fn with_photodiodes(&self, rows: usize, cols: usize) -> Self {
        let side = self.sensor.binning_side();
        self.with_size(rows / side, cols / side)
    }

    /// The same camera with another colour filter array, with binning that of the samples. Its description remains unchanged.
    #[must_use]
    pub fn with_cfa(&self, cfa: Cfa) -> Self {
        let sensor = Sensor { cfa, ..self.sensor.clone() };
        Self { sensor, has_other_cfa: true, ..self.clone() }
    }

    /// Whether the colour filter array differs from the description; see [`Camera::with_cfa`].
    #[must_use]
    pub fn has_other_cfa(&self) -> bool {
        self.has_other_cfa
    }

    /// The same camera with its curves sampled on another wavelength grid, such as that of a scene.
    ///
    /// # Errors
    /// When a curve does not cover the grid.
    pub fn on_grid(&self, grid: WavelengthGrid) -> Result<Self, CameraError> {
        if grid == self.grid {
            return Ok(self.clone());
        }
        let fresh = Self::new(self.description.clone(), grid)?;
        let cfa = if self.has_other_cfa { self.sensor.cfa.on_grid(grid)? } else { fresh.sensor.cfa.clone() };
        let Sensor { rows, cols, window, .. } = self.sensor;
        let sensor = Sensor { cfa, rows, cols, window, ..fresh.sensor };
        Ok(Self { sensor, has_other_cfa: self.has_other_cfa, ..fresh })
    }

    /// Horizontal field of view of `cols` pixels for a scene at a distance, degrees.
    ///
    /// # Errors
    /// When the scene is not beyond the focal length, or the pixels see more than the 170° that a scene may have.
    pub fn field_of_view_deg(&self, cols: usize, distance_m: f64) -> Result<f64, CameraError> {
        let width_m = cols as f64 * self.sensor.pixel.pitch_m;
        let geometry = self.optics.geometry(distance_m)?;
        let deg = 2.0 * (width_m / 2.0 / geometry.image_distance_m()).atan().to_degrees();
        if deg > MAX_FOV_DEG {
            let message =
                format!("{cols} pixels see {deg:.1}° behind the lens; expected at most {MAX_FOV_DEG}°");
            return Err(CameraError::Key { key: "sensor.pixel.pitch_um".into(), message });
        }
        Ok(deg)
    }

    /// The scene with the field of view that fits it on the sensor. A scene from a file (`is_file`) covers at most as many pixels
    /// as it has samples, because it holds no finer detail.
    ///
    /// # Errors
    /// When the scene is not beyond the focal length.
    pub fn fitted(&self, scene: Scene, is_file: bool) -> Result<Scene, CameraError> {
        let (rows, cols) = (scene.radiance().rows(), scene.radiance().cols());
        let whole = self.sensor.cols.min(self.sensor.rows * cols / rows.max(1));
        let span = if is_file { whole.min(cols) } else { whole };
        let deg = self.field_of_view_deg(span.max(1), scene.distance_m())?;
        Ok(scene.with_fov(deg)?)
    }

    /// The pixels that a scene covers in the centre of the sensor. The window begins with a whole tile of the mosaic.
    ///
    /// # Errors
    /// When the scene is not beyond the focal length.
    pub fn window_on(&self, scene: &Scene) -> Result<Window, CameraError> {
        let radiance = scene.radiance();
        let geometry = self.optics.geometry(scene.distance_m())?;
        let spacing_m = geometry.sample_spacing_m(scene.horizontal_fov_deg(), radiance.cols());
        let mosaic = self.sensor.cfa.mosaic();
        let extent = |samples: usize, pixels: usize, tile: usize| {
            let covered = samples as f64 * spacing_m / self.sensor.pixel.pitch_m;
            let middle = pixels as f64 / 2.0;
            // A hundredth of a pixel tolerates rounding in a field of view that was computed from the pixels.
            let first = (middle - covered / 2.0 - 0.01).ceil().max(0.0) as usize;
            let end = ((middle + covered / 2.0 + 0.01).floor() as usize).min(pixels);
            let first = first.next_multiple_of(tile);
            // For a scene smaller than a tile, all pixels are read.
            if first < end { (first, end - first) } else { (0, pixels) }
        };
        let (row, rows) = extent(radiance.rows(), self.sensor.rows, mosaic.rows());
        let (col, cols) = extent(radiance.cols(), self.sensor.cols, mosaic.cols());
        Ok(Window { row, col, rows, cols })
    }

    /// Gains and offset of the exposure, with a time of 1 s. If the conversion gain is chosen for each exposure, it is the low one, with
    /// which exposure rules find their times.
    #[must_use]
    pub fn gain_and_offset(&self) -> Exposure {
        Exposure {
            time_s: 1.0,
            analog_gain: self.analog_gain,
            analog_offset_v: self.analog_offset_v,
            conversion_gain: match self.gain {
                GainChoice::Fixed(gain) => gain,
                GainChoice::Auto(low) => ConversionGain::Low(low),
            },
        }
    }

    /// An exposure with the high conversion gain if the gain is chosen for each exposure and light fits the high one.
    fn with_gain_for<'a>(
        &self,
        exposure: Exposure,
        light: impl Into<Light<'a>>,
    ) -> Result<Exposure, CameraError> {
        let GainChoice::Auto(_) = self.gain else { return Ok(exposure) };
        let high = Exposure { conversion_gain: ConversionGain::High, ..exposure };
        let rule = AutoExposure::SaturatedShare { share: SATURATED_AT_HIGH_GAIN };
        match rule.time_for_samples(&self.sensor, light, &high) {
            Ok(longest_s) if exposure.time_s > longest_s => Ok(exposure),
            Ok(_) | Err(SensorError::NoLight) => Ok(high),
            Err(error) => Err(error.into()),
        }
    }

    /// An error if the conversion gain is chosen for each exposure: a pipeline is learned for the noise of one.
    pub(crate) fn ensure_one_gain(&self) -> Result<(), CameraError> {
        match self.gain {
            GainChoice::Fixed(_) => Ok(()),
            GainChoice::Auto(_) => Err(CameraError::Key {
                key: "exposure.conversion_gain".into(),
                message: "auto changes the noise between exposures, and a pipeline is learned for one; expected high, low or combined".into(),
            }),
        }
    }

    /// The exposure for an optical image, with the stated time or that of the exposure rule.
    ///
    /// # Errors
    /// When the rule finds no light.
    pub fn exposure(&self, image: &OpticalImage) -> Result<Exposure, CameraError> {
        let exposure =
            self.exposure_by(|rule, exposure| rule.exposure_time(&self.sensor, image, exposure))?;
        self.with_gain_for(exposure, image)
    }

    /// The exposure with a given time, s, or with that of the description.
    ///
    /// # Errors
    /// When no time is given and the rule finds no light.
    pub fn exposure_or(&self, time_s: Option<f64>, image: &OpticalImage) -> Result<Exposure, CameraError> {
        match time_s {
            Some(time_s) => self.exposure_for(time_s, image),
            None => self.exposure(image),
        }
    }

    /// The exposure with a given time, s, for light on the sensor.
    ///
    /// # Errors
    /// When the conversion gain depends on the light and a stage fails.
    pub(crate) fn exposure_for<'a>(
        &self,
        time_s: f64,
        light: impl Into<Light<'a>>,
    ) -> Result<Exposure, CameraError> {
        self.with_gain_for(Exposure { time_s, ..self.gain_and_offset() }, light)
    }

    /// The exposure time that the description states, s; `None` when a rule determines it.
    #[must_use]
    pub fn stated_time_s(&self) -> Option<f64> {
        match self.exposure_time {
            ExposureTime::Fixed(time_s) => Some(time_s),
            ExposureTime::Auto(_) => None,
        }
    }

    /// The exposure time of the description, s, for an optical image at several multiples of its light.
    ///
    /// # Errors
    /// When the rule finds no light.
    pub fn times_in_light(&self, image: &OpticalImage, factors: &[f64]) -> Result<Vec<f64>, CameraError> {
        match self.exposure_time {
            ExposureTime::Fixed(time_s) => Ok(vec![time_s; factors.len()]),
            ExposureTime::Auto(rule) => self.times_by(rule, image, factors),
        }
    }

    /// The exposure time of a rule, s, for an optical image at several multiples of its light.
    ///
    /// # Errors
    /// When the rule is invalid or finds no light.
    pub fn times_by(
        &self,
        rule: AutoExposure,
        image: &OpticalImage,
        factors: &[f64],
    ) -> Result<Vec<f64>, CameraError> {
        let (rate, exposure) = (rule.rate(&self.sensor, image)?, self.gain_and_offset());
        let time = |factor: &f64| Ok(rule.time_for_rate(&self.sensor, rate * factor, &exposure)?);
        factors.iter().map(time).collect()
    }

    /// The exposure with the stated time or that of the exposure rule.
    fn exposure_by(
        &self,
        find: impl FnOnce(AutoExposure, &Exposure) -> Result<f64, SensorError>,
    ) -> Result<Exposure, CameraError> {
        let exposure = self.gain_and_offset();
        let time_s = match self.exposure_time {
            ExposureTime::Fixed(time_s) => time_s,
            ExposureTime::Auto(rule) => find(rule, &exposure)?,
        };
        Ok(Exposure { time_s, ..exposure })
    }

    /// The irradiance at the point of an optical image that the exposure rule meters; `None` when the time is stated or the rule
    /// meters the whole image. It does not depend on the colour filter array.
    ///
    /// # Errors
    /// When the rule is invalid or the optical image does not reach the sensor.
    pub fn metered(&self, image: &OpticalImage) -> Result<Option<Spectrum>, CameraError> {
        match self.exposure_time {
            ExposureTime::Fixed(_) => Ok(None),
            ExposureTime::Auto(rule) => Ok(rule.metered(&self.sensor, image)?),
        }
    }

    /// The exposure for a known [metered](Self::metered) irradiance.
    ///
    /// # Errors
    /// When the rule finds no light.
    pub fn exposure_metered(&self, irradiance: &Spectrum) -> Result<Exposure, CameraError> {
        if let GainChoice::Auto(_) = self.gain {
            let message = "auto needs a picture, and only the light at one point is known here; expected high, low or combined";
            return Err(CameraError::Key { key: "exposure.conversion_gain".into(), message: message.into() });
        }
        self.exposure_by(|rule, exposure| rule.time_for_metered(&self.sensor, irradiance, exposure))
    }

    /// The exposure for light that was gathered on the pixels, with the stated time or that of a rule that meters all samples.
    ///
    /// # Errors
    /// When the rule finds no light, or meters a point and needs [`Camera::exposure_metered`].
    pub fn exposure_gathered(&self, pixels: &PixelSpectra) -> Result<Exposure, CameraError> {
        let exposure =
            self.exposure_by(|rule, exposure| rule.time_for_samples(&self.sensor, pixels, exposure))?;
        self.with_gain_for(exposure, pixels)
    }

    /// The processing for scenes under a light (photons): demosaicking, white balance, colour matrix.
    ///
    /// # Errors
    /// When the colour matrix cannot be computed.
    pub fn isp(&self, light: &Spectrum, white_balance: WhiteBalance) -> Result<Classic, CameraError> {
        self.isp_fitted_to(&self.color_fit(light)?, white_balance)
    }

    /// The training data of the camera's colour matrix under an illuminant (photons).
    ///
    /// # Errors
    /// When the illuminant has no luminance.
    pub fn color_fit(&self, light: &Spectrum) -> Result<ColorFit, CameraError> {
        Ok(ColorFit::new(&self.surfaces()?, light, Observer::Cie1931)?)
    }

    /// [`Camera::isp`] with given training data of the colour matrix.
    ///
    /// # Errors
    /// When the colour matrix cannot be computed.
    pub fn isp_fitted_to(&self, fit: &ColorFit, white_balance: WhiteBalance) -> Result<Classic, CameraError> {
        let isp = &self.description.isp;
        let constraint =
            if isp.preserve_white { ColorConstraint::PreserveWhite } else { ColorConstraint::None };
        let matrix = fit.matrix(&self.responsivities()?, constraint, self.color_noise)?;
        Ok(Classic { demosaic: isp.demosaic, white_balance, ..Classic::new(matrix) })
    }

    /// Camera values from XYZ under a light (photons), a row for each channel, as a raw file states them; see
    /// [`camera_from_xyz`](crate::isp::camera_from_xyz).
    ///
    /// # Errors
    /// When the solver fails.
    pub fn camera_from_xyz(&self, light: &Spectrum) -> Result<Vec<[f64; 3]>, CameraError> {
        Ok(isp::camera_from_xyz(&self.responsivities()?, &self.surfaces()?, light, Observer::Cie1931)?)
    }

    /// The reflectances that the colour matrix is fitted to.
    pub(crate) fn surfaces(&self) -> Result<Vec<Spectrum>, CameraError> {
        let named = match self.description.isp.color_correction {
            ColorCorrectionName::Macbeth => reflectance::colorchecker(self.grid)?,
            ColorCorrectionName::Natural => reflectance::natural(self.grid)?,
        };
        Ok(named.into_iter().map(|(_, s)| s).collect())
    }

    /// The output colour space of pictures.
    #[must_use]
    pub fn output_space(&self) -> ColorSpace {
        match self.description.isp.output {
            OutputName::Srgb => ColorSpace::Srgb,
            OutputName::DisplayP3 => ColorSpace::DisplayP3,
        }
    }

    /// The white balance of the description.
    #[must_use]
    pub fn white_balance(&self) -> WhiteBalance {
        self.description.isp.white_balance
    }

    /// Electrons per photon that enters the lens, for each channel: lens, filters and quantum efficiency.
    pub(crate) fn responsivities(&self) -> Result<Vec<Spectrum>, CameraError> {
        let lens = self.optics.transmittance_on(self.grid)?;
        let channels = self.sensor.spectral_responsivity_on(self.grid)?;
        channels.iter().map(|c| Ok(c.times(&lens)?)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::description::{ArchitectureName, PatternDescription};
    use crate::scene::{Setting, macbeth, uniform};
    use crate::sensor::NoiseMode;

    fn camera(change: impl FnOnce(&mut CameraDescription)) -> Camera {
        let mut d = CameraDescription::default();
        (d.sensor.rows, d.sensor.cols) = (48, 64);
        d.exposure.time_ms = Some(20.0);
        change(&mut d);
        Camera::new(d, WavelengthGrid::VISIBLE).unwrap()
    }

    fn key(change: impl FnOnce(&mut CameraDescription)) -> String {
        let mut d = CameraDescription::default();
        change(&mut d);
        match Camera::new(d, WavelengthGrid::VISIBLE) {
            Err(CameraError::Key { key, .. }) => key,
            other => panic!("expected an error about a key, got {other:?}"),
        }
    }

    #[test]
    fn an_impossible_value_names_its_key() {
        assert_eq!(key(|d| d.sensor.pixel.fill_factor = 1.5), "sensor.pixel.fill_factor");
        assert_eq!(key(|d| d.sensor.pixel.voltage_swing_v = 0.0), "sensor.pixel.voltage_swing_v");
        assert_eq!(key(|d| d.sensor.pixel.read_noise_mv = f64::NAN), "sensor.pixel.read_noise_mv");
        assert_eq!(key(|d| d.optics.f_number = -1.0), "optics.f_number");
        assert_eq!(key(|d| d.sensor.adc_bits = 17), "sensor.adc_bits");
        assert_eq!(
            key(|d| d.optics.transmittance = crate::sensor::Filter::Flat(1.2)),
            "optics.transmittance"
        );
        assert_eq!(
            key(|d| d.sensor.cfa.pattern = PatternDescription::Name("bayr".into())),
            "sensor.cfa.pattern"
        );
        assert_eq!(key(|d| d.isp.color_noise_percent = -1.0), "isp.color_noise_percent");
    }

    #[test]
    fn pixels_that_see_more_than_a_scene_may_have_name_the_pitch() {
        let wide = camera(|d| (d.sensor.pixel.pitch_um, d.optics.focal_length_mm) = (50.0, 4.0));
        let message = wide.field_of_view_deg(2000, 1.0).unwrap_err().to_string();
        let expected =
            "`sensor.pixel.pitch_um`: 2000 pixels see 170.8° behind the lens; expected at most 170°";
        assert_eq!(message, expected);
        assert!(wide.field_of_view_deg(1000, 1.0).unwrap() < 170.0);
    }

    /// Electrons and volts are two units of one quantity: read noise of 2 e⁻ at 50 µV/e⁻ is 0.1 mV.
    #[test]
    fn electrons_are_volts_times_the_conversion_gain() {
        let in_electrons = camera(|d| {
            let p = &mut d.sensor.pixel;
            p.conversion_gain_uv_per_e = 50.0;
            (p.read_noise_e, p.dark_current_e_per_s) = (Some(2.0), Some(4.0));
            d.sensor.dsnu_e = Some(6.0);
        });
        let pixel = &in_electrons.sensor.pixel;
        assert!((pixel.read_noise_v - 1e-4).abs() < 1e-16);
        assert!((pixel.dark_voltage_v_per_s - 2e-4).abs() < 1e-16);
        assert!((in_electrons.sensor.nonuniformity.dsnu_v - 3e-4).abs() < 1e-16);
        let stated = in_electrons.description();
        assert_eq!(stated.sensor.pixel.read_noise_e, None);
        assert!((stated.sensor.pixel.read_noise_mv - 0.1).abs() < 1e-15);
        // The description of the camera gives the same camera.
        let again = Camera::new(stated.clone(), WavelengthGrid::VISIBLE).unwrap();
        assert_eq!((&again.sensor, again.description()), (&in_electrons.sensor, stated));
        assert_eq!(key(|d| d.sensor.pixel.read_noise_e = Some(-1.0)), "sensor.pixel.read_noise_e");
        assert_eq!(key(|d| d.sensor.dsnu_e = Some(f64::NAN)), "sensor.dsnu_e");
    }

    /// A grey field is rendered neutral and uniform in every architecture.
    #[test]
    fn a_uniform_scene_gives_a_uniform_grey_picture() {
        for architecture in
            [ArchitectureName::Mosaic, ArchitectureName::Prism, ArchitectureName::FieldSequential]
        {
            let c = camera(|d| {
                d.sensor.architecture = architecture;
                d.sensor.adc_bits = 0;
                d.isp.preserve_white = true;
                d.optics.falloff = crate::optics::Falloff::None;
            });
            let setting = Setting { horizontal_fov_deg: 20.0, luminance_cd_m2: 10.0, ..Setting::default() };
            let scene = uniform(64, 64, &setting).unwrap();
            let image = c.optics.image(&scene).unwrap();
            let photo = c.photograph(image, scene.illuminant(), NoiseMode::None, 1).unwrap();
            let rgb = photo.picture.converted(ColorSpace::LinearSrgb).unwrap();
            let (least, most) =
                rgb.planes().data().iter().fold((f32::MAX, 0.0f32), |(a, b), &v| (a.min(v), b.max(v)));
            assert!(least > 0.0 && most / least < 1.001, "{architecture:?}: {least} to {most}");
        }
    }

    #[test]
    fn the_window_lies_on_the_scene_and_begins_with_the_pattern() {
        let c = camera(|d| (d.sensor.rows, d.sensor.cols) = (480, 640));
        let deg = c.field_of_view_deg(240, 1.2).unwrap();
        let setting = Setting { horizontal_fov_deg: deg, ..Setting::default() };
        let w = c.window_on(&macbeth::chart(8, &setting).unwrap()).unwrap();
        assert_eq!((w.rows, w.cols), (160, 240));
        assert_eq!((w.row % 2, w.col % 2), (0, 0));
        assert_eq!((w.row, w.col), (160, 200));
    }
}
