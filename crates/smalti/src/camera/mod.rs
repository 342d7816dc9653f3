//! The whole camera: optics, sensor and processing composed, and its description.

pub mod description;
