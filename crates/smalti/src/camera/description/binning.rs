//! Binning of photodiodes: `sensor.binning`.

use serde::{Deserialize, Deserializer, Serialize};

use crate::sensor::BinningMode;

/// Binning: the mode alone, or with the side of the blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "expected \"charge\", \"digital\", \"none\", or { side = 2, mode = \"charge\" }"
)]
pub enum BinningDescription {
    /// The mode, for the largest blocks of one filter that the tile of the mosaic consists of.
    Mode(BinningMode),
    /// The mode and the side of the blocks.
    Blocks(BinnedBlocks),
}

impl BinningDescription {
    /// The mode.
    #[must_use]
    pub fn mode(self) -> BinningMode {
        match self {
            Self::Mode(mode) | Self::Blocks(BinnedBlocks { mode, .. }) => mode,
        }
    }
}

/// Side of the blocks in photodiodes, 2 to 8, and the mode of their binning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BinnedBlocks {
    /// Photodiodes along each side of a block.
    pub side: usize,
    /// Where their signals are combined.
    pub mode: BinningMode,
}

/// What a file may state: [`BinningDescription`], or the word `none`.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"charge\", \"digital\", \"none\", or { side = 2, mode = \"charge\" }"
)]
enum BinningOrNone {
    Binning(BinningDescription),
    None(NoneWord),
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum NoneWord {
    None,
}

/// Binning, or the word `none`.
pub(super) fn binning_or_none<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<BinningDescription>, D::Error> {
    Ok(match Option::<BinningOrNone>::deserialize(deserializer)? {
        Some(BinningOrNone::Binning(binning)) => Some(binning),
        Some(BinningOrNone::None(NoneWord::None)) | None => None,
    })
}

#[cfg(feature = "schema")]
pub(super) fn binning_or_none_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let binning = generator.subschema_for::<BinningDescription>();
    schemars::json_schema!({ "anyOf": [binning, { "type": "null" }, { "const": "none" }] })
}
