//! What can be wrong with a family of designs.

use thiserror::Error;

use crate::camera::CameraError;
use crate::sensor::CfaError;

/// What can be wrong with a family of designs, or with what is asked of it.
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
    /// A filter array has 1 to 26 colours: one letter each.
    #[error("{colors} colours; expected 1 to 26")]
    Colors {
        /// Colours that were asked for.
        colors: usize,
    },
    /// There are more designs than 2¹²⁸ − 1.
    #[error("{what} has more than 2^128 designs of {colors} colours, too many to number")]
    Uncountable {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
    },
    /// A design is asked for by a number that it does not have.
    #[error("{what} has {count} designs of {colors} colours; there is no design {index} (counted from 0)")]
    Index {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// The number asked for.
        index: u128,
        /// Designs there are.
        count: u128,
    },
    /// More designs are asked for than there are.
    #[error("{wanted} different mosaics of {colors} colours are asked for, but {what} has only {available}")]
    TooFew {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// Number asked for.
        wanted: u64,
        /// Number there is.
        available: u128,
    },
    /// More mosaics are asked for than one list holds.
    #[error(
        "{wanted} mosaics of {colors} colours of {what} are too many to list; ask for at most {limit} of them"
    )]
    TooMany {
        /// The family.
        what: &'static str,
        /// Colours.
        colors: usize,
        /// Number asked for; where all were, the number there is.
        wanted: u128,
        /// Largest number that is listed.
        limit: u64,
    },
    /// More mosaics of all numbers of colours together are asked for than one study holds.
    #[error(
        "{wanted} mosaics are too many to list; ask for at most {limit} of all numbers of colours together"
    )]
    TooManyMosaics {
        /// Number asked for.
        wanted: u64,
        /// Largest number that is listed.
        limit: u64,
    },
    /// More sets of filters are asked for than there are.
    #[error("{wanted} different sets of {colors} filters are asked for, but the family has only {available}")]
    TooFewSets {
        /// Colours.
        colors: usize,
        /// Number asked for.
        wanted: u64,
        /// Number there is.
        available: u128,
    },
    /// All sets of filters are asked for, and there are more than can be numbered.
    #[error("the family has {available} sets of {colors} filters; ask for a number of them in place of all")]
    TooManySets {
        /// Colours.
        colors: usize,
        /// Number there is.
        available: u128,
    },
    /// Sets of filters times mosaics times conditions are more than 2⁶⁴ − 1.
    #[error("sets of filters times mosaics times conditions are more than 2^64 designs")]
    TooManyDesigns,
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
    /// A design is asked for by a number beyond the last.
    #[error("the study has {count} designs; there is no design {number} (counted from 0)")]
    NoSuchDesign {
        /// The number asked for.
        number: u64,
        /// Designs there are.
        count: u64,
    },
    /// A condition is asked for by a number beyond the last.
    #[error("the study has no condition {index} (counted from 0)")]
    NoSuchCondition {
        /// The number asked for.
        index: usize,
    },
    /// A camera cannot be made, or its targets cannot be imaged.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A filter of the family cannot be made.
    #[error("filter '{name}': {problem}")]
    Filter {
        /// Its name or place.
        name: String,
        /// What is wrong with it.
        problem: CfaError,
    },
    /// A mosaic of the family is impossible.
    #[error(transparent)]
    Cfa(#[from] CfaError),
}

/// What there is of each number of colours, in words.
fn counted(colors: &[usize], sets: &[u64], mosaics: &[u64]) -> String {
    let of = |((colors, sets), mosaics): ((&usize, &u64), &u64)| {
        format!("{colors} colours have {sets} sets of filters and {mosaics} mosaics; ")
    };
    colors.iter().zip(sets).zip(mosaics).map(of).collect()
}

impl DesignError {
    pub(super) fn key(key: impl Into<String>, message: impl ToString) -> Self {
        Self::Key { key: key.into(), message: message.to_string() }
    }
}

/// Colours that a filter array can have: one letter each.
pub(super) fn colors_checked(colors: usize) -> Result<u32, DesignError> {
    match u32::try_from(colors) {
        Ok(n @ 1..=26) => Ok(n),
        _ => Err(DesignError::Colors { colors }),
    }
}
