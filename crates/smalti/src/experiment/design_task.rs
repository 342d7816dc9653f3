//! What a search for the best colour filter array is asked for, and what it finds.

use crate::camera::Camera;
use crate::design::light::LightSettings;
use crate::design::screen::{ExpectedError, ScreenCondition};
use crate::design::search::{
    Annealing, FilterSpace, FoundFilters, Front, Goal, LayoutRules, Objective, SearchSettings, Tolerance,
};
use crate::design::{Design, DesignError, FilterSet, MosaicFamily};
use crate::sensor::{Filter, Mosaic};
use crate::spectrum::{Illuminant, Spectrum};

/// A search: which array is wanted, for which camera and light.
#[derive(Debug, Clone)]
pub struct DesignTask {
    /// Its name.
    pub name: String,
    /// The camera, whose own filters do not matter.
    pub camera: Camera,
    /// The illuminants of the scenes. All count equally.
    pub illuminants: Vec<Illuminant>,
    /// Luminances and exposures, under each of the illuminants.
    pub conditions: Vec<ScreenCondition>,
    /// Numbers of filters.
    pub colors: Vec<usize>,
    /// The filters that can be made.
    pub filters: FilterSpace,
    /// The mosaics that are searched.
    pub mosaics: MosaicFamily,
    /// Number of mosaics drawn for each number of filters. When `None`, all are tried if they are few; those of larger tiles are annealed.
    pub mosaic_count: Option<u64>,
    /// What mosaics must fulfil. Published ones that compete need not.
    pub rules: LayoutRules,
    /// The search for layouts of large tiles.
    pub annealing: Annealing,
    /// Whether the published mosaics compete, with filters found for each in the same way.
    pub rivals: bool,
    /// What is minimised.
    pub objective: Objective,
    /// The aims between which compromises are wanted as well.
    pub front: Option<Front>,
    /// How filters deviate from those that were wanted.
    pub tolerance: Tolerance,
    /// The extent of the search.
    pub search: SearchSettings,
    /// The statistics of the light.
    pub light: LightSettings,
}

/// A mosaic with the filters that were found for it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignedCfa {
    /// The name of a published mosaic, else its tile in letters.
    pub name: String,
    /// Whether the mosaic is published.
    pub is_published: bool,
    /// The mosaic; channel i has filter i.
    pub mosaic: Mosaic,
    /// The best filters of each start, best first; never empty.
    pub found: Vec<FoundFilters>,
}

impl DesignedCfa {
    /// The best filters.
    #[must_use]
    pub fn best(&self) -> Option<&FoundFilters> {
        self.found.first()
    }

    /// The array with its best filters in ascending order of wavelength.
    #[must_use]
    pub fn design(&self) -> Option<Design> {
        let best = self.best()?;
        let mean_nm = |s: &Spectrum| {
            let sum: f64 = s.values().iter().sum();
            let moment: f64 = s.values().iter().zip(s.grid().wavelengths_nm()).map(|(t, nm)| t * nm).sum();
            moment / sum.max(f64::MIN_POSITIVE)
        };
        let mut order: Vec<usize> = (0..best.transmittances.len()).collect();
        order.sort_by(|&a, &b| {
            mean_nm(&best.transmittances[a]).total_cmp(&mean_nm(&best.transmittances[b])).then(a.cmp(&b))
        });
        let place = |cell: &u8| order.iter().position(|i| *i == usize::from(*cell)).map(|p| p as u8);
        let cells = self.mosaic.cells().iter().map(place).collect::<Option<Vec<u8>>>()?;
        let filter = |i: &usize| Filter::sampled(&best.transmittances[*i]);
        Some(Design {
            filters: FilterSet { label: self.name.clone(), filters: order.iter().map(filter).collect() },
            mosaic: Mosaic::new(self.mosaic.rows(), self.mosaic.cols(), cells).ok()?,
        })
    }

    pub(super) fn cost(&self) -> f64 {
        self.best().map_or(f64::INFINITY, |f| f.cost)
    }
}

/// A compromise between the aims of a front.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontPoint {
    /// The share of each aim.
    pub shares: Vec<f64>,
    /// The cost of each aim, less is better; the number of filters comes last when it is an aim.
    pub costs: Vec<f64>,
    /// The array.
    pub cfa: DesignedCfa,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Designs {
    /// The expected errors of the camera's own array, by illuminant and condition.
    pub own: Vec<ExpectedError>,
    /// What was minimised.
    pub goal: Goal,
    /// The searched mosaics, best first.
    pub searched: Vec<DesignedCfa>,
    /// The published mosaics with filters of the same kind, best first.
    pub rivals: Vec<DesignedCfa>,
    /// The compromises between the aims of the front that no other surpasses in all of them, by the cost of the first aim.
    pub front: Vec<FrontPoint>,
}

impl DesignTask {
    /// Checks everything that needs no statistics. The keys of errors are those of a design file.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first key that is out of its range.
    pub fn validate(&self) -> Result<(), DesignError> {
        self.objective.validate()?;
        self.tolerance.validate()?;
        self.search.validate()?;
        self.annealing.validate()?;
        self.rules.validate()?;
        if let Some(front) = &self.front {
            front.validate(&self.luminances_cd_m2())?;
        }
        let of_tile = matches!(self.mosaics, MosaicFamily::Tile(_)) && self.mosaic_count.is_none();
        if !of_tile && !self.rules.kept.is_empty() {
            let message = "cells are kept in the tile of `mosaics.tile` without `mosaic_count` only";
            return Err(DesignError::key("rules.kept", message));
        }
        Ok(())
    }

    /// The mean luminance of the scenes of each condition, cd/m².
    #[must_use]
    pub fn luminances_cd_m2(&self) -> Vec<f64> {
        self.conditions.iter().map(|c| c.luminance_cd_m2).collect()
    }

    /// The filters of the first channels that are given, sampled.
    pub(super) fn given(&self) -> Result<Vec<Option<Spectrum>>, DesignError> {
        let of = |letter: char| {
            let Some(filter) = self.rules.filters.get(&letter) else { return Ok(None) };
            let wrong = |e: &dyn ToString| DesignError::key(format!("rules.filters.{letter}"), e.to_string());
            filter.spectrum(self.camera.grid()).map(Some).map_err(|e| wrong(&e))
        };
        self.rules.letters().into_iter().map(of).collect()
    }

    /// The mosaics of a number of filters when they are tried one by one, or `None` when layouts are annealed.
    ///
    /// # Errors
    /// When there is no such mosaic, or too many.
    pub fn listed_mosaics(&self, colors: usize) -> Result<Option<Vec<Mosaic>>, DesignError> {
        if let (MosaicFamily::Tile(tile), None) = (&self.mosaics, self.mosaic_count) {
            return self.rules.of_tile(*tile)?.all(colors);
        }
        let mut all = self.mosaics.pick_layouts(colors, self.mosaic_count, self.search.seed)?;
        let count = all.len();
        all.retain(|mosaic| self.rules.allow(mosaic));
        if all.is_empty() && count > 0 {
            let message = format!("none of the {count} mosaics of {colors} filters fulfils it");
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        Ok(Some(all))
    }
}
