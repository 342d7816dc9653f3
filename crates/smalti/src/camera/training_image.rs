//! The optical image of a training scene.

use super::{Camera, CameraError};
use crate::optics::{OpticalImage, Optics, Padding};
use crate::scene::Scene;

/// The widest margin around a scene in training, relative to its size. With dark surroundings, light that a lens spreads farther than the
/// margins of both sides together comes back in on the other side; docs/l3.md states how little that changes.
const WIDEST_MARGIN: f64 = 1.0 / 16.0;
/// Relative difference between the pitch of photodiodes and two samples that rounding may cause.
const PITCH_TOLERANCE: f64 = 1e-6;

/// How the optical image of a scene is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ImageSampling {
    /// By means of two by two samples of the scene.
    Halved,
    /// By the samples of the scene.
    Whole,
}

impl ImageSampling {
    /// All of them.
    pub(crate) const ALL: [Self; 2] = [Self::Halved, Self::Whole];
}

impl Camera {
    /// The sampling of a training scene for this camera: halved if every photodiode covers two by two samples, and all of them together
    /// cover all samples. They then collect the same light from the means.
    pub(crate) fn training_sampling(&self, scene: &Scene) -> Result<ImageSampling, CameraError> {
        let (camera, radiance) = (self.with_scene_size(scene)?, scene.radiance());
        let sensor = camera.sensor.unbinned();
        let geometry = self.optics.geometry(scene.distance_m())?;
        let spacing_m = geometry.sample_spacing_m(scene.horizontal_fov_deg(), radiance.cols());
        let is_twice = (sensor.pixel.pitch_m / (2.0 * spacing_m) - 1.0).abs() < PITCH_TOLERANCE;
        let covers_all = [2 * sensor.rows, 2 * sensor.cols] == [radiance.rows(), radiance.cols()];
        Ok(if is_twice && covers_all { ImageSampling::Halved } else { ImageSampling::Whole })
    }

    /// The image of a training scene.
    pub(crate) fn training_image(
        &self,
        scene: &Scene,
        sampling: ImageSampling,
    ) -> Result<OpticalImage, CameraError> {
        let optics = self.training_optics();
        Ok(match sampling {
            ImageSampling::Halved => optics.halved_image_of_scene(scene)?,
            ImageSampling::Whole => optics.image_of_scene(scene)?,
        })
    }

    /// The lens of this camera, with at most a narrow margin around a scene.
    pub(super) fn training_optics(&self) -> Optics {
        let padding = &self.optics.padding;
        let padding = Padding { margin: padding.margin.min(WIDEST_MARGIN), ..*padding };
        Optics { padding, ..self.optics.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::scene::{Setting, catalog};
    use crate::sensor::{AutoExposure, Binning, BinningMode, Cfa, ElectronRates, Exposure, Mosaic};
    use crate::spectrum::WavelengthGrid;

    fn camera(change: impl Fn(&mut Camera)) -> Camera {
        let mut camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        change(&mut camera);
        camera
    }

    /// A scene before a camera, `samples` of it as wide as a pixel.
    fn scene(camera: &Camera, spec: &str, samples: f64) -> Scene {
        let setting = Setting { grid: camera.grid(), ..Setting::default() };
        let scene = catalog::build_natural(spec, &setting).unwrap();
        let px = scene.radiance().cols() as f64 / samples;
        let wide = camera.with_size(1, px.round() as usize);
        let fov_deg = wide.field_of_view_deg(px.round() as usize, scene.distance_m()).unwrap();
        scene.with_fov(fov_deg).unwrap()
    }

    const LEAVES: &str = "dead-leaves?rows=64&cols=80&least=2&largest=20";

    /// Photodiodes that cover two by two samples collect the same light from their means, also with part of their area and with crosstalk.
    #[test]
    fn photodiodes_collect_the_same_light_from_means() {
        let crosstalk = [[0.0, 0.02, 0.0], [0.02, 0.92, 0.02], [0.0, 0.02, 0.0]];
        for (fill_factor, crosstalk) in [(1.0, None), (0.4, None), (0.4, Some(crosstalk))] {
            let camera = camera(|c| {
                (c.sensor.pixel.fill_factor, c.sensor.crosstalk) = (fill_factor, crosstalk);
            });
            let scene = scene(&camera, LEAVES, 2.0);
            assert_eq!(camera.training_sampling(&scene).unwrap(), ImageSampling::Halved);
            let sensor = camera.with_scene_size(&scene).unwrap().sensor;
            let light = |sampling| {
                let image = camera.training_image(&scene, sampling).unwrap();
                let rates = ElectronRates::new(&sensor, &image).unwrap();
                let brightest = AutoExposure::SaturatedShare { share: 0.0 };
                let time_s = brightest.rate(&sensor, &image).unwrap().recip() * 100.0;
                sensor.expected_volts((&rates, 1.0), &Exposure::new(time_s)).unwrap().into_data()
            };
            let [halved, whole] = ImageSampling::ALL.map(light);
            let largest = whole.iter().fold(0.0f32, |largest, v| largest.max(*v));
            assert!(largest > 0.0 && halved.len() == 32 * 40);
            for (halved, whole) in halved.iter().zip(&whole) {
                assert!((halved - whole).abs() < 1e-5 * largest, "{halved} and {whole}");
            }
        }
    }

    #[test]
    fn other_photodiodes_need_all_samples() {
        let plain = camera(|_| ());
        let binned = camera(|c| c.sensor.binning = Some(Binning { side: 2, mode: BinningMode::Digital }));
        let tile = |c: &mut Camera| {
            let cells = (0..25).map(|i| i % 3).collect();
            let mosaic = Mosaic::new(5, 5, cells).unwrap();
            c.sensor.cfa = Cfa::new("fives", mosaic, c.sensor.cfa.channels().to_vec()).unwrap();
        };
        for (camera, spec, samples) in [
            (&binned, LEAVES, 2.0),
            (&camera(tile), "dead-leaves?rows=64&cols=84&least=2&largest=20", 2.0),
            (&plain, "dead-leaves?rows=65&cols=80&least=2&largest=20", 2.0),
            (&plain, LEAVES, 4.0),
            (&plain, LEAVES, 1.0),
        ] {
            let scene = scene(camera, spec, samples);
            assert_eq!(camera.training_sampling(&scene).unwrap(), ImageSampling::Whole, "{spec}, {samples}");
        }
    }
}
