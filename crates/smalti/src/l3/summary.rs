//! Statistics of the learned table, for reports.

use serde_json::{Value, json};

use super::{Class, Origin, Pipeline};

/// Size and occupancy of a pipeline.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Summary {
    /// One entry per position of the mosaic's tile, in row order.
    pub positions: Vec<PositionSummary>,
    /// Classes of the table.
    pub classes: usize,
    /// Classes with training data.
    pub occupied: usize,
    /// Kernels: occupied classes times outputs.
    pub operators: usize,
    /// Training patches.
    pub patches: u64,
}

/// The classes of a position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PositionSummary {
    /// Row of the cell in the tile, from 0.
    pub row: usize,
    /// Column of the cell, from 0.
    pub col: usize,
    /// Name of its channel.
    pub channel: String,
    /// Training patches.
    pub patches: u64,
    /// Classes with training data.
    pub occupied: usize,
    /// Number of classes by origin of their kernels, in the order of [`Origin::ALL`].
    pub by_origin: [usize; Origin::ALL.len()],
}

impl Pipeline {
    /// Statistics of the table.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let mosaic = self.axes().mosaic();
        let each = self.classes().len() / self.axes().positions();
        let position = |(position, classes): (usize, &[Class])| {
            let (row, col) = (position / mosaic.cols(), position % mosaic.cols());
            let channel = self.channel_names()[mosaic.channel_at(row, col)].clone();
            let mut by_origin = [0; Origin::ALL.len()];
            classes.iter().for_each(|class| by_origin[class.origin as usize] += 1);
            let patches = classes.iter().map(|c| c.count).sum();
            let occupied = classes.iter().filter(|c| c.count > 0).count();
            PositionSummary { row, col, channel, patches, occupied, by_origin }
        };
        let positions: Vec<PositionSummary> =
            self.classes().chunks_exact(each.max(1)).enumerate().map(position).collect();
        let occupied = positions.iter().map(|p| p.occupied).sum();
        Summary {
            classes: self.classes().len(),
            occupied,
            operators: occupied * self.outputs().len(),
            patches: positions.iter().map(|p| p.patches).sum(),
            positions,
        }
    }

    /// The names of the channels in a combination of clipped channels, one after the other, or `none`.
    #[must_use]
    pub fn clipped_names(&self, saturation: u32) -> String {
        let clipped = self.channel_names().iter().enumerate().filter(|(c, _)| saturation >> c & 1 == 1);
        if saturation == 0 { "none".into() } else { clipped.map(|(_, name)| name.as_str()).collect() }
    }

    /// A record for each class: position, clipped channels, level, texture, patches, origin of its kernels.
    #[must_use]
    pub fn class_records(&self) -> Vec<Value> {
        let textures = self.axes().textures().names();
        let record = |(i, class): (usize, &Class)| {
            let key = self.key(i);
            json!({
                "position": key.position,
                "clipped": self.clipped_names(key.saturation),
                "level": key.level,
                "texture": textures[usize::from(key.texture)],
                "patches": class.count,
                "origin": class.origin.name(),
            })
        };
        self.classes().iter().enumerate().map(record).collect()
    }
}
