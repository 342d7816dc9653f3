//! The expected error of a colour filter array in closed form: no scene is simulated.
//!
//! A patch of raw samples is x = A u + n: the coefficients u of the light on its pixels ([`LightStatistics`](super::light::LightStatistics)), the linear map A of the
//! filters at each pixel, and noise n. Within a class of patches with the covariance C of u, the best linear estimate of the colour
//! M u₀ of the middle pixel leaves the error covariance
//!
//! `E = Mᵀ C₀₀ M − Rᵀ (A C Aᵀ + Σ)⁻¹ R`, with `R = A C₀ M`,
//!
//! where Σ is the variance of the noise at the mean light of the class ([kay1993], section 12.5). E depends on the position of the middle pixel in
//! the tile. A pipeline that is learned for the array approximates this estimate, so that figures of E rank arrays as learned
//! pipelines do; their absolute values differ from scores.
//! What the eye sees of the error at the viewing distance of S-CIELAB follows from E and the noise within it.
//!
//! The classes lie in the lanes of vectors: every step serves eight classes at once.
//!
//! [kay1993]: https://doi.org/10.5555/151045

mod color_error;
mod condition;
mod crosstalk;
mod expected;
#[allow(clippy::needless_range_loop)]
mod eye;
mod figures;
// Indices that several arrays share read better than zipped iterators, and become vector code.
#[allow(clippy::needless_range_loop)]
mod gradient;
#[allow(clippy::needless_range_loop)]
mod kernel;
#[allow(clippy::needless_range_loop)]
pub(in crate::design) mod lanes;
mod layout;
mod limits;
mod model;
mod responses;
mod weights;

pub use condition::{ScreenCondition, ScreenTime};
pub use expected::ExpectedError;
pub use figures::Figures;
pub use gradient::Differentiable;
pub use limits::{CausedError, ClassLimits};
pub(crate) use model::MIN_PATCHES;
pub use model::Screen;
pub use responses::FilterResponses;
pub use weights::FigureWeights;
