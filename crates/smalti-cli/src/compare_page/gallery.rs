//! Pictures in the page, by scene and light: the script makes the viewer of them, and without it they stand in rows.

use rayon::prelude::*;
use smalti::numeric::Planes;
use smalti_report::Rgb;
use smalti_report::page::{DataUri, Markup, el};

use crate::pictures::Pixels;

/// Of JPEG, the best that fits: noise and false colour are what one looks for.
const QUALITIES: [u8; 4] = [90, 82, 72, 60];
/// Most bytes of all pictures at the best quality that fits, and of all at the last.
const MOST_BYTES: usize = 5_000_000;
const MOST_AT_LAST: usize = 40_000_000;
/// Of JPEG for maps: they are smooth.
const MAP_QUALITY: u8 = 75;

/// A plane in the colours of viridis, 0 to `top`.
pub(super) fn map(plane: &Planes, top: f64) -> Pixels {
    let colors: Vec<[u8; 3]> = (0..=255u8)
        .map(|i| {
            let Rgb(r, g, b) = Rgb::viridis(f64::from(i) / 255.0);
            [r, g, b]
        })
        .collect();
    let place = |v: &f32| (f64::from(*v) / top * 255.0).clamp(0.0, 255.0) as usize;
    let rgb = plane.plane(0).iter().flat_map(|v| colors.get(place(v)).copied().unwrap_or([0; 3]));
    Pixels { width: plane.cols(), height: plane.rows(), rgb: rgb.collect() }
}

/// What one camera with its processing makes of a scene.
pub(super) struct Shot {
    pub(super) name: String,
    /// Its figures, in words.
    pub(super) caption: String,
    pub(super) picture: Pixels,
    pub(super) map: Option<Pixels>,
}

/// All pictures of a scene in one light.
pub(super) struct Group {
    pub(super) scene: String,
    pub(super) luminance_cd_m2: f64,
    pub(super) shots: Vec<Shot>,
    /// The value that the brightest colour of the maps stands for.
    pub(super) top: f64,
}

/// What maps show, and the unit of their values.
pub(super) struct Maps {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
}

/// The value below which all but one in twenty of the maps lie, to one digit upwards.
pub(super) fn top<'a>(maps: impl Iterator<Item = &'a Planes>) -> f64 {
    let mut values: Vec<f32> =
        maps.flat_map(|m| m.data().iter().copied().filter(|v| v.is_finite())).collect();
    if values.is_empty() {
        return 1.0;
    }
    let place = (values.len() - 1) * 19 / 20;
    let (_, value, _) = values.select_nth_unstable_by(place, f32::total_cmp);
    let value = f64::from(*value).max(1.0);
    let step = 10f64.powf(value.log10().floor());
    (value / step).ceil() * step
}

/// The place of the viewer, and all pictures.
pub(super) fn gallery(groups: &[Group], maps: &Maps) -> Markup {
    let mut quality = QUALITIES[QUALITIES.len() - 1];
    let mut encoded = Vec::new();
    for of in QUALITIES {
        encoded = encode(groups, of);
        quality = of;
        if encoded.iter().flatten().map(Encoded::bytes).sum::<usize>() <= MOST_BYTES {
            break;
        }
    }
    let mut left = MOST_AT_LAST;
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
            .attr("data-top", group.top.to_string())
            .child(el("h3").child(format!("{}, {light} cd/m²", group.scene)))
            .child(el("div").class("row").children(figures))
    });
    let rows: Markup = rows.collect();
    el("div")
        .id("viewer")
        .child(el("div").class("gallery").attr("data-map", maps.name).attr("data-unit", maps.unit).child(rows))
        .child(el("p").class("help").child(format!(
            "JPEG of quality {quality}, each pixel of the camera one of the picture; the PNG files beside this page lose nothing."
        )))
        .into()
}

struct Encoded {
    picture: Result<DataUri, String>,
    map: Option<DataUri>,
}

impl Encoded {
    fn bytes(&self) -> usize {
        let one = |uri: Option<&DataUri>| uri.map_or(0, |u| u.as_str().len());
        one(self.picture.as_ref().ok()) + one(self.map.as_ref())
    }
}

fn encode(groups: &[Group], quality: u8) -> Vec<Vec<Encoded>> {
    let jpeg = |p: &Pixels, quality| DataUri::jpeg(p.width, p.height, &p.rgb, quality);
    let shot = |s: &Shot| Encoded {
        picture: jpeg(&s.picture, quality).map_err(|e| e.to_string()),
        map: s.map.as_ref().and_then(|m| jpeg(m, MAP_QUALITY.min(quality)).ok()),
    };
    groups.par_iter().map(|g| g.shots.iter().map(shot).collect()).collect()
}

fn figure(group: &Group, shot: &Shot, encoded: &Encoded, maps: &Maps, fits: bool) -> Markup {
    let Pixels { width, height, .. } = shot.picture;
    let what = format!("{} at {} cd/m², {}", group.scene, group.luminance_cd_m2, shot.name);
    let none = |why: &str| Markup::from(el("p").class("none").child(format!("No picture: {why}.")));
    let picture = match &encoded.picture {
        Ok(uri) if fits => uri.image(width, height, &what).class("shot").into(),
        Ok(_) => none("the page would have become too large"),
        Err(why) => none(why),
    };
    let map = encoded.map.as_ref().filter(|_| fits).map(|uri| {
        let what = format!("{}: {what}", maps.name);
        Markup::from(uri.image(width, height, &what).class("map"))
    });
    let caption = el("figcaption").child(el("b").child(&shot.name)).child(format!(" {}", shot.caption));
    el("figure")
        .attr("data-name", &shot.name)
        .child(picture)
        .child(map.unwrap_or_default())
        .child(caption)
        .into()
}
