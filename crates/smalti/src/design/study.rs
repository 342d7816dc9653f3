//! A study: families of filters and mosaics on cameras, and its numbered trials.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::DesignError;
use super::filters::{FilterFamily, FilterSet};
use super::learning_settings::LearningSettings;
use super::mosaics::{MosaicFamily, MosaicRequest};
use super::permutation::Permutation;
use super::scenes::StudyScene;
use super::scores::Metric;
use crate::camera::description::{BinnedBlocks, BinningDescription, CfaDescription, PatternDescription};
use crate::camera::{Camera, CameraDescription, CameraError};
use crate::sensor::{Cfa, Channel, Filter, Mosaic};
use crate::spectrum::{Illuminant, WavelengthGrid};

/// Purpose key of the random numbers that choose sets of filters.
const PURPOSE: u32 = 0x4453_4E03;

/// Maximum number of sets of filters that are computed in advance and cached.
const MAX_CACHED_SETS: u64 = 64;

/// The processing that renders the raw images of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TrialProcessing {
    /// The processing of the camera description: demosaicking and a colour matrix.
    Classic,
    /// An L³ pipeline trained for the design.
    L3,
}

impl TrialProcessing {
    /// Its name in study files and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Classic => "classic",
            Self::L3 => "l3",
        }
    }
}

/// A value of a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ConditionValue {
    /// A number in the unit of its key.
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

/// A condition of a study: camera, illuminant and luminance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The keys and values that differ between conditions. All conditions of a study have the same keys in the same order.
    pub values: Vec<(String, ConditionValue)>,
    /// Mean luminance of the targets, cd/m².
    pub luminance_cd_m2: f64,
    /// Illuminant of the targets.
    pub illuminant: Illuminant,
    /// The camera. The colour filter array of each design replaces its own.
    pub camera: CameraDescription,
}

impl Condition {
    /// The camera on its own wavelengths.
    ///
    /// # Errors
    /// When its description is invalid.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        Camera::new(self.camera.clone(), self.camera.grid()?)
    }
}

/// A resolved study, which defines every trial.
///
/// Reading its JSON gives an equal study; unknown keys are ignored. The JSON holds the hashes of `optics.psf` and of scene files
/// instead of their contents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Its name.
    pub name: String,
    /// Seed of the random designs and of the noise. Every trial has the same noise.
    pub seed: u64,
    /// Numbers of colours.
    pub colors: Vec<usize>,
    /// The family of filters.
    pub filters: FilterFamily,
    /// Number of sets of filters for each number of colours; `None` takes all.
    pub filter_sets: Option<u64>,
    /// The family of mosaics. Every mosaic is combined with every set of filters.
    pub mosaics: MosaicFamily,
    /// Number of mosaics for each number of colours; `None` takes all.
    pub mosaic_count: Option<u64>,
    /// The conditions. Every design is scored under each.
    pub conditions: Vec<Condition>,
    /// The kinds of processing. Every design is scored with each.
    pub processing: Vec<TrialProcessing>,
    /// Training settings for learned pipelines.
    pub l3: LearningSettings,
    /// The metrics, in the order of the results.
    pub metrics: Vec<Metric>,
    /// The scenes that [`Metric::OF_SCENES`] are measured on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenes: Vec<StudyScene>,
}

/// A design: the filters and the mosaic of a colour filter array.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The filters in ascending wavelength.
    pub filters: FilterSet,
    /// The mosaic, whose channel i has filter i.
    pub mosaic: Mosaic,
}

/// A trial: a design under a condition, with a processing. Trials are what a sweep scores.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Its number in the study, from 0.
    pub number: u64,
    /// Index of the condition.
    pub condition: usize,
    /// The processing.
    pub processing: TrialProcessing,
    /// The design.
    pub design: Design,
}

impl Design {
    /// The colour filter array. Its channels are named A, B, C, …
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

    /// The description of a camera with the filters and the mosaic of this design; channels are named as in [`Design::cfa`]. The mosaic
    /// of a camera that bins is that of its samples, so that each cell becomes a block of photodiodes.
    #[must_use]
    pub fn camera(&self, fixed: &CameraDescription) -> CameraDescription {
        let mut camera = fixed.clone();
        let side = fixed.sensor.binning_side().unwrap_or(1);
        if let Some(binning) = fixed.sensor.binning {
            camera.sensor.binning =
                Some(BinningDescription::Blocks(BinnedBlocks { side, mode: binning.mode() }));
        }
        let mosaic = self.mosaic.with_blocks(side);
        let row = |cells: &[u8]| cells.iter().map(|&c| letter(usize::from(c))).collect();
        let pattern = mosaic.cells().chunks(mosaic.cols().max(1)).map(row).collect();
        let named = |(i, filter): (usize, &Filter)| (letter(i).to_string(), filter.clone());
        camera.sensor.cfa = CfaDescription {
            pattern: PatternDescription::Letters(pattern),
            filters: self.filters.filters.iter().enumerate().map(named).collect(),
            mixtures: BTreeMap::new(),
        };
        camera
    }

    /// The tile in letters, with rows separated by `/`. `a` is the filter of the shortest wavelengths.
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
    /// Random order of the sets of the family; `None` takes all in their order.
    order: Option<Permutation>,
    /// All sets when there are few of them. Some are slow to compute, and every mosaic needs them again.
    cached_sets: Vec<FilterSet>,
    mosaics: Vec<Mosaic>,
}

impl Group {
    fn len(&self) -> Option<u64> {
        self.sets.checked_mul(self.mosaics.len() as u64)
    }

    fn set(&self, family: &FilterFamily, index: u64) -> Result<FilterSet, DesignError> {
        if let Some(set) = self.cached_sets.get(index as usize) {
            return Ok(set.clone());
        }
        let index = u128::from(index);
        match &self.order {
            // The family refuses a number beyond the order, which is beyond its own sets too.
            Some(order) => family.set(self.colors, order.at(index).unwrap_or(index)),
            None => family.set(self.colors, index),
        }
    }
}

/// The trials of a study. Any trial can be computed from its number alone.
///
/// The number runs fastest over the sets of filters, then over mosaics, numbers of colours, processing and conditions, so that
/// whatever is slowest to prepare changes least often.
#[derive(Debug, Clone)]
pub struct Trials {
    study: Study,
    groups: Vec<Group>,
    /// Number of designs, each of which has one trial under a condition with a processing.
    per_setup: u64,
    count: u64,
}

impl Trials {
    /// Counts the trials and draws the mosaics.
    ///
    /// # Errors
    /// When a key of a family is invalid, more designs are requested than the family has, more mosaics than can be listed, or the
    /// study has no design.
    pub fn new(study: Study) -> Result<Self, DesignError> {
        study.filters.validate()?;
        // All requests are checked before the first list is made, which may take seconds.
        let request = |&colors: &usize| match study.mosaics.request(colors, study.mosaic_count) {
            Err(DesignError::TooFew { available: 0, .. }) => Ok(None),
            request => Ok(Some(request?).filter(|r| r.count > 0)),
        };
        let requests = study.colors.iter().map(request).collect::<Result<Vec<_>, DesignError>>()?;
        let listed = requests.iter().flatten().fold(0u64, |n, r| n.saturating_add(r.count));
        if let Some(limit) = requests.iter().flatten().map(|r| r.limit).min().filter(|limit| listed > *limit)
        {
            return Err(DesignError::TooManyMosaics { wanted: listed, limit });
        }
        let group = |(&colors, request): (&usize, Option<MosaicRequest>)| {
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
            let mosaics = match request {
                Some(request) => study.mosaics.list(colors, request, study.seed)?,
                None => Vec::new(),
            };
            let mut group = Group { colors, sets, order, cached_sets: Vec::new(), mosaics };
            if sets <= MAX_CACHED_SETS {
                group.cached_sets =
                    (0..sets).map(|i| group.set(&study.filters, i)).collect::<Result<_, _>>()?;
            }
            Ok(group)
        };
        let groups = study.colors.iter().zip(requests).map(group).collect::<Result<Vec<_>, DesignError>>()?;
        let too_many = || DesignError::TooManyTrials;
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

    /// The number of trials: of designs times conditions times kinds of processing.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.count
    }

    /// Always `false`, because [`Trials::new`] refuses a study without a design.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// For each number of colours: that number, the number of sets of filters, and the number of mosaics.
    pub fn groups(&self) -> impl Iterator<Item = (usize, u64, usize)> {
        self.groups.iter().map(|g| (g.colors, g.sets, g.mosaics.len()))
    }

    /// The mosaics of all designs, for each number of colours.
    pub fn mosaics(&self) -> impl Iterator<Item = &Mosaic> {
        self.groups.iter().filter(|g| g.sets > 0).flat_map(|g| &g.mosaics)
    }

    /// The setup of a trial, that is its combination of condition and processing, counted from 0.
    #[must_use]
    pub fn setup_of(&self, number: u64) -> u64 {
        number / self.per_setup
    }

    /// Condition index and processing of a setup; `None` beyond the last setup.
    #[must_use]
    pub fn setup(&self, setup: u64) -> Option<(usize, TrialProcessing)> {
        let kinds = self.study.processing.len() as u64;
        let condition = usize::try_from(setup / kinds).ok().filter(|&c| c < self.study.conditions.len())?;
        Some((condition, *self.study.processing.get((setup % kinds) as usize)?))
    }

    /// The condition index of a trial.
    #[must_use]
    pub fn condition_of(&self, number: u64) -> usize {
        (self.setup_of(number) / self.study.processing.len() as u64) as usize
    }

    /// The number of the first trial of the condition after that of `number`.
    #[must_use]
    pub fn end_of_condition(&self, number: u64) -> u64 {
        (self.condition_of(number) as u64 + 1) * self.per_setup * self.study.processing.len() as u64
    }

    /// The trial with a number.
    ///
    /// # Errors
    /// When there is no such trial or a filter is invalid.
    pub fn trial(&self, number: u64) -> Result<Trial, DesignError> {
        let beyond = || DesignError::NoSuchTrial { number, count: self.count };
        if number >= self.count {
            return Err(beyond());
        }
        let (condition, processing) = self.setup(self.setup_of(number)).ok_or_else(beyond)?;
        let mut rest = number % self.per_setup;
        for group in &self.groups {
            let here = group.len().ok_or_else(beyond)?;
            if rest >= here {
                rest -= here;
                continue;
            }
            let (mosaic, set) = (rest / group.sets, rest % group.sets);
            let design = Design {
                filters: group.set(&self.study.filters, set)?,
                mosaic: group.mosaics.get(mosaic as usize).ok_or_else(beyond)?.clone(),
            };
            return Ok(Trial { number, condition, processing, design });
        }
        Err(beyond())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Two conditions, two kinds of processing, and five sets of three and of four filters, each on one mosaic.
    pub(in crate::design) fn study() -> Study {
        let study: Study = serde_json::from_str(
            r#"{
                "name": "small", "seed": 5, "colors": [3, 4], "filter_sets": 5, "mosaic_count": null,
                "filters": {"gaussian_grid": {"centers_nm": [430, 10, 660], "sigmas_nm": [20, 5, 55], "min_spacing_nm": 20}},
                "mosaics": {"given": [["bc", "ab"], ["ab", "cd"]]},
                "conditions": [], "processing": ["classic", "l3"], "metrics": [], "l3": {}
            }"#,
        )
        .unwrap();
        let condition = |luminance_cd_m2| Condition {
            values: vec![("luminance_cd_m2".into(), ConditionValue::Number(luminance_cd_m2))],
            luminance_cd_m2,
            illuminant: Illuminant::D65,
            camera: CameraDescription::default(),
        };
        Study { conditions: vec![condition(10.0), condition(75.0)], ..study }
    }

    /// Every combination is one trial, and what is stated of a number is what its trial has.
    #[test]
    fn numbers_run_over_all_combinations() {
        let trials = Trials::new(study()).unwrap();
        assert!(trials.len() == 2 * 2 * (5 + 5) && !trials.is_empty());
        assert_eq!(trials.groups().collect::<Vec<_>>(), [(3, 5, 1), (4, 5, 1)]);
        assert_eq!(trials.mosaics().count(), 2);
        let all: Vec<Trial> = (0..trials.len()).map(|number| trials.trial(number).unwrap()).collect();
        let mut seen = BTreeSet::new();
        for (number, trial) in all.iter().enumerate() {
            let Trial { condition, processing, design, .. } = trial;
            assert_eq!(trial.number, number as u64);
            assert!(seen.insert((*condition, *processing, design.filters.label.clone(), design.tile())));
            assert_eq!(design.filters.filters.len(), design.mosaic.channels());
            assert_eq!(trials.setup(trials.setup_of(trial.number)), Some((*condition, *processing)));
            assert_eq!(trials.condition_of(trial.number), *condition);
            let end = all.iter().position(|other| other.condition > *condition).unwrap_or(all.len());
            assert_eq!(trials.end_of_condition(trial.number), end as u64);
        }
        // Conditions change least often.
        assert!(all.windows(2).all(|w| w[0].condition <= w[1].condition) && all[39].condition == 1);
        assert_eq!(trials.setup(4), None);
        let beyond = DesignError::NoSuchTrial { number: 40, count: 40 };
        assert_eq!(trials.trial(40), Err(beyond));
    }

    /// A tile in letters is the given one, and the camera with a design has its filters and its mosaic, by the same letters.
    #[test]
    fn letters_name_the_filters_of_a_mosaic() {
        let trials = Trials::new(study()).unwrap();
        let grid = WavelengthGrid::VISIBLE;
        for (number, tile, names) in [(0, "bc/ab", "ABC"), (5, "ab/cd", "ABCD")] {
            let design = trials.trial(number).unwrap().design;
            assert_eq!(design.tile(), tile);
            let cfa = design.cfa(grid).unwrap();
            assert_eq!(cfa.channels().iter().map(|c| &*c.name).collect::<String>(), names);
            let camera = design.camera(&CameraDescription::default());
            let found = crate::camera::Camera::new(camera, grid).unwrap().sensor.cfa;
            // Its channels may be in another order.
            let of_cells = |cfa: &Cfa| -> Vec<Channel> {
                cfa.mosaic().cells().iter().map(|c| cfa.channels()[usize::from(*c)].clone()).collect()
            };
            assert_eq!(of_cells(&found), of_cells(&cfa));
        }
    }
}
