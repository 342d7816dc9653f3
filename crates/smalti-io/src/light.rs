//! Statistics of the light on pixels, `.light`: what [`smalti::design::screen`] scores colour filter arrays with.
//!
//! The files are [safetensors](https://huggingface.co/docs/safetensors) files with a hash over their content, as `.l3` files are. `docs/formats-light.md` lists
//! their tensors.

use std::path::Path;

use serde_json::json;
use smalti::design::light::{COLOR_GROUPS, ClassParts, LightParts, LightStatistics};
use smalti::spectrum::WavelengthGrid;

use crate::container::{Content, Opened};
use crate::error::At;
use crate::{IoError, Limits, file};

const EXPECTED: &str = "statistics of light (.light, a safetensors file)";
const FORMAT: (&str, &str) = ("smalti-light-statistics", "2");

/// Writes statistics so that they read back bit for bit: merging continues as if they had stayed in memory.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(path: &Path, statistics: &LightStatistics) -> Result<(), IoError> {
    content(statistics).write(path)
}

/// The bytes of the file of [`write()`]; `path` is only named in errors.
///
/// # Errors
/// When the statistics have more classes or components than a file may have.
pub fn to_bytes(statistics: &LightStatistics, path: &Path) -> Result<Vec<u8>, IoError> {
    content(statistics).into_bytes(path)
}

fn content(statistics: &LightStatistics) -> Content {
    let parts = statistics.parts();
    let mut content = Content::default();
    content.text("format", FORMAT.0);
    content.text("version", FORMAT.1);
    content.text("settings", json!(parts.settings));
    content.text("grid", json!([parts.grid.start_nm(), parts.grid.step_nm(), parts.grid.len()]));
    content.text("left_out", parts.left_out);
    content.text("white", json!(parts.white));
    content.text("source", &parts.source);
    content.text("scenes", parts.scenes);
    content.text("energy", json!(parts.energy));
    let count = parts.components.len();
    content.tensor("components", &[count, parts.grid.len()], parts.components.iter().flatten().copied());
    content.tensor("analysis", &[count, parts.grid.len()], parts.analysis.iter().flatten().copied());
    content.tensor("xyz", &[count, 3], parts.xyz.iter().flatten().copied());
    content.tensor("white_coefficients", &[count], parts.white_coefficients.iter().copied());
    let classes = &parts.classes;
    let triangle = triangle(statistics.coefficients());
    content.tensor("classes", &[classes.len()], classes.iter().map(|c| c.number as u32));
    content.tensor("sums", &[classes.len(), triangle], classes.iter().flat_map(|c| c.sums.iter().copied()));
    content.tensor("per_white_squared", &[classes.len()], classes.iter().map(|c| c.per_white_squared));
    let colors = classes.iter().flat_map(|c| c.colors.as_flattened().iter().copied());
    content.tensor("colors", &[classes.len(), COLOR_GROUPS, 4], colors);
    content
}

/// Entries on and above the diagonal of the sums.
fn triangle(coefficients: usize) -> usize {
    let size = coefficients.saturating_add(1);
    size.saturating_mul(size.saturating_add(1)) / 2
}

/// Reads statistics.
///
/// # Errors
/// When the file cannot be read, is of another kind or version, is damaged, or its parts do not fit each other.
pub fn read(path: &Path) -> Result<LightStatistics, IoError> {
    from_bytes(&file::read(path, Limits::default().file_bytes)?, path)
}

/// As [`read`], from memory; `path` is only named in errors.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<LightStatistics, IoError> {
    let opened = Opened::new(bytes, path, EXPECTED, (FORMAT.0, &[FORMAT.1]))?;
    let (start_nm, step_nm, samples): (f64, f64, usize) = opened.json("grid")?;
    let grid = WavelengthGrid::new(start_nm, step_nm, samples).at(path)?;
    let (shape, components) = opened.any::<f64>("components", 2)?;
    if shape[1] != grid.len() {
        let expected = format!("{} wavelengths", grid.len());
        return Err(opened.wrong("tensor 'components'", format!("of shape {shape:?}"), expected));
    }
    let rows = |values: &[f64]| values.chunks_exact(grid.len()).map(<[f64]>::to_vec).collect::<Vec<_>>();
    let triples = |values: &[f64]| {
        values.chunks_exact(3).map(|v| std::array::from_fn(|i| v[i])).collect::<Vec<[f64; 3]>>()
    };
    let count = shape[0];
    let analysis: Vec<f64> = opened.shaped("analysis", &shape)?;
    let xyz: Vec<f64> = opened.shaped("xyz", &[count, 3])?;
    let (numbered, numbers) = opened.any::<u32>("classes", 1)?;
    let per_white_squared: Vec<f64> = opened.shaped("per_white_squared", &numbered)?;
    let colors: Vec<f64> = opened.shaped("colors", &[numbered[0], COLOR_GROUPS, 4])?;
    let of_class = |at: usize| {
        let number = |group: usize, i: usize| colors[(at * COLOR_GROUPS + group) * 4 + i];
        std::array::from_fn(|group| std::array::from_fn(|i| number(group, i)))
    };
    let (shape, sums) = opened.any::<f64>("sums", 2)?;
    if shape[0] != numbered[0] || shape[1] == 0 {
        let expected = format!("{} classes", numbered[0]);
        return Err(opened.wrong("tensor 'sums'", format!("of shape {shape:?}"), expected));
    }
    let class = |(at, number): (usize, &u32)| ClassParts {
        number: *number as usize,
        sums: sums[at * shape[1]..(at + 1) * shape[1]].to_vec(),
        per_white_squared: per_white_squared[at],
        colors: of_class(at),
    };
    let parts = LightParts {
        settings: opened.json("settings")?,
        grid,
        components: rows(&components),
        analysis: rows(&analysis),
        left_out: opened.number("left_out")?,
        xyz: triples(&xyz),
        white: opened.json("white")?,
        white_coefficients: opened.shaped("white_coefficients", &[count])?,
        source: opened.text("source")?.to_owned(),
        scenes: opened.number("scenes")?,
        energy: opened.json("energy")?,
        classes: numbers.iter().enumerate().map(class).collect(),
    };
    LightStatistics::from_parts(parts).map_err(Box::new).at(path)
}

#[cfg(test)]
mod tests {
    use smalti::camera::Camera;
    use smalti::design::light::LightSettings;
    use smalti::experiment::{Resources, light_statistics};
    use smalti::spectrum::Illuminant;

    use super::*;

    fn statistics() -> LightStatistics {
        let camera =
            Camera::new(smalti::camera::CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let scene = crate::scenes::load("macbeth?patch=8", &crate::scenes::SceneRequest::default()).unwrap();
        let settings = LightSettings { side: 3, max_components: 4, ..LightSettings::default() };
        light_statistics(&camera, &Illuminant::D65, Some(&[scene]), &settings, Resources::default()).unwrap()
    }

    #[test]
    fn statistics_read_back_bit_for_bit_and_damage_is_noticed() {
        let (dir, statistics) = (tempfile::tempdir().unwrap(), statistics());
        let path = dir.path().join("macbeth.light");
        write(&path, &statistics).unwrap();
        assert_eq!(read(&path).unwrap(), statistics);
        let bytes = std::fs::read(&path).unwrap();
        for at in (0..bytes.len()).step_by(bytes.len() / 97) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(from_bytes(&damaged, &path).is_err(), "byte {at}");
            assert!(from_bytes(&bytes[..at], &path).is_err(), "{at} bytes");
        }
    }

    #[test]
    fn parts_that_do_not_fit_are_named() {
        let parts = statistics().parts();
        let key = |change: &dyn Fn(&mut LightParts)| {
            let mut changed = parts.clone();
            change(&mut changed);
            LightStatistics::from_parts(changed).unwrap_err().to_string()
        };
        assert!(key(&|p| p.settings.side = 4).contains("side"));
        assert!(key(&|p| p.components[0][3] = f64::NAN).contains("components"));
        assert!(key(&|p| p.xyz.truncate(1)).contains("xyz"));
        assert!(key(&|p| p.classes[0].number = 99).contains("class 99"));
        assert!(key(&|p| p.classes[0].sums.truncate(4)).contains("class"));
        assert!(key(&|p| p.classes[0].colors[3][0] = -1.0).contains("class"));
        assert!(key(&|p| p.energy[0] = -1.0).contains("energy"));
    }
}
