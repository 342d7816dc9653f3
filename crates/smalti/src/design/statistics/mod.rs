//! Statistics of the scores of a study: distributions of a metric over the designs of a group, Pareto fronts, and rankings.
//! All are plain functions on columns of numbers.
//!
//! ```
//! use smalti::design::statistics::{Objective, Rule, best_per_group, pareto_front, summarize_groups};
//!
//! let colors = [3, 3, 3, 4, 4, 4];
//! let delta_e = [5.0, 2.0, f64::NAN, 3.0, 1.5, 1.2];
//! let mtf50 = [72.0, 75.0, 60.0, 61.0, 60.0, 50.0];
//!
//! let groups = summarize_groups(&colors, &delta_e, 0.95)?;
//! assert_eq!((groups[0].1.count, groups[0].1.left_out), (2, 1));
//!
//! let front = pareto_front(&[Objective::lower(&delta_e), Objective::higher(&mtf50)])?;
//! assert_eq!((front.rows, front.left_out), (vec![1, 4, 5], 1));
//!
//! let rule = Rule::Keeping { best: Objective::lower(&delta_e), keep: Objective::higher(&mtf50) };
//! assert_eq!(best_per_group(&colors, &rule, 1)?, [(3, vec![1]), (4, vec![4])]);
//! # Ok::<(), smalti::design::statistics::StatisticsError>(())
//! ```

mod distribution;
mod objective;
mod pareto;
mod ranking;
mod summary;

pub use objective::Objective;
pub use pareto::{ParetoFront, pareto_front};
pub use ranking::{Rule, best_per_group};
pub use summary::{Estimate, Summary, quantile_of_sorted, summarize, summarize_groups};

use thiserror::Error;

/// An error of the statistics of a study.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StatisticsError {
    /// The confidence is not a probability.
    #[error("the confidence must lie between 0 and 1, both excluded; got {value}")]
    Confidence {
        /// The confidence.
        value: f64,
    },
    /// Columns of one table differ in length.
    #[error("the columns must have one row per design: {expected} rows in the first, {got} in another")]
    Lengths {
        /// Rows of the first column.
        expected: usize,
        /// Rows of the one that differs.
        got: usize,
    },
    /// A Pareto front or a ranking rule has no objective.
    #[error("no objective given")]
    NoObjective,
    /// A weight is negative or not finite.
    #[error("the weight of objective {index} (counted from 0) must be finite and not negative; got {value}")]
    Weight {
        /// Position of the objective, from 0.
        index: usize,
        /// The weight.
        value: f64,
    },
}
