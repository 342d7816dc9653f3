//! Figures and curves of a design, without a picture.

use std::collections::BTreeMap;

use serde::Serialize;
use smalti::camera::{ArrayFigures, Camera, CameraError, ColorimetricObserver};
use smalti::color::{ColorSpace, Image};
use smalti::design::light::LightStatistics;
use smalti::design::live::live_conditions;
use smalti::design::screen::{ExpectedError, FigureWeights, Figures, Screen};
use smalti::design::search::{FilterSpace, Pigments, SampledSpace};
use smalti::numeric::Planes;
use smalti::sensor::Filter;
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

use super::EngineError;
use super::warnings::{self, Warning};

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub(super) luminances_cd_m2: &'a [f64],
    pub(super) derivatives: bool,
}

/// Expected figures at a luminance.
#[derive(Debug, Serialize)]
pub(super) struct Expected {
    luminance_cd_m2: f64,
    cpsnr_db: f64,
    detail_db: f64,
    delta_e_2000: f64,
    scielab: f64,
    time_s: f64,
}

/// Expected figures with their luminances.
pub(super) fn expected(all: &[ExpectedError], luminances_cd_m2: &[f64]) -> Vec<Expected> {
    let of = |(e, luminance_cd_m2): (&ExpectedError, &f64)| Expected {
        luminance_cd_m2: *luminance_cd_m2,
        cpsnr_db: e.cpsnr_db,
        detail_db: e.detail_db,
        delta_e_2000: e.delta_e_2000,
        scielab: e.scielab,
        time_s: e.time_s,
    };
    all.iter().zip(luminances_cd_m2).map(of).collect()
}

type Derivative = BTreeMap<String, Vec<f64>>;

#[derive(Debug, Serialize)]
pub(super) struct Derivatives {
    cpsnr_db: Derivative,
    delta_e_2000: Derivative,
}

#[derive(Debug, Serialize)]
pub(super) struct Scores {
    expected: Vec<Expected>,
    array: ArrayFigures,
    wavelengths_nm: Vec<f64>,
    derivatives: Option<Derivatives>,
    pub(super) warnings: Vec<Warning>,
}

pub(super) fn scores(
    camera: &Camera,
    statistics: Option<&LightStatistics>,
    observer: &ColorimetricObserver,
    wanted: Wanted<'_>,
) -> Result<Scores, EngineError> {
    let (expected, derivatives) = match statistics {
        None => (Vec::new(), None),
        Some(statistics) => of_light(camera, statistics, wanted)?,
    };
    Ok(Scores {
        expected,
        array: camera.array_figures(observer)?,
        wavelengths_nm: camera.grid().wavelengths_nm().collect(),
        derivatives,
        warnings: warnings::of_camera(camera)?,
    })
}

/// What is expected of a camera, and the derivatives if they are asked for.
fn of_light(
    camera: &Camera,
    statistics: &LightStatistics,
    wanted: Wanted<'_>,
) -> Result<(Vec<Expected>, Option<Derivatives>), EngineError> {
    let Wanted { luminances_cd_m2, derivatives } = wanted;
    let screen = Screen::new(camera, statistics, &live_conditions(camera, luminances_cd_m2))?;
    let cfa = &camera.sensor.cfa;
    let found = screen.expected(cfa)?;
    let of = |figure: FigureWeights| {
        let transmittances: Vec<Spectrum> = cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
        let responses = screen.responses(&transmittances);
        let by_response =
            screen.differentiable(cfa.mosaic(), &responses, Figures::Color).by_response(&[figure]);
        let by_wavelength = |by_component: &Vec<f64>| {
            let mut sums = vec![0.0; camera.grid().len()];
            for (g, spectrum) in by_component.iter().zip(screen.response_spectra()) {
                sums.iter_mut().zip(spectrum.values()).for_each(|(sum, v)| *sum += g * v);
            }
            sums
        };
        cfa.channels().iter().map(|c| c.name.clone()).zip(by_response.iter().map(by_wavelength)).collect()
    };
    let none = FigureWeights::default();
    let derivatives = derivatives.then(|| Derivatives {
        cpsnr_db: of(FigureWeights { cpsnr_db: 1.0, ..none }),
        delta_e_2000: of(FigureWeights { delta_e_2000: 1.0, ..none }),
    });
    Ok((expected(&found, luminances_cd_m2), derivatives))
}

/// A pigment in a filter, and its thickness relative to the built-in filter.
#[derive(Debug, Serialize)]
pub(super) struct Layer {
    name: String,
    thickness: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Channel {
    letter: String,
    transmittance: Vec<f64>,
    quantum_efficiency: Vec<f64>,
    color: String,
    /// The pigments that make a filter in samples, `None` if none do.
    pigments: Option<Vec<Layer>>,
}

#[derive(Debug, Serialize)]
pub(super) struct ObserverCurves {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct Curves {
    wavelengths_nm: Vec<f64>,
    channels: Vec<Channel>,
    sensor_quantum_efficiency: Vec<f64>,
    lens_transmittance: Vec<f64>,
    light: Vec<f64>,
    observer: ObserverCurves,
    mosaic: Vec<Vec<String>>,
}

pub(super) fn curves(camera: &Camera, illuminant: &Illuminant) -> Result<Curves, CameraError> {
    let stated = &camera.description().sensor.cfa.filters;
    let is_sampled = |letter: &str| matches!(stated.get(letter), Some(Filter::Samples { .. }));
    let (grid, cfa) = (camera.grid(), &camera.sensor.cfa);
    let pigments = PigmentsOn::new(grid);
    let light = illuminant.photons(grid)?;
    let lens = camera.optics.transmittance_on(grid)?;
    let channel = |(channel, response): (&smalti::sensor::Channel, Spectrum)| {
        Ok::<_, CameraError>(Channel {
            letter: channel.name.clone(),
            transmittance: channel.transmittance.values().to_vec(),
            quantum_efficiency: response.times(&lens)?.values().to_vec(),
            color: color(&channel.transmittance, &light)?,
            pigments: match is_sampled(&channel.name) {
                true => pigments.of(&channel.transmittance),
                false => None,
            },
        })
    };
    let responses = camera.sensor.spectral_responsivity_on(grid)?;
    let weights = Observer::Cie1931.matching_functions(grid)?;
    let relative = |s: &Spectrum| {
        let most = s.max().max(f64::MIN_POSITIVE);
        s.values().iter().map(|v| v / most).collect::<Vec<f64>>()
    };
    let [x, y, z] = weights.map(|w| w.values().to_vec());
    let mosaic = cfa.mosaic();
    let name = |row, col| {
        cfa.channels().get(mosaic.channel_at(row, col)).map_or_else(String::new, |c| c.name.clone())
    };
    Ok(Curves {
        wavelengths_nm: grid.wavelengths_nm().collect(),
        channels: cfa.channels().iter().zip(responses).map(channel).collect::<Result<_, _>>()?,
        sensor_quantum_efficiency: camera.sensor.bare_responsivity_on(grid)?.values().to_vec(),
        lens_transmittance: lens.values().to_vec(),
        light: relative(&light),
        observer: ObserverCurves { x, y, z },
        mosaic: (0..mosaic.rows())
            .map(|row| (0..mosaic.cols()).map(|col| name(row, col)).collect())
            .collect(),
    })
}

/// The pigments of searches at some wavelengths.
struct PigmentsOn {
    names: Vec<String>,
    /// `None` at wavelengths where the pigments are not known.
    sampled: Option<SampledSpace>,
}

impl PigmentsOn {
    fn new(grid: WavelengthGrid) -> Self {
        let family = Pigments::default();
        let name = |filter: &Filter| match filter {
            Filter::Builtin(name) => Some(name.clone()),
            _ => None,
        };
        let names: Vec<String> = family.library.iter().filter_map(name).collect();
        // Filters of other searches may have more pigments than those of the page.
        let any = FilterSpace::Pigments(Pigments { max_pigments: names.len(), ..family });
        Self { names, sampled: any.sampled(grid).ok() }
    }

    /// The pigments that make a filter; `None` if none do.
    fn of(&self, transmittance: &Spectrum) -> Option<Vec<Layer>> {
        let thicknesses = self.sampled.as_ref()?.layers(transmittance)?;
        let layer = |(name, thickness): (&String, f64)| Layer { name: name.clone(), thickness };
        Some(self.names.iter().zip(thicknesses).filter(|(_, t)| *t > 0.0).map(layer).collect())
    }
}

/// A filter before a light as the standard observer sees it, beside white: sRGB as `#rrggbb`.
fn color(transmittance: &Spectrum, light: &Spectrum) -> Result<String, CameraError> {
    let white = Observer::Cie1931.white(light)?;
    let white_y = Observer::Cie1931.xyz_from_photons(light)?[1];
    let xyz = Observer::Cie1931.xyz_from_photons(&transmittance.times(light)?)?;
    let values = xyz.iter().map(|v| (v / white_y) as f32).collect();
    let planes = Planes::new(1, 1, 3, values).map_err(smalti::sensor::SensorError::from)?;
    let rgb = Image::new(ColorSpace::Xyz, planes)?.shown(Some(white), 1.0)?.rgb8();
    Ok(rgb.iter().fold("#".to_owned(), |text, byte| format!("{text}{byte:02x}")))
}
