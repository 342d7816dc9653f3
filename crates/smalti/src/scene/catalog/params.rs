//! Parameters of the built-in scenes: their definitions, and the parsing of their values.

use crate::names::nearest;
use crate::scene::SceneError;
use crate::spectrum::Illuminant;

/// A parameter of a built-in scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParamInfo {
    /// Its name.
    pub name: &'static str,
    /// The default value; empty where the setting decides.
    pub default: &'static str,
    /// The accepted values, in words.
    pub expected: &'static str,
    /// What it means.
    pub doc: &'static str,
    pub(super) kind: Kind,
}

/// The type and range of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Whole { least: u64, most: u64 },
    Number { least: f64, most: f64 },
    Choice(&'static [&'static str]),
    Light,
}

/// A whole number. The range is stated once; the text of the error message derives from it.
macro_rules! whole {
    ($name:literal, $default:literal, $least:literal ..= $most:literal, $doc:literal) => {
        ParamInfo {
            name: $name,
            default: stringify!($default),
            expected: concat!("a whole number from ", $least, " to ", $most),
            doc: $doc,
            kind: Kind::Whole { least: $least, most: $most },
        }
    };
}

/// A number or a fraction such as 7/3. The range is stated once; the text of the error message derives from
/// it.
macro_rules! number {
    ($name:literal, $default:literal, $least:literal ..= $most:literal, $doc:literal) => {
        ParamInfo {
            name: $name,
            default: $default,
            expected: concat!("a number from ", $least, " to ", $most),
            doc: $doc,
            kind: Kind::Number { least: $least, most: $most },
        }
    };
}

/// One of two keywords.
macro_rules! choice {
    ($name:literal, $default:literal, $one:literal or $other:literal, $doc:expr) => {
        ParamInfo {
            name: $name,
            default: $default,
            expected: concat!($one, " or ", $other),
            doc: $doc,
            kind: Kind::Choice(&[$one, $other]),
        }
    };
}

pub(super) use {choice, number, whole};

/// Parameters of every scene, which override the setting.
pub(super) static COMMON: [ParamInfo; 4] = [
    number!("luminance", "", 1e-6..=1e12, "mean luminance, cd/m²"),
    number!("distance", "", 1e-6..=1e12, "distance from the lens, m"),
    number!("fov", "", 1e-6..=170.0, "full horizontal field of view, degrees"),
    ParamInfo {
        name: "illuminant",
        default: "",
        expected: "A, D50, D55, D65, D75, E, F2, F11, LED, a daylight such as D:5600 (4000 to 25000 K), or a radiator such as blackbody:2856 (100 to 1e9 K)",
        doc: "light on the scene",
        kind: Kind::Light,
    },
];

/// The parameter values of one scene, checked against its definitions.
pub(super) struct Args<'a> {
    scene: &'static str,
    own: &'static [ParamInfo],
    given: Vec<(&'static ParamInfo, &'a str)>,
}

impl<'a> Args<'a> {
    /// Parses `name=value` pairs separated by `&` or `,`.
    pub(super) fn parse(
        scene: &'static str,
        own: &'static [ParamInfo],
        text: &'a str,
    ) -> Result<Self, SceneError> {
        let mut args = Self { scene, own, given: Vec::new() };
        for piece in text.split(['&', ',']).filter(|p| !p.trim().is_empty()) {
            let syntax = |expected| SceneError::Syntax { scene, piece: piece.to_owned(), expected };
            let (name, value) = piece.split_once('=').ok_or_else(|| syntax("name=value"))?;
            let (name, value) = (name.trim(), value.trim());
            let Some(info) = args.all().find(|p| p.name == name) else {
                return Err(args.unknown(name));
            };
            if args.given.iter().any(|(p, _)| p.name == name) {
                return Err(syntax("each parameter once"));
            }
            if !info.kind.accepts(value) {
                return Err(args.bad(info.name, value, info.expected));
            }
            args.given.push((info, value));
        }
        Ok(args)
    }

    fn all(&self) -> impl Iterator<Item = &'static ParamInfo> + use<> {
        self.own.iter().chain(&COMMON)
    }

    fn unknown(&self, name: &str) -> SceneError {
        let names: Vec<&'static str> = self.all().map(|p| p.name).collect();
        SceneError::UnknownParameter {
            scene: self.scene,
            name: name.to_owned(),
            suggestion: nearest(name, names.iter().copied()),
            known: names.join(", "),
        }
    }

    fn bad(&self, name: &'static str, value: &str, expected: &'static str) -> SceneError {
        SceneError::BadValue { scene: self.scene, name, value: value.to_owned(), expected }
    }

    /// The text given for a parameter.
    fn given(&self, name: &str) -> Option<&'a str> {
        self.given.iter().find(|(p, _)| p.name == name).map(|(_, value)| *value)
    }

    /// The text given, or the default; empty where the setting decides.
    fn text(&self, name: &'static str) -> Result<&'a str, SceneError> {
        let info = self.all().find(|p| p.name == name).ok_or_else(|| self.unknown(name))?;
        Ok(self.given(name).unwrap_or(info.default))
    }

    /// Whether the parameter is the first of two words, and not the second.
    pub(super) fn is_first_of(&self, name: &'static str, words: [&str; 2]) -> Result<bool, SceneError> {
        let text = self.text(name)?;
        match words.iter().position(|w| *w == text) {
            Some(place) => Ok(place == 0),
            None => Err(self.bad(name, text, "one of its words")),
        }
    }

    /// A whole number.
    pub(super) fn whole(&self, name: &'static str) -> Result<u64, SceneError> {
        let text = self.text(name)?;
        parse_whole(text).ok_or_else(|| self.bad(name, text, "a whole number"))
    }

    /// A whole number of pixels or objects.
    pub(super) fn count(&self, name: &'static str) -> Result<usize, SceneError> {
        let whole = self.whole(name)?;
        usize::try_from(whole).map_err(|_| self.bad(name, &whole.to_string(), "a number of objects"))
    }

    /// A number, if it was given or has a default.
    pub(super) fn number_if(&self, name: &'static str) -> Result<Option<f64>, SceneError> {
        let text = self.text(name)?;
        if text.is_empty() {
            return Ok(None);
        }
        parse_number(text).map(Some).ok_or_else(|| self.bad(name, text, "a number"))
    }

    /// A number with a default.
    pub(super) fn number(&self, name: &'static str) -> Result<f64, SceneError> {
        self.number_if(name)?.ok_or_else(|| self.bad(name, "", "a number"))
    }

    /// The illuminant, if it was given.
    pub(super) fn light(&self) -> Result<Option<Illuminant>, SceneError> {
        Ok(self.given("illuminant").map(Illuminant::from_name).transpose()?)
    }
}

impl Kind {
    fn accepts(self, text: &str) -> bool {
        match self {
            Self::Whole { least, most } => parse_whole(text).is_some_and(|v| (least..=most).contains(&v)),
            Self::Number { least, most } => parse_number(text).is_some_and(|v| v >= least && v <= most),
            Self::Choice(words) => words.contains(&text),
            Self::Light => Illuminant::from_name(text).is_ok(),
        }
    }
}

/// A whole number; the form `1e3` is accepted.
fn parse_whole(text: &str) -> Option<u64> {
    let exact = |v: f64| (v >= 0.0 && v.fract() == 0.0 && v < 9e15).then_some(v as u64);
    text.parse().ok().or_else(|| text.parse().ok().and_then(exact))
}

/// A finite number, or a fraction of two.
fn parse_number(text: &str) -> Option<f64> {
    let one = |t: &str| t.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => one(a)? / one(b)?,
        None => one(text)?,
    };
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    static OWN: [ParamInfo; 3] = [
        whole!("size", 64, 1..=128, "size"),
        number!("slope", "2.5", 0.0..=9.0, "slope"),
        number!("angle", "", 0.0..=9.0, "angle"),
    ];

    #[test]
    fn a_parameter_that_is_not_declared_or_of_another_type_is_an_error() {
        let args = Args::parse("test", &OWN, "size=7").unwrap();
        assert_eq!((args.count("size"), args.number("slope")), (Ok(7), Ok(2.5)));
        assert_eq!((args.number_if("angle"), args.number_if("fov")), (Ok(None), Ok(None)));
        assert_eq!(args.light(), Ok(None));
        let unknown = |e: Option<SceneError>| matches!(e, Some(SceneError::UnknownParameter { .. }));
        assert!(unknown(args.count("rows").err()) && unknown(args.number_if("rows").err()));
        assert!(unknown(args.is_first_of("rows", ["a", "b"]).err()));
        let bad = |e: Option<SceneError>| matches!(e, Some(SceneError::BadValue { .. }));
        assert!(bad(args.whole("slope").err()) && bad(args.number("angle").err()));
        assert!(bad(args.is_first_of("size", ["a", "b"]).err()));
    }

    #[test]
    fn numbers_are_read() {
        assert_eq!(parse_whole("1e3"), Some(1000));
        assert_eq!(parse_whole("18446744073709551615"), Some(u64::MAX));
        assert_eq!(
            [parse_whole("-1"), parse_whole("1.5"), parse_whole("nan"), parse_whole("1e99")],
            [None; 4]
        );
        assert_eq!(parse_number("7/3"), Some(7.0 / 3.0));
        assert_eq!(
            [parse_number("inf"), parse_number("1/0"), parse_number("x"), parse_number("")],
            [None; 4]
        );
    }
}
