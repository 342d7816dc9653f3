//! Files of experiments by the method of constant stimuli.

use serde::Deserialize;

use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, builtin};

static EXPERIMENTS: &[BuiltinFile] =
    &[builtin!("experiments", "bayer-light", "How much light does Bayer need to look like RGBW at 1 cd/m²?")];

/// The most amounts of light.
const MOST_STOPS: usize = 50;

/// The built-in experiments.
#[must_use]
pub fn names() -> &'static [BuiltinFile] {
    EXPERIMENTS
}

/// An experiment that asks how much light one camera needs to look like another.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightExperiment {
    /// Purpose of the experiment, in one sentence.
    #[serde(default)]
    pub about: String,
    /// The camera whose light varies: a name or a file.
    pub varied: String,
    /// The camera that it is compared with: a name or a file.
    pub standard: String,
    /// Mean luminance of the scenes for the standard, cd/m².
    pub luminance_cd_m2: f64,
    /// Light of the varied camera beyond this luminance, stops.
    pub stops: Vec<f64>,
    /// Scenes, built in or files.
    pub scenes: Vec<String>,
    /// Ratings of each observer.
    pub ratings: usize,
}

/// An experiment by its built-in name, or from a TOML file.
///
/// # Errors
/// When there is none of that name, or the file is not one of an experiment: its line and what was expected.
pub fn load(name: &str) -> Result<LightExperiment, Box<Diagnostic>> {
    let source = TomlSource::find("experiment", EXPERIMENTS, name)?;
    let found: LightExperiment = source.parse()?;
    let about = |key: &str, message: &str| Err(Box::new(source.about_key(key, message)));
    if !(found.luminance_cd_m2 > 0.0 && found.luminance_cd_m2.is_finite()) {
        return about("luminance_cd_m2", "expected a number above 0");
    }
    let is_usual = found.stops.iter().all(|s| (-10.0..=10.0).contains(s));
    let is_ascending = found.stops.windows(2).all(|w| w[0] < w[1]);
    if !(2..=MOST_STOPS).contains(&found.stops.len()) || !is_usual || !is_ascending {
        return about("stops", "expected two to fifty ascending numbers from -10 to 10");
    }
    if found.scenes.is_empty() {
        return about("scenes", "expected at least one scene");
    }
    if !(1..=10_000).contains(&found.ratings) {
        return about("ratings", "expected 1 to 10000");
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_experiments_are_valid_and_mistakes_name_their_line() {
        for file in names() {
            let found = load(file.name).unwrap();
            assert_eq!(found.about, file.summary);
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("own.toml");
        let good = names()[0].toml;
        for (from, to, expected) in [
            ("[-1, -0.5", "[1, -0.5", "ascending"),
            ("luminance_cd_m2 = 1", "luminance_cd_m2 = 0", "above 0"),
            ("standard =", "standart =", "standart"),
            ("ratings = 56", "ratings = 0", "1 to 10000"),
        ] {
            std::fs::write(&path, good.replace(from, to)).unwrap();
            let error = load(path.to_str().unwrap()).unwrap_err().to_string();
            assert!(error.contains(expected) && error.contains("own.toml"), "{error}");
        }
        assert!(load("bayer-lihgt").unwrap_err().to_string().contains("did you mean 'bayer-light'?"));
    }
}
