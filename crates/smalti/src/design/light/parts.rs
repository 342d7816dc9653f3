//! Statistics of light as plain numbers, for files.

use std::collections::BTreeMap;

use super::super::error::DesignError;
use super::{COLOR_GROUPS, ClassColors, LightClass, LightSettings, LightStatistics, SpectralBasis};
use crate::camera::CameraError;
use crate::l3::Moments;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// A class of patches as plain numbers; see [`LightClass`].
#[derive(Debug, Clone, PartialEq)]
pub struct ClassParts {
    /// Its number by the rule of the settings.
    pub number: usize,
    /// The upper triangle of Σ z zᵀ, row by row.
    pub sums: Vec<f64>,
    /// Σ 1/w².
    pub per_white_squared: f64,
    /// For each group of [`ClassColors`], the number of patches and Σ (X, Y, Z)/w of the middle pixels.
    pub colors: [[f64; 4]; COLOR_GROUPS],
}

/// [`LightStatistics`] as plain numbers. Statistics that are made of the parts of others equal them bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct LightParts {
    /// The settings.
    pub settings: LightSettings,
    /// The wavelengths.
    pub grid: WavelengthGrid,
    /// The components, each on all wavelengths.
    pub components: Vec<Vec<f64>>,
    /// The weights of the light before the lens whose sums are the coefficients, for each component.
    pub analysis: Vec<Vec<f64>>,
    /// The share of the energy that the components leave out.
    pub left_out: f64,
    /// X, Y, Z of each component.
    pub xyz: Vec<[f64; 3]>,
    /// X, Y, Z of white with Y = 1.
    pub white: [f64; 3],
    /// The coefficients of a white surface of 1 cd/m².
    pub white_coefficients: Vec<f64>,
    /// Lens, pixel geometry, wavelengths and light, as text.
    pub source: String,
    /// Number of scenes.
    pub scenes: u64,
    /// Σ of the squared Y, and of its squared error.
    pub energy: [f64; 2],
    /// The classes in ascending order of their numbers.
    pub classes: Vec<ClassParts>,
}

impl LightStatistics {
    /// All that the statistics consist of.
    #[must_use]
    pub fn parts(&self) -> LightParts {
        let class = |(number, class): (&usize, &LightClass)| ClassParts {
            number: *number,
            sums: class.moments.sums().to_vec(),
            per_white_squared: class.per_white_squared,
            colors: *class.colors.groups(),
        };
        LightParts {
            settings: self.settings.clone(),
            grid: self.basis.grid(),
            components: self.basis.components.iter().map(|c| c.values().to_vec()).collect(),
            analysis: self.basis.analysis.clone(),
            left_out: self.basis.left_out,
            xyz: self.xyz.clone(),
            white: self.white,
            white_coefficients: self.white_coefficients.clone(),
            source: self.source.clone(),
            scenes: self.scenes,
            energy: self.energy,
            classes: self.classes.iter().map(class).collect(),
        }
    }

    /// Statistics from their parts.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first part that does not fit the others or is not finite.
    pub fn from_parts(parts: LightParts) -> Result<Self, DesignError> {
        let LightParts { settings, grid, components, analysis, left_out, xyz, .. } = parts;
        settings.validate()?;
        let count = components.len();
        let check = |key: &str, fits: bool, expected: &str| {
            if fits { Ok(()) } else { Err(DesignError::key(key, format!("expected {expected}"))) }
        };
        let finite = |rows: &[Vec<f64>]| rows.iter().flatten().all(|v| v.is_finite());
        check(
            "components",
            (1..=settings.max_components).contains(&count),
            "1 to max_components components",
        )?;
        let whole = |rows: &[Vec<f64>]| rows.len() == count && rows.iter().all(|row| row.len() == grid.len());
        check("components", whole(&components) && finite(&components), "finite numbers at every wavelength")?;
        check("analysis", whole(&analysis) && finite(&analysis), "finite numbers at every wavelength")?;
        let numbers = |all: &[f64]| all.iter().all(|v| v.is_finite());
        let fits = xyz.len() == count && numbers(xyz.as_flattened());
        check("xyz", fits, "three finite numbers for each component")?;
        let fits = parts.white_coefficients.len() == count && numbers(&parts.white_coefficients);
        check("white_coefficients", fits, "a finite number for each component")?;
        check("white", numbers(&parts.white) && parts.white[1] > 0.0, "X, Y, Z with Y = 1")?;
        check(
            "energy",
            parts.energy.iter().all(|e| *e >= 0.0 && e.is_finite()),
            "two numbers of at least 0",
        )?;
        check("left_out", (0.0..=1.0).contains(&left_out), "0 to 1")?;
        let taps = settings.side * settings.side * count;
        let mut classes = BTreeMap::new();
        for class in parts.classes {
            let moments = Moments::from_sums(taps, 0, class.sums).filter(|m| m.count() > 0);
            let fits = class.number < settings.classes.count()
                && class.per_white_squared > 0.0
                && class.per_white_squared.is_finite()
                && numbers(class.colors.as_flattened())
                && class.colors.iter().all(|group| group[0] >= 0.0)
                && class.colors.iter().any(|group| group[0] > 0.0);
            let (Some(moments), true) = (moments, fits) else {
                let message = "expected the sums of at least one patch for a class of the settings";
                return Err(DesignError::key(format!("class {}", class.number), message));
            };
            let (per_white_squared, colors) = (class.per_white_squared, ClassColors(class.colors));
            classes.insert(class.number, LightClass { moments, per_white_squared, colors });
        }
        let spectrum = |values| Spectrum::new(grid, values).map_err(CameraError::from);
        let components = components.into_iter().map(spectrum).collect::<Result<_, _>>()?;
        Ok(Self {
            settings,
            basis: SpectralBasis { components, analysis, left_out },
            xyz,
            white: parts.white,
            white_coefficients: parts.white_coefficients,
            source: parts.source,
            classes,
            scenes: parts.scenes,
            energy: parts.energy,
        })
    }
}
