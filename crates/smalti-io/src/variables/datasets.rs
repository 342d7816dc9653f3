//! Cubes of known data sets and of any other origin: an array of three axes, one of which is that of the wavelengths.

use std::path::Path;

use smalti::spectrum::WavelengthGrid;

use super::{Attribute, Axes, Fields, Numbers, Reading, Value, at, placed, text_at, wavelengths};
use crate::file::stem;
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::tiles::Tiles;
use crate::{IoError, Quantity, UnstatedProperty};

/// What is known of the cube of a data set by its name.
struct Known {
    name: &'static str,
    quantity: Quantity,
    /// Written by MATLAB without its attributes.
    matlab: bool,
}

/// In the order in which they are looked for.
const KNOWN: [Known; 4] = [
    // ICVL (Arad and Ben-Shahar 2016): radiance of 12 bits beside `bands` and `rgb`.
    Known { name: "rad", quantity: Quantity::RelativeEnergy, matlab: false },
    // ARAD (NTIRE 2020, 2022): normalised radiance beside `bands` and `norm_factor`.
    Known { name: "cube", quantity: Quantity::RelativeEnergy, matlab: false },
    // KAUST (Li et al. 2021): reflectance, alone. The name ends in a backslash.
    Known { name: "img\\", quantity: Quantity::Reflectance, matlab: true },
    Known { name: "img", quantity: Quantity::Reflectance, matlab: false },
];

/// Wavelengths of data sets that state none: from 400 nm in steps of 10 nm, to 700 (CAVE, ICVL, ARAD, KAUST) or 730 nm (KAUST).
const UNSTATED_COUNTS: [usize; 2] = [31, 34];

// Names that are looked at for a cube, at most, and how deep.
const MAX_ARRAYS: usize = 1000;
const DEEPEST: usize = 4;

/// The cube among the variables of a file.
pub(super) fn open(fields: &dyn Fields, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    let Reading { path, options } = of;
    let (place, numbers) = match &options.variable {
        Some(place) => (place.clone(), chosen(fields, place, path)?),
        None => found(fields, of)?,
    };
    let (group, last) = place.rsplit_once(['.', '/']).unwrap_or(("", &place));
    let known = KNOWN.iter().find(|k| k.name == last || k.name == place);
    let matlab = numbers.matlab || known.is_some_and(|k| k.matlab);

    let inside = match at(fields, group)? {
        Some(Value::Fields(inside)) => Some(inside),
        _ => None,
    };
    let mut stated = wavelengths::attribute(&numbers, path)?;
    for fields in inside.as_deref().into_iter().chain([fields]) {
        if stated.is_none() {
            stated = wavelengths::beside(fields, of)?;
        }
    }
    let stated = stated.or_else(|| wavelengths::given(of));
    let (axes, nm) = axes(&numbers, &place, matlab, known.is_some(), stated, path)?;

    let attribute = |name: &str| {
        numbers.attributes.iter().find_map(|(n, value)| match value {
            Attribute::Text(text) if n == name => Some(text.clone()),
            _ => None,
        })
    };
    let comment = match attribute("comment") {
        Some(comment) => Some(comment),
        None => text_at(fields, "comment")?,
    };
    let facts = comment.and_then(|c| Comment::parse(&c));
    let from_layout = known.map_or(Quantity::RelativeEnergy, |k| k.quantity);
    let stated = facts.as_ref().and_then(Facts::quantity);
    let quantity = stated.or(options.quantity).unwrap_or(from_layout);
    let name = (stem(path), quantity);
    let mut file = placed(&numbers.array, axes, name, &nm, facts.as_ref(), of)?;
    Facts::state(facts, &mut file.header, path)?;
    Ok(Box::new(file))
}

fn is_cube(numbers: &Numbers) -> bool {
    let dims = &numbers.array.dims;
    dims.len() >= 3 && dims.iter().filter(|&&d| d > 1).count() == 3 && dims.iter().skip(3).all(|&d| d == 1)
}

/// The requested cube.
fn chosen(fields: &dyn Fields, place: &str, path: &Path) -> Result<Numbers, IoError> {
    let wrong = |found: &str| Err(IoError::field(path, place, found, "an array of three axes"));
    match at(fields, place)? {
        Some(Value::Numbers(numbers)) if is_cube(&numbers) => Ok(numbers),
        Some(Value::Numbers(numbers)) => wrong(&numbers.shape()),
        Some(Value::Text(_)) => wrong("a text"),
        Some(Value::Fields(_)) => wrong("a struct or group"),
        Some(Value::Other(what)) => wrong(what),
        None => {
            let names = fields.names();
            Err(IoError::field(path, place, "absent", format!("one of {}", listed(&names))))
        }
    }
}

/// The first few names.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let shown: Vec<&str> = names.iter().take(SHOWN).map(String::as_str).collect();
    let more = if names.len() > SHOWN { ", …" } else { "" };
    format!("{}{more}", shown.join(", "))
}

/// The cube of a known data set, or the only one there is.
fn found(fields: &dyn Fields, of: Reading<'_>) -> Result<(String, Numbers), IoError> {
    for known in &KNOWN {
        if let Some(Value::Numbers(numbers)) = fields.get(known.name)?
            && is_cube(&numbers)
        {
            return Ok((known.name.to_owned(), numbers));
        }
    }
    let mut arrays = Vec::new();
    let mut seen = 0;
    let mut others = Vec::new();
    collect(fields, "", 0, &mut seen, &mut arrays, &mut others)?;
    // A picture beside the cube is no cube, unless there is nothing else.
    if arrays.len() > 1 {
        let bands = wavelengths::beside(fields, of)?.map(|(nm, _)| nm.len());
        let fits = |n: &Numbers| match bands {
            Some(bands) => n.array.dims.contains(&bands),
            None => !n.array.dims.contains(&3),
        };
        if arrays.iter().filter(|(_, n)| fits(n)).count() == 1 {
            arrays.retain(|(_, n)| fits(n));
        }
    }
    if arrays.len() > 1 {
        let names: Vec<String> = arrays.iter().map(|(name, n)| format!("{name} ({})", n.shape())).collect();
        let expected = "one; name it (variable)";
        return Err(IoError::field(of.path, "the cube", format!("any of {}", listed(&names)), expected));
    }
    arrays.pop().ok_or_else(|| {
        let found =
            if others.is_empty() { "absent".into() } else { format!("absent among {}", listed(&others)) };
        IoError::field(of.path, "the cube", found, "an array of three axes, or a scene of ISETCam")
    })
}

fn collect(
    fields: &dyn Fields,
    within: &str,
    depth: usize,
    seen: &mut usize,
    arrays: &mut Vec<(String, Numbers)>,
    others: &mut Vec<String>,
) -> Result<(), IoError> {
    for name in fields.names() {
        *seen += 1;
        if *seen > MAX_ARRAYS {
            return Ok(());
        }
        let place = if within.is_empty() { name.clone() } else { format!("{within}/{name}") };
        match fields.get(&name)? {
            Some(Value::Numbers(numbers)) if is_cube(&numbers) => arrays.push((place, numbers)),
            Some(Value::Numbers(numbers)) => others.push(format!("{place} ({})", numbers.shape())),
            Some(Value::Fields(inner)) if depth < DEEPEST => {
                collect(&*inner, &place, depth + 1, seen, arrays, others)?;
            }
            Some(Value::Other(what)) => others.push(format!("{place} ({what})")),
            _ => {}
        }
    }
    Ok(())
}

/// Which axis is that of the wavelengths: the one of their number. The others are rows and columns in the order of
/// MATLAB or of C.
fn axes(
    numbers: &Numbers,
    place: &str,
    matlab: bool,
    known: bool,
    stated: Option<(Vec<f64>, String)>,
    path: &Path,
) -> Result<(Axes, Vec<f64>), IoError> {
    let array = &numbers.array;
    let fitting = |count: usize| (0..3).filter(|&a| array.dim(a) == count).collect::<Vec<usize>>();
    let error = |found: String, expected: &str| Err(IoError::field(path, place, found, expected));
    let (nm, counts) = match stated {
        Some((nm, name)) => {
            let axes = fitting(nm.len());
            if axes.is_empty() {
                let expected = format!("an axis of {} wavelengths, as {name} has", nm.len());
                return error(numbers.shape(), &expected);
            }
            (nm, axes)
        }
        None => {
            let all: Vec<usize> = UNSTATED_COUNTS.into_iter().filter(|&n| !fitting(n).is_empty()).collect();
            match all[..] {
                [count] if known => {
                    let grid = WavelengthGrid::new(400.0, 10.0, count);
                    (grid.map(|g| g.wavelengths_nm().collect()).unwrap_or_default(), fitting(count))
                }
                _ => {
                    let found = format!("{} without wavelengths", numbers.shape());
                    let names = wavelengths::NAMES.join(", ");
                    return error(found, &format!("one of {names} beside it"))
                        .map_err(|e| e.or_given(UnstatedProperty::Wavelengths));
                }
            }
        }
    };
    let band = match counts[..] {
        [band] => band,
        // Data sets of MATLAB have bands last.
        _ if known && matlab && counts.contains(&2) => 2,
        _ => {
            let found = format!("{}: several axes have the length of the wavelengths", numbers.shape());
            return error(found, "one axis of wavelengths; crop the image by a row or column");
        }
    };
    let mut rest = (0..3).filter(|&a| a != band);
    let (fast, slow) = (rest.next().unwrap_or(0), rest.next().unwrap_or(1));
    let (row, col) = if matlab { (fast, slow) } else { (slow, fast) };
    Ok((Axes { row, col, band }, nm))
}
