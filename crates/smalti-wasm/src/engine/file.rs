//! What the page loads.

/// The files of the studio.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StudioFile {
    /// The light that pipelines are learned from.
    Training,
    /// The light of a scene.
    Scene,
    /// Statistics of light.
    Statistics,
}
