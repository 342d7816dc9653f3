//! Gathers the statistics of the light of scenes.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::error::DesignError;
use super::classes::PatchFigures;
use super::{ClassColors, LightClass, LightSettings, LightStatistics, SpectralBasis};
use crate::camera::chart::LUMINANCE;
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraError, ScoreSettings};
use crate::design::patch_products::{AddPatches, PatchSource};
use crate::l3::Moments;
use crate::numeric::dense::dot;
use crate::numeric::products::LANES;
use crate::numeric::simd::dispatch;
use crate::scene::{self, Scene, Setting};
use crate::sensor::PixelSpectra;
use crate::spectrum::{Illuminant, Observer, Spectrum};

/// Patches of a class per partial sum.
const PART_PATCHES: usize = 4096;
/// Size of a batch of patches, in doubles: 128 KiB, beside sums of 350 KiB for patches of 5 × 5 pixels.
const BATCH: usize = 1 << 14;

/// Gathers the light of scenes on the pixels of a camera. Its filters do not matter.
#[derive(Debug, Clone)]
pub struct LightGatherer {
    camera: Camera,
    empty: LightStatistics,
    /// Weights of the light on a pixel whose sums are the coefficients, per cd/m² of the scene.
    analysis: Vec<Vec<f64>>,
    /// Weights of the light on a pixel whose sums are Y, per cd/m² of the scene.
    luminance: Vec<f64>,
}

/// The light of a scene on the pixels, as coefficients.
struct Coefficients {
    rows: usize,
    cols: usize,
    count: usize,
    /// Coefficients of each pixel, pixel after pixel.
    values: Vec<f32>,
    /// Y of each pixel, as the components give it, relative to the mean of the scene.
    y: Vec<f32>,
    /// Σ of the squared Y, and of the squared difference between Y and that of the components.
    energy: [f64; 2],
}

impl LightGatherer {
    /// A gatherer for a lens and pixel under an illuminant. `spectra` are typical light of scenes under it, such as reflectances times
    /// the illuminant, from which the components are made.
    ///
    /// # Errors
    /// When a setting is out of range, or the camera sees no light.
    pub fn new(
        camera: &Camera,
        illuminant: &Illuminant,
        spectra: &[Spectrum],
        settings: &LightSettings,
    ) -> Result<Self, DesignError> {
        settings.validate()?;
        let mut camera = camera.clone();
        // The light before crosstalk, which mixes what filters have passed.
        camera.sensor.crosstalk = None;
        let camera = &camera;
        let grid = camera.grid();
        let basis = SpectralBasis::new(camera, spectra, settings.max_components, settings.max_left_out)?;
        let light = illuminant.photons(grid).map_err(CameraError::from)?;
        let observer = Observer::Cie1931.photon_weights(grid).map_err(CameraError::from)?;
        let before = basis.analysis_behind(camera)?;
        // X, Y, Z of components, and of the light before the lens from that behind it.
        let xyz: Vec<[f64; 3]> = basis
            .components()
            .iter()
            .map(|c| observer.each_ref().map(|o| dot(o.values(), c.values())))
            .collect();
        let lens = camera.optics.transmittance_on(grid).map_err(CameraError::from)?;
        let undone = |(w, t): (&f64, &f64)| if *t >= 1e-4 { w / t } else { 0.0 };
        let luminance: Vec<f64> =
            observer[LUMINANCE].values().iter().zip(lens.values()).map(undone).collect();
        let mut gatherer = Self {
            camera: camera.clone(),
            empty: LightStatistics {
                source: stable_text(&(&camera.optics, &geometry(camera), grid, &light))?,
                white: Observer::Cie1931.white(&light).map_err(CameraError::from)?,
                settings: settings.clone(),
                basis,
                xyz,
                white_coefficients: Vec::new(),
                classes: BTreeMap::new(),
                scenes: 0,
                energy: [0.0; 2],
            },
            analysis: before,
            luminance,
        };
        // A uniform scene of 1 cd/m² gives the scale.
        let setting =
            Setting { illuminant: illuminant.clone(), grid, luminance_cd_m2: 1.0, ..Setting::default() };
        let white = scene::uniform(8, 8, &setting).map_err(CameraError::from)?;
        let small = camera.with_size(1, 1);
        let image = small.optics.image(&white).map_err(CameraError::from)?;
        let pixel = PixelSpectra::new(&small.sensor, &image).map_err(CameraError::from)?;
        // A sample has the light of all its photodiodes, which is the same for each.
        let photodiodes = camera.sensor.photodiodes_per_sample();
        let spectrum =
            pixel.spectrum(0, 0).ok_or(CameraError::Sensor(crate::sensor::SensorError::NoLight))?;
        let spectrum = spectrum.scaled(photodiodes).map_err(CameraError::from)?;
        let unit = dot(&gatherer.luminance, spectrum.values());
        gatherer.luminance.iter_mut().for_each(|w| *w /= unit);
        gatherer.empty.white_coefficients =
            gatherer.analysis.iter().map(|a| dot(a, spectrum.values())).collect();
        gatherer.empty.xyz.iter_mut().for_each(|c| *c = c.map(|v| v / unit));
        Ok(gatherer)
    }

    /// Statistics of no scene.
    #[must_use]
    pub fn statistics(&self) -> LightStatistics {
        self.empty.clone()
    }

    /// Adds the light of a scene, with its field of view, to statistics of this gatherer.
    ///
    /// # Errors
    /// When the scene cannot be imaged, is dark, or is not larger than a patch.
    pub fn add(&self, statistics: &mut LightStatistics, scene: &Scene) -> Result<(), DesignError> {
        let camera = self.camera.with_scene_size(scene)?;
        let image = camera.optics.image(scene).map_err(CameraError::from)?;
        let pixels = PixelSpectra::new(&camera.sensor, &image).map_err(CameraError::from)?;
        let luminance_cd_m2 = scene.mean_luminance_cd_m2().map_err(CameraError::from)?;
        let light = self.coefficients(&pixels, luminance_cd_m2)?;
        let white = white_level(&light.y);
        let side = self.empty.settings.side;
        if light.rows < side || light.cols < side {
            let (rows, cols) = (light.rows, light.cols);
            let message = format!("{rows} × {cols} pixels; expected more than a patch of {side} × {side}");
            return Err(DesignError::key("scene", message));
        }
        let members = self.members(&light, white);
        for (number, patches) in members {
            let moments = self.moments(&light, &patches);
            let class = LightClass {
                moments,
                per_white_squared: patches.len() as f64 / (white * white),
                colors: self.middle_colors(&light, &patches, white),
            };
            statistics.classes.entry(number).or_insert_with(|| self.empty.empty_class()).merge(&class);
        }
        statistics.scenes += 1;
        statistics.energy.iter_mut().zip(light.energy).for_each(|(a, b)| *a += b);
        Ok(())
    }

    /// The coefficients of every pixel, per cd/m² of the mean luminance of the scene.
    fn coefficients(&self, pixels: &PixelSpectra, luminance_cd_m2: f64) -> Result<Coefficients, DesignError> {
        let window = pixels.window();
        // Photodiodes along the side of a sample.
        let side = self.camera.sensor.binning_side();
        let (rows, cols, count) = (window.rows / side, window.cols / side, self.analysis.len());
        let analysis: Vec<Vec<f32>> =
            self.analysis.iter().map(|a| a.iter().map(|v| *v as f32).collect()).collect();
        let luminance: Vec<f32> = self.luminance.iter().map(|v| *v as f32).collect();
        let y_of: Vec<f32> = self.empty.xyz.iter().map(|c| c[LUMINANCE] as f32).collect();
        let row = |r: usize| {
            let mut lines = vec![0.0f32; (count + 2) * cols];
            let mut add = |at: usize, weights: &[f32]| {
                let line = &mut lines[at * cols..(at + 1) * cols];
                for (i, &w) in weights.iter().enumerate() {
                    for of_block in 0..side {
                        let light = pixels.line(window.row + r * side + of_block, i);
                        if side == 1 {
                            line.iter_mut().zip(light).for_each(|(sum, l)| *sum += w * l);
                            continue;
                        }
                        let blocks = line.iter_mut().zip(light.chunks_exact(side));
                        blocks.for_each(|(sum, block)| *sum += w * block.iter().sum::<f32>());
                    }
                }
            };
            analysis.iter().enumerate().for_each(|(k, weights)| add(k, weights));
            add(count, &luminance);
            for (k, y) in y_of.iter().enumerate() {
                let (coefficients, sums) = lines.split_at_mut((count + 1) * cols);
                let coefficient = &coefficients[k * cols..(k + 1) * cols];
                sums.iter_mut().zip(coefficient).for_each(|(sum, c)| *sum += y * c);
            }
            lines
        };
        let lines: Vec<Vec<f32>> = (0..rows).into_par_iter().map(row).collect();
        let (mut values, mut y) = (Vec::with_capacity(rows * cols * count), Vec::with_capacity(rows * cols));
        let mut energy = [0.0f64; 2];
        for line in &lines {
            for col in 0..cols {
                values.extend((0..count).map(|k| line[k * cols + col]));
                let (exact, described) = (line[count * cols + col], line[(count + 1) * cols + col]);
                y.push(described);
                energy[0] += f64::from(exact).powi(2);
                energy[1] += f64::from(exact - described).powi(2);
            }
        }
        if !(luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()) {
            return Err(DesignError::key("scene", "it is dark to the standard observer"));
        }
        let scale = (1.0 / luminance_cd_m2) as f32;
        values.iter_mut().chain(&mut y).for_each(|v| *v *= scale);
        let energy = energy.map(|e| e / (luminance_cd_m2 * luminance_cd_m2));
        Ok(Coefficients { rows, cols, count, values, y, energy })
    }

    /// The middle pixels of the patches of each class.
    fn members(&self, light: &Coefficients, white: f64) -> BTreeMap<usize, Vec<u32>> {
        let LightSettings { side, step_px, classes, .. } = &self.empty.settings;
        let half = side / 2;
        let of_row = |row: usize| -> Vec<(usize, u32)> {
            (half..light.cols - half)
                .step_by(*step_px)
                .map(|col| {
                    let figures = self.figures(light, row, col, white);
                    (classes.class_of(&figures, self.empty.white), (row * light.cols + col) as u32)
                })
                .collect()
        };
        let rows: Vec<usize> = (half..light.rows - half).step_by(*step_px).collect();
        let rows: Vec<Vec<(usize, u32)>> = rows.into_par_iter().map(of_row).collect();
        let mut members: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (class, pixel) in rows.into_iter().flatten() {
            members.entry(class).or_default().push(pixel);
        }
        members
    }

    fn figures(&self, light: &Coefficients, row: usize, col: usize, white: f64) -> PatchFigures {
        let side = self.empty.settings.side;
        let (top, left) = (row - side / 2, col - side / 2);
        let (mut sum, mut squares, mut along) = (0.0f64, 0.0f64, [0.0f64; 2]);
        let at = |r: usize, c: usize| f64::from(light.y[(top + r) * light.cols + left + c]);
        let mut xyz = [0.0f64; 3];
        for r in 0..side {
            for c in 0..side {
                let y = at(r, c);
                sum += y;
                squares += y * y;
                if c > 0 {
                    along[0] += (y - at(r, c - 1)).abs();
                }
                if r > 0 {
                    along[1] += (y - at(r - 1, c)).abs();
                }
            }
        }
        let first = (top * light.cols + left) * light.count;
        for (k, of_component) in self.empty.xyz.iter().enumerate() {
            let line = |r: usize| {
                let start = first + r * light.cols * light.count + k;
                light.values[start..]
                    .iter()
                    .step_by(light.count)
                    .take(side)
                    .map(|&v| f64::from(v))
                    .sum::<f64>()
            };
            let coefficient: f64 = (0..side).map(line).sum();
            xyz.iter_mut().zip(of_component).for_each(|(x, m)| *x += coefficient * m);
        }
        let n = (side * side) as f64;
        let mean_y = sum / n;
        let variance = (squares / n - mean_y * mean_y).max(0.0);
        let contrast = if mean_y > 0.0 { variance.sqrt() / mean_y } else { 0.0 };
        PatchFigures { mean_y, contrast, along, xyz: xyz.map(|v| v / n / white) }
    }

    /// Σ z zᵀ over patches.
    fn moments(&self, light: &Coefficients, patches: &[u32]) -> Moments {
        let coefficients = self.empty.coefficients();
        let stride = (1 + coefficients).next_multiple_of(LANES);
        let source = PatchSource {
            values: &light.values,
            count: light.count,
            cols: light.cols,
            side: self.empty.settings.side,
            targets: &[],
        };
        let of_part = |part: &[u32]| {
            let mut sums = vec![0.0; stride * stride];
            let count = (BATCH / stride).max(1);
            let mut batch = vec![0.0; count * stride];
            for pixels in part.chunks(count) {
                let batch = &mut batch[..pixels.len() * stride];
                dispatch(AddPatches { source, pixels, batch, stride, sums: &mut sums });
            }
            sums
        };
        let parts: Vec<Vec<f64>> = patches.par_chunks(PART_PATCHES).map(of_part).collect();
        let mut moments = Moments::new(coefficients, 0);
        parts.iter().for_each(|sums| moments.add_square(sums, stride));
        moments
    }

    /// The colours of the middle pixels, relative to display white.
    fn middle_colors(&self, light: &Coefficients, patches: &[u32], white: f64) -> ClassColors {
        let mut colors = ClassColors::default();
        for &pixel in patches {
            let mut xyz = [0.0; 3];
            let values = light.values[pixel as usize * light.count..].iter().take(light.count);
            for (value, of_component) in values.zip(&self.empty.xyz) {
                xyz.iter_mut().zip(of_component).for_each(|(x, m)| *x += f64::from(*value) * m);
            }
            colors.add(xyz.map(|v| v / white), self.empty.white);
        }
        colors
    }
}

/// The parts of a sensor that collect light: the pitch of its samples, the area of a photodetector and, if they are several, the
/// photodiodes of a sample.
fn geometry(camera: &Camera) -> Vec<f64> {
    let sensor = &camera.sensor;
    let mut all = vec![sensor.pixel.pitch_m, sensor.pixel.photodetector_area_m2()];
    all.extend(sensor.binning.map(|_| sensor.photodiodes_per_sample()));
    all
}

/// The luminance that all but the share of [`ScoreSettings`] of the pixels do not exceed.
fn white_level(y: &[f32]) -> f64 {
    let mut sorted = y.to_vec();
    let last = sorted.len().saturating_sub(1);
    let at = (last as f64 * (1.0 - ScoreSettings::default().highlight_share)) as usize;
    f64::from(*sorted.select_nth_unstable_by(at, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::optics::OpticsModel;
    use crate::sensor::{Binning, BinningMode};
    use crate::spectrum::{SpectralCube, WavelengthGrid};

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
    const SIDE: usize = 24;

    /// A grey scene on as many samples as it has pixels, with the given reflectance of its left half and white in its right half.
    fn halves(camera: &Camera, left: f32) -> Scene {
        let white = scene::uniform(SIDE, SIDE, &Setting { grid: GRID, ..Setting::default() }).unwrap();
        let mut planes = white.radiance().planes().clone();
        planes.data_mut().chunks_mut(SIDE).flat_map(|row| &mut row[..SIDE / 2]).for_each(|v| *v *= left);
        let deg = camera.field_of_view_deg(SIDE, white.distance_m()).unwrap();
        let radiance = SpectralCube::new(GRID, planes).unwrap();
        Scene::new("halves", radiance, white.illuminant().clone(), white.distance_m(), deg).unwrap()
    }

    /// Also with binning, the pixels of a uniform scene have the coefficients of white. Where half of a scene is a quarter as bright as the
    /// other, white is 1/0.625 of its mean. Light falls off towards the border by less than 0.1 %.
    #[test]
    fn white_is_the_brightest_grey() {
        let light = [Illuminant::D65.photons(GRID).unwrap()];
        let settings = LightSettings { side: 3, ..LightSettings::default() };
        for binning in [None, Some(Binning { side: 2, mode: BinningMode::Charge })] {
            let mut camera = Camera::new(CameraDescription::default(), GRID).unwrap();
            camera.optics.model = OpticsModel::Pinhole;
            camera.sensor.binning = binning;
            let gatherer = LightGatherer::new(&camera, &Illuminant::D65, &light, &settings).unwrap();
            for (left, white) in [(1.0, 1.0), (0.25, 1.0 / 0.625)] {
                let scene = halves(&camera, left);
                let camera = gatherer.camera.with_scene_size(&scene).unwrap();
                let image = camera.optics.image(&scene).unwrap();
                let pixels = PixelSpectra::new(&camera.sensor, &image).unwrap();
                let found = gatherer.coefficients(&pixels, scene.mean_luminance_cd_m2().unwrap()).unwrap();
                // The middle of the right half, or any pixel of a uniform scene.
                let at = found.rows / 2 * found.cols + 3 * found.cols / 4;
                let of_white = &gatherer.empty.white_coefficients;
                assert_eq!(found.count, of_white.len());
                let largest = of_white.iter().fold(0.0f64, |most, c| most.max(c.abs()));
                for (value, of_white) in found.values[at * found.count..].iter().zip(of_white) {
                    let apart = f64::from(*value) - of_white * white;
                    assert!(apart.abs() < 1e-3 * largest, "{binning:?}, {left}: {value}, white {of_white}");
                }
                let mut statistics = gatherer.statistics();
                gatherer.add(&mut statistics, &scene).unwrap();
                for class in statistics.classes.values() {
                    let mean = class.per_white_squared / class.moments.get(0, 0);
                    assert!((mean * white * white - 1.0).abs() < 1e-2, "{binning:?}, {left}: {mean}");
                }
            }
        }
    }
}
