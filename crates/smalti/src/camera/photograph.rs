//! The camera: its parts, resolved from a description, and the way from a scene to a picture.

use super::CameraError;
use super::description::{
    CameraDescription, ColorCorrectionName, DemosaicName, OutputName, WhiteBalanceName,
};
use super::resolve::{self, ExposureTime};
use crate::color::{ColorSpace, Image};
use crate::isp::{Classic, ColorConstraint, ColorFit, Demosaic, Isp, IspError, WhiteBalance};
use crate::numeric::least_squares::{Matrix, lstsq};
use crate::optics::{OpticalImage, Optics};
use crate::scene::Scene;
use crate::sensor::{AutoExposure, Cfa, Exposure, NoiseMode, RawImage, Sensor, SensorError, Window};
use crate::spectrum::{Observer, Spectrum, WavelengthGrid, reflectance};

/// A camera, ready to take pictures of scenes on one wavelength grid.
#[derive(Debug, Clone)]
pub struct Camera {
    description: CameraDescription,
    grid: WavelengthGrid,
    /// The lens.
    pub optics: Optics,
    /// The image sensor.
    pub sensor: Sensor,
    exposure_time: ExposureTime,
    analog_gain: f64,
    analog_offset_v: f64,
    color_noise: f64,
}

/// One picture with all that led to it.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// Irradiance on the sensor.
    pub optical_image: OpticalImage,
    /// The exposure, stated or found.
    pub exposure: Exposure,
    /// The raw file.
    pub raw: RawImage,
    /// The picture in XYZ, white-balanced as described.
    pub picture: Image,
}

impl Camera {
    /// A camera from its description, its curves sampled on a wavelength grid.
    ///
    /// # Errors
    /// On the first key that is impossible: its name, its value, what was expected.
    pub fn new(description: CameraDescription, grid: WavelengthGrid) -> Result<Self, CameraError> {
        let (exposure_time, analog_gain, analog_offset_v) = resolve::exposure(&description)?;
        Ok(Self {
            optics: resolve::optics(&description.optics, grid)?,
            sensor: resolve::sensor(&description.sensor, grid)?,
            color_noise: resolve::color_noise(&description)?,
            exposure_time,
            analog_gain,
            analog_offset_v,
            description,
            grid,
        })
    }

    /// What the camera was made from.
    #[must_use]
    pub fn description(&self) -> &CameraDescription {
        &self.description
    }

    /// The wavelengths of its curves.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// The same camera with another number of pixels, all of them read.
    #[must_use]
    pub fn with_size(&self, rows: usize, cols: usize) -> Self {
        let sensor = Sensor { rows, cols, window: None, ..self.sensor.clone() };
        Self { sensor, ..self.clone() }
    }

    /// The same camera with another colour filter array. Its description is still that of the first.
    #[must_use]
    pub fn with_cfa(&self, cfa: Cfa) -> Self {
        let sensor = Sensor { cfa, ..self.sensor.clone() };
        Self { sensor, ..self.clone() }
    }

    /// Field of view, degrees, that `cols` pixels span of a scene at a distance.
    ///
    /// # Errors
    /// When the scene is not beyond the focal length.
    pub fn field_of_view_deg(&self, cols: usize, distance_m: f64) -> Result<f64, CameraError> {
        let width_m = cols as f64 * self.sensor.pixel.pitch_m;
        let geometry = self.optics.geometry(distance_m)?;
        Ok(2.0 * (width_m / 2.0 / geometry.image_distance_m()).atan().to_degrees())
    }

    /// A scene, as wide as needed to lie on the sensor whole; `is_file` says that it has no more detail than its samples, so that it is
    /// not spread over more pixels than those.
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

    /// The pixels that a scene covers, in the middle of the sensor and in whole tiles of the mosaic, so that the
    /// pattern begins as on the whole sensor.
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
            // A hundredth of a pixel forgives rounding in a field of view that was computed from the pixels.
            let first = (middle - covered / 2.0 - 0.01).ceil().max(0.0) as usize;
            let end = ((middle + covered / 2.0 + 0.01).floor() as usize).min(pixels);
            let first = first.next_multiple_of(tile);
            // A scene smaller than a tile is read with what is beside it.
            if first < end { (first, end - first) } else { (0, pixels) }
        };
        let (row, rows) = extent(radiance.rows(), self.sensor.rows, mosaic.rows());
        let (col, cols) = extent(radiance.cols(), self.sensor.cols, mosaic.cols());
        Ok(Window { row, col, rows, cols })
    }

    /// The exposure without its time, which is 1 s.
    #[must_use]
    pub fn gain_and_offset(&self) -> Exposure {
        Exposure { time_s: 1.0, analog_gain: self.analog_gain, analog_offset_v: self.analog_offset_v }
    }

    /// How the exposure time is found.
    #[must_use]
    pub fn exposure_time(&self) -> ExposureTime {
        self.exposure_time
    }

    /// The exposure for an optical image: the stated time, or the one that the rule finds.
    ///
    /// # Errors
    /// When there is no light to find a time by.
    pub fn exposure(&self, image: &OpticalImage) -> Result<Exposure, CameraError> {
        self.exposure_by(|rule, exposure| rule.exposure_time(&self.sensor, image, exposure))
    }

    /// The exposure of the stated time, or of the one that is found with the rule.
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

    /// The irradiance that the exposure rule looks at in an optical image; `None` where the time is stated or the rule looks at
    /// the whole image. It is the same for any colour filter array.
    ///
    /// # Errors
    /// When the rule is impossible or the sensor sees nothing of the image.
    pub fn metered(&self, image: &OpticalImage) -> Result<Option<Spectrum>, CameraError> {
        match self.exposure_time {
            ExposureTime::Fixed(_) => Ok(None),
            ExposureTime::Auto(rule) => Ok(rule.metered(&self.sensor, image)?),
        }
    }

    /// The exposure for an optical image of which the [metered](Self::metered) irradiance is known.
    ///
    /// # Errors
    /// When there is no light to find a time by.
    pub fn exposure_metered(&self, irradiance: &Spectrum) -> Result<Exposure, CameraError> {
        self.exposure_by(|rule, exposure| rule.time_for_metered(&self.sensor, irradiance, exposure))
    }

    /// The processing for scenes under a light (photons): demosaicking, white balance, colour matrix.
    ///
    /// # Errors
    /// When the colour matrix cannot be computed.
    pub fn isp(&self, light: &Spectrum, white_balance: WhiteBalance) -> Result<Classic, CameraError> {
        self.isp_fitted_to(&self.color_fit(light)?, white_balance)
    }

    /// What the camera's colour matrix is fitted to under a light (photons).
    ///
    /// # Errors
    /// When the light is dark.
    pub fn color_fit(&self, light: &Spectrum) -> Result<ColorFit, CameraError> {
        Ok(ColorFit::new(&self.surfaces()?, light, Observer::Cie1931)?)
    }

    /// As [`Camera::isp`], where what the colour matrix is fitted to is known.
    ///
    /// # Errors
    /// When the colour matrix cannot be computed.
    pub fn isp_fitted_to(&self, fit: &ColorFit, white_balance: WhiteBalance) -> Result<Classic, CameraError> {
        let isp = &self.description.isp;
        let constraint =
            if isp.preserve_white { ColorConstraint::PreserveWhite } else { ColorConstraint::None };
        let matrix = fit.matrix(&self.responsivities()?, constraint, self.color_noise)?;
        let demosaic = match isp.demosaic {
            DemosaicName::Bilinear => Demosaic::Bilinear,
            DemosaicName::Malvar2004 => Demosaic::Malvar2004,
            DemosaicName::Adaptive => Demosaic::Adaptive,
        };
        Ok(Classic { demosaic, white_balance, ..Classic::new(matrix) })
    }

    /// Camera values from XYZ under a light (photons), a row per channel, as raw files state it: least squares over the
    /// surfaces that the colour matrix is fitted to.
    ///
    /// # Errors
    /// When the solver fails.
    pub fn camera_from_xyz(&self, light: &Spectrum) -> Result<Vec<[f64; 3]>, CameraError> {
        let responsivities = self.responsivities()?;
        let observer = Observer::Cie1931.photon_weights(self.grid)?;
        let white = |s: &Spectrum| Ok::<f64, CameraError>(s.times(light)?.integral());
        let camera_white = responsivities.iter().map(white).collect::<Result<Vec<_>, _>>()?;
        let camera_scale = camera_white.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let observer_scale = white(&observer[1])?;
        let (mut xyz, mut camera) = (Vec::new(), Vec::new());
        let surfaces = self.surfaces()?;
        for surface in &surfaces {
            let lit = surface.times(light)?;
            for (list, curves, scale) in
                [(&mut xyz, &observer[..], observer_scale), (&mut camera, &responsivities[..], camera_scale)]
            {
                for curve in curves {
                    list.push(curve.times(&lit)?.integral() / scale);
                }
            }
        }
        let (rows, channels) = (surfaces.len(), responsivities.len());
        let solved = lstsq(Matrix::new(rows, 3, &xyz), Matrix::new(rows, channels, &camera))
            .map_err(IspError::from)?;
        let entry = |row: usize, channel: usize| solved.get(row * channels + channel).copied().unwrap_or(0.0);
        Ok((0..channels).map(|c| std::array::from_fn(|row| entry(row, c))).collect())
    }

    /// The reflectances that the colour matrix is fitted to.
    pub(crate) fn surfaces(&self) -> Result<Vec<Spectrum>, CameraError> {
        let named = match self.description.isp.color_correction {
            ColorCorrectionName::Macbeth => reflectance::colorchecker(self.grid)?,
            ColorCorrectionName::Natural => reflectance::natural(self.grid)?,
        };
        Ok(named.into_iter().map(|(_, s)| s).collect())
    }

    /// The colour space that pictures are written in.
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
        match self.description.isp.white_balance {
            WhiteBalanceName::None => WhiteBalance::None,
            WhiteBalanceName::GrayWorld => WhiteBalance::GrayWorld,
            WhiteBalanceName::Illuminant => WhiteBalance::Illuminant,
        }
    }

    /// Electrons per photon that enters the lens, per channel: lens, filters, quantum efficiency.
    pub(crate) fn responsivities(&self) -> Result<Vec<Spectrum>, CameraError> {
        let lens = self.optics.transmittance_on(self.grid)?;
        let channels = self.sensor.spectral_responsivity_on(self.grid)?;
        channels.iter().map(|c| Ok(c.times(&lens)?)).collect()
    }

    /// Takes a picture of what the lens throws on the sensor, under a light (photons).
    ///
    /// # Errors
    /// When a stage refuses; the message says which.
    pub fn photograph(
        &self,
        optical_image: OpticalImage,
        light: &Spectrum,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<Photograph, CameraError> {
        let exposure = self.exposure(&optical_image)?;
        let raw = self.sensor.capture(&optical_image, &exposure, noise, seed)?;
        let picture = self.isp(light, self.white_balance())?.render(&raw)?;
        Ok(Photograph { optical_image, exposure, raw, picture })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::description::{ArchitectureName, PatternDescription};
    use crate::scene::{Setting, macbeth, uniform};

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

    /// A grey field comes out neutral and even, in every architecture.
    #[test]
    fn a_uniform_scene_gives_a_uniform_grey_picture() {
        for architecture in
            [ArchitectureName::Mosaic, ArchitectureName::Prism, ArchitectureName::FieldSequential]
        {
            let c = camera(|d| {
                d.sensor.architecture = architecture;
                d.sensor.adc_bits = 0;
                d.isp.preserve_white = true;
                d.optics.falloff = crate::camera::description::FalloffName::None;
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
