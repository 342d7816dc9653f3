//! Pairs of a raw file and its target picture.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;
use smalti::experiment::{PairAlignment, Progress, RawAndPicture, TrainingPair};
use smalti::sensor::SignalNoise;
use smalti_io::dng::Dng;
use smalti_io::{ReadOptions, picture};

use crate::raw_args::RawOptions;

/// The alignment of a pair.
pub(crate) struct Report<'a> {
    raw: &'a Path,
    picture: &'a Path,
    alignment: &'a PairAlignment,
}

/// Noise that differs from the camera's by more than this factor is told.
const NOTABLE_NOISE: f64 = 1.5;
/// The sample at which noise is compared.
const TENTH: f64 = 0.1;

/// A pair of files, which are read when their turn comes. `noise` is that of the camera's samples.
pub(crate) fn pair<'a>(
    [raw, target]: [&'a Path; 2],
    options: &'a RawOptions,
    align: bool,
    noise: SignalNoise,
    progress: &'a dyn Progress,
) -> TrainingPair<'a, anyhow::Error> {
    // A pair is read several times.
    let told = AtomicBool::new(false);
    let read = move || {
        let is_first = !told.swap(true, Ordering::Relaxed);
        let note = |text: &str| {
            if is_first {
                progress.note(text)
            }
        };
        let Dng { raw: image, default_crop, orientation, noise: stated, .. } = options.read(raw, note)?;
        if let Some(text) = stated.and_then(|stated| noise_note(stated, &noise)) {
            note(&format!("{}: {text}", raw.display()));
        }
        let picture = picture::read(target, &ReadOptions::default())?;
        // Some cameras turn the samples of the picture and state no orientation for it, others state that of the raw file.
        let picture = match picture.orientation == orientation {
            true => picture.image,
            false => orientation.inverse().apply(picture.orientation.apply(picture.image)),
        };
        let default_crop = default_crop.map(|c| (c.rows, c.cols));
        Ok(RawAndPicture { raw: image, default_crop, picture })
    };
    let name = format!("{} and {}", raw.display(), target.display());
    TrainingPair { name, align, read: Box::new(read) }
}

/// The noise that a raw file states, variance `per_signal` · x + `constant` of a sample x, where that of the camera differs much.
fn noise_note([per_signal, constant]: [f64; 2], camera: &SignalNoise) -> Option<String> {
    let [stated, own] = [per_signal * TENTH + constant, camera.variance(TENTH)].map(f64::sqrt);
    let differs = !(1.0 / NOTABLE_NOISE..=NOTABLE_NOISE).contains(&(stated / own));
    (per_signal > 0.0 && differs).then(|| {
        format!(
            "NoiseProfile states a standard deviation of {:.2} % of the range at a tenth of it, the camera has {:.2} %. Classes depend on the \
             noise: expected a camera with a full well of {:.0} electrons and a read noise of {:.1} electrons",
            100.0 * stated,
            100.0 * own,
            1.0 / per_signal,
            constant.sqrt() / per_signal,
        )
    })
}

impl<'a> From<(&'a [PathBuf], &'a PairAlignment)> for Report<'a> {
    fn from((files, alignment): (&'a [PathBuf], &'a PairAlignment)) -> Self {
        Self { raw: &files[0], picture: &files[1], alignment }
    }
}

impl Report<'_> {
    /// A line of the summary.
    pub(crate) fn line(&self) -> String {
        let (raw, picture) = (self.raw.display(), self.picture.display());
        let PairAlignment { registration, rows, cols } = self.alignment;
        let Some(r) = registration else {
            return format!("{raw} and {picture}: {rows} × {cols} pixels, not aligned\n");
        };
        let scale = if r.scale == 1.0 { String::new() } else { format!(", scaled by {:.4}", r.scale) };
        let moved = if r.is_identity() { " (left as it is)" } else { "" };
        format!(
            "{raw} and {picture}: {rows} × {cols} pixels, the picture shifted by {:.2} rows and {:.2} columns{scale}{moved}; \
             correlation {:.3}, quadrants within {:.2} pixels\n",
            r.row_shift_px,
            r.col_shift_px,
            r.correlation,
            r.largest_residual_px(),
        )
    }

    pub(crate) fn json(&self) -> serde_json::Value {
        let alignment = self.alignment.registration.as_ref().map(|r| {
            json!({
                "row_shift_px": r.row_shift_px,
                "col_shift_px": r.col_shift_px,
                "scale": r.scale,
                "correlation": r.correlation,
                "quadrant_residuals_px": r.residuals_px,
                "left_as_it_is": r.is_identity(),
            })
        });
        json!({
            "raw": self.raw.display().to_string(),
            "picture": self.picture.display().to_string(),
            "rows": self.alignment.rows,
            "cols": self.alignment.cols,
            "alignment": alignment,
        })
    }
}
