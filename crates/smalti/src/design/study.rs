//! A study: families of filters and mosaics before cameras, and the designs that it has, numbered.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::DesignError;
use super::filters::{FilterFamily, FilterSet};
use super::learned::LessonSettings;
use super::mosaics::{MosaicFamily, Wanted};
use super::permutation::Permutation;
use super::scenes::StudyScene;
use super::scores::Metric;
use crate::camera::description::{CfaDescription, PatternDescription};
use crate::camera::{CameraDescription, CameraError};
use crate::sensor::{Cfa, Channel, Filter, Mosaic};
use crate::spectrum::{Illuminant, Spectrum, SpectrumError, WavelengthGrid};

/// Separates the choice of filters from other uses of the same seed.
const PURPOSE: u32 = 0x4453_4E03;

/// Sets of filters that are made at once and kept.
const MAX_MADE: u64 = 64;

/// What makes a picture of the raw samples of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Processing {
    /// That of the camera's description: demosaicking, one matrix for colour.
    Classic,
    /// A pipeline learned for the design.
    L3,
}

/// A value of a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ConditionValue {
    /// In the unit of its key.
    Number(f64),
    /// A name.
    Text(String),
}

impl std::fmt::Display for ConditionValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(v) => v.fmt(f),
            Self::Text(v) => v.fmt(f),
        }
    }
}

/// What designs are seen under.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// What sets this condition apart: the same keys, in the same order, in every condition of a study.
    pub values: Vec<(String, ConditionValue)>,
    /// Mean luminance of the targets, cd/m².
    pub luminance_cd_m2: f64,
    /// The light of the targets.
    #[serde(serialize_with = "name_of_light", deserialize_with = "light")]
    pub illuminant: Illuminant,
    /// The camera. Its own colour filter array is not used.
    pub camera: CameraDescription,
}

fn name_of_light<S: serde::Serializer>(light: &Illuminant, to: S) -> Result<S::Ok, S::Error> {
    match light {
        // A name alone would not say what was in the file.
        Illuminant::Measured { name, power } => {
            (name, power.grid().start_nm(), power.grid().step_nm(), power.values()).serialize(to)
        }
        named => named.name().serialize(to),
    }
}

/// As [`name_of_light`] writes it.
fn light<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Illuminant, D::Error> {
    #[derive(Deserialize)]
    #[serde(
        untagged,
        expecting = "expected the name of a light, or its name, first wavelength, step and samples"
    )]
    enum Written {
        Name(String),
        Measured(String, f64, f64, Vec<f64>),
    }
    let wrong = <D::Error as serde::de::Error>::custom::<SpectrumError>;
    match Written::deserialize(from)? {
        Written::Name(name) => Illuminant::from_name(&name).map_err(wrong),
        Written::Measured(name, start_nm, step_nm, values) => {
            let grid = WavelengthGrid::new(start_nm, step_nm, values.len()).map_err(wrong)?;
            let power = Spectrum::new(grid, values).map_err(wrong)?;
            Ok(Illuminant::Measured { name, power })
        }
    }
}

/// A study, resolved: it alone says what every design is.
///
/// As JSON it is read as it was written, keys beside its own ignored. The samples of `optics.psf` and the scenes in files are
/// not part of it, but their hashes are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// What it is called.
    pub name: String,
    /// Decides which designs are drawn, and the noise of the captures: the same for every design.
    pub seed: u64,
    /// Numbers of colours.
    pub colors: Vec<usize>,
    /// The filters.
    pub filters: FilterFamily,
    /// Sets of filters for each number of colours; all when `None`.
    pub filter_sets: Option<u64>,
    /// The mosaics, each with every set of filters.
    pub mosaics: MosaicFamily,
    /// Mosaics for each number of colours; all when `None`.
    pub mosaic_count: Option<u64>,
    /// Every design under every condition.
    pub conditions: Vec<Condition>,
    /// Every design with every processing.
    pub processing: Vec<Processing>,
    /// How pipelines of designs are learned.
    pub l3: LessonSettings,
    /// What every design is scored by, in the order of the results.
    pub metrics: Vec<Metric>,
    /// What [`Metric::OF_SCENES`] are of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenes: Vec<StudyScene>,
}

/// One design under one condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Its number in the study, from 0.
    pub number: u64,
    /// Index of the condition.
    pub condition: usize,
    /// What makes the picture.
    pub processing: Processing,
    /// The filters, ascending in wavelength.
    pub filters: FilterSet,
    /// Channel i has filter i.
    pub mosaic: Mosaic,
}

impl Design {
    /// The colour filter array; channels are named A, B, C, …
    ///
    /// # Errors
    /// When a filter cannot be sampled on the grid.
    pub fn cfa(&self, grid: WavelengthGrid) -> Result<Cfa, CameraError> {
        let channel = |(i, filter): (usize, &Filter)| {
            Ok(Channel { name: letter(i).to_string(), transmittance: filter.spectrum(grid)? })
        };
        let channels =
            self.filters.filters.iter().enumerate().map(channel).collect::<Result<_, CameraError>>()?;
        Ok(Cfa::new(self.filters.label.clone(), self.mosaic.clone(), channels)?)
    }

    /// A camera with the filters and the mosaic of this design in place of its own; channels are named as in [`Design::cfa`].
    #[must_use]
    pub fn camera(&self, fixed: &CameraDescription) -> CameraDescription {
        let row = |cells: &[u8]| cells.iter().map(|&c| letter(usize::from(c))).collect();
        let pattern = self.mosaic.cells().chunks(self.mosaic.cols().max(1)).map(row).collect();
        let named = |(i, filter): (usize, &Filter)| (letter(i).to_string(), filter.clone());
        let mut camera = fixed.clone();
        camera.sensor.cfa = CfaDescription {
            pattern: PatternDescription::Letters(pattern),
            filters: self.filters.filters.iter().enumerate().map(named).collect(),
            mixtures: BTreeMap::new(),
        };
        camera
    }

    /// The tile in letters, rows apart by `/`: `a` is the filter of the shortest wavelengths.
    #[must_use]
    pub fn tile(&self) -> String {
        let row = |cells: &[u8]| cells.iter().map(|&c| letter(usize::from(c)).to_ascii_lowercase()).collect();
        self.mosaic.cells().chunks(self.mosaic.cols().max(1)).map(row).collect::<Vec<String>>().join("/")
    }
}

fn letter(i: usize) -> char {
    char::from(b'A' + (i % 26) as u8)
}

/// Designs of one number of colours.
#[derive(Debug, Clone)]
struct Group {
    colors: usize,
    sets: u64,
    /// Which set of the family comes first, second, …; `None` where all are taken in their order.
    order: Option<Permutation>,
    /// The sets, where they are few: some take long to make, and come again with every mosaic.
    made: Vec<FilterSet>,
    mosaics: Vec<Mosaic>,
}

impl Group {
    fn len(&self) -> Option<u64> {
        self.sets.checked_mul(self.mosaics.len() as u64)
    }

    fn set(&self, family: &FilterFamily, index: u64) -> Result<FilterSet, DesignError> {
        if let Some(set) = self.made.get(index as usize) {
            return Ok(set.clone());
        }
        let index = u128::from(index);
        family.set(self.colors, self.order.as_ref().and_then(|o| o.at(index)).unwrap_or(index))
    }
}

/// The designs of a study. Any of them is found by its number alone; of mosaics a list is kept.
///
/// Numbers run over the sets of filters first, then mosaics, numbers of colours, processing, conditions: what is slowest to
/// prepare changes least often.
#[derive(Debug, Clone)]
pub struct Designs {
    study: Study,
    groups: Vec<Group>,
    /// Under one condition with one processing.
    per_setup: u64,
    count: u64,
}

impl Designs {
    /// Counts the designs and draws the mosaics.
    ///
    /// # Errors
    /// When a family refuses a key, more designs are asked for than it has, more mosaics than are listed at once, or there is no design
    /// at all.
    pub fn new(study: Study) -> Result<Self, DesignError> {
        study.filters.validate()?;
        // Before the first of them is listed, which may take seconds.
        let wanted = |&colors: &usize| match study.mosaics.wanted(colors, study.mosaic_count) {
            Err(DesignError::TooFew { available: 0, .. }) => Ok(None),
            wanted => Ok(Some(wanted?).filter(|w| w.count > 0)),
        };
        let wanted = study.colors.iter().map(wanted).collect::<Result<Vec<_>, DesignError>>()?;
        let listed = wanted.iter().flatten().fold(0u64, |n, w| n.saturating_add(w.count));
        if let Some(limit) = wanted.iter().flatten().map(|w| w.limit).min().filter(|limit| listed > *limit) {
            return Err(DesignError::TooManyMosaics { wanted: listed, limit });
        }
        let group = |(&colors, wanted): (&usize, Option<Wanted>)| {
            let available = study.filters.count(colors)?;
            let sets = match study.filter_sets {
                Some(wanted) if u128::from(wanted) > available && available > 0 => {
                    return Err(DesignError::TooFewSets { colors, wanted, available });
                }
                Some(_) if available == 0 => 0,
                Some(wanted) => wanted,
                None => {
                    u64::try_from(available).map_err(|_| DesignError::TooManySets { colors, available })?
                }
            };
            let order = (u128::from(sets) < available)
                .then(|| Permutation::new(available, study.seed, PURPOSE, colors as u32));
            let mosaics = match wanted {
                Some(wanted) => study.mosaics.list(colors, wanted, study.seed)?,
                None => Vec::new(),
            };
            let mut group = Group { colors, sets, order, made: Vec::new(), mosaics };
            if sets <= MAX_MADE {
                group.made = (0..sets).map(|i| group.set(&study.filters, i)).collect::<Result<_, _>>()?;
            }
            Ok(group)
        };
        let groups = study.colors.iter().zip(wanted).map(group).collect::<Result<Vec<_>, DesignError>>()?;
        let too_many = || DesignError::TooManyDesigns;
        let per_setup = groups.iter().try_fold(0u64, |n, g| n.checked_add(g.len()?)).ok_or_else(too_many)?;
        let setups = (study.conditions.len() as u64).checked_mul(study.processing.len() as u64);
        let count = setups.and_then(|n| n.checked_mul(per_setup)).ok_or_else(too_many)?;
        if count == 0 {
            return Err(DesignError::NoDesign {
                colors: study.colors.clone(),
                sets: groups.iter().map(|g| g.sets).collect(),
                mosaics: groups.iter().map(|g| g.mosaics.len() as u64).collect(),
            });
        }
        Ok(Self { study, groups, per_setup, count })
    }

    /// The study.
    #[must_use]
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// The number of designs, under all conditions.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.count
    }

    /// Never: a study without a design is refused.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Per number of colours: sets of filters and mosaics.
    pub fn groups(&self) -> impl Iterator<Item = (usize, u64, usize)> {
        self.groups.iter().map(|g| (g.colors, g.sets, g.mosaics.len()))
    }

    /// Which condition with which processing a design is seen under, counted from 0.
    #[must_use]
    pub fn setup_of(&self, number: u64) -> u64 {
        number / self.per_setup
    }

    /// Index of the condition, and processing, of a setup; `None` where there are not so many.
    #[must_use]
    pub fn setup(&self, setup: u64) -> Option<(usize, Processing)> {
        let ways = self.study.processing.len() as u64;
        let condition = usize::try_from(setup / ways).ok().filter(|&c| c < self.study.conditions.len())?;
        Some((condition, *self.study.processing.get((setup % ways) as usize)?))
    }

    /// The condition of a design.
    #[must_use]
    pub fn condition_of(&self, number: u64) -> usize {
        (self.setup_of(number) / self.study.processing.len() as u64) as usize
    }

    /// The first design after `number` that has another condition.
    #[must_use]
    pub fn end_of_condition(&self, number: u64) -> u64 {
        (self.condition_of(number) as u64 + 1) * self.per_setup * self.study.processing.len() as u64
    }

    /// The design of a number.
    ///
    /// # Errors
    /// When there are not so many, or a filter cannot be made.
    pub fn design(&self, number: u64) -> Result<Design, DesignError> {
        let beyond = || DesignError::NoSuchDesign { number, count: self.count };
        if number >= self.count {
            return Err(beyond());
        }
        let (condition, processing) = self.setup(self.setup_of(number)).ok_or_else(beyond)?;
        let mut rest = number % self.per_setup;
        for group in &self.groups {
            let here = group.len().unwrap_or(0);
            if rest >= here {
                rest -= here;
                continue;
            }
            let (mosaic, set) = (rest / group.sets, rest % group.sets);
            return Ok(Design {
                number,
                condition,
                processing,
                filters: group.set(&self.study.filters, set)?,
                mosaic: group.mosaics.get(mosaic as usize).ok_or_else(beyond)?.clone(),
            });
        }
        Err(beyond())
    }
}
