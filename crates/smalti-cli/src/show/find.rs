//! The kind of item that a name stands for.

use std::path::Path;

use anyhow::bail;
use clap::ValueEnum;
use smalti::names::nearest;
use smalti::sensor::{Filter, cfa};
use smalti::spectrum::{Illuminant, WavelengthGrid};
use smalti_io::{cameras, scenes, studies, text};

use super::curve::is_csv;
use crate::resolve::has_extension;

/// The kinds of items, in the order of precedence for a name with several meanings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// A camera, built in or a TOML file
    Camera,
    /// A built-in colour filter array
    Cfa,
    /// A scene, built in or a file
    Scene,
    /// A study, built in or a TOML file
    Study,
    /// An illuminant, built in or a CSV file
    Illuminant,
    /// A filter or another transmittance curve, built in or a CSV file
    Filter,
}

impl Kind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Cfa => "cfa",
            Self::Scene => "scene",
            Self::Study => "study",
            Self::Illuminant => "illuminant",
            Self::Filter => "filter",
        }
    }

    pub(crate) fn with_article(self) -> String {
        match self {
            Self::Cfa => "a CFA".into(),
            Self::Illuminant => "an illuminant".into(),
            other => format!("a {}", other.name()),
        }
    }

    /// The built-in names of this kind.
    fn names(self) -> Vec<&'static str> {
        match self {
            Self::Camera => cameras::names().iter().map(|f| f.name).collect(),
            Self::Cfa => cfa::names()
                .iter()
                .flat_map(|c| [c.name].into_iter().chain(c.aliases.iter().copied()))
                .collect(),
            Self::Scene => scenes::names().map(|(name, _)| name).collect(),
            Self::Study => studies::names().iter().map(|f| f.name).collect(),
            Self::Illuminant => Illuminant::names().to_vec(),
            Self::Filter => cfa::builtin_filters().iter().map(|f| f.name).collect(),
        }
    }

    /// Whether a built-in item of this kind has this name.
    fn has(self, name: &str) -> bool {
        match self {
            Self::Camera | Self::Study => self.names().contains(&name),
            Self::Cfa => cfa::info(name).is_ok(),
            Self::Scene => self.names().contains(&before_parameters(name)),
            Self::Illuminant => Illuminant::from_name(name).is_ok(),
            Self::Filter => Filter::Builtin(name.into()).spectrum(WavelengthGrid::VISIBLE).is_ok(),
        }
    }
}

fn before_parameters(name: &str) -> &str {
    name.split_once('?').map_or(name, |(n, _)| n).trim()
}

/// The kind of a name, and the other kinds that it could mean.
pub(crate) fn kind(name: &str, asked: Option<Kind>) -> anyhow::Result<(Kind, Vec<Kind>)> {
    if let Some(kind) = asked {
        return Ok((kind, Vec::new()));
    }
    if cameras::has_mosaic(name) {
        return Ok((Kind::Camera, Vec::new()));
    }
    let mut kinds: Vec<Kind> = Kind::value_variants().iter().copied().filter(|k| k.has(name)).collect();
    if kinds.is_empty() {
        kinds = of_file(name)?;
    }
    if kinds.is_empty() {
        bail!("{}", unknown(name));
    }
    Ok((kinds.remove(0), kinds))
}

/// The kinds that a file can be, from its name and, for TOML, its text; empty when the name is no file.
fn of_file(name: &str) -> anyhow::Result<Vec<Kind>> {
    let path = Path::new(name);
    if has_extension(path, &["toml"]) {
        let text = text::read_to_string(path)?;
        return Ok(vec![if is_study(&text) { Kind::Study } else { Kind::Camera }]);
    }
    if is_csv(name) {
        return Ok(vec![Kind::Filter, Kind::Illuminant]);
    }
    Ok(if crate::resolve::is_file(name) { vec![Kind::Scene] } else { Vec::new() })
}

/// A study names its camera before all tables; a camera has no such key.
fn is_study(toml: &str) -> bool {
    let top = toml.lines().map(str::trim).take_while(|l| !l.starts_with('['));
    top.filter_map(|l| l.split_once('=')).any(|(key, _)| key.trim().trim_matches('"') == "camera")
}

/// The message about an unknown name, with the nearest known names.
fn unknown(name: &str) -> String {
    let wanted = before_parameters(name);
    let mut names: Vec<&str> =
        Kind::value_variants().iter().filter_map(|k| nearest(wanted, k.names())).collect();
    names.sort_unstable();
    names.dedup();
    let what = |name: &&str| {
        let kinds = Kind::value_variants().iter().filter(|k| k.has(name)).map(|k| k.name());
        format!("{name} ({})", kinds.collect::<Vec<_>>().join(", "))
    };
    let near: Vec<String> = names.iter().map(what).collect();
    let known = "smalti list prints the built-in cameras, cfas, scenes, studies, illuminants and filters";
    let guess = if near.is_empty() { String::new() } else { format!("did you mean {}? ", near.join(", ")) };
    format!("'{name}' is neither built in nor a file; {guess}{known}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found_as_what_it_is() {
        for wanted in Kind::value_variants() {
            for name in wanted.names() {
                let (first, others) = kind(name, None).unwrap();
                assert!(first == *wanted || others.contains(wanted), "{name} is no {}", wanted.name());
            }
        }
        assert_eq!(kind("zone-plate?frequency=0.4", None).unwrap(), (Kind::Scene, vec![]));
        assert_eq!(kind("bayer@quad-bayer", None).unwrap(), (Kind::Camera, vec![]));
        assert_eq!(kind("bayer", Some(Kind::Scene)).unwrap(), (Kind::Scene, vec![]));
    }

    #[test]
    fn studies_are_told_from_cameras() {
        studies::names().iter().for_each(|s| assert!(is_study(s.toml), "{}", s.name));
        cameras::names().iter().for_each(|c| assert!(!is_study(c.toml), "{}", c.name));
    }
}
