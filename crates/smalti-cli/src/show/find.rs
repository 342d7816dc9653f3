//! What kind of thing a name is.

use std::path::Path;

use anyhow::bail;
use clap::ValueEnum;
use serde_json::json;
use smalti::names::nearest;
use smalti::scene::catalog;
use smalti::sensor::{Filter, cfa};
use smalti::spectrum::{Illuminant, WavelengthGrid};
use smalti_io::{cameras, studies, text};

use super::{Part, Shown};
use crate::resolve::has_extension;

/// A kind of thing, in the order in which a name that means several is understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Kind {
    /// A camera, built in or a TOML file
    Camera,
    /// A built-in colour filter array
    Cfa,
    /// A scene, built in or a file
    Scene,
    /// A study, built in or a TOML file
    Study,
    /// A light: a name, or a CSV file
    Illuminant,
    /// A filter or another curve of transmittance: a name, or a CSV file
    Filter,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Cfa => "cfa",
            Self::Scene => "scene",
            Self::Study => "study",
            Self::Illuminant => "illuminant",
            Self::Filter => "filter",
        }
    }

    pub(super) fn with_article(self) -> String {
        match self {
            Self::Cfa => "a CFA".into(),
            Self::Illuminant => "an illuminant".into(),
            other => format!("a {}", other.name()),
        }
    }

    /// Names of this kind.
    fn names(self) -> Vec<&'static str> {
        match self {
            Self::Camera => cameras::names().iter().map(|f| f.name).collect(),
            Self::Cfa => cfa::names()
                .iter()
                .flat_map(|c| [c.name].into_iter().chain(c.aliases.iter().copied()))
                .collect(),
            Self::Scene => catalog::names().iter().map(|s| s.name).collect(),
            Self::Study => studies::names().iter().map(|f| f.name).collect(),
            Self::Illuminant => Illuminant::names().to_vec(),
            Self::Filter => cfa::builtin_filters().iter().map(|f| f.name).collect(),
        }
    }

    /// Whether a built-in of this kind has that name.
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

/// What a name is, and what else it could be.
pub(super) fn kind(name: &str, asked: Option<Kind>) -> anyhow::Result<(Kind, Vec<Kind>)> {
    if let Some(kind) = asked {
        return Ok((kind, Vec::new()));
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

/// What a file is, by its name, where that does not say by its text; nothing when it is none.
fn of_file(name: &str) -> anyhow::Result<Vec<Kind>> {
    let path = Path::new(name);
    if has_extension(path, &["toml"]) {
        let text = text::read_to_string(path)?;
        return Ok(vec![if is_study(&text) { Kind::Study } else { Kind::Camera }]);
    }
    // A CSV may name a column after `#`.
    if has_extension(Path::new(name.split('#').next().unwrap_or(name)), &["csv"]) {
        return Ok(vec![Kind::Filter, Kind::Illuminant]);
    }
    Ok(if crate::resolve::is_file(name) { vec![Kind::Scene] } else { Vec::new() })
}

/// A study names its camera before all tables; a camera has no such key.
fn is_study(toml: &str) -> bool {
    let top = toml.lines().map(str::trim).take_while(|l| !l.starts_with('['));
    top.filter_map(|l| l.split_once('=')).any(|(key, _)| key.trim().trim_matches('"') == "camera")
}

/// The nearest names, and what they are.
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
    let known = "smalti list cameras, cfas, scenes, studies, illuminants or filters says what is built in";
    match near.is_empty() {
        true => format!("'{name}' is neither built in nor a file; {known}"),
        false => {
            format!("'{name}' is neither built in nor a file; did you mean {}? {known}", near.join(", "))
        }
    }
}

/// The file of a camera or study, as it stands.
pub(super) fn file(name: &str, built_in: &[smalti_io::BuiltinFile]) -> anyhow::Result<(String, String)> {
    match built_in.iter().find(|f| f.name == name) {
        Some(file) => Ok((file.summary.into(), file.toml.into())),
        None => Ok((String::new(), text::read_to_string(Path::new(name))?)),
    }
}

/// A study is its file, once it is known to be one.
pub(super) fn study(name: &str) -> anyhow::Result<Shown> {
    let (designs, about) = studies::load(name).map_err(|e| anyhow::anyhow!("{e}"))?;
    let (summary, toml) = file(name, studies::names())?;
    let study = designs.study();
    let title = format!("{}: a study of {} designs", study.name, designs.len());
    let next = format!("smalti sweep {name} --dry-run says how long it takes.");
    Ok(Shown {
        title,
        about: vec![if about.is_empty() { summary.clone() } else { about.clone() }, next],
        parts: vec![Part::Lines(toml.clone())],
        json: json!({
            "kind": "study", "name": study.name, "summary": summary, "about": about, "designs": designs.len(), "toml": toml,
        }),
        toml: Some(toml),
    })
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
        assert_eq!(kind("bayer", Some(Kind::Scene)).unwrap(), (Kind::Scene, vec![]));
    }

    #[test]
    fn studies_are_told_from_cameras() {
        studies::names().iter().for_each(|s| assert!(is_study(s.toml), "{}", s.name));
        cameras::names().iter().for_each(|c| assert!(!is_study(c.toml), "{}", c.name));
    }
}
