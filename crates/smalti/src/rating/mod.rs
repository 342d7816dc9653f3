//! Scaling of paired comparisons by observers: a scale from their choices, the pair to ask next, psychometric functions, screening of
//! observers and agreement with metrics.
//!
//! Scores are in just-objectionable differences (JOD): of two pictures that differ by 1 JOD, 75 % of the choices prefer the better one
//! ([perezortiz2017]).
//!
//! ```
//! use smalti::rating::{Counts, Model, Penalty, fit};
//! // The second of two pictures was preferred in 75 of 100 comparisons.
//! let mut counts = Counts::new(2);
//! counts.add(1, 0, 75.0);
//! counts.add(0, 1, 25.0);
//! let scale = fit(&counts, Model::ThurstoneCaseV, Penalty::None).unwrap();
//! assert!((scale.scores[1] - scale.scores[0] - 1.0).abs() < 1e-3);
//! ```
//!
//! [perezortiz2017]: https://arxiv.org/abs/1712.03686

mod active;
mod analysis;
mod counts;
mod intervals;
mod model;
mod psychometric;
mod rank;
mod scale;
mod schedule;
mod screening;

pub use active::Posterior;
pub use analysis::{Agreement, ObserverChoices, Reason, ScaledConditions, Scales, Screening, scale, screen};
pub use counts::Counts;
pub use intervals::{IntervalBasis, ObserverResamples, percentiles};
pub use model::{JOD_DEVIATION, Model};
pub(crate) use psychometric::summed;
pub use psychometric::{Level, MAX_LAPSE, Psychometric, PsychometricFit, equality};
pub use rank::{kendall_tau_b, spearman_rho};
pub use scale::{Penalty, Scale, ScaleError, fit, fit_from};
pub use schedule::{Question, Role, Schedule, Shown, Side, Trial};
pub use screening::{Likelihood, OUTLIER_DISTANCE, likelihoods};
