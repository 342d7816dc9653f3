//! Built-in scenes that come from files: those that a spectral path tracer rendered from measured reflectances and lamps, in
//! their own light, and photographs whose pixels were given measured reflectances, in daylight.
//!
//! `tools/scenes/README.md` states sources, licences and errors.

mod components;
mod photograph;
pub(crate) mod training;

use std::path::Path;

use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Illuminant, Spectrum, WavelengthGrid};

use self::photograph::{decode, reflectances};
pub use self::training::{BuiltInTrainingScenes, TrainingSet};
use crate::IoError;
use crate::error::At;
use crate::scene_file::Upsampling;

/// A scene from a built-in file.
#[derive(Debug, Clone, Copy)]
pub struct StoredScene {
    /// Its name.
    pub name: &'static str,
    /// Its content and light, in one line.
    pub summary: &'static str,
    content: Content,
}

#[derive(Debug, Clone, Copy)]
enum Content {
    /// Components of spectral radiance.
    Rendered(&'static [u8]),
    /// A photograph as JPEG.
    Photograph(&'static [u8]),
}

macro_rules! stored {
    ($($name:literal: $kind:ident($content:expr), $summary:literal;)*) => {
        [$(StoredScene {
            name: $name,
            summary: $summary,
            content: Content::$kind($content),
        }),*]
    };
}

static SCENES: [StoredScene; 14] = stored! {
    "natural-portrait": Rendered(smalti_scenes::PORTRAIT), "Path traced: a head with measured skin, hair and fabrics under LED and tungsten lamps.";
    "natural-foliage": Rendered(smalti_scenes::FOLIAGE), "Path traced: a garden with leaves, grass, flowers and brick under sun and sky.";
    "natural-table": Rendered(smalti_scenes::TABLE), "Path traced: fabrics and food on a table under LED light.";
    "natural-street": Rendered(smalti_scenes::STREET), "Path traced: a street at night with sodium, LED, fluorescent and neon lamps.";
    "natural-shelf": Rendered(smalti_scenes::SHELF), "Path traced: a shop shelf with packaging and fine print under LED panels.";
    "natural-interior": Rendered(smalti_scenes::INTERIOR), "Path traced: a living room with daylight through a window and a tungsten lamp.";
    "photo-astronaut": Photograph(include_bytes!("../../scenes/photo-astronaut.jpg")), "Photograph with measured reflectances: an astronaut in an orange suit before a flag (NASA).";
    "photo-brushes": Photograph(include_bytes!("../../scenes/photo-brushes.jpg")), "Photograph with measured reflectances: paint brushes of saturated colours (Trevor \"Freespace\").";
    "photo-dahlia": Photograph(include_bytes!("../../scenes/photo-dahlia.jpg")), "Photograph with measured reflectances: a dahlia before dark foliage (vultilion).";
    "photo-fig": Photograph(include_bytes!("../../scenes/photo-fig.jpg")), "Photograph with measured reflectances: a fig in a red bowl on concrete (Trevor \"Freespace\").";
    "photo-pagoda": Photograph(include_bytes!("../../scenes/photo-pagoda.jpg")), "Photograph with measured reflectances: a painted pagoda by a lake (danielbuechele).";
    "photo-raccoon": Photograph(include_bytes!("../../scenes/photo-raccoon.jpg")), "Photograph with measured reflectances: a raccoon among palm leaves (public-domain-image.com).";
    "photo-spices": Photograph(include_bytes!("../../scenes/photo-spices.jpg")), "Photograph with measured reflectances: spices and seeds on a market (Clyde Robinson).";
    "photo-stream": Photograph(include_bytes!("../../scenes/photo-stream.jpg")), "Photograph with measured reflectances: a stream between rocks in a wood (Aitzol Berasategi).";
};

/// The scenes. The rendered ones have 576 × 768 samples, photographs at most as many; all have 31 bands from 400 to 700 nm.
#[must_use]
pub fn names() -> &'static [StoredScene] {
    &SCENES
}

/// The scene of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static StoredScene> {
    SCENES.iter().find(|scene| scene.name == name)
}

impl StoredScene {
    /// Whether one light illuminates the whole scene, so that another can replace it. The lamps of a rendered scene cannot be
    /// replaced: each has its own spectrum, and surfaces reflect light on others.
    #[must_use]
    pub fn has_one_light(&self) -> bool {
        matches!(self.content, Content::Photograph(_))
    }

    /// The light of a scene whose lamps cannot be replaced: radiance of a white diffuser, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹; `None` for one
    /// that can be relit.
    ///
    /// # Errors
    /// When the stored file is damaged.
    pub(crate) fn own_light(&self) -> Result<Option<Spectrum>, IoError> {
        match self.content {
            Content::Rendered(bytes) => components::light(self.name, bytes).map(Some),
            Content::Photograph(_) => Ok(None),
        }
    }

    /// The scene at the distance and with the field of view of [`Setting::default`]: a rendered one in its own light, a photograph
    /// in daylight (D65) at the mean luminance of [`Setting::default`].
    ///
    /// # Errors
    /// When the stored file is damaged.
    pub fn load(&self) -> Result<Scene, IoError> {
        match self.content {
            Content::Rendered(bytes) => components::decode(self.name, bytes)?
                .into_scene(&Setting { illuminant: Illuminant::D65, ..Setting::default() }),
            Content::Photograph(bytes) => of_photograph(self.name, bytes),
        }
    }

    /// The file of a photograph.
    pub(crate) fn photograph(&self) -> Option<&'static [u8]> {
        match self.content {
            Content::Photograph(bytes) => Some(bytes),
            Content::Rendered(_) => None,
        }
    }
}

/// A photograph, a JPEG file, whose pixels get measured reflectances, in daylight (D65) at the mean luminance of [`Setting::default`].
///
/// # Errors
/// When the file is damaged.
pub(crate) fn of_photograph(name: &str, bytes: &[u8]) -> Result<Scene, IoError> {
    let cube = Upsampling::Measured.spectra(&decode(name, bytes)?, WavelengthGrid::VISIBLE);
    let file = reflectances(name, cube.at(Path::new(name))?);
    file.into_scene(&Setting { illuminant: Illuminant::D65, ..Setting::default() })
}

#[cfg(test)]
mod tests {
    use smalti::spectrum::units::photons_per_joule;

    use super::*;

    /// Means over the picture in the bands at 400, 550 and 700 nm, and the radiance at row 301, column 402, 520 nm, in
    /// W m⁻² sr⁻¹ nm⁻¹, by the decoder of `tools/scenes/codec.py`.
    const DECODED: [(&str, [f64; 3], f64); 6] = [
        ("natural-portrait", [6.995_186_379e-06, 4.235_402_118e-04, 2.746_194_033e-04], 3.475_745_325e-04),
        ("natural-foliage", [4.673_430_263e-02, 4.752_030_455e-02, 3.117_817_283e-02], 3.252_157_569e-02),
        ("natural-table", [1.108_380_407e-05, 7.323_748_271e-04, 4.611_047_376e-04], 1.382_187_183e-04),
        ("natural-street", [2.394_059_463e-05, 9.345_183_909e-05, 1.622_502_862e-04], 7.288_307_415e-07),
        ("natural-shelf", [3.125_815_234e-06, 9.018_162_682e-04, 2.638_284_952e-04], 2.121_420_839e-04),
        ("natural-interior", [1.533_011_689e-03, 3.395_632_382e-03, 3.880_847_442e-03], 1.364_395_022e-03),
    ];

    /// The reflectances of the photographs have their colours under D65, but for a few pixels at the border of sRGB.
    #[test]
    fn photographs_keep_their_colours() {
        let repaint = smalti::color::repaint::Repaint::new(
            WavelengthGrid::VISIBLE,
            smalti::spectrum::Observer::Cie1931,
        );
        let repaint = repaint.unwrap();
        for scene in names() {
            let Content::Photograph(bytes) = scene.content else { continue };
            let image = decode(scene.name, bytes).unwrap();
            let (pixels, missed) = (image.rows() * image.cols(), repaint.repainted(&image).unwrap().missed);
            println!("{}: {missed} of {pixels} pixels", scene.name);
            assert!(missed * 100 < pixels, "{}: {missed} of {pixels}", scene.name);
        }
    }

    #[test]
    fn scenes_are_those_of_the_encoder() {
        for (scene, (name, means, one)) in names().iter().filter(|s| !s.has_one_light()).zip(DECODED) {
            assert_eq!(scene.name, name);
            let decoded = find(name).unwrap().load().unwrap();
            let cube = decoded.radiance();
            assert_eq!((cube.rows(), cube.cols(), cube.grid()), (576, 768, WavelengthGrid::VISIBLE));
            let joule = |band: usize| 1.0 / photons_per_joule(400.0 + 10.0 * band as f64);
            for (band, expected) in [0, 15, 30].into_iter().zip(means) {
                let plane = cube.planes().plane(band).unwrap();
                let mean =
                    plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64 * joule(band);
                assert!((mean / expected - 1.0).abs() < 1e-6, "{name}, band {band}: {mean}");
            }
            let found = f64::from(cube.planes().plane(12).unwrap()[301 * 768 + 402]) * joule(12);
            assert!((found / one - 1.0).abs() < 1e-6, "{name}: {found}");
            assert!(decoded.mean_luminance_cd_m2().unwrap() > 1.0);
        }
    }

    /// At most 1.5 MB for a scene, and 8 MB for the rendered test scenes together.
    #[test]
    fn stored_scenes_are_small() {
        let mut rendered = 0;
        for scene in names() {
            let (Content::Rendered(bytes) | Content::Photograph(bytes)) = scene.content;
            assert!(bytes.len() <= 1_500_000, "{}: {} bytes", scene.name, bytes.len());
            rendered += if scene.has_one_light() { 0 } else { bytes.len() };
        }
        assert!(rendered <= 8_000_000, "{rendered} bytes");
    }

    /// The ratio of each sample to the light of its scene: the reflectance where this light alone illuminates it.
    fn ratios(scene: &StoredScene) -> Vec<Vec<f64>> {
        let loaded = scene.load().unwrap();
        let planes = loaded.radiance().planes();
        let ratio = |(band, light): (usize, &f64)| {
            planes.plane(band).unwrap().iter().map(|v| f64::from(*v) / light).collect()
        };
        loaded.illuminant().values().iter().enumerate().map(ratio).collect()
    }

    /// The reflectances of photographs are those of surfaces: between 0 and 1 in every band.
    #[test]
    fn photographs_have_reflectances() {
        for scene in names().iter().filter(|s| s.has_one_light()) {
            let ratios = ratios(scene);
            let all = || ratios.iter().flatten().copied();
            let (least, largest) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
            println!("{}: {least:.4} to {largest:.4}", scene.name);
            assert!(least >= 0.0 && largest <= 1.0 + 1e-6, "{}: {least} to {largest}", scene.name);
        }
    }

    /// Sum of the second differences of a spectrum over that of its values: 0.01 to 0.04 for smooth spectra, more for lines and bands.
    fn roughness(spectrum: &[f64]) -> f64 {
        let bends: f64 = spectrum.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).sum();
        bends / spectrum.iter().sum::<f64>()
    }

    /// Rendered scenes have deep shade and highlights: the brightest and the darkest hundredth of their samples differ by a factor of 100
    /// and more. Without the light, what remains of the mean spectrum is smooth like a reflectance. The street is left out there,
    /// because lamps of several kinds illuminate it.
    #[test]
    fn rendered_scenes_have_plausible_ranges_and_spectra() {
        for scene in names().iter().filter(|s| !s.has_one_light()) {
            let ratios = ratios(scene);
            let mut green = ratios[15].clone();
            green.sort_by(f64::total_cmp);
            let at = |share: f64| green[((green.len() - 1) as f64 * share) as usize];
            let [shade, bright] = [0.01, 0.99].map(at);
            assert!(
                shade > 0.0 && bright > 100.0 * shade && bright < 1.1,
                "{}: {shade} {bright}",
                scene.name
            );
            let light = scene.load().unwrap().illuminant().values().to_vec();
            let brightest = light.iter().copied().fold(0.0, f64::max);
            // Without light there is no reflectance.
            let lit: Vec<usize> = (0..light.len()).filter(|band| light[*band] > 0.05 * brightest).collect();
            let mean = |band: &usize| ratios[*band].iter().sum::<f64>() / green.len() as f64;
            let rough = roughness(&lit.iter().map(mean).collect::<Vec<_>>());
            assert!(rough < 0.04 || scene.name == "natural-street", "{}: {rough}", scene.name);
        }
    }

    /// Cards under an LED lamp, rendered by Mitsuba and stored by `tools/scenes/check.py`, have their measured reflectances to 2 %.
    #[test]
    fn rendered_cards_have_their_reflectances() {
        let surfaces = smalti::spectrum::reflectance::surfaces(WavelengthGrid::VISIBLE).unwrap();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cards");
        for card in ["TCS 5", "TCS 32", "TCS 76", "Skin 36", "Cotton Fabric GDS437 White"] {
            let file = folder.join(format!("{}.spc", card.replace(' ', "-").to_lowercase()));
            let file = components::decode(card, &std::fs::read(file).unwrap()).unwrap();
            let scene =
                file.into_scene(&Setting { illuminant: Illuminant::D65, ..Setting::default() }).unwrap();
            let (_, truth) = surfaces.iter().find(|(name, _)| *name == card).unwrap();
            let bands = scene.illuminant().values().iter().zip(truth.values()).enumerate();
            for (band, (light, expected)) in bands {
                let samples = scene.radiance().planes().plane(band).unwrap();
                let mean = samples.iter().map(|v| f64::from(*v)).sum::<f64>() / samples.len() as f64;
                let error = mean / light / expected - 1.0;
                assert!(error.abs() < 0.02, "{card}, band {band}: {error}");
            }
        }
    }

    #[test]
    fn photographs_are_scenes_in_daylight() {
        for scene in names().iter().filter(|s| s.has_one_light()) {
            let loaded = scene.load().unwrap();
            let (rows, cols) = (loaded.radiance().rows(), loaded.radiance().cols());
            assert!(
                rows <= 576 && cols <= 768 && rows * cols >= 400 * 500,
                "{}: {rows} × {cols}",
                scene.name
            );
            assert!((loaded.mean_luminance_cd_m2().unwrap() / 100.0 - 1.0).abs() < 1e-4, "{}", scene.name);
            assert!(scene.summary.starts_with("Photograph"), "{}", scene.name);
        }
    }
}
