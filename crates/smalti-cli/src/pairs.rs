//! Pairs of a raw file and the picture that should come of it, aligned.

use std::path::Path;

use anyhow::Context;
use serde_json::json;
use smalti::camera::Camera;
use smalti::color::ColorSpace;
use smalti::l3::{GOOD_CORRELATION, GOOD_RESIDUAL_PX, Pair, Registration, Statistics};
use smalti::numeric::Planes;
use smalti_io::dng::{self, Dng};
use smalti_io::{Limits, ReadOptions, picture};

use crate::progress::Progress;

/// What was learned from a pair.
pub(crate) struct Report {
    raw: String,
    picture: String,
    /// Where the picture lies on the raw image; `None` where that was not asked.
    registration: Option<Registration>,
    rows: usize,
    cols: usize,
}

/// Adds a pair to the statistics. With `align` the picture may be a crop of the raw image, shifted by a fraction of a
/// pixel or scaled; without, it is taken pixel by pixel.
pub(crate) fn add(
    statistics: &mut Statistics,
    camera: &Camera,
    [raw, target]: [&Path; 2],
    align: bool,
    progress: &Progress,
) -> anyhow::Result<Report> {
    let both = || format!("{} with {}", raw.display(), target.display());
    let names: Vec<String> = camera.sensor.cfa.channels().iter().map(|c| c.name.clone()).collect();
    let dng = dng::read(raw, Limits::default())?;
    for note in &dng.notes {
        progress.note(&format!("{}: {note}", raw.display()));
    }
    let wanted = picture::read(target, &ReadOptions::default())?.image.converted(ColorSpace::Xyz)?;
    let wanted = wanted.planes();
    let scales = scales(&dng, wanted);
    // A raw file may list its channels in another order than the camera does; names tell.
    let image = dng.raw.with_channels(&names);
    let report = |registration, rows, cols| Report {
        raw: raw.display().to_string(),
        picture: target.display().to_string(),
        registration,
        rows,
        cols,
    };
    if !align {
        statistics.add(&Pair { raw: &image, seen: None, target: wanted }).with_context(both)?;
        return Ok(report(None, image.rows(), image.cols()));
    }
    let luminance = Planes::new(wanted.rows(), wanted.cols(), 1, wanted.plane(1).to_vec())?;
    let found = Registration::best(&image, &luminance, &scales).with_context(both)?;
    if found.correlation < GOOD_CORRELATION {
        progress.note(&format!(
            "{}: their correlation is {:.2} only; look whether they are of the same shot",
            both(),
            found.correlation
        ));
    }
    if found.largest_residual_px() > GOOD_RESIDUAL_PX {
        progress.note(&format!(
            "{}: quadrants are off by up to {:.2} pixels; is the picture's distortion corrected?",
            both(),
            found.largest_residual_px()
        ));
    }
    let aligned = found.apply(&image, wanted).with_context(both)?;
    statistics.add(&aligned.pair()).with_context(both)?;
    Ok(report(Some(found), aligned.raw.rows(), aligned.raw.cols()))
}

/// Pixels of the raw image that a pixel of the picture may be: as many, or as their sizes or that of the default crop
/// say.
fn scales(dng: &Dng, picture: &Planes) -> Vec<f64> {
    let whole = (dng.raw.rows(), dng.raw.cols());
    let crop = dng.default_crop.map(|c| (c.rows, c.cols));
    let mut scales = vec![1.0];
    for (rows, cols) in crop.into_iter().chain([whole]) {
        let down = rows as f64 / picture.rows().max(1) as f64;
        let across = cols as f64 / picture.cols().max(1) as f64;
        let scale = if rows > cols { down } else { across };
        let is_new = scales.iter().all(|s| (s / scale - 1.0).abs() > 1e-4);
        if (down / across - 1.0).abs() < 0.01 && is_new && (0.25..=8.0).contains(&scale) {
            scales.push(scale);
        }
    }
    scales
}

impl Report {
    /// A line of the summary.
    pub(crate) fn line(&self) -> String {
        let Self { raw, picture, rows, cols, .. } = self;
        let Some(r) = &self.registration else {
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
        let alignment = self.registration.as_ref().map(|r| {
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
            "rows": self.rows,
            "cols": self.cols,
            "alignment": alignment,
        })
    }
}
