//! Errors of studies and of families of designs.

use thiserror::Error;

use crate::camera::CameraError;
use crate::sensor::CfaError;

/// An error of a study or of a family of designs.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A key of the family has an impossible value.
    #[error("`{key}`: {message}")]
    Key {
        /// Dotted path of the key below the table of the study that holds the family, such as
        /// `gaussian-grid.centers_nm`.
        key: String,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// A colour filter array has 1 to 26 colours, because each colour has a letter.
    #[error("{colors} colours; expected 1 to 26")]
    Colors {
        /// Requested number of colours.
        colors: usize,
    },
    /// The family has more than 2¹²⁸ − 1 designs.
    #[error("{what} has more than 2^128 designs of {colors} colours, too many to number")]
    Uncountable {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
    },
    /// The family has no design with the requested number.
    #[error("{what} has {count} designs of {colors} colours; there is no design {index} (counted from 0)")]
    Index {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// The requested number.
        index: u128,
        /// Number of designs.
        count: u128,
    },
    /// More mosaics are requested than the family has.
    #[error("{wanted} different mosaics of {colors} colours are requested, but {what} has only {available}")]
    TooFew {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// Requested number.
        wanted: u64,
        /// Number of mosaics of the family.
        available: u128,
    },
    /// More mosaics are requested than can be listed.
    #[error(
        "{wanted} mosaics of {colors} colours of {what} are too many to list; request at most {limit} of them"
    )]
    TooMany {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// Requested number, or the number of mosaics of the family when all are requested.
        wanted: u128,
        /// Largest number that can be listed.
        limit: u64,
    },
    /// More mosaics of all numbers of colours together are requested than one study can list.
    #[error(
        "{wanted} mosaics are too many to list; request at most {limit} of all numbers of colours together"
    )]
    TooManyMosaics {
        /// Requested number.
        wanted: u64,
        /// Largest number that can be listed.
        limit: u64,
    },
    /// More sets of filters are requested than the family has.
    #[error("{wanted} different sets of {colors} filters are requested, but the family has only {available}")]
    TooFewSets {
        /// Colours.
        colors: usize,
        /// Requested number.
        wanted: u64,
        /// Number of sets of the family.
        available: u128,
    },
    /// All sets of filters are requested, and there are more than 2⁶⁴ − 1.
    #[error("the family has {available} sets of {colors} filters; request a number of them instead of all")]
    TooManySets {
        /// Colours.
        colors: usize,
        /// Number of sets of the family.
        available: u128,
    },
    /// Sets of filters times mosaics times conditions are more than 2⁶⁴ − 1.
    #[error("the filter sets, mosaics and conditions give more than 2^64 trials")]
    TooManyTrials,
    /// A study has no design.
    #[error(
        "the study has no design: {}expected filters and mosaics for at least one number of colours, and at least one \
         condition and processing",
        counted(colors, sets, mosaics)
    )]
    NoDesign {
        /// Numbers of colours.
        colors: Vec<usize>,
        /// Sets of filters for each.
        sets: Vec<u64>,
        /// Mosaics for each.
        mosaics: Vec<u64>,
    },
    /// The study has no trial with the requested number.
    #[error("the study has {count} trials; there is no trial {number} (counted from 0)")]
    NoSuchTrial {
        /// The requested number.
        number: u64,
        /// Number of trials.
        count: u64,
    },
    /// The study has no condition with the requested index.
    #[error("the study has no condition {index} (counted from 0)")]
    NoSuchCondition {
        /// The requested index.
        index: usize,
    },
    /// Statistics of light differ in what they are of.
    #[error("statistics of light with another {what}; statistics to merge or to use must have the same")]
    OtherLight {
        /// What differs.
        what: &'static str,
    },
    /// The statistics cannot score colour filter arrays.
    #[error("the statistics of light have no class of at least {least} patches; add scenes")]
    TooFewPatches {
        /// Least number of patches of a class.
        least: u64,
    },
    /// The caller stopped the scoring of trials.
    #[error("stopped")]
    Stopped,
    /// A camera is invalid, or its targets cannot be imaged.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A filter of the family is invalid.
    #[error("filter '{name}': {problem}")]
    Filter {
        /// Its name or its position in the family.
        name: String,
        /// What is wrong with it.
        problem: CfaError,
    },
    /// A mosaic of the family is impossible.
    #[error(transparent)]
    Cfa(#[from] CfaError),
}

/// The sets of filters and the mosaics for each number of colours, as text.
fn counted(colors: &[usize], sets: &[u64], mosaics: &[u64]) -> String {
    let of = |((colors, sets), mosaics): ((&usize, &u64), &u64)| {
        format!("{colors} colours have {sets} sets of filters and {mosaics} mosaics; ")
    };
    colors.iter().zip(sets).zip(mosaics).map(of).collect()
}

impl DesignError {
    pub(crate) fn key(key: impl Into<String>, message: impl ToString) -> Self {
        Self::Key { key: key.into(), message: message.to_string() }
    }
}

/// Checks the number of colours of a colour filter array.
pub(super) fn colors_checked(colors: usize) -> Result<u32, DesignError> {
    match u32::try_from(colors) {
        Ok(n @ 1..=26) => Ok(n),
        _ => Err(DesignError::Colors { colors }),
    }
}
