//! Writing `.npz` and `.npy`.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use super::zip_write::{Stored, end};
use crate::scene_file::blocks::write_planes;
use crate::scene_file::tiles::{Header, Tiles};
use crate::{IoError, npy, write};

/// Writes an archive for `numpy.load`, stored as `numpy.savez` does: `cube` (`<f4`: band, row, column), `wavelengths_nm`, `axes`,
/// `quantity`, `name`, and where they are known `illuminant_photons`, `distance_m` and `horizontal_fov_deg`. The image is read by
/// rows, so that it need not fit into memory.
///
/// # Errors
/// When the file cannot be written, or the image cannot be read.
pub fn write(path: &Path, image: &dyn Tiles) -> Result<(), IoError> {
    let header = image.header();
    let io = IoError::writing(path);
    write::atomic(path, |out| {
        let mut members: Vec<Stored> = Vec::new();
        let mut at = 0;
        for (name, content) in small(header) {
            members.push(Stored::write(out, name, &[&content], &mut at).map_err(io)?);
        }
        let begin = npy_begin(header);
        let size = header.decoded_bytes() + begin.len() as u64;
        let mut cube = Stored { name: "cube.npy".into(), crc: 0, size, at };
        let local = cube.local();
        out.write_all(&local).and_then(|()| out.write_all(&begin)).map_err(io)?;
        let base = at + (local.len() + begin.len()) as u64;
        let mut crcs = vec![crc32fast::Hasher::new(); header.wavelengths_nm.len()];
        write_planes(out, base, image, path, |band, bytes| {
            if let Some(crc) = crcs.get_mut(band) {
                crc.update(bytes);
            }
        })?;
        let mut crc = crc32fast::Hasher::new();
        crc.update(&begin);
        crcs.iter().for_each(|band| crc.combine(band));
        cube.crc = crc.finalize();
        // The check sum is known now.
        out.seek(SeekFrom::Start(at)).and_then(|_| out.write_all(&cube.local())).map_err(io)?;
        let list = at + local.len() as u64 + size;
        members.push(cube);
        out.seek(SeekFrom::Start(list)).and_then(|_| out.write_all(&end(&members, list))).map_err(io)
    })
}

/// Writes the samples alone, ordered band, row, column. The file does not state the wavelengths or the quantity.
///
/// # Errors
/// As [`write()`].
pub fn write_npy(path: &Path, image: &dyn Tiles) -> Result<(), IoError> {
    write::atomic(path, |out| {
        let begin = npy_begin(image.header());
        out.write_all(&begin).map_err(IoError::writing(path))?;
        write_planes(out, begin.len() as u64, image, path, |_, _| {})
    })
}

/// The header before the samples.
fn npy_begin(header: &Header) -> Vec<u8> {
    let shape = [header.wavelengths_nm.len(), header.rows, header.cols];
    // Three axes always have a header.
    npy::header("<f4", &shape).unwrap_or_default()
}

/// All arrays but the cube.
fn small(header: &Header) -> Vec<(&'static str, Vec<u8>)> {
    let array = |descr: &str, shape: &[usize], bytes: Vec<u8>| {
        [npy::header(descr, shape).unwrap_or_default(), bytes].concat()
    };
    let numbers = |v: &[f64]| array("<f8", &[v.len()], v.iter().flat_map(|x| x.to_le_bytes()).collect());
    let number = |v: f64| array("<f8", &[], v.to_le_bytes().to_vec());
    let text = |s: &str| {
        // NumPy has no string of no characters.
        let count = s.chars().count().max(1);
        let mut bytes: Vec<u8> = s.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        bytes.resize(4 * count, 0);
        array(&format!("<U{count}"), &[], bytes)
    };
    let mut out = vec![
        ("wavelengths_nm", numbers(&header.wavelengths_nm)),
        ("axes", text("band row column")),
        ("quantity", text(header.quantity.name())),
        ("name", text(&header.name)),
    ];
    if let Some(light) = &header.illuminant {
        out.push(("illuminant_photons", numbers(&light_on_bands(header, light))));
    }
    out.extend(header.distance_m.map(|m| ("distance_m", number(m))));
    out.extend(header.horizontal_fov_deg.map(|deg| ("horizontal_fov_deg", number(deg))));
    out
}

/// The light at the wavelengths of the bands, which need not be those of its grid.
fn light_on_bands(header: &Header, light: &smalti::spectrum::Spectrum) -> Vec<f64> {
    let same = header.wavelengths_nm.len() == light.values().len();
    if same && header.grid.wavelengths_nm().eq(header.wavelengths_nm.iter().copied()) {
        return light.values().to_vec();
    }
    header.wavelengths_nm.iter().map(|nm| light.at(*nm).unwrap_or(0.0)).collect()
}
