//! Pairs of a raw file and its target picture.

use std::path::{Path, PathBuf};

use serde_json::json;
use smalti::experiment::{PairAlignment, Progress, RawAndPicture, TrainingPair};
use smalti_io::{Limits, ReadOptions, dng, picture};

/// The alignment of a pair.
pub(crate) struct Report<'a> {
    raw: &'a Path,
    picture: &'a Path,
    alignment: &'a PairAlignment,
}

/// A pair of files, which are read when its turn comes.
pub(crate) fn pair<'a>(
    raw: &'a Path,
    target: &'a Path,
    align: bool,
    progress: &'a dyn Progress,
) -> TrainingPair<'a, anyhow::Error> {
    let read = move || {
        let dng = dng::read(raw, Limits::default())?;
        for note in &dng.notes {
            progress.note(&format!("{}: {note}", raw.display()));
        }
        let picture = picture::read(target, &ReadOptions::default())?.image;
        let default_crop = dng.default_crop.map(|c| (c.rows, c.cols));
        Ok(RawAndPicture { raw: dng.raw, default_crop, picture })
    };
    let name = format!("{} and {}", raw.display(), target.display());
    TrainingPair { name, align, read: Box::new(read) }
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
