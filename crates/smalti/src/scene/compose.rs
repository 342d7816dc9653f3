//! Spectral images of a chosen mean luminance, from a few spectra and a map. Apart from the image itself, a
//! few bytes of memory per pixel are needed.

use rayon::prelude::*;

use super::setting::require_reflectance;
use super::{Scene, SceneError, Setting};
use crate::numeric::simd::{Kernel, dispatch};
use crate::numeric::{Planes, bands_of};
use crate::spectrum::{Observer, SpectralCube, Spectrum, WavelengthGrid};

/// Maximum number of values (pixels times wavelengths) of a built-in scene: 4 GiB.
pub const MAX_VALUES: usize = 1 << 30;

/// A part of one pixel with one spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fragment {
    /// Column of the pixel.
    pub col: u32,
    /// Index into the list of spectra.
    pub spectrum: u32,
    /// Fraction of the pixel, or any other factor on the spectrum.
    pub weight: f32,
}

/// Fails when a scene of this size would be empty or too large. Call it before any allocation.
pub(super) fn check_size(rows: usize, cols: usize, grid: WavelengthGrid) -> Result<(), SceneError> {
    let values = rows.checked_mul(cols).and_then(|n| n.checked_mul(grid.len())).unwrap_or(usize::MAX);
    if (1..=MAX_VALUES).contains(&values) && rows <= u32::MAX as usize && cols <= u32::MAX as usize {
        Ok(())
    } else {
        Err(SceneError::TooLarge { rows, cols, bands: grid.len(), limit: MAX_VALUES })
    }
}

/// The number of reflectances. Fails when there is none, or one is negative or on another grid.
pub(super) fn count_reflectances(list: &[Spectrum], grid: WavelengthGrid) -> Result<u32, SceneError> {
    let count = u32::try_from(list.len()).ok().filter(|&n| n > 0);
    let count = count.ok_or(SceneError::Reflectances { got: list.len(), expected: "at least 1" })?;
    list.iter().try_for_each(|r| require_reflectance(r, grid))?;
    Ok(count)
}

/// A scene of spectrally flat reflectances, one per pixel in row order.
pub(super) fn grey(
    name: &str,
    rows: usize,
    cols: usize,
    reflectance: &[f32],
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let light = setting.light()?;
    let mean = reflectance.iter().map(|&v| f64::from(v)).sum::<f64>() / reflectance.len().max(1) as f64;
    let scale = scale_to(setting, &light, mean)?;
    let light = light.scaled(scale)?;
    fill(name, rows, cols, light.clone(), setting, |row, band, out| {
        // One rounding per pixel: radiance is exactly proportional to the illuminant where reflectances are
        // equal.
        let light = light.values()[band];
        for (out, &r) in out.iter_mut().zip(&reflectance[row * cols..]) {
            *out = (light * f64::from(r)) as f32;
        }
    })
}

/// A scene of weighted spectra: row `r` is composed of `rows[r]`. `radiance` holds relative photon radiances;
/// `light`, in the same unit, is the radiance of a perfect white diffuser.
pub(super) fn fragments(
    name: &str,
    cols: usize,
    rows: &[Vec<Fragment>],
    radiance: &[Spectrum],
    light: &Spectrum,
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let y = &Observer::Cie1931.photon_weights(setting.grid)?[1];
    let luminance = radiance.iter().map(|s| Ok(s.times(y)?.values().iter().sum()));
    let luminance = luminance.collect::<Result<Vec<f64>, SceneError>>()?;
    let sums: Vec<f64> = rows
        .par_iter()
        .map(|row| row.iter().map(|f| f64::from(f.weight) * luminance[f.spectrum as usize]).sum())
        .collect();
    let mean = sums.iter().sum::<f64>() / (rows.len() * cols).max(1) as f64;
    let scale = scale_of(setting, mean)?;
    let light = light.scaled(scale)?;
    let mut planes = checked_planes(rows.len(), cols, setting)?;
    let blocks = setting.grid.len().div_ceil(LANES);
    let spectra = |block: usize| -> Vec<Lanes> {
        let lane =
            |s: &Spectrum, l: usize| s.values().get(block * LANES + l).map_or(0.0, |v| (v * scale) as f32);
        radiance.iter().map(|s| std::array::from_fn(|l| lane(s, l))).collect()
    };
    let spectra: Vec<Vec<Lanes>> = (0..blocks).map(spectra).collect();
    let tasks = bands_of(1, planes.data_mut(), rows.len(), cols);
    tasks.into_par_iter().zip(rows).for_each_init(Vec::new, |sums, (mut bands, fragments)| {
        for (bands, spectra) in bands.chunks_mut(LANES).zip(&spectra) {
            sums.clear();
            sums.resize(cols, [0.0; LANES]);
            dispatch(FragmentRow { fragments, spectra, sums, bands });
        }
    });
    into_scene(name, planes, light, setting)
}

/// Wavelengths that are summed at once.
const LANES: usize = 16;
type Lanes = [f32; LANES];

/// A row of fragments at some wavelengths.
struct FragmentRow<'a, 'b> {
    fragments: &'a [Fragment],
    spectra: &'a [Lanes],
    /// For each pixel; zero before.
    sums: &'a mut [Lanes],
    /// The row of the plane of each wavelength.
    bands: &'a mut [&'b mut [f32]],
}

impl Kernel for FragmentRow<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { fragments, spectra, sums, bands } = self;
        for f in fragments {
            let (sum, spectrum) = (&mut sums[f.col as usize], &spectra[f.spectrum as usize]);
            for (sum, value) in sum.iter_mut().zip(spectrum) {
                *sum += f.weight * value;
            }
        }
        for (l, band) in bands.iter_mut().enumerate() {
            band.iter_mut().zip(sums.iter()).for_each(|(out, sum)| *out = sum[l]);
        }
    }
}

/// Reflectances times an illuminant.
pub(super) fn lit(reflectances: &[Spectrum], light: &Spectrum) -> Result<Vec<Spectrum>, SceneError> {
    reflectances.iter().map(|r| Ok(r.times(light)?)).collect()
}

/// The factor on the illuminant that gives a mean reflectance the luminance of the setting.
fn scale_to(setting: &Setting, light: &Spectrum, mean_reflectance: f64) -> Result<f64, SceneError> {
    scale_of(setting, Observer::Cie1931.xyz_from_photons(light)?[1] * mean_reflectance)
}

fn scale_of(setting: &Setting, mean_luminance: f64) -> Result<f64, SceneError> {
    let scale = setting.luminance_cd_m2 / mean_luminance;
    if mean_luminance > 0.0 && scale.is_finite() {
        Ok(scale)
    } else {
        Err(SceneError::Dark { start_nm: setting.grid.start_nm(), end_nm: setting.grid.end_nm() })
    }
}

/// Fills a cube in parallel, row by row of each plane, with `paint(row, band, out)`.
fn fill(
    name: &str,
    rows: usize,
    cols: usize,
    light: Spectrum,
    setting: &Setting,
    paint: impl Fn(usize, usize, &mut [f32]) + Sync,
) -> Result<Scene, SceneError> {
    let mut planes = checked_planes(rows, cols, setting)?;
    planes.data_mut().par_chunks_mut(cols).enumerate().for_each(|(i, out)| paint(i % rows, i / rows, out));
    into_scene(name, planes, light, setting)
}

/// Dark planes for the wavelengths of a setting.
fn checked_planes(rows: usize, cols: usize, setting: &Setting) -> Result<Planes, SceneError> {
    setting.check()?;
    check_size(rows, cols, setting.grid)?;
    Ok(Planes::zeros(rows, cols, setting.grid.len()))
}

fn into_scene(name: &str, planes: Planes, light: Spectrum, setting: &Setting) -> Result<Scene, SceneError> {
    let radiance = SpectralCube::new(setting.grid, planes)?;
    Scene::new(name, radiance, light, setting.distance_m, setting.horizontal_fov_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With as many wavelengths as are summed at once, one fewer, one more, and twice as many.
    #[test]
    fn pixels_are_the_weighted_sums_of_their_fragments() {
        const COLS: usize = 7;
        for count in [15, 16, 17, 32] {
            let grid = WavelengthGrid::new(500.0, 2.0, count).unwrap();
            let spectrum = |s: usize| {
                let value = |i: usize| 0.1 + ((i * 7 + s * 5) % 11) as f64;
                Spectrum::new(grid, (0..count).map(value).collect()).unwrap()
            };
            let spectra = [0, 1, 2].map(spectrum);
            let fragment = |i: usize| Fragment {
                col: (i % COLS) as u32,
                spectrum: (i % 3) as u32,
                weight: 0.25 * (1 + i % 5) as f32,
            };
            // The last row has no fragment: it is black.
            let rows = [(0..COLS).map(fragment).collect(), (2..19).map(fragment).collect(), Vec::new()];
            let setting = Setting { grid, ..Setting::default() };
            let scene = fragments("test", COLS, &rows, &spectra, &spectra[0], &setting).unwrap();
            let scale = scene.illuminant().values()[0] / spectra[0].values()[0];
            for (band, plane) in scene.radiance().planes().planes().enumerate() {
                for (i, value) in plane.iter().enumerate() {
                    let own = rows[i / COLS].iter().filter(|f| f.col as usize == i % COLS);
                    let of = |f: &Fragment| f64::from(f.weight) * spectra[f.spectrum as usize].values()[band];
                    let sum = own.map(of).sum::<f64>() * scale;
                    assert!(
                        (f64::from(*value) - sum).abs() <= 1e-6 * sum,
                        "{count} {band} {i}: {value} {sum}"
                    );
                }
            }
        }
    }
}
