//! Designs of the page as cameras.

use serde_json::Value;
use smalti::camera::Camera;
use smalti::camera::description::PatternDescription;
use smalti_io::cameras;

use super::error::JobError;

/// The largest side of a tile, as on the page.
const MOST_SIDE: usize = 16;
/// The most pixels of a sensor.
const MOST_PIXELS: usize = 100_000_000;

/// The camera of a design. Curves and point spread functions that are names of files are refused by the library, which opens none.
pub(super) fn camera(design: &Value) -> Result<Camera, JobError> {
    let description = cameras::from_json(design.clone())?;
    let PatternDescription::Letters(rows) = &description.sensor.cfa.pattern else {
        return Err(JobError::Wrong(
            "`sensor.cfa.pattern` is a name; expected the lines of the tile in letters".into(),
        ));
    };
    let is_small = rows.len() <= MOST_SIDE
        && rows.iter().all(|row| row.chars().take(MOST_SIDE + 1).count() <= MOST_SIDE);
    if !is_small {
        return Err(JobError::Wrong(format!(
            "`sensor.cfa.pattern` is larger than {MOST_SIDE} × {MOST_SIDE} cells"
        )));
    }
    let (rows, cols) = (description.sensor.rows, description.sensor.cols);
    if rows.checked_mul(cols).is_none_or(|pixels| pixels > MOST_PIXELS) {
        return Err(JobError::Wrong(format!(
            "a sensor of {rows} × {cols} pixels; expected at most {MOST_PIXELS} pixels in all"
        )));
    }
    let grid = description.grid()?;
    Ok(Camera::new(description, grid)?)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_design_is_read_as_strictly_as_a_camera_file_and_opens_no_file() {
        let filters = |red: Value| json!({"R": red, "G": {"builtin": "green"}, "B": {"flat": 0.5}});
        let cfa = |red: Value| json!({"pattern": ["RG", "GB"], "filters": filters(red)});
        let found = camera(&json!({"name": "a", "sensor": {"cfa": cfa(json!({"flat": 0.3}))}}));
        assert!(found.is_ok(), "{found:?}");
        let wide = "R".repeat(17);
        let error = |design: Value| camera(&design).unwrap_err().to_string();
        let path = cfa(json!({"file": "/etc/passwd"}));
        for (design, expected) in [
            (json!({"sensor": {"cfa": path}}), "/etc/passwd"),
            (json!({"optics": {"psf": {"file": "/etc/passwd"}}}), "psf"),
            (json!({"sensor": {"cfa": {"pattern": "bayer"}}}), "expected the lines of the tile"),
            (json!({"sensor": {"cfa": {"pattern": [wide]}}}), "larger than 16 × 16 cells"),
            (json!({"sensor": {"cfa": {"pattern": ["R"]}, "rows": 1_000_000, "cols": 1_000_000}}), "pixels"),
            (json!({"sensor": {"rows": "many"}}), "rows"),
            (json!({"sensors": {}}), "sensors"),
            (json!([1]), "expected"),
        ] {
            let found = error(design.clone());
            assert!(found.contains(expected), "{design}: {found}");
        }
    }
}
