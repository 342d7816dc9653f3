//! Maps of the difference between pictures and the reference.

use smalti::camera::{PictureScores, SceneScores};
use smalti::numeric::Planes;

use super::gallery::{Map, Maps};
use crate::{Rgb, Sheet};

/// Rows of the colour scale below the maps of a sheet.
const RAMP_ROWS: usize = 14;

/// A difference with a value per pixel.
pub(super) struct Difference {
    pub(super) maps: Maps,
    of: fn(&PictureScores) -> &Planes,
    mean: fn(&PictureScores) -> f64,
}

/// All differences, in the order of pages and sheets.
pub(super) const DIFFERENCES: [Difference; 2] = [
    Difference {
        maps: Maps {
            name: "ΔE2000 difference",
            unit: "ΔE00",
            about: "The difference between each pixel and the reference (CIEDE2000). Noise and false colour count fully.",
        },
        of: |s| &s.delta_e_2000_map,
        mean: |s| s.pixel_delta_e_2000_mean,
    },
    Difference {
        maps: Maps {
            name: "S-CIELAB difference",
            unit: "ΔE*ab",
            about: "The difference after the spatial blur of the eye. Detail that is too fine to see, above all noise, has little weight.",
        },
        of: |s| &s.scielab_map,
        mean: |s| s.scielab_mean,
    },
];

impl Difference {
    /// The end of the common scale of the maps of a scene at one luminance: the 95th percentile of their values, rounded up to one
    /// digit.
    pub(super) fn top<'a>(&self, scored: impl Iterator<Item = &'a SceneScores>) -> f64 {
        let finite =
            |s: &'a SceneScores| (self.of)(&s.scores).data().iter().copied().filter(|v| v.is_finite());
        let mut values: Vec<f32> = scored.flat_map(finite).collect();
        if values.is_empty() {
            return 1.0;
        }
        let place = (values.len() - 1) * 19 / 20;
        let (_, value, _) = values.select_nth_unstable_by(place, f32::total_cmp);
        let value = f64::from(*value).max(1.0);
        let step = 10f64.powf(value.log10().floor());
        (value / step).ceil() * step
    }

    /// The map in 256 steps from 0 to `top`.
    pub(super) fn map(&self, scores: &PictureScores, top: f64) -> Map {
        let plane = (self.of)(scores);
        // The nearest step. Where processors have no instruction for it, `round` calls a function.
        let step = |v: &f32| {
            let place = f64::from(*v) / top * 255.0;
            let whole = place as u8;
            whole.saturating_add(u8::from(place - f64::from(whole) >= 0.5))
        };
        let steps = plane.data().iter().map(step).collect();
        Map::Values { width: plane.cols(), height: plane.rows(), steps }
    }
}

/// The maps in a row per name, in the colours of viridis, with the colour scale below.
pub(super) fn sheet(title: String, scored: &[(String, &SceneScores)]) -> Sheet {
    let color = |step: usize| {
        let Rgb(r, g, b) = Rgb::viridis(step as f64 / 255.0);
        [r, g, b]
    };
    let of_steps: [[u8; 3]; 256] = std::array::from_fn(color);
    let colors = |steps: &[u8]| -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * steps.len());
        steps.iter().for_each(|step| bytes.extend_from_slice(&of_steps[usize::from(*step)]));
        bytes
    };
    let tops = DIFFERENCES.each_ref().map(|d| d.top(scored.iter().map(|(_, s)| *s)));
    let mut sheet = Sheet::new(DIFFERENCES.len()).title(title);
    let mut across = 0;
    for (name, s) in scored {
        for (difference, top) in DIFFERENCES.iter().zip(tops) {
            let Map::Values { width, height, steps } = difference.map(&s.scores, top) else { continue };
            let caption = format!(
                "{name}\n{}, mean {:.2} {}",
                difference.maps.name,
                (difference.mean)(&s.scores),
                difference.maps.unit
            );
            across = width;
            sheet = sheet.picture(caption, width, height, &colors(&steps));
        }
    }
    let row: Vec<u8> = (0..across).map(|c| (c * 255 / across.saturating_sub(1).max(1)) as u8).collect();
    for (difference, top) in DIFFERENCES.iter().zip(tops) {
        let caption = format!("0 to {top} {} and more", difference.maps.unit);
        sheet = sheet.picture(caption, across, RAMP_ROWS, &colors(&row.repeat(RAMP_ROWS)));
    }
    sheet
}
