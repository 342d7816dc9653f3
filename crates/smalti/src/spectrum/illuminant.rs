//! Light sources as relative spectral power.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::generated::{DAYLIGHT_BASIS, F2, F11, LED_B3};
use super::units::{BOLTZMANN_J_PER_K, LIGHT_M_PER_S, PLANCK_J_S, photons_per_joule};
use super::{Extrapolation, Spectrum, SpectrumError, WavelengthGrid};
use crate::names::nearest;
use crate::numeric::{OutOfRange, require};

/// The CIE named its D illuminants with c₂ = 1.4380e-2 m K; c₂ is 1.4388e-2 since 1968, which moves them up.
const C2_SINCE_1968: f64 = 1.4388 / 1.4380;

/// Every name [`Illuminant::from_name`] takes, besides the forms with a temperature.
const NAMES: [&str; 9] = ["A", "D50", "D55", "D65", "D75", "E", "F2", "F11", "LED"];

/// A light source. Its spectral power is relative; scenes set the luminance.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Illuminant {
    /// CIE standard illuminant A (ISO/CIE 11664-2), a Planckian radiator with c₂ = 1.435e-2 m K at 2848 K.
    A,
    /// Equal energy.
    E,
    /// CIE daylight of a correlated colour temperature, 4000–25000 K.
    Daylight {
        /// Correlated colour temperature, K.
        cct_k: f64,
    },
    /// CIE FL2, cool white fluorescent.
    F2,
    /// CIE FL11, narrow-band fluorescent.
    F11,
    /// CIE LED-B3, phosphor white LED near 4100 K.
    Led,
    /// Planckian radiator.
    Blackbody {
        /// Temperature, K.
        temperature_k: f64,
    },
    /// Measured relative power, energy units.
    Measured {
        /// What it is called.
        name: String,
        /// Relative spectral power.
        power: Spectrum,
    },
}

/// A light that has a name is written by its name. A measured one is written with its samples, since its name alone would not say what was
/// in the file: name, first wavelength, step, values.
impl Serialize for Illuminant {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Measured { name, power } => {
                (name, power.grid().start_nm(), power.grid().step_nm(), power.values()).serialize(to)
            }
            named => named.name().serialize(to),
        }
    }
}

impl<'de> Deserialize<'de> for Illuminant {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "expected the name of a light, or its name, first wavelength, step and samples"
        )]
        enum Form {
            Name(String),
            Measured(String, f64, f64, Vec<f64>),
        }
        let wrong = <D::Error as serde::de::Error>::custom::<SpectrumError>;
        match Form::deserialize(from)? {
            Form::Name(name) => Self::from_name(&name).map_err(wrong),
            Form::Measured(name, start_nm, step_nm, values) => {
                let grid = WavelengthGrid::new(start_nm, step_nm, values.len()).map_err(wrong)?;
                let power = Spectrum::new(grid, values).map_err(wrong)?;
                Ok(Self::Measured { name, power })
            }
        }
    }
}

impl Illuminant {
    /// Daylight of 5003 K, the white of print.
    pub const D50: Self = Self::Daylight { cct_k: 5000.0 * C2_SINCE_1968 };
    /// Daylight of 5503 K.
    pub const D55: Self = Self::Daylight { cct_k: 5500.0 * C2_SINCE_1968 };
    /// Daylight of 6504 K, the white of sRGB.
    pub const D65: Self = Self::Daylight { cct_k: 6500.0 * C2_SINCE_1968 };
    /// Daylight of 7504 K.
    pub const D75: Self = Self::Daylight { cct_k: 7500.0 * C2_SINCE_1968 };

    /// The names that [`Illuminant::from_name`] takes, besides `D:<kelvin>` and `blackbody:<kelvin>`.
    #[must_use]
    pub fn names() -> &'static [&'static str] {
        &NAMES
    }

    /// An illuminant from its name, in any case: one of [`Illuminant::names`], `D:<kelvin>` for CIE daylight or
    /// `blackbody:<kelvin>` for a Planckian radiator. `FL2`, `FL11` and `LED-B3` are accepted as well.
    ///
    /// # Errors
    /// When the name is unknown (the error holds the nearest known one), or the temperature is out of range.
    ///
    /// ```
    /// use smalti::spectrum::Illuminant;
    /// assert_eq!(Illuminant::from_name("d65")?, Illuminant::D65);
    /// assert_eq!(Illuminant::from_name("D:5600")?, Illuminant::Daylight { cct_k: 5600.0 });
    /// assert!(Illuminant::from_name("D56").unwrap_err().to_string().contains("D55"));
    /// # Ok::<(), smalti::spectrum::SpectrumError>(())
    /// ```
    pub fn from_name(name: &str) -> Result<Self, SpectrumError> {
        let unknown = || SpectrumError::UnknownName {
            what: "illuminant",
            name: name.to_owned(),
            suggestion: nearest(name, NAMES),
            expected: format!("{}, D:<kelvin>, blackbody:<kelvin>", NAMES.join(", ")),
        };
        let key = name.trim().to_ascii_lowercase();
        if let Some((kind, kelvin)) = key.split_once(':') {
            let kelvin: f64 =
                kelvin.trim().trim_end_matches('k').trim_end().parse().map_err(|_| unknown())?;
            let illuminant = match kind.trim() {
                "d" | "daylight" => Self::Daylight { cct_k: kelvin },
                "blackbody" | "planck" => Self::Blackbody { temperature_k: kelvin },
                _ => return Err(unknown()),
            };
            illuminant.check()?;
            return Ok(illuminant);
        }
        Ok(match key.as_str() {
            "a" => Self::A,
            "d50" => Self::D50,
            "d55" => Self::D55,
            "d65" => Self::D65,
            "d75" => Self::D75,
            "e" => Self::E,
            "f2" | "fl2" => Self::F2,
            "f11" | "fl11" => Self::F11,
            "led" | "led-b3" => Self::Led,
            _ => return Err(unknown()),
        })
    }

    /// A light of a name from its photons; its largest power is 1.
    ///
    /// # Errors
    /// When a value is not finite, or none is above 0.
    pub fn of_photons(name: &str, photons: &Spectrum) -> Result<Self, SpectrumError> {
        let power = photons.map(|nm, v| v / photons_per_joule(nm))?;
        let power = power.scaled(1.0 / power.max())?;
        Ok(Self::Measured { name: name.to_owned(), power })
    }

    /// Its name, in the form that [`Illuminant::from_name`] takes; a measured one has the name it was given.
    #[must_use]
    pub fn name(&self) -> String {
        let fixed = match self {
            Self::A => "A",
            Self::E => "E",
            Self::F2 => "F2",
            Self::F11 => "F11",
            Self::Led => "LED",
            d if *d == Self::D50 => "D50",
            d if *d == Self::D55 => "D55",
            d if *d == Self::D65 => "D65",
            d if *d == Self::D75 => "D75",
            Self::Daylight { cct_k } => return format!("D:{cct_k}"),
            Self::Blackbody { temperature_k } => return format!("blackbody:{temperature_k}"),
            Self::Measured { name, .. } => return name.clone(),
        };
        fixed.to_owned()
    }

    /// Whether the temperature is one the formula is defined for.
    fn check(&self) -> Result<(), OutOfRange> {
        match *self {
            Self::Daylight { cct_k: t } => {
                require((4000.0..=25000.0).contains(&t), "cct_k", t, "4000 to 25000 K for CIE daylight")
            }
            Self::Blackbody { temperature_k: t } => {
                require((100.0..=1e9).contains(&t), "temperature_k", t, "100 to 1e9 K")
            }
            _ => Ok(()),
        }
    }

    /// Relative spectral power per nm, 100 at 560 nm where the source is defined by a formula.
    ///
    /// # Errors
    /// When a temperature is out of range, or tabulated data do not cover the grid.
    pub fn energy(&self, grid: WavelengthGrid) -> Result<Spectrum, SpectrumError> {
        self.check()?;
        let power = match self {
            Self::A => planck_relative(grid, 2848.0, 1.435e-2),
            Self::E => Spectrum::constant(grid, 100.0),
            Self::Daylight { cct_k } => daylight(grid, *cct_k),
            Self::F2 => F2.spectrum(0, grid, Extrapolation::Error),
            Self::F11 => F11.spectrum(0, grid, Extrapolation::Error),
            Self::Led => LED_B3.spectrum(0, grid, Extrapolation::Error),
            Self::Blackbody { temperature_k } => {
                planck_relative(grid, *temperature_k, PLANCK_J_S * LIGHT_M_PER_S / BOLTZMANN_J_PER_K)
            }
            Self::Measured { power, .. } => power.resampled(grid, Extrapolation::Error),
        };
        power.map_err(|problem| problem.of(format!("the illuminant {}", self.name())))
    }

    /// Relative photons per nm: [`Illuminant::energy`] times wavelength, up to a constant.
    ///
    /// # Errors
    /// As [`Illuminant::energy`].
    pub fn photons(&self, grid: WavelengthGrid) -> Result<Spectrum, SpectrumError> {
        self.energy(grid)?.map(|nm, v| v * photons_per_joule(nm))
    }
}

/// Planck's law scaled to 100 at 560 nm.
fn planck_relative(grid: WavelengthGrid, temperature_k: f64, c2_m_k: f64) -> Result<Spectrum, SpectrumError> {
    let exponent = |nm: f64| c2_m_k / (nm * 1e-9 * temperature_k);
    let at_560 = libm::expm1(exponent(560.0));
    Spectrum::from_fn(grid, |nm| 100.0 * (560.0 / nm).powi(5) * (at_560 / libm::expm1(exponent(nm))))
}

/// CIE daylight, CIE 15:2018 section 4.1.2.
fn daylight(grid: WavelengthGrid, cct_k: f64) -> Result<Spectrum, SpectrumError> {
    let t = cct_k;
    let x = if t <= 7000.0 {
        0.244063 + 0.09911e3 / t + 2.9678e6 / (t * t) - 4.6070e9 / (t * t * t)
    } else {
        0.237040 + 0.24748e3 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t)
    };
    let y = -3.000 * x * x + 2.870 * x - 0.275;
    // CIE 15 rounds M1 and M2 to three decimals; the tabulated D65 follows from that.
    let round = |v: f64| (v * 1000.0).round() / 1000.0;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let m1 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
    let m2 = round((0.0300 - 31.4424 * x + 30.0717 * y) / m);
    let s = |i| DAYLIGHT_BASIS.spectrum(i, grid, Extrapolation::Error);
    let (s0, s1, s2) = (s(0)?, s(1)?, s(2)?);
    let values = (0..grid.len()).map(|i| s0.values()[i] + m1 * s1.values()[i] + m2 * s2.values()[i]);
    Spectrum::new(grid, values.map(|v| v.max(0.0)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Observer;
    use crate::spectrum::generated::D65_TABLE;

    fn grid(step_nm: f64) -> WavelengthGrid {
        WavelengthGrid::new(380.0, step_nm, (400.0 / step_nm) as usize + 1).unwrap()
    }

    fn xy(illuminant: &Illuminant, observer: Observer, grid: WavelengthGrid) -> [f64; 2] {
        let [x, y, z] = observer.xyz_from_photons(&illuminant.photons(grid).unwrap()).unwrap();
        [x / (x + y + z), y / (x + y + z)]
    }

    #[test]
    fn the_formula_gives_the_tabulated_d65() {
        let grid = WavelengthGrid::new(300.0, 5.0, 97).unwrap();
        let (formula, table) = (
            Illuminant::D65.energy(grid).unwrap(),
            D65_TABLE.spectrum(0, grid, Extrapolation::Error).unwrap(),
        );
        for ((nm, got), want) in grid.wavelengths_nm().zip(formula.values()).zip(table.values()) {
            // The table's digits go to 1e-4; M₁ and M₂ were rounded in making it, as here.
            assert!((got - want).abs() < 1e-3 * want.max(1.0), "{nm} nm: {got} is not {want}");
        }
    }

    /// White points of the 1931 and 1964 observers: CIE 15:2004, tables T.3 and T.8.1; LED-B3 CIE 15:2018. Those of
    /// the lamps hold in steps of 5 nm, in which their spectra are defined: interpolated lines are not the lines.
    #[test]
    fn white_points_are_the_published_ones() {
        let (two, ten) = (Observer::Cie1931, Observer::Cie1964);
        for (name, observer, x, y) in [
            ("A", two, 0.44758, 0.40745),
            ("D50", two, 0.34567, 0.35851),
            ("D55", two, 0.33243, 0.34744),
            ("D65", two, 0.31272, 0.32903),
            ("D75", two, 0.29903, 0.31488),
            ("E", two, 1.0 / 3.0, 1.0 / 3.0),
            ("F2", two, 0.3721, 0.3751),
            ("F11", two, 0.3805, 0.3769),
            ("LED", two, 0.3756, 0.3723),
            ("A", ten, 0.45117, 0.40594),
            ("D50", ten, 0.34773, 0.35952),
            ("D65", ten, 0.31381, 0.33098),
            ("E", ten, 1.0 / 3.0, 1.0 / 3.0),
        ] {
            let illuminant = Illuminant::from_name(name).unwrap();
            let lamp = ["F2", "F11", "LED"].contains(&name);
            for step_nm in if lamp { vec![5.0] } else { vec![1.0, 5.0] } {
                let got = xy(&illuminant, observer, grid(step_nm));
                assert!(
                    (got[0] - x).abs() < 1e-4 && (got[1] - y).abs() < 1e-4,
                    "{name} {observer:?} {step_nm} nm: {got:?}, not {x}, {y}"
                );
            }
        }
    }

    #[test]
    fn planck_obeys_wien_and_stefan_boltzmann() {
        let wien_m_k = 2.897_771_955e-3;
        for temperature_k in [3000.0, 5772.0, 10_000.0] {
            let body = Illuminant::Blackbody { temperature_k };
            let peak_nm = wien_m_k / temperature_k * 1e9;
            let near = WavelengthGrid::new(peak_nm - 10.0, 1.0, 21).unwrap();
            let power = body.energy(near).unwrap();
            let at = power.values().iter().position(|&v| v == power.max()).unwrap();
            assert_eq!(at, 10, "{temperature_k} K");
        }
        // The relative power is scaled at 560 nm; undone by Planck's law there, the sum follows T⁴.
        let total = |temperature_k: f64| {
            let grid = WavelengthGrid::new(20.0, 20.0, 20_000).unwrap();
            let c2 = PLANCK_J_S * LIGHT_M_PER_S / BOLTZMANN_J_PER_K;
            let at_560 = 1.0 / (c2 / (560e-9 * temperature_k)).exp_m1();
            Illuminant::Blackbody { temperature_k }.energy(grid).unwrap().integral() * at_560
        };
        let exponent = (total(6000.0) / total(3000.0)).log2();
        assert!((exponent - 4.0).abs() < 1e-4, "{exponent}");
    }

    #[test]
    fn names_round_trip() {
        for name in Illuminant::names() {
            assert_eq!(Illuminant::from_name(name).unwrap().name(), *name);
        }
        for name in ["D:5600", "blackbody:3000"] {
            assert_eq!(Illuminant::from_name(name).unwrap().name(), name);
        }
        assert_eq!(
            Illuminant::from_name(" Daylight: 5600 K ").unwrap(),
            Illuminant::Daylight { cct_k: 5600.0 }
        );
        assert_eq!(Illuminant::from_name("fl11").unwrap(), Illuminant::F11);
    }

    #[test]
    fn a_wrong_name_gets_the_nearest_right_one() {
        for (name, expected) in [("D6", "D65"), ("F111", "F11"), ("LEDs", "LED"), ("d 65", "D65")] {
            match Illuminant::from_name(name) {
                Err(SpectrumError::UnknownName { suggestion, .. }) => {
                    assert_eq!(suggestion, Some(expected), "{name}")
                }
                other => panic!("{name}: {other:?}"),
            }
        }
        for name in
            ["", ":", "D:", "D:x", "D:NaN", "D:1e4000", "D:3999", "blackbody:0", "blackbody:-1", "x:5000"]
        {
            assert!(Illuminant::from_name(name).is_err(), "{name}");
        }
        assert!(Illuminant::from_name(&"é".repeat(100_000)).is_err());
    }

    #[test]
    fn daylight_formula_is_continuous_at_7000_k() {
        let at = |cct_k| xy(&Illuminant::Daylight { cct_k }, Observer::Cie1931, grid(5.0));
        let (below, above) = (at(6999.9), at(7000.1));
        assert!((below[0] - above[0]).abs() < 1e-4 && (below[1] - above[1]).abs() < 1e-4);
    }

    #[test]
    fn data_that_do_not_reach_are_an_error() {
        let infrared = WavelengthGrid::new(800.0, 10.0, 20).unwrap();
        for illuminant in [Illuminant::D65, Illuminant::F2, Illuminant::Led] {
            assert!(matches!(illuminant.energy(infrared), Err(SpectrumError::Of { .. })), "{illuminant:?}");
        }
        assert!(Illuminant::A.energy(infrared).is_ok());
    }
}
