//! Pictures in the page, by scene and luminance. A script shows them in a viewer; without it they stand in rows.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde_json::json;

use crate::page::{DataUri, Markup, el, paragraph};
use crate::pictures::Pixels;

/// How pictures are compressed.
#[derive(Clone, Copy)]
struct Quality {
    /// JPEG quality.
    picture: u8,
    map: u8,
    /// Whether maps have one pixel for four of the camera.
    coarse: bool,
    /// Whether pictures have one pixel for four of the camera.
    halved: bool,
}

/// From the best. The first that fits is used, since noise and false colour must remain visible. Each takes fewer bytes than those
/// before it, except for pictures with almost no content, which fit at any quality.
const QUALITIES: [Quality; 7] = [
    Quality { picture: 90, map: 75, coarse: false, halved: false },
    Quality { picture: 82, map: 75, coarse: false, halved: false },
    Quality { picture: 72, map: 70, coarse: false, halved: false },
    Quality { picture: 60, map: 60, coarse: false, halved: false },
    Quality { picture: 60, map: 60, coarse: true, halved: false },
    Quality { picture: 45, map: 50, coarse: true, halved: false },
    Quality { picture: 60, map: 50, coarse: true, halved: true },
];
/// The largest number of bytes of all pictures. Pictures beyond it at the last quality are left out.
pub(super) const MAX_BYTES: usize = 5_000_000;

/// The picture of a scene by one camera with its processing.
pub(super) struct Shot {
    pub(super) name: String,
    /// Whether it is what the others are compared with, which stays in view beside them.
    pub(super) is_reference: bool,
    /// Its scores, in words.
    pub(super) caption: String,
    pub(super) picture: Pixels,
    /// In the order of the kinds of maps. Empty for the reference.
    pub(super) maps: Vec<Map>,
}

/// A map of the errors of a picture.
pub(super) enum Map {
    /// A value per pixel, 0 to 255 from 0 to the end of the scale. The script gives colours to the values.
    Values { width: usize, height: usize, steps: Vec<u8> },
    /// A picture in sRGB.
    Picture(Pixels),
}

/// All pictures of a scene at one luminance.
pub(super) struct Group {
    pub(super) scene: String,
    pub(super) luminance_cd_m2: f64,
    pub(super) shots: Vec<Shot>,
    /// For each kind of map the value of its brightest colour.
    pub(super) tops: Vec<f64>,
}

/// A kind of map.
pub(super) struct Maps {
    pub(super) name: &'static str,
    /// The unit of its values. Empty where it is a picture.
    pub(super) unit: &'static str,
    /// Its explanation.
    pub(super) about: &'static str,
}

/// The viewer and all pictures. Other parts of the page take `used` bytes of those that pictures may take.
pub(super) fn gallery(groups: &[Group], maps: &[&Maps], used: usize) -> Markup {
    let last = QUALITIES[QUALITIES.len() - 1];
    let most = MAX_BYTES.saturating_sub(used);
    let fitting = first_fitting(&QUALITIES, |of| encode(groups, *of, most));
    let (quality, encoded) = fitting.map_or_else(
        || (last, encode(groups, last, usize::MAX).unwrap_or_default()),
        |(of, encoded)| (*of, encoded),
    );
    let mut left = most;
    let rows = groups.iter().zip(&encoded).map(|(group, shots)| {
        let figures = group.shots.iter().zip(shots).map(|(shot, encoded)| {
            let fits = encoded.bytes() <= left;
            left -= if fits { encoded.bytes() } else { 0 };
            figure(group, shot, encoded, maps, fits)
        });
        let light = group.luminance_cd_m2.to_string();
        el("section")
            .class("shots")
            .attr("data-scene", &group.scene)
            .attr("data-light", &light)
            .attr("data-tops", json!(group.tops).to_string())
            .child(el("h3").child(format!("{}, {light} cd/m²", group.scene)))
            .child(el("div").class("row").children(figures))
    });
    let rows: Markup = rows.collect();
    let kinds: Vec<_> =
        maps.iter().map(|m| json!({"name": m.name, "unit": m.unit, "about": m.about})).collect();
    el("div")
        .id("viewer")
        .child(el("div").class("gallery").attr("data-maps", json!(kinds).to_string()).child(rows))
        .child(paragraph("help", format!(
            "The pictures are JPEG of quality {}, {}. The PNG files in the folder of this page are lossless.",
            quality.picture,
            match (quality.halved, quality.coarse) {
                (true, _) => "with one pixel of a picture for four of the camera, which is their mean",
                (_, true) =>
                    "with one pixel per pixel of the camera, and one pixel of a map for four of them, which is their mean",
                _ => "with one pixel per pixel of the camera",
            }
        )))
        .into()
}

/// The first of several choices of which `made` makes something that fits, by bisection: all those after it fit as well.
fn first_fitting<C, T>(choices: &[C], made: impl Fn(&C) -> Option<T>) -> Option<(&C, T)> {
    let (mut from, mut to, mut found) = (0, choices.len(), None);
    while from < to {
        let middle = (from + to) / 2;
        match made(&choices[middle]) {
            Some(fitting) => (to, found) = (middle, Some((&choices[middle], fitting))),
            None => from = middle + 1,
        }
    }
    found
}

struct Encoded {
    picture: Result<DataUri, String>,
    maps: Vec<Option<DataUri>>,
}

impl Encoded {
    fn bytes(&self) -> usize {
        let all = self.picture.as_ref().ok().into_iter().chain(self.maps.iter().flatten());
        all.map(|u| u.as_str().len()).sum()
    }
}

/// All pictures in their order; `None` where they are larger than allowed.
fn encode(groups: &[Group], quality: Quality, most_bytes: usize) -> Option<Vec<Vec<Encoded>>> {
    let jpeg = |p: &Pixels, of| {
        if !quality.halved {
            return DataUri::jpeg(p.width, p.height, &p.rgb, of);
        }
        let (width, height, rgb) = coarse(p.width, p.height, 3, &p.rgb);
        DataUri::jpeg(width, height, &rgb, of)
    };
    let map = |m: &Map| match m {
        Map::Values { width, height, steps } if quality.coarse => {
            let (width, height, steps) = coarse(*width, *height, 1, steps);
            DataUri::grey_jpeg(width, height, &steps, quality.map).ok()
        }
        Map::Values { width, height, steps } => DataUri::grey_jpeg(*width, *height, steps, quality.map).ok(),
        Map::Picture(pixels) => jpeg(pixels, quality.map).ok(),
    };
    let bytes = AtomicUsize::new(0);
    let shot = |s: &Shot| {
        let picture = jpeg(&s.picture, quality.picture).map_err(|e| e.to_string());
        let encoded = Encoded { picture, maps: s.maps.iter().map(map).collect() };
        let so_far = bytes.fetch_add(encoded.bytes(), Ordering::Relaxed) + encoded.bytes();
        (so_far <= most_bytes).then_some(encoded)
    };
    groups.par_iter().map(|g| g.shots.par_iter().map(shot).collect()).collect()
}

/// Means of two by two pixels of `each` values, and of fewer pixels in an odd last row or column.
fn coarse(width: usize, height: usize, each: usize, steps: &[u8]) -> (usize, usize, Vec<u8>) {
    let (wide, high) = (width.div_ceil(2), height.div_ceil(2));
    let mean = |(row, col, value): (usize, usize, usize)| {
        let rows = (2 * row..height.min(2 * row + 2)).map(|r| r * width);
        let places =
            rows.flat_map(|at| (2 * col..width.min(2 * col + 2)).map(move |c| (at + c) * each + value));
        let of: Vec<u16> = places.filter_map(|p| steps.get(p)).map(|s| u16::from(*s)).collect();
        let count = of.len().max(1) as u16;
        ((of.iter().sum::<u16>() + count / 2) / count) as u8
    };
    let pixels = (0..high).flat_map(|row| (0..wide).map(move |col| (row, col)));
    let values = pixels.flat_map(|(row, col)| (0..each).map(move |value| (row, col, value)));
    (wide, high, values.map(mean).collect())
}

fn figure(group: &Group, shot: &Shot, encoded: &Encoded, kinds: &[&Maps], fits: bool) -> Markup {
    let Pixels { width, height, .. } = shot.picture;
    let what = format!("{} at {} cd/m², {}", group.scene, group.luminance_cd_m2, shot.name);
    let none = |why: &str| paragraph("none", format!("No picture: {why}."));
    let picture = match &encoded.picture {
        Ok(uri) if fits => uri.image(width, height, &what).class("shot").into(),
        Ok(_) => none("the page would be too large; the folder of this page has the picture"),
        Err(why) => none(why),
    };
    let maps = kinds.iter().zip(&encoded.maps).enumerate().filter_map(|(i, (kind, uri))| {
        let what = format!("{}: {what}", kind.name);
        let uri = uri.as_ref().filter(|_| fits)?;
        Some(uri.image(width, height, &what).class("map").attr("data-map", i.to_string()))
    });
    let caption = el("figcaption").child(el("b").child(&shot.name)).child(format!(" {}", shot.caption));
    let figure = el("figure").attr("data-name", &shot.name);
    let figure = if shot.is_reference { figure.class("reference") } else { figure };
    figure.child(picture).children(maps).child(caption).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_choice_that_fits_is_found() {
        for count in 0..9 {
            let choices: Vec<usize> = (0..count).collect();
            for least in 0..=count {
                let found = first_fitting(&choices, |of| (*of >= least).then_some(*of * 10));
                assert_eq!(found, (least < count).then_some((&least, least * 10)));
            }
        }
    }

    #[test]
    fn coarse_maps_hold_the_means() {
        let steps = [0, 10, 20, 30, 41, 50];
        assert_eq!(coarse(3, 2, 1, &steps), (2, 1, vec![20, 35]));
        assert_eq!(coarse(2, 3, 1, &steps), (1, 2, vec![15, 46]));
        assert_eq!(coarse(1, 1, 1, &[255]), (1, 1, vec![255]));
        assert_eq!(coarse(2, 1, 3, &steps), (1, 1, vec![15, 26, 35]));
    }

    /// Noise, which JPEG cannot compress, in more pictures than a usual comparison has.
    #[test]
    fn many_pictures_fit() {
        let (width, height) = (384, 288);
        let noise = |each: usize, seed: u32| -> Vec<u8> {
            let mut state = seed;
            let mut next = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 25) as u8
            };
            (0..width * height * each).map(|_| next()).collect()
        };
        let shot = |i: u32| Shot {
            name: format!("camera {i}"),
            is_reference: false,
            caption: String::new(),
            picture: Pixels { width, height, rgb: noise(3, i) },
            maps: (1..3).map(|m| Map::Values { width, height, steps: noise(1, 100 * m + i) }).collect(),
        };
        let group = |shots: u32| Group {
            scene: "noise".into(),
            luminance_cd_m2: 1.0,
            shots: (0..shots).map(shot).collect(),
            tops: vec![5.0, 2.0],
        };
        const KIND: Maps = Maps { name: "map", unit: "ΔE", about: "" };
        let html = gallery(&[group(33)], &[&KIND, &KIND], 0);
        assert_eq!(html.as_str().matches("class=\"map\"").count(), 66);
        assert!(html.as_str().contains("one pixel of a map for four"));
        assert!(html.as_str().len() < 5_100_000, "{} bytes", html.as_str().len());
        // Other pictures of the page take their share.
        let html = gallery(&[group(33)], &[&KIND, &KIND], 3_500_000);
        assert!(html.as_str().len() < 1_600_000, "{} bytes", html.as_str().len());
        // Too many: pictures become coarse, and some are replaced by a message.
        let html = gallery(&[group(320)], &[&KIND, &KIND], 0);
        assert!(
            html.as_str().contains("one pixel of a picture for four") && html.as_str().contains("No picture")
        );
        assert!(html.as_str().len() < 5_200_000, "{} bytes", html.as_str().len());
    }
}
