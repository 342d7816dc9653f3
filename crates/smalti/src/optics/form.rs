//! Formation of the optical image.

use rayon::prelude::*;

use super::error::OpticsError;
use super::geometry::Geometry;
use super::image::OpticalImage;
use super::lens::{Blur, Falloff, Optics};
use super::otf::Otf;
use super::padding::Extent;
use crate::numeric::Planes;
use crate::numeric::fft::{FftError, RealFft2};
use crate::numeric::halving_filter::HalvingFilter;
use crate::numeric::plane_filter::PlaneFilter;
use crate::scene::Scene;
use crate::spectrum::{SpectralCube, WavelengthGrid};

/// Minimum number of bands per set of scratch memory. It keeps the total scratch memory below the size of the
/// image.
const BANDS_PER_GROUP: usize = 8;
/// Maximum width of the blur, in sides of the image.
const WIDEST_BLUR: f64 = 4.0;

/// What of the image is formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    /// With its margin.
    Whole,
    /// Without the margin.
    Scene,
    /// The scene, with means of two by two samples.
    HalvedScene,
}

impl Kept {
    /// Samples that each sample of the image is the mean of, in each direction.
    fn step(self) -> usize {
        if self == Self::HalvedScene { 2 } else { 1 }
    }
}

impl Optics {
    /// The irradiance that the lens forms from a scene, photons s⁻¹ m⁻² nm⁻¹. It has the wavelengths and the
    /// sampling of the scene and is enlarged by [`Padding`](super::Padding). Relative illumination is applied
    /// before the blur.
    ///
    /// The function needs memory for the scene and the image, and scratch memory for a few planes per thread.
    /// The result has the same bits for any number of threads.
    ///
    /// # Errors
    /// When a parameter is out of range, the scene is not beyond the focal length, a spectrum or the point
    /// spread functions do not cover the scene's wavelengths, or the blur is too steep or too wide to
    /// compute.
    pub fn image(&self, scene: &Scene) -> Result<OpticalImage, OpticsError> {
        self.form(scene, Kept::Whole)
    }

    /// [`Optics::image`] of the size of the scene: without the margin of dark surroundings and the light that spreads into it. Up to
    /// rounding, the samples are those in the middle of the image.
    ///
    /// # Errors
    /// As [`Optics::image`].
    pub fn image_of_scene(&self, scene: &Scene) -> Result<OpticalImage, OpticsError> {
        self.form(scene, Kept::Scene)
    }

    /// [`Optics::image_of_scene`] with half of its rows and columns. Each sample is the mean of two by two samples of that image, up to rounding
    /// and to what limits the samples at 0. Pixels of two by two samples collect the same light from both, and this one takes less time.
    ///
    /// # Errors
    /// As [`Optics::image`]; and when the scene has an odd number of rows or columns.
    pub fn halved_image_of_scene(&self, scene: &Scene) -> Result<OpticalImage, OpticsError> {
        let (rows, cols) = (scene.radiance().rows(), scene.radiance().cols());
        if !rows.is_multiple_of(2) || !cols.is_multiple_of(2) {
            return Err(FftError::Odd { rows, cols }.into());
        }
        self.form(scene, Kept::HalvedScene)
    }

    fn form(&self, scene: &Scene, kept: Kept) -> Result<OpticalImage, OpticsError> {
        let radiance = scene.radiance();
        let grid = radiance.grid();
        let geometry = self.geometry(scene.distance_m())?;
        let spacing_m = geometry.sample_spacing_m(scene.horizontal_fov_deg(), radiance.cols());
        self.padding.check()?;
        let transmittance = self.transmittance_on(grid)?;
        let wavelengths: Vec<f64> = grid.wavelengths_nm().collect();
        let blur = Blur::new(self, &geometry, &wavelengths)?;

        let band = |(radiance, transmittance): (_, &f64)| {
            let gain = (transmittance * geometry.irradiance_per_radiance_sr()) as f32;
            Band { radiance, gain }
        };
        let bands = radiance.planes().planes().zip(transmittance.values()).map(band).collect();
        let falloff = FalloffMap::new(self.falloff, &geometry, radiance, spacing_m);
        let light = Light { bands, falloff };
        let planes = if blur.is_none() {
            light.sharp(radiance, kept.step())
        } else {
            let frame = self.frame(radiance, (spacing_m, blur.reach_m()), kept)?;
            let (rows, cols) = (frame.rows.total, frame.cols.total);
            match kept {
                Kept::HalvedScene => frame.blurred(&HalvingFilter::new(rows, cols)?, &light, &blur, grid)?,
                Kept::Whole | Kept::Scene => {
                    frame.blurred(&RealFft2::new(rows, cols)?, &light, &blur, grid)?
                }
            }
        };
        let spacing_m = spacing_m * kept.step() as f64;
        Ok(OpticalImage::new(SpectralCube::new(grid, planes)?, spacing_m)?)
    }

    fn frame(
        &self,
        radiance: &SpectralCube,
        (spacing_m, reach_m): (f64, f64),
        kept: Kept,
    ) -> Result<Frame, OpticsError> {
        let (rows, cols) = (radiance.rows(), radiance.cols());
        let longest = rows.max(cols) as f64;
        let reach = (reach_m / spacing_m).ceil();
        if reach.is_nan() || reach > WIDEST_BLUR * longest {
            return Err(OpticsError::BlurTooWide { radius_m: reach_m, image_m: longest * spacing_m });
        }
        let [rows, cols] = [rows, cols].map(|len| {
            let extent = self.padding.extent(len, reach as usize);
            if kept == Kept::Whole { extent } else { extent.without_margin() }
        });
        Ok(Frame { rows, cols, spacing_m, step: kept.step() })
    }
}

/// The light of the scene as the lens receives it.
struct Light<'a> {
    bands: Vec<Band<'a>>,
    falloff: FalloffMap,
}

impl Light<'_> {
    /// The irradiance without blur, with means of `step` × `step` samples.
    fn sharp(&self, radiance: &SpectralCube, step: usize) -> Planes {
        let (rows, cols) = (radiance.rows() / step, radiance.cols() / step);
        let mut planes = Planes::zeros(rows, cols, self.bands.len());
        let share = 1.0 / (step * step) as f32;
        planes.data_mut().par_chunks_mut(cols).enumerate().for_each_init(Vec::new, |line, (i, out)| {
            line.resize(cols * step, 0.0f32);
            for row in i % rows * step..(i % rows + 1) * step {
                self.bands[i / rows].row(row, &self.falloff, line);
                for (o, samples) in out.iter_mut().zip(line.chunks_exact(step)) {
                    *o += samples.iter().sum::<f32>() * share;
                }
            }
        });
        planes
    }
}

/// One wavelength of the scene, and its conversion to irradiance on the axis.
struct Band<'a> {
    radiance: &'a [f32],
    gain: f32,
}

impl Band<'_> {
    /// Irradiance of a row of the scene without blur.
    fn row(&self, row: usize, falloff: &FalloffMap, out: &mut [f32]) {
        let cols = out.len();
        let radiance = self.radiance.get(row * cols..(row + 1) * cols).unwrap_or(&[]);
        if let FalloffMap::Cos4 { x2, y2 } = falloff {
            let y2 = y2.get(row).copied().unwrap_or(0.0);
            for ((o, &v), &x2) in out.iter_mut().zip(radiance).zip(x2) {
                // tan² of the field angle is x² + y² over the squared image distance.
                let cos2 = 1.0 / (1.0 + x2 + y2);
                *o = v * self.gain * (cos2 * cos2);
            }
        } else {
            for (o, &v) in out.iter_mut().zip(radiance) {
                *o = v * self.gain;
            }
        }
    }
}

/// Squared positions of columns and rows, in units of the image distance.
enum FalloffMap {
    None,
    Cos4 { x2: Vec<f32>, y2: Vec<f32> },
}

impl FalloffMap {
    fn new(falloff: Falloff, geometry: &Geometry, radiance: &SpectralCube, spacing_m: f64) -> Self {
        let squares = |count: usize| {
            let middle = (count as f64 - 1.0) / 2.0;
            let unit = spacing_m / geometry.image_distance_m();
            (0..count).map(|i| ((i as f64 - middle) * unit).powi(2) as f32).collect()
        };
        match falloff {
            Falloff::None => Self::None,
            Falloff::Cos4 => Self::Cos4 { x2: squares(radiance.cols()), y2: squares(radiance.rows()) },
        }
    }
}

/// The padded image.
struct Frame {
    rows: Extent,
    cols: Extent,
    spacing_m: f64,
    /// Samples that each sample of the image is the mean of, in each direction.
    step: usize,
}

impl Frame {
    /// The irradiance with the blur of the lens.
    fn blurred<F: PlaneFilter>(
        &self,
        filter: &F,
        light: &Light<'_>,
        blur: &Blur<'_>,
        grid: WavelengthGrid,
    ) -> Result<Planes, OpticsError> {
        let [rows, cols] = [self.rows, self.cols].map(|extent| extent.out / self.step);
        let mut planes = Planes::zeros(rows, cols, grid.len());
        let groups = rayon::current_num_threads().min(grid.len() / BANDS_PER_GROUP).max(1);
        let per_group = grid.len().div_ceil(groups);
        let plane_len = planes.plane_len();
        let groups = planes.data_mut().par_chunks_mut(plane_len * per_group);
        groups.enumerate().try_for_each(|(g, group)| {
            let mut work = filter.workspace();
            for (i, out) in group.chunks_exact_mut(plane_len).enumerate() {
                let b = g * per_group + i;
                let otf = blur.otf(grid.wavelength_nm(b))?;
                self.blur((filter, &mut work), &light.bands[b], &light.falloff, &otf, (out, cols))?;
            }
            Ok::<_, OpticsError>(())
        })?;
        Ok(planes)
    }

    /// Applies the blur of the lens to one band.
    fn blur<F: PlaneFilter>(
        &self,
        (filter, work): (&F, &mut F::Workspace),
        band: &Band<'_>,
        falloff: &FalloffMap,
        otf: &Otf,
        out: (&mut [f32], usize),
    ) -> Result<(), OpticsError> {
        let (rows, cols) = (self.rows, self.cols);
        let otf = otf.on_grid(rows.total, cols.total, self.spacing_m);
        let fill = |r: usize, row: &mut [f32]| {
            let Some(source) = rows.source(r) else {
                row.fill(0.0);
                return;
            };
            band.row(source, falloff, &mut row[cols.offset..cols.offset + cols.len]);
            cols.surround(row);
        };
        // Coarse sampling (Gibbs ringing) and rounding cause small negative values. NaN is kept, so that a
        // later check can find it.
        let not_negative = |v: f32| if v < 0.0 { 0.0 } else { v };
        let passing = otf.passing();
        let apply = |kx: usize, column: &mut [_]| otf.apply(kx, column);
        Ok(filter.filter(work, fill, passing, apply, out, not_negative)?)
    }
}
