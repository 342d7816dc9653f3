//! Black levels (DNG 1.4, chapter 5: mapping raw values to linear reference values).

use std::path::Path;

use smalti::sensor::RawSamples;

use crate::IoError;
use crate::tiff::{Directory, tags};

/// The black level of the image, after `samples` (of the active area, ordered plane, row, column, of the size
/// `(rows, cols, planes)`) have been shifted to have one. That is the highest of all, as DNG scales from it: what is
/// saturated stays so.
pub(super) fn one_black_level(
    ifd: &Directory,
    (rows, cols, planes): (usize, usize, usize),
    samples: &mut RawSamples,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<f64, IoError> {
    let repeat = ifd.numbers(tags::BLACK_LEVEL_REPEAT_DIM).unwrap_or_else(|| vec![1.0, 1.0]);
    let (down, across) = match repeat.as_slice() {
        [r, c] if *r >= 1.0 && *c >= 1.0 => (*r as usize, *c as usize),
        _ => {
            let found = format!("{repeat:?}");
            return Err(IoError::field(path, "BlackLevelRepeatDim", found, "rows and columns, at least 1"));
        }
    };
    let levels = numbers(ifd, tags::BLACK_LEVEL, "BlackLevel", path)?.unwrap_or_else(|| vec![0.0]);
    let expected = [down, across, planes].iter().try_fold(1usize, |n, &k| n.checked_mul(k));
    // Some writers state one level for all.
    let single = (levels.len() == 1).then(|| levels.first().copied()).flatten();
    if single.is_none() && Some(levels.len()) != expected {
        let expected = format!("{down} × {across} for each of {planes} planes");
        return Err(IoError::field(path, "BlackLevel", format!("{} long", levels.len()), expected));
    }
    let delta = |tag, name: &str, len: usize| {
        let Some(values) = numbers(ifd, tag, name, path)? else { return Ok(vec![0.0; len]) };
        if values.len() != len {
            let found = format!("{} long", values.len());
            return Err(IoError::field(path, name, found, format!("{len}, the size of the active area")));
        }
        Ok(values)
    };
    let delta_h = delta(tags::BLACK_LEVEL_DELTA_H, "BlackLevelDeltaH", cols)?;
    let delta_v = delta(tags::BLACK_LEVEL_DELTA_V, "BlackLevelDeltaV", rows)?;
    let level = |p: usize, r: usize, c: usize| match single {
        Some(level) => level,
        None => levels.get((r % down * across + c % across) * planes + p).copied().unwrap_or(0.0),
    };
    let same = |v: &[f64]| v.iter().all(|x| Some(x) == v.first());
    let black = |p, r, c| {
        let of = |v: &[f64], i: usize| v.get(i).copied().unwrap_or(0.0);
        level(p, r, c) + of(&delta_h, c) + of(&delta_v, r)
    };
    if same(&levels) && same(&delta_h) && same(&delta_v) {
        return Ok(black(0, 0, 0));
    }
    let places = (0..planes).flat_map(|p| (0..rows).flat_map(move |r| (0..cols).map(move |c| (p, r, c))));
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for (p, r, c) in places.clone() {
        least = least.min(black(p, r, c));
        most = most.max(black(p, r, c));
    }
    match samples {
        RawSamples::Digital(v) => {
            for (v, (p, r, c)) in v.iter_mut().zip(places) {
                *v = (f64::from(*v) - black(p, r, c) + most).round() as u16;
            }
        }
        RawSamples::Analog(v) => {
            for (v, (p, r, c)) in v.iter_mut().zip(places) {
                *v = (f64::from(*v) - black(p, r, c) + most) as f32;
            }
        }
    }
    notes.push(format!("black levels from {least} to {most}: samples are shifted to have {most}"));
    Ok(most)
}

fn numbers(ifd: &Directory, tag: u16, name: &str, path: &Path) -> Result<Option<Vec<f64>>, IoError> {
    let values = ifd.numbers(tag).filter(|v| !v.is_empty());
    if values.as_ref().is_some_and(|v| v.iter().any(|x| !x.is_finite())) {
        return Err(IoError::field(path, name, "not finite", "numbers"));
    }
    Ok(values)
}
