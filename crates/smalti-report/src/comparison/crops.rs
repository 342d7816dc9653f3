//! The region of each scene with the largest differences: where the errors of the cameras differ most.

use std::borrow::Cow;

use rayon::prelude::*;
use smalti::camera::SceneScores;
use smalti::metrics::patch_means;
use smalti::numeric::{Planes, Rect};

use super::gallery::{Group, Shot};
use super::results::Comparison;
use crate::page::{DataUri, Element, Markup, el, paragraph};
use crate::pictures::Pixels;

/// The side of a crop, pixels.
const SIDE: usize = 96;
/// The largest number of bytes of all crops. Beyond it they are JPEG.
const MAX_BYTES: usize = 1_200_000;
/// JPEG qualities; `None` is PNG. The first that fits is used.
const QUALITIES: [Option<u8>; 3] = [None, Some(92), Some(75)];
/// The largest width of the small picture that shows where a crop lies, pixels.
const OVERVIEW_WIDTH: usize = 220;

/// A window of a scene at one luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    light: usize,
    rect: Rect,
    /// What the means over the window differ by.
    difference: f64,
}

/// The crops of all scenes, and the number of bytes that their pictures take, at most `most`. `groups` are all pictures.
pub(super) fn crops(
    report: &Comparison<'_>,
    groups: &[Group],
    scenes: &[String],
    most: usize,
) -> (Markup, usize) {
    let most = most.min(MAX_BYTES);
    let row = |(scene, name): (usize, &String)| Row::of(report, groups, scene, name);
    let rows: Vec<Row<'_>> = scenes.par_iter().enumerate().filter_map(row).collect();
    let encoded = |quality| -> Vec<Vec<Result<DataUri, String>>> {
        rows.par_iter().map(|row| row.pictures.iter().map(|p| encode(p, quality)).collect()).collect()
    };
    let bytes_of =
        |uris: &[Result<DataUri, String>]| uris.iter().flatten().map(|u| u.as_str().len()).sum::<usize>();
    let total = |all: &[Vec<Result<DataUri, String>>]| all.iter().map(|uris| bytes_of(uris)).sum::<usize>();
    let mut all = Vec::new();
    for quality in QUALITIES {
        all = encoded(quality);
        if total(&all) <= most {
            break;
        }
    }
    let (mut used, mut left_out) = (0, 0);
    let mut out = Markup::new();
    for (row, uris) in rows.iter().zip(&all) {
        // With very many cameras not even the smallest crops of all scenes fit.
        if used > 0 && used + bytes_of(uris) > most {
            left_out += 1;
            continue;
        }
        used += bytes_of(uris);
        out = out.and(row.markup(uris));
    }
    if left_out > 0 {
        let words = format!("The crops of {left_out} more scenes are left out: the page would be too large.");
        out = out.and(paragraph("none", words));
    }
    let several = report.contenders.len() > 1;
    let about = if several {
        "Each crop is the region of a scene, and the luminance, in which the mean S-CIELAB differences of the cameras from the reference are farthest apart, whichever \
         camera has the smaller one. Found automatically; the pixels are enlarged."
    } else {
        "For each scene, the window and the luminance of the largest mean S-CIELAB difference from the reference. Found automatically; \
         the pixels are enlarged."
    };
    (paragraph("help", about).and(out), used)
}

fn encode(pixels: &Pixels, quality: Option<u8>) -> Result<DataUri, String> {
    let Pixels { width, height, rgb } = pixels;
    match quality {
        None => DataUri::png(*width, *height, rgb),
        Some(quality) => DataUri::jpeg(*width, *height, rgb, quality),
    }
    .map_err(|e| e.to_string())
}

/// The crop of a scene: an overview, the reference and the picture of each contender.
struct Row<'a> {
    group: &'a Group,
    window: Window,
    /// Rows and columns of the largest picture. Smaller ones are enlarged to this size, so that a window shows the same part of the
    /// scene in all of them.
    size: (usize, usize),
    /// The overview, then a crop of each picture of the group.
    pictures: Vec<Pixels>,
    /// For each contender the means of ΔE2000 and S-CIELAB over the window.
    means: Vec<[f64; 2]>,
}

impl<'a> Row<'a> {
    /// `None` without a picture.
    fn of(report: &Comparison<'_>, groups: &'a [Group], scene: usize, name: &str) -> Option<Self> {
        let luminances = report.luminances();
        let scored = |light: usize| -> Vec<&SceneScores> {
            report.of_scene(light, scene).map(|(_, s)| &s.scores).collect()
        };
        let size = scored(0).iter().fold((0, 0), |(rows, cols), s| {
            let map = &s.scores.scielab_map;
            (map.rows().max(rows), map.cols().max(cols))
        });
        let window = |light: usize| {
            let scored = scored(light);
            let maps = scored.iter().map(|s| map_of_size(&s.scores.scielab_map, size));
            let (rect, difference) = window_of_largest_range(&maps.collect::<Option<Vec<_>>>()?, size, SIDE)?;
            Some(Window { light, rect, difference })
        };
        // Of equal windows the first.
        let window = (0..luminances.len())
            .filter_map(window)
            .reduce(|best, w| if w.difference > best.difference { w } else { best })?;
        let luminance = luminances.get(window.light)?;
        let group = groups.iter().find(|g| g.scene == name && g.luminance_cd_m2 == *luminance)?;
        let overview = overview(&picture_of_size(&group.shots.first()?.picture, size), window.rect);
        let cut = group.shots.iter().map(|shot| cut(&picture_of_size(&shot.picture, size), window.rect));
        let means = scored(window.light).into_iter().map(|s| {
            [&s.scores.delta_e_2000_map, &s.scores.scielab_map]
                .map(|map| map_of_size(map, size).map_or(f64::NAN, |map| mean_within(&map, window.rect)))
        });
        let means = means.collect();
        Some(Self { group, window, size, pictures: std::iter::once(overview).chain(cut).collect(), means })
    }

    fn markup(&self, uris: &[Result<DataUri, String>]) -> Markup {
        let (Group { scene, luminance_cd_m2, shots, .. }, Rect { row, col, rows, cols }) =
            (self.group, self.window.rect);
        let (all_rows, all_cols) = self.size;
        let mut place = format!(
            "Rows {row} to {}, columns {col} to {} of {all_rows} × {all_cols} pixels, counted from 0.",
            row + rows - 1,
            col + cols - 1,
        );
        if shots.iter().any(|s| (s.picture.height, s.picture.width) != self.size) {
            place += " Pictures with fewer pixels are enlarged to this size by repeating pixels.";
        }
        let picture = |i: usize, class: &str, alternative: &str| -> Markup {
            match (uris.get(i), self.pictures.get(i)) {
                (Some(Ok(uri)), Some(p)) => uri.image(p.width, p.height, alternative).class(class).into(),
                (Some(Err(why)), _) => paragraph("none", format!("No picture: {why}.")),
                _ => Markup::new(),
            }
        };
        let figure = |(i, shot): (usize, &Shot)| -> Element {
            let alternative = format!("Crop of {scene} at {luminance_cd_m2} cd/m², {}", shot.name);
            let mut caption = el("figcaption").child(el("b").child(&shot.name));
            if let Some([delta_e, scielab]) = i.checked_sub(1).and_then(|contender| self.means.get(contender))
            {
                let here = format!("Here: ΔE2000 {delta_e:.2}, S-CIELAB {scielab:.2}.");
                let whole = format!("Whole picture: {}.", shot.caption);
                caption = caption.child(el("br")).child(here).child(el("br")).child(whole);
            }
            let figure = el("figure").child(picture(i + 1, "crop", &alternative)).child(caption);
            if shot.is_reference { figure.class("reference") } else { figure }
        };
        let text = el("div")
            .child(el("h3").child(format!("{scene}, {luminance_cd_m2} cd/m²")))
            .child(paragraph("help", place));
        let overview = picture(0, "overview", &format!("Where the crop lies in {scene}"));
        let share = |at: usize, size: usize, all: usize| {
            format!("{:.4}", (at as f64 + 0.5 * size as f64) / all.max(1) as f64)
        };
        el("section")
            .class("telling")
            .attr("data-scene", scene)
            .attr("data-light", luminance_cd_m2.to_string())
            .attr("data-x", share(col, cols, all_cols))
            .attr("data-y", share(row, rows, all_rows))
            .attr("data-width", format!("{:.4}", cols as f64 / all_cols.max(1) as f64))
            .child(el("div").class("where").child(overview).child(text))
            .child(
                el("div")
                    .class("across")
                    .attr("tabindex", "0")
                    .attr("role", "group")
                    .attr("aria-label", format!("Crops of {scene}"))
                    .children(shots.iter().enumerate().map(figure)),
            )
            .into()
    }
}

/// The pixels of a picture of `before` rows and columns that are nearest to those of a picture of `after` rows and columns of the same
/// scene, row by row.
fn nearest(before: (usize, usize), after: (usize, usize)) -> impl Iterator<Item = usize> {
    // The centre of a pixel lies half a pixel from its edge.
    let place = |at: usize, after: usize, before: usize| (2 * at + 1) * before / (2 * after);
    let row = move |row: usize| place(row, after.0, before.0) * before.1;
    (0..after.0).flat_map(move |r| (0..after.1).map(move |col| row(r) + place(col, after.1, before.1)))
}

/// A map of one plane with as many rows and columns. `None` for an empty map.
fn map_of_size(map: &Planes, size: (usize, usize)) -> Option<Cow<'_, Planes>> {
    let before = (map.rows(), map.cols());
    if before == size {
        return Some(Cow::Borrowed(map));
    }
    let values = nearest(before, size).map(|i| map.data().get(i).copied()).collect::<Option<Vec<_>>>()?;
    Planes::new(size.0, size.1, 1, values).ok().map(Cow::Owned)
}

/// A picture with as many rows and columns.
fn picture_of_size(picture: &Pixels, size: (usize, usize)) -> Cow<'_, Pixels> {
    let before = (picture.height, picture.width);
    if before == size {
        return Cow::Borrowed(picture);
    }
    let pixel = |i: usize| picture.rgb.get(3 * i..3 * i + 3).unwrap_or(&[0; 3]).to_vec();
    let rgb = nearest(before, size).flat_map(pixel).collect();
    Cow::Owned(Pixels { width: size.1, height: size.0, rgb })
}

/// The square window of `side` pixels in which the mean S-CIELAB differences of the contenders from the reference have the largest range, and
/// that range; with one contender, its largest mean. Means over the window count and not differences at pixels, which
/// are mostly those of the noise. Of equal windows the first by rows; windows are as large as a smaller picture. Values that are not finite count as 0.
/// `None` without a map or for empty ones. The maps have the same size.
fn window_of_largest_range(
    maps: &[Cow<'_, Planes>],
    (rows, cols): (usize, usize),
    side: usize,
) -> Option<(Rect, f64)> {
    let (high, wide) = (side.min(rows), side.min(cols));
    if maps.is_empty() || high == 0 || wide == 0 {
        return None;
    }
    // For each map, sums over all pixels above and left of a corner.
    let summed = |map: &Cow<'_, Planes>| {
        let mut sums = vec![0.0f64; (rows + 1) * (cols + 1)];
        for (row, line) in map.data().chunks_exact(cols).take(rows).enumerate() {
            let mut along = 0.0;
            for (col, value) in line.iter().enumerate() {
                along += if value.is_finite() { f64::from(*value) } else { 0.0 };
                sums[(row + 1) * (cols + 1) + col + 1] = sums[row * (cols + 1) + col + 1] + along;
            }
        }
        sums
    };
    let sums: Vec<Vec<f64>> = maps.iter().map(summed).collect();
    let least = if maps.len() == 1 { 0.0 } else { f64::INFINITY };
    let mut best = (Rect { row: 0, col: 0, rows: high, cols: wide }, f64::NEG_INFINITY);
    for row in 0..=rows - high {
        for col in 0..=cols - wide {
            let at = |sums: &[f64], row: usize, col: usize| sums[row * (cols + 1) + col];
            let sum_of = |sums: &Vec<f64>| {
                at(sums, row + high, col + wide) - at(sums, row, col + wide) - at(sums, row + high, col)
                    + at(sums, row, col)
            };
            let (smallest, largest) = sums
                .iter()
                .map(sum_of)
                .fold((least, f64::NEG_INFINITY), |(a, b), sum| (a.min(sum), b.max(sum)));
            // Differences by rounding alone do not move the window.
            if largest - smallest > best.1 + 1e-9 * largest.abs() {
                best = (Rect { row, col, ..best.0 }, largest - smallest);
            }
        }
    }
    Some((best.0, best.1 / (high * wide) as f64))
}

/// The mean of a map over a window.
fn mean_within(map: &Planes, window: Rect) -> f64 {
    // The window lies within the map, which has one plane.
    patch_means(map, &[window]).ok().and_then(|means| means.concat().first().copied()).unwrap_or(f64::NAN)
}

/// The part of a picture within a window.
fn cut(picture: &Pixels, window: Rect) -> Pixels {
    let row = |row: usize| {
        let first = 3 * (row * picture.width + window.col);
        picture.rgb.get(first..first + 3 * window.cols).unwrap_or_default()
    };
    let rgb = (window.row..window.row + window.rows).flat_map(row).copied().collect();
    Pixels { width: window.cols, height: window.rows, rgb }
}

/// A small copy of a picture with a frame around a window.
fn overview(picture: &Pixels, window: Rect) -> Pixels {
    let by = picture.width.div_ceil(OVERVIEW_WIDTH).max(1);
    let (width, height) = (picture.width.div_ceil(by), picture.height.div_ceil(by));
    let mut rgb = Vec::with_capacity(3 * width * height);
    for (row, col) in (0..height).flat_map(|row| (0..width).map(move |col| (row, col))) {
        for channel in 0..3 {
            let rows = (by * row)..picture.height.min(by * (row + 1));
            let places =
                rows.flat_map(|r| (by * col..picture.width.min(by * (col + 1))).map(move |c| (r, c)));
            let (sum, count) = places.fold((0usize, 0usize), |(sum, count), (r, c)| {
                (sum + usize::from(picture.rgb[3 * (r * picture.width + c) + channel]), count + 1)
            });
            rgb.push((sum / count.max(1)) as u8);
        }
    }
    // White within black, visible on any picture.
    for (inset, value) in [(0, 0), (1, 255), (2, 0)] {
        let ends = |first: usize, size: usize, all: usize| {
            (first / by + inset, ((first + size).div_ceil(by).min(all)).saturating_sub(1 + inset))
        };
        let (top, bottom) = ends(window.row, window.rows, height);
        let (left, right) = ends(window.col, window.cols, width);
        let mut paint = |row: usize, col: usize| rgb[3 * (row * width + col)..][..3].fill(value);
        if top < bottom && left < right {
            (left..=right).for_each(|col| [top, bottom].into_iter().for_each(|row| paint(row, col)));
            (top..=bottom).for_each(|row| [left, right].into_iter().for_each(|col| paint(row, col)));
        }
    }
    Pixels { width, height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(rows: usize, cols: usize, value: impl Fn(usize, usize) -> f32) -> Cow<'static, Planes> {
        let value = &value;
        let values = (0..rows).flat_map(|r| (0..cols).map(move |c| value(r, c))).collect();
        Cow::Owned(Planes::new(rows, cols, 1, values).unwrap())
    }

    /// A patch of large differences on a slope of small ones, and a single very bright pixel elsewhere.
    #[test]
    fn the_window_holds_the_largest_differences() {
        let (rows, cols) = (150, 200);
        let value = |row: usize, col: usize| match (row, col) {
            (3, 3) => 500.0,
            (40..72, 110..142) => 2.0,
            // What is not finite counts as nothing.
            (10, 10) => f32::INFINITY,
            (20, 20) => f32::NAN,
            _ => 0.001 * col as f32 / cols as f32,
        };
        let expected = Rect { row: 40, col: 110, rows: 32, cols: 32 };
        let (rect, mean) = window_of_largest_range(&[map(rows, cols, value)], (rows, cols), 32).unwrap();
        assert!(rect == expected && (mean - 2.0).abs() < 1e-6, "{rect:?} {mean}");
        // Errors of two cameras that differ at every pixel but have one mean do not count; a better mean does.
        let noisy = |row: usize, col: usize| 5.0 + if (row + col).is_multiple_of(2) { 4.0 } else { -4.0 };
        let first = map(rows, cols, |r, c| {
            noisy(r, c) + if (40..72).contains(&r) && (110..142).contains(&c) { 1.0 } else { 0.0 }
        });
        let second = map(rows, cols, |r, c| noisy(r + 1, c));
        let (rect, range) = window_of_largest_range(&[first, second], (rows, cols), 32).unwrap();
        assert!(rect == expected && (range - 1.0).abs() < 1e-6, "{rect:?} {range}");
    }

    /// Of a camera with half as many pixels in each direction, and of one with two thirds.
    #[test]
    fn pictures_and_maps_of_fewer_pixels_are_enlarged() {
        let map = Planes::new(1, 2, 1, vec![3.0, 5.0]).unwrap();
        assert_eq!(map_of_size(&map, (2, 4)).unwrap().data(), [3.0, 3.0, 5.0, 5.0, 3.0, 3.0, 5.0, 5.0]);
        assert_eq!(map_of_size(&map, (1, 3)).unwrap().data(), [3.0, 5.0, 5.0]);
        assert_eq!(map_of_size(&map, (1, 2)).unwrap().as_ref(), &map);
        let picture = Pixels { width: 2, height: 1, rgb: vec![1, 2, 3, 4, 5, 6] };
        let large = picture_of_size(&picture, (1, 4));
        assert_eq!((large.height, large.width), (1, 4));
        assert_eq!(large.rgb, [1, 2, 3, 1, 2, 3, 4, 5, 6, 4, 5, 6]);
        // The cameras are compared at the same place of the scene.
        let fine = Planes::new(2, 4, 1, vec![3.0, 3.0, 5.0, 9.0, 3.0, 3.0, 5.0, 5.0]).unwrap();
        let maps = [map_of_size(&fine, (2, 4)).unwrap(), map_of_size(&map, (2, 4)).unwrap()];
        let expected = Some((Rect { row: 0, col: 3, rows: 1, cols: 1 }, 4.0));
        assert_eq!(window_of_largest_range(&maps, (2, 4), 1), expected);
    }

    #[test]
    fn windows_of_equal_means_are_the_first_and_those_of_small_pictures_the_whole() {
        let (rect, mean) = window_of_largest_range(&[map(7, 9, |_, _| 0.3)], (7, 9), 4).unwrap();
        assert_eq!((rect, (mean - 0.3).abs() < 1e-6), (Rect { row: 0, col: 0, rows: 4, cols: 4 }, true));
        assert_eq!(
            window_of_largest_range(&[map(2, 3, |_, _| 1.0)], (2, 3), 96).unwrap().0,
            Rect::whole(2, 3)
        );
        assert_eq!(window_of_largest_range(&[], (2, 3), 4), None);
    }

    #[test]
    fn a_cut_has_the_pixels_of_the_window_and_the_overview_its_frame() {
        let picture = Pixels {
            width: 500,
            height: 300,
            rgb: (0..500 * 300).flat_map(|i| [(i % 500 / 2) as u8, 90, 90]).collect(),
        };
        let window = Rect { row: 100, col: 200, rows: 96, cols: 96 };
        let part = cut(&picture, window);
        assert_eq!((part.width, part.height, part.rgb.len()), (96, 96, 3 * 96 * 96));
        assert_eq!((part.rgb[0], part.rgb[3 * 95]), (100, 147));
        let small = overview(&picture, window);
        assert_eq!((small.width, small.height), (167, 100));
        let at = |row: usize, col: usize| small.rgb[3 * (row * small.width + col)];
        // A third of the size: black, white, black from the corner of the window inwards.
        assert_eq!([at(33, 66), at(34, 67), at(35, 68)], [0, 255, 0]);
        assert_eq!(at(50, 80), 120);
    }
}
