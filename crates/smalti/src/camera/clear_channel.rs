//! Light that only clear channels see.
//!
//! A clear (panchromatic) channel such as W of RGBW is subtracted from, or added to, the colour channels when colour is estimated.
//! Light that it alone sees, mostly near infrared without an infrared-cut filter, therefore becomes an error of colour that depends on
//! the reflectance in that range, and that no processing can know.

use super::{Camera, CameraError};
use crate::spectrum::Spectrum;

/// The range in which a channel must transmit to be clear, nm.
const CLEAR_NM: [f64; 2] = [430.0, 640.0];
/// A clear channel transmits at least this share of its maximum in all of [`CLEAR_NM`], and a colour channel sees a wavelength where its
/// transmittance, relative to that of the clear channel, is at least this share of its maximum.
const HALF: f64 = 0.5;
/// Where a clear channel transmits less than this share of its maximum, ratios to it say nothing.
const FAINT: f64 = 0.1;
/// With fewer colour channels a camera does not measure colour.
const LEAST_COLORS: usize = 2;

/// The share of the response of a clear channel from which on it affects colour: [`Camera::unshared_light`] is worth a warning.
pub const NOTABLE_UNSHARED_SHARE: f64 = 0.02;

/// Where the near infrared begins, nm.
const INFRARED_NM: f64 = 700.0;

/// The share of the response of every channel from which on a camera is one for near infrared: [`Camera::infrared_share`] is worth a
/// note.
pub const NOTABLE_INFRARED_SHARE: f64 = 0.02;

/// Light that a clear channel sees at wavelengths beyond those of all colour channels.
#[derive(Debug, Clone, PartialEq)]
pub struct UnsharedLight {
    /// The name of the clear channel.
    pub channel: String,
    /// Its share of the channel's response, 0 to 1.
    pub share: f64,
    /// The part of it at wavelengths above those of the colour channels, 0 to 1.
    pub share_above: f64,
    /// The first and the last wavelength that a colour channel sees, nm.
    pub seen_nm: [f64; 2],
}

impl Camera {
    /// For each clear channel, the light that it sees outside the range of wavelengths of the colour channels, under an illuminant
    /// (photons) as a white object reflects it. Empty for a camera without clear channels or with fewer than two colour channels.
    ///
    /// A channel is clear if its filter transmits at least half of its maximum at all wavelengths from 430 to 640 nm. A colour channel,
    /// which an infrared channel is as well, sees a wavelength if its filter there, divided by the clear one, has at least half of its
    /// largest value.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths of the illuminant.
    pub fn unshared_light(&self, light: &Spectrum) -> Result<Vec<UnsharedLight>, CameraError> {
        let camera = self.on_grid(light.grid())?;
        let responsivities = camera.responsivities()?;
        let channels = camera.sensor.cfa.channels();
        let (clear, colors): (Vec<usize>, Vec<usize>) =
            (0..channels.len()).partition(|&c| is_clear(&channels[c].transmittance));
        if colors.len() < LEAST_COLORS {
            return Ok(Vec::new());
        }
        let nm: Vec<f64> = light.grid().wavelengths_nm().collect();
        let unshared = |&c: &usize| {
            let own = &channels[c].transmittance;
            let seen = |&color: &usize| seen_beside(&channels[color].transmittance, own);
            let range = colors.iter().filter_map(seen).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
            let [first, last] = range.map(|i| nm[i]);
            let response = responsivities[c].values().iter().zip(light.values()).map(|(r, l)| r * l);
            let mut parts = [0.0; 3];
            for (value, &nm) in response.zip(&nm) {
                parts[usize::from(nm >= first) + usize::from(nm > last)] += value;
            }
            let [below, between, above] = parts;
            let total = below + between + above;
            (total > 0.0).then(|| UnsharedLight {
                channel: channels[c].name.clone(),
                share: (below + above) / total,
                share_above: above / total,
                seen_nm: [first, last],
            })
        };
        Ok(clear.iter().filter_map(unshared).collect())
    }

    /// The share of the response to a white object that is due to light above 700 nm, under an illuminant (photons): that of the channel
    /// in which it is least. A camera with an infrared-cut filter has almost none.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths of the illuminant.
    pub fn infrared_share(&self, light: &Spectrum) -> Result<f64, CameraError> {
        let (camera, grid) = (self.on_grid(light.grid())?, light.grid());
        let share = |channel: &Spectrum| {
            let parts = channel.values().iter().zip(light.values()).zip(grid.wavelengths_nm());
            let (above, all) = parts.fold((0.0, 0.0), |(above, all), ((r, l), nm)| {
                (if nm > INFRARED_NM { above + r * l } else { above }, all + r * l)
            });
            if all > 0.0 { above / all } else { 0.0 }
        };
        Ok(camera.responsivities()?.iter().map(share).reduce(f64::min).unwrap_or(0.0))
    }
}

/// Whether a filter transmits throughout the visible.
fn is_clear(filter: &Spectrum) -> bool {
    let inside = |nm: f64| (CLEAR_NM[0]..=CLEAR_NM[1]).contains(&nm);
    let visible: Vec<f64> = filter
        .grid()
        .wavelengths_nm()
        .zip(filter.values())
        .filter_map(|(nm, &v)| inside(nm).then_some(v))
        .collect();
    let largest = visible.iter().copied().fold(0.0, f64::max);
    largest > 0.0 && visible.iter().all(|&v| v >= HALF * largest)
}

/// The first and the last sample at which a filter sees light that a clear filter sees.
fn seen_beside(filter: &Spectrum, clear: &Spectrum) -> Option<[usize; 2]> {
    let floor = FAINT * clear.max();
    let ratio = |(&v, &c): (&f64, &f64)| if c > floor { v / c } else { 0.0 };
    let ratios: Vec<f64> = filter.values().iter().zip(clear.values()).map(ratio).collect();
    let largest = ratios.iter().copied().fold(0.0, f64::max);
    let sees = |r: &f64| largest > 0.0 && *r >= HALF * largest;
    Some([ratios.iter().position(sees)?, ratios.iter().rposition(sees)?])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::camera::CameraDescription;
    use crate::camera::description::PatternDescription;
    use crate::sensor::Filter;
    use crate::spectrum::{Illuminant, WavelengthGrid};

    fn camera(pattern: &str, change: impl FnOnce(&mut CameraDescription)) -> Camera {
        let mut d = CameraDescription::default();
        d.sensor.cfa.pattern = PatternDescription::Name(pattern.into());
        change(&mut d);
        Camera::new(d, WavelengthGrid::VISIBLE).unwrap()
    }

    fn under(camera: &Camera, light: &Illuminant, end_nm: f64) -> Vec<UnsharedLight> {
        let grid = WavelengthGrid::new(400.0, 10.0, ((end_nm - 400.0) / 10.0) as usize + 1).unwrap();
        camera.unshared_light(&light.photons(grid).unwrap()).unwrap()
    }

    fn cut(d: &mut CameraDescription) {
        d.optics.ir_cut = Some(Filter::Builtin("hot-mirror".into()));
    }

    #[test]
    fn boxes_have_the_share_that_the_numbers_say() {
        // Equal photons on 400–700 nm, a flat clear channel, and colours from 430 to 670 nm: 25 of 31 samples.
        let c = camera("rgbw", |d| {
            let of = |low_nm, high_nm| Filter::Box { low_nm, high_nm, peak: 0.8 };
            let boxes = [("R", of(575.0, 675.0)), ("G", of(495.0, 575.0)), ("B", of(425.0, 495.0))];
            d.sensor.cfa.filters.extend(boxes.map(|(l, f)| (l.to_owned(), f)));
        });
        let flat = Spectrum::constant(WavelengthGrid::VISIBLE, 1e15).unwrap();
        let [w] = &c.unshared_light(&flat).unwrap()[..] else { panic!("one clear channel") };
        assert_eq!((w.channel.as_str(), w.seen_nm), ("W", [430.0, 670.0]));
        assert!((w.share - 6.0 / 31.0).abs() < 1e-12 && (w.share_above - 3.0 / 31.0).abs() < 1e-12, "{w:?}");
    }

    #[test]
    fn an_infrared_cut_removes_it_under_every_light() {
        for pattern in ["rgbw", "rccb", "kodak", "wang2011"] {
            for light in [Illuminant::D65, Illuminant::A] {
                for end_nm in [700.0, 780.0] {
                    let without = under(&camera(pattern, |_| ()), &light, end_nm);
                    assert!(without[0].share > NOTABLE_UNSHARED_SHARE, "{pattern}: {without:?}");
                    assert!(without[0].share_above > 0.99 * without[0].share, "{pattern}: {without:?}");
                    let with = under(&camera(pattern, cut), &light, end_nm);
                    assert!(with[0].share < NOTABLE_UNSHARED_SHARE / 2.0, "{pattern}: {with:?}");
                }
            }
        }
    }

    #[test]
    fn cameras_without_clear_or_colour_channels_have_none() {
        for pattern in ["bayer", "rgbir", "rgbx", "ryyb", "cygm", "rgbe", "five-band", "rccc", "condat2011"] {
            assert!(under(&camera(pattern, |_| ()), &Illuminant::D65, 700.0).is_empty(), "{pattern}");
        }
        // Pigments that transmit infrared see it as the clear channel does.
        let pigments = camera("rccb", |d| {
            for letter in ["R", "B"] {
                d.sensor.cfa.filters.insert(letter.into(), Filter::Builtin(format!("pigment/{letter}")));
            }
        });
        let seen = under(&pigments, &Illuminant::A, 780.0);
        assert!(seen[0].share < NOTABLE_UNSHARED_SHARE, "{seen:?}");
    }
}
