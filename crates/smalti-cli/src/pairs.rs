//! Pairs of a raw file and its target picture.

use std::path::Path;

use serde_json::json;
use smalti::camera::Camera;
use smalti::experiment::{PairAlignment, Progress, RawAndPicture, add_pair};
use smalti::l3::Statistics;
use smalti_io::{Limits, ReadOptions, dng, picture};

/// The alignment of a pair that was added to the statistics.
pub(crate) struct Report {
    raw: String,
    picture: String,
    alignment: PairAlignment,
}

/// Adds a pair of files to the statistics; see [`add_pair`].
pub(crate) fn add(
    statistics: &mut Statistics,
    camera: &Camera,
    [raw, target]: [&Path; 2],
    align: bool,
    progress: &dyn Progress,
) -> anyhow::Result<Report> {
    let dng = dng::read(raw, Limits::default())?;
    for note in &dng.notes {
        progress.note(&format!("{}: {note}", raw.display()));
    }
    let picture = picture::read(target, &ReadOptions::default())?.image;
    let pair = RawAndPicture {
        name: &format!("{} with {}", raw.display(), target.display()),
        raw: &dng.raw,
        default_crop: dng.default_crop.map(|c| (c.rows, c.cols)),
        picture: &picture,
    };
    let alignment = add_pair(statistics, camera, pair, align, progress)?;
    Ok(Report { raw: raw.display().to_string(), picture: target.display().to_string(), alignment })
}

impl Report {
    /// A line of the summary.
    pub(crate) fn line(&self) -> String {
        let Self { raw, picture, alignment: PairAlignment { registration, rows, cols } } = self;
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
            "raw": self.raw,
            "picture": self.picture,
            "rows": self.alignment.rows,
            "cols": self.alignment.cols,
            "alignment": alignment,
        })
    }
}
