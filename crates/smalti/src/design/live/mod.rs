//! Pictures of designs as fast as they are changed, each with the pipeline that is learned for it.
//!
//! The light of the scenes and of the training scene is gathered once, on *bare* pixels: behind a clear lens, without filters, in photons
//! ([`LiveSetup::bare`]). Lens and pixel geometry are those of a [`LiveSetup`]; the transmittance of the lens, quantum
//! efficiency, filters, mosaic, noise, well and exposure are those of each design.

mod improvement;
mod learner;
mod pictures;
mod setup;
mod target_light;
mod targets;

pub use improvement::{
    FoundChannel, LiveFamily, LiveLockError, LiveLocks, live_conditions, live_objective, with_array,
};
pub use learner::{LiveDesign, LiveEffort, LiveLearner};
pub use pictures::{LiveCrop, LivePicture, LivePictures};
pub use setup::{LiveScene, LiveSetup, LiveTraining};
pub use targets::LiveTargetScores;
