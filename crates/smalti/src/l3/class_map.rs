//! The classes of the pixels of a raw image.

use rayon::prelude::*;

use super::classify::{Classifier, RowClasses};
use super::statistics::{check_size, phase_in};
use super::window::Window;
use super::{Axes, L3Error};
use crate::isp::source::Source;
use crate::sensor::RawImage;

/// Rows that one task classifies.
const TASK_ROWS: usize = 16;

/// The class of every pixel whose patch lies within the image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ClassMap {
    /// First row and first column of these pixels.
    pub(crate) first: usize,
    /// Columns of these pixels.
    pub(crate) cols: usize,
    /// Level × number of textures + texture, row by row, whether a sample of the patch is clipped or not.
    pub(crate) local: Vec<u16>,
    /// Smallest and largest mean response of a patch.
    pub(crate) range: [f32; 2],
}

impl ClassMap {
    /// Classifies a raw image whose mosaic is that of the axes, at any phase.
    ///
    /// # Errors
    /// When mosaic or size do not match the axes.
    pub(crate) fn new(axes: &Axes, raw: &RawImage) -> Result<Self, L3Error> {
        let phase = phase_in(axes.mosaic(), raw.channel_names(), raw)?;
        check_size(axes, raw.rows(), raw.cols())?;
        let (half, tile) = (axes.side() / 2, [axes.mosaic().rows(), axes.mosaic().cols()]);
        let (classifier, cols) = (Classifier::new(axes), raw.cols());
        let inner: Vec<usize> = (half..raw.rows() - half).step_by(TASK_ROWS).collect();
        let of_task = |(window, classes): &mut (Window, RowClasses), first: usize| {
            let rows = TASK_ROWS.min(raw.rows() - half - first);
            window.read(Source::of(raw), first, rows, classifier.margin(), tile);
            let (mut local, mut range) = (Vec::new(), [f32::INFINITY, f32::NEG_INFINITY]);
            for row in 0..rows {
                let down = (phase[0] + first + row) % tile[0];
                classifier.row(window, row, [down, phase[1]], 0..cols, classes);
                for col in half..cols - half {
                    let mean = classes.mean[col];
                    range = [range[0].min(mean), range[1].max(mean)];
                    local.push(classes.local[col] as u16);
                }
            }
            (local, range)
        };
        let parts: Vec<(Vec<u16>, [f32; 2])> =
            inner.into_par_iter().map_init(<(Window, RowClasses)>::default, of_task).collect();
        let range = parts
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |all, (_, r)| [all[0].min(r[0]), all[1].max(r[1])]);
        let local = parts.into_iter().flat_map(|(local, _)| local).collect();
        Ok(Self { first: half, cols: cols - 2 * half, local, range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::{Levels, Pair, Statistics, Textures};
    use crate::numeric::Planes;
    use crate::numeric::philox::Stream;
    use crate::sensor::{Mosaic, RawSamples, Sampling, SignalNoise};

    /// The classes are those that training assigns.
    #[test]
    fn classes_are_those_of_training() {
        let mut random = Stream::new(5, 1, 2);
        let (rows, cols) = (60, 45);
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let volts =
            (0..rows * cols).map(|i| (0.3 + 0.01 * (i % 50) as f64 * random.uniform()) as f32).collect();
        let names = ["R", "G", "B"].map(String::from).to_vec();
        let sampling = Sampling::Mosaic(mosaic.clone());
        let raw = RawImage::new(rows, cols, RawSamples::Analog(volts), sampling, names, 0.0, 1.0).unwrap();
        let noise = SignalNoise { constant: 1e-3, ..SignalNoise::default() };
        let axes = Axes::new(mosaic, 5, Levels::logarithmic(8, 0.1, 0.8).unwrap(), noise).unwrap();
        let axes = axes.with_textures(Textures::Oriented);
        let map = ClassMap::new(&axes, &raw).unwrap();
        assert_eq!((map.first, map.cols, map.local.len()), (2, 41, 56 * 41));
        let mut trained = Statistics::new(axes.clone(), vec!["Y".into()], true).unwrap();
        let target = Planes::zeros(rows, cols, 1);
        trained.add(&Pair { raw: &raw, seen: None, target: &target }).unwrap();
        let mut counts = std::collections::BTreeMap::new();
        map.local.iter().for_each(|class| *counts.entry(*class).or_insert(0u64) += 1);
        assert!(counts.len() > 4);
        let textures = axes.textures().count() as u16;
        for (class, count) in counts {
            let of_class = |k: &&crate::l3::ClassKey| k.level * textures + k.texture == class;
            let keys = trained.classes().keys().filter(of_class);
            assert_eq!(keys.map(|k| trained.classes()[k].count()).sum::<u64>(), count, "class {class}");
        }
        let range = trained
            .trained()
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |all, r| [all[0].min(r[0]), all[1].max(r[1])]);
        assert_eq!(map.range, range);
        // A raw image of another mosaic is refused.
        let other = Axes::new(Mosaic::new(1, 2, vec![0, 1]).unwrap(), 5, Levels::new(vec![]).unwrap(), noise);
        assert!(ClassMap::new(&other.unwrap(), &raw).is_err());
    }
}
