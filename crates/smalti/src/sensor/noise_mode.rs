//! Which noise sources a capture has.

/// The noise sources of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseMode {
    /// None: the signal of light alone on an ideal device, without dark signal and fixed-pattern noise, but
    /// with saturation and quantisation. These are ISETCam's noise-free volts.
    None,
    /// Photon shot noise in addition to [`NoiseMode::None`].
    PhotonOnly,
    /// All noise sources.
    #[default]
    All,
}
