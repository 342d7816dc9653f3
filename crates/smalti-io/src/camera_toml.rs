//! Camera files: TOML read strictly, errors shown at their line.

use serde::Deserialize;
use smalti::camera::description::{CameraDescription, TWIN_KEYS};

use crate::diagnostic::Diagnostic;
use crate::toml_source::{TomlSource, explain};

/// `key=value` from the command line: replaces one key of a camera file.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// Dotted path, such as `sensor.pixel.pitch_um`.
    pub key: String,
    /// A TOML value; what is none is taken as a string.
    pub value: String,
}

impl std::str::FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Ok(Self { key: key.trim().into(), value: value.trim().into() })
            }
            _ => Err(format!("expected KEY=VALUE, such as sensor.pixel.pitch_um=1.4; got '{text}'")),
        }
    }
}

impl Override {
    fn toml_value(&self) -> toml::Value {
        let parsed = toml::from_str::<toml::Table>(&format!("v = {}", self.value));
        let value = parsed.ok().filter(|table| table.len() == 1).and_then(|mut table| table.remove("v"));
        value.unwrap_or_else(|| toml::Value::String(self.value.clone()))
    }

    /// An error about what it sets.
    pub(crate) fn wrong(&self, message: String) -> Diagnostic {
        Diagnostic::new(format!("--set {}={}", self.key, self.value), message)
    }

    /// Sets the key in a document, making tables on the way.
    fn apply(&self, document: &mut toml::Table) {
        let (mut table, mut rest) = (document, self.key.as_str());
        while let Some((part, after)) = rest.split_once('.') {
            let entry = table.entry(part).or_insert_with(|| toml::Value::Table(toml::Table::new()));
            // A value in the way, such as the name of a pattern, gives way to the table that the key asks for.
            if !entry.is_table() {
                *entry = toml::Value::Table(toml::Table::new());
            }
            let toml::Value::Table(inner) = entry else { return };
            (table, rest) = (inner, after);
        }
        // Of keys that exclude each other, the later one holds.
        let twins = TWIN_KEYS.iter().chain(&[["exposure.auto", "exposure.time_ms"]]);
        let others = twins.flat_map(|[a, b]| [(a, b), (b, a)]).filter(|(key, _)| **key == self.key);
        for (_, other) in others.filter_map(|(_, other)| other.rsplit_once('.')) {
            table.remove(other);
        }
        table.insert(rest.into(), self.toml_value());
    }
}

impl TomlSource {
    /// The description in the file, with overrides applied in order. Files that it names are not read yet.
    ///
    /// # Errors
    /// On the first key or value that does not fit: its line, what was expected, the nearest valid key.
    pub fn describe(&self, overrides: &[Override]) -> Result<CameraDescription, Box<Diagnostic>> {
        let study = || "this is the file of a study: smalti sweep takes those".to_owned();
        let description: CameraDescription = self.parse_or_tell(&["colors", "mosaics"], study)?;
        let mut document: toml::Table = self.parse()?;
        if let Some([volts, electrons]) =
            TWIN_KEYS.iter().find(|twins| twins.iter().all(|key| has(&document, key)))
        {
            let message = format!("it and `{volts}` are one quantity; expected one of them");
            return Err(Box::new(self.about_key(electrons, &message)));
        }
        if overrides.is_empty() {
            return Ok(description);
        }
        let is_set = |key: &&str| overrides.iter().any(|o| o.key == *key);
        if let Some([volts, electrons]) = TWIN_KEYS.iter().find(|twins| twins.iter().all(is_set)) {
            let message = format!("{volts} and {electrons} are one quantity; expected one of them");
            return Err(Box::new(Diagnostic::new("--set", message)));
        }
        // All are applied before the result counts: one may need another, as a table's two required keys do. Of a
        // document that is wrong in the end, the override is blamed after which it never was right again.
        let mut result = Ok(description);
        for o in overrides {
            o.apply(&mut document);
            let was_right = result.is_ok();
            result = match (CameraDescription::deserialize(document.clone()), result) {
                (Ok(description), _) => Ok(description),
                (Err(e), Err((blamed, _))) if !was_right => Err((blamed, e)),
                (Err(e), _) => Err((o, e)),
            };
        }
        result.map_err(|(o, e)| {
            let (message, help) = explain(e.message());
            Box::new(Diagnostic { help, ..o.wrong(message) })
        })
    }
}

/// Whether a document has a dotted key.
fn has(document: &toml::Table, key: &str) -> bool {
    let mut parts = key.split('.');
    let first = parts.next().and_then(|part| document.get(part));
    parts.fold(first, |value, part| value?.get(part)).is_some()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn source(text: &str) -> TomlSource {
        TomlSource { name: "camera.toml".into(), folder: PathBuf::new(), text: text.into() }
    }

    #[test]
    fn an_unknown_key_shows_its_line_and_the_nearest_valid_one() {
        let e = source("[sensor.pixel]\npich_um = 2.2\n").describe(&[]).unwrap_err().to_string();
        assert!(
            e.contains("camera.toml:2") && e.contains("pich_um") && e.contains("did you mean `pitch_um`?"),
            "{e}"
        );
    }

    #[test]
    fn a_quantity_without_its_unit_is_that_of_either_key() {
        let e = source("[sensor.pixel]\nread_noise = 2\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains("did you mean `read_noise_mv` or `read_noise_e`?"), "{e}");
    }

    #[test]
    fn a_quantity_is_given_in_volts_or_in_electrons() {
        let both = source("[sensor.pixel]\nread_noise_mv = 0.1\nread_noise_e = 2.0\n");
        let e = both.describe(&[]).unwrap_err().to_string();
        let message = "camera.toml:3:16: `sensor.pixel.read_noise_e`: it and `sensor.pixel.read_noise_mv` are one quantity";
        assert!(e.contains(message), "{e}");
        // An override replaces the quantity in either unit.
        let set = |s: &str| s.parse::<Override>().unwrap();
        let in_volts = source("[sensor.pixel]\nread_noise_mv = 0.1\n");
        let d = in_volts.describe(&[set("sensor.pixel.read_noise_e=2")]).unwrap();
        assert_eq!(d.sensor.pixel.read_noise_e, Some(2.0));
        let in_electrons = source("[sensor]\ndsnu_e = 3.0\n");
        let d = in_electrons.describe(&[set("sensor.dsnu_mv=0.5")]).unwrap();
        assert_eq!((d.sensor.dsnu_e, d.sensor.dsnu_mv), (None, 0.5));
    }

    #[test]
    fn an_override_replaces_one_key_and_is_checked() {
        let set = |s: &str| s.parse::<Override>().unwrap();
        let d = source("name = \"a\"")
            .describe(&[set("sensor.pixel.pitch_um=1.4"), set("sensor.cfa.pattern=rgbw")]);
        assert_eq!(d.unwrap().sensor.pixel.pitch_um, 1.4);
        let e = source("").describe(&[set("sensor.pixel.pich_um=1.4")]).unwrap_err().to_string();
        assert!(e.contains("--set") && e.contains("pitch_um"), "{e}");
        assert!("sensor".parse::<Override>().is_err());
        // Two required keys of one table, the first of them alone is not enough.
        let psf = [set("optics.psf.file=p.npy"), set("optics.psf.spacing_um=1")];
        assert_eq!(source("").describe(&psf).unwrap().optics.psf.unwrap().spacing_um, 1.0);
        let e = source("").describe(&[psf[0].clone(), set("name=x")]).unwrap_err().to_string();
        assert!(e.contains("--set optics.psf.file=p.npy: missing key `spacing_um`"), "{e}");
    }

    #[test]
    fn a_quantity_is_not_set_in_volts_and_in_electrons() {
        let set = |s: &str| s.parse::<Override>().unwrap();
        let both = [set("sensor.pixel.read_noise_mv=1"), set("sensor.pixel.read_noise_e=2")];
        let e = source("").describe(&both).unwrap_err().to_string();
        assert!(e.contains("--set") && e.contains("are one quantity"), "{e}");
        assert!(source("[sensor.pixel]\nread_noise_mv = 1").describe(&both[1..]).is_ok());
    }

    #[test]
    fn of_two_ways_to_expose_the_later_one_holds() {
        let set = |s: &str| s.parse::<Override>().unwrap();
        let text = "[exposure]\ntime_ms = 5\n";
        let d = source(text).describe(&[set("exposure.auto=mean")]).unwrap();
        assert!(d.exposure.time_ms.is_none() && d.exposure.auto.is_some());
        let d = source(text).describe(&[set("exposure.auto=mean"), set("exposure.time_ms=7")]).unwrap();
        assert!(d.exposure.time_ms == Some(7.0) && d.exposure.auto.is_none());
    }

    #[test]
    fn a_wrong_type_says_what_was_expected() {
        let e = source("[sensor.cfa]\npattern = 3\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains(":2") && e.contains("the name of a CFA"), "{e}");
        let e = source("[optics]\nf_number = \"wide\"\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains(":2:12: found string \"wide\"; expected a number"), "{e}");
        let e = source("[sensor]\nrows = -4\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains("found integer `-4`; expected a whole number"), "{e}");
        let e = source("sensor = 1\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains("expected a table"), "{e}");
    }

    #[test]
    fn a_value_is_found_by_its_key() {
        let s = source("[sensor]\nrows = 4\n[sensor.pixel]\nfill_factor = 1.5\n");
        let e = s.about_key("sensor.pixel.fill_factor", "1.5 is above 1").to_string();
        assert!(e.contains("camera.toml:4"), "{e}");
    }
}
