//! The kinds of entries, and their keys.

use blake3::{Hash, Hasher};
use smalti::design::SCORES_REVISION;
use smalti::numeric::arithmetic;
use smalti::optics::OPTICAL_IMAGE_REVISION;

/// Revision of the files of the studio. Increase it with every change of their content or format.
const STUDIO_LIGHT_REVISION: u32 = 3;

/// What an entry holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum EntryKind {
    /// The optical image of a scene behind a lens.
    OpticalImage,
    /// Statistics that pipelines are learned from.
    Statistics,
    /// A pipeline of best quality.
    Pipeline,
    /// The scores of a camera.
    Scores,
    /// The light of the scenes of the studio.
    StudioLight,
}

impl EntryKind {
    /// All kinds.
    pub const ALL: [Self; 5] =
        [Self::OpticalImage, Self::Statistics, Self::Pipeline, Self::Scores, Self::StudioLight];

    /// The name of its entries, in the plural.
    #[must_use]
    pub fn plural(self) -> &'static str {
        match self {
            Self::OpticalImage => "optical images",
            Self::Statistics => "training statistics",
            Self::Pipeline => "pipelines",
            Self::Scores => "scores",
            Self::StudioLight => "light for the studio",
        }
    }

    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::OpticalImage => "smalti-oi",
            Self::Statistics => "smalti-l3",
            Self::Pipeline => "smalti-l3-best",
            Self::Scores => "smalti-scores",
            Self::StudioLight => "smalti-studio",
        }
    }

    /// The hash of everything that an entry was computed from. A cache must not outlive a correction.
    pub(super) fn key(self, description: &str) -> Hash {
        let revision = match self {
            Self::OpticalImage => OPTICAL_IMAGE_REVISION,
            Self::Scores => SCORES_REVISION,
            Self::StudioLight => STUDIO_LIGHT_REVISION,
            Self::Statistics | Self::Pipeline => 0,
        };
        hash(&[
            ("kind", self.extension().as_bytes()),
            ("revision", &revision.to_le_bytes()),
            ("version", env!("CARGO_PKG_VERSION").as_bytes()),
            // Machines may share a folder.
            ("arithmetic", arithmetic().as_bytes()),
            ("of", description.as_bytes()),
        ])
    }
}

/// The hash of labelled parts. The lengths of labels and parts are hashed too: `("a", "bc")` and `("ab", "c")` differ.
fn hash(parts: &[(&str, &[u8])]) -> Hash {
    let mut hasher = Hasher::new();
    for part in parts.iter().flat_map(|(label, value)| [label.as_bytes(), value]) {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_and_lengths_are_part_of_the_key() {
        assert_ne!(hash(&[("a", b"bc")]), hash(&[("ab", b"c")]));
        assert_ne!(hash(&[("a", b"b"), ("c", b"d")]), hash(&[("a", b"bcd")]));
        assert_eq!(hash(&[("x", b"y")]), hash(&[("x", b"y")]));
    }
}
