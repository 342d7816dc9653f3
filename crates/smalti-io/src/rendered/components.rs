//! Spectral pictures that are stored as principal components of their spectra, with the light of the scene;
//! `tools/scenes/README.md` specifies the format.

use std::io::Read;
use std::path::PathBuf;

use flate2::read::ZlibDecoder;
use smalti::spectrum::units::photons_per_joule;
use smalti::spectrum::{Components, SpectralCube, Spectrum, WavelengthGrid};

use crate::error::At;
use crate::{IoError, Quantity, SpectralFile};

const MAGIC: &[u8; 8] = b"SMALTSPC";
const VERSION: u32 = 1;
/// The largest number of samples of all planes.
const MAX_SAMPLES: usize = 1 << 27;
const FORMAT: &str = "spectral picture";

/// Reads numbers from the beginning of a picture.
struct Reader<'a> {
    path: PathBuf,
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn wrong(&self, message: impl ToString) -> IoError {
        IoError::decode(&self.path, FORMAT, message)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], IoError> {
        let (head, rest) = self.bytes.split_at_checked(count).ok_or_else(|| self.wrong("it is cut short"))?;
        self.bytes = rest;
        Ok(head)
    }

    fn u32(&mut self) -> Result<u32, IoError> {
        let bytes = self.take(4)?.first_chunk().copied().unwrap_or_default();
        Ok(u32::from_le_bytes(bytes))
    }

    fn f32(&mut self) -> Result<f64, IoError> {
        let value = f32::from_bits(self.u32()?);
        if value.is_finite() { Ok(value.into()) } else { Err(self.wrong("a number is not finite")) }
    }

    fn numbers(&mut self, count: usize) -> Result<Vec<f64>, IoError> {
        (0..count).map(|_| self.f32()).collect()
    }
}

/// Whether a file is a picture of this format, by its first bytes.
pub(super) fn is_file(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// What precedes the planes.
struct Header {
    rows: usize,
    cols: usize,
    grid: WavelengthGrid,
    /// The number of components.
    components: usize,
    /// The steps of the logarithms of the level and of the coefficients.
    log_step: f64,
    step: f64,
    /// The level whose logarithm is 0.
    floor: f64,
    /// The mean of the spectra.
    mean: Vec<f64>,
    /// The components, band by band.
    basis: Vec<f64>,
    /// The light of the scene, photons.
    light: Spectrum,
}

impl Header {
    fn read(file: &mut Reader<'_>) -> Result<Self, IoError> {
        if file.take(MAGIC.len())? != MAGIC {
            return Err(file.wrong("it does not begin with SMALTSPC"));
        }
        let version = file.u32()?;
        if version != VERSION {
            return Err(file.wrong(format_args!("version {version} is not version {VERSION}")));
        }
        let [rows, cols, bands, components] =
            [file.u32()?, file.u32()?, file.u32()?, file.u32()?].map(|n| n as usize);
        let [start_nm, step_nm, log_step, step] = [file.f32()?, file.f32()?, file.f32()?, file.f32()?];
        let text = file.u32()? as usize;
        let floor = file.f32()?;
        let samples =
            rows.checked_mul(cols).and_then(|n| n.checked_mul(components + 1)).filter(|&n| n <= MAX_SAMPLES);
        if rows == 0 || cols == 0 || samples.is_none() || components >= bands || bands > 1000 {
            return Err(
                file.wrong(format_args!("{rows} × {cols} samples, {bands} bands, {components} components"))
            );
        }
        if std::str::from_utf8(file.take(text)?).is_err() {
            return Err(file.wrong("its text is not UTF-8"));
        }
        let (mean, basis) = (file.numbers(bands)?, file.numbers(bands * components)?);
        let light = file.numbers(bands)?;
        let path = file.path.as_path();
        let grid = WavelengthGrid::new(start_nm, step_nm, bands).at(path)?;
        let light = Spectrum::new(grid, light).and_then(|light| light.map(|nm, v| v * photons_per_joule(nm)));
        let light = light.at(path)?;
        Ok(Self { rows, cols, grid, components, log_step, step, floor, mean, basis, light })
    }
}

/// The light of the scene of a picture, photons.
pub(super) fn light(name: &str, bytes: &[u8]) -> Result<Spectrum, IoError> {
    Ok(Header::read(&mut Reader { path: PathBuf::from(name), bytes })?.light)
}

/// Decodes a picture.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<SpectralFile, IoError> {
    let mut file = Reader { path: PathBuf::from(name), bytes };
    let Header { rows, cols, grid, components, log_step, step, floor, mean, basis, light } =
        Header::read(&mut file)?;
    let planes = planes(&file, rows, cols, components)?;
    let path = file.path.as_path();
    let (logarithms, coefficients) = planes.split_at(rows * cols);
    let levels = &levels(logarithms, |logarithm| floor * libm::exp(log_step * f64::from(logarithm)));
    let (mean, basis) = (&mean, &basis);
    let cube = Components { mean, basis, coefficients, step, levels }.planes(rows, cols).at(path)?;
    Ok(SpectralFile {
        name: name.to_owned(),
        cube: SpectralCube::new(grid, cube).at(path)?,
        quantity: Quantity::Energy,
        illuminant: Some(light),
        distance_m: None,
        horizontal_fov_deg: None,
    })
}

/// The level of each logarithm; 0 where the logarithm is 0. Most logarithms occur often. A table therefore holds
/// the level of each, unless they span more numbers than there are pixels.
fn levels(logarithms: &[i32], level: impl Fn(i32) -> f64) -> Vec<f64> {
    let level = |logarithm: i32| if logarithm == 0 { 0.0 } else { level(logarithm) };
    let least = logarithms.iter().copied().min().unwrap_or(0);
    let most = logarithms.iter().copied().max().unwrap_or(0);
    if i64::from(most) - i64::from(least) > logarithms.len() as i64 {
        return logarithms.iter().map(|&logarithm| level(logarithm)).collect();
    }
    let table: Vec<f64> = (least..=most).map(level).collect();
    logarithms.iter().map(|logarithm| table[(logarithm - least) as usize]).collect()
}

/// The quantised planes: the logarithm of the level, then the coefficients.
fn planes(file: &Reader<'_>, rows: usize, cols: usize, components: usize) -> Result<Vec<i32>, IoError> {
    let mut stream = Vec::new();
    // No plane takes more than a byte and an escape for each sample.
    let most = 3 * (rows * cols * (components + 1)) as u64;
    let read = ZlibDecoder::new(file.bytes).take(most + 1).read_to_end(&mut stream);
    read.map_err(|e| file.wrong(e))?;
    let mut stream = Reader { path: file.path.clone(), bytes: &stream };
    let mut planes = Vec::with_capacity(rows * cols * (components + 1));
    let mut codes = vec![0u32; rows * cols];
    for plane in 0..=components {
        let escape = if plane == 0 {
            let bytes = stream.take(rows * cols)?;
            codes.iter_mut().zip(bytes).for_each(|(code, &byte)| *code = byte.into());
            255
        } else {
            let bytes = stream.take(rows.div_ceil(2) * cols)?;
            for (pair, bytes) in codes.chunks_mut(2 * cols).zip(bytes.chunks_exact(cols)) {
                let (low, high) = pair.split_at_mut(cols);
                low.iter_mut().zip(bytes).for_each(|(code, byte)| *code = u32::from(byte & 15));
                high.iter_mut().zip(bytes).for_each(|(code, byte)| *code = u32::from(byte >> 4));
            }
            15
        };
        for code in codes.iter_mut().filter(|code| **code == escape) {
            let rest = stream.take(2)?.first_chunk().copied().unwrap_or_default();
            *code += u32::from(u16::from_le_bytes(rest));
        }
        let first = planes.len();
        for (i, &code) in codes.iter().enumerate() {
            let half = (code >> 1).cast_signed();
            let residual = if code & 1 == 0 { half } else { -half - 1 };
            let (row, col) = (i / cols, i % cols);
            let at = |behind: usize, inside: bool| if inside { planes[first + i - behind] } else { 0 };
            let (left, above) = (at(1, col > 0), at(cols, row > 0));
            let corner = at(cols + 1, row > 0 && col > 0);
            let predicted: i32 = if corner >= left.max(above) {
                left.min(above)
            } else if corner <= left.min(above) {
                left.max(above)
            } else {
                left + above - corner
            };
            // Codes have 17 bits, so that a damaged plane can only overflow over very many samples.
            planes.push(predicted.wrapping_add(residual));
        }
    }
    if !stream.bytes.is_empty() {
        return Err(file.wrong("it has more samples than declared"));
    }
    Ok(planes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_picture_is_refused() {
        let good = smalti_scenes::STREET;
        let error = |bytes: &[u8]| decode("x.spc", bytes).unwrap_err().to_string();
        for length in [0, 7, 20, 51, 60, 1000, good.len() / 2, good.len() - 1] {
            let message = error(&good[..length]);
            assert!(message.starts_with("x.spc: not a valid spectral picture file: "), "{length}: {message}");
        }
        let changed = |at: usize, value: u8| {
            let mut bytes = good.to_vec();
            bytes[at] = value;
            error(&bytes)
        };
        assert!(changed(0, b'X').contains("SMALTSPC"));
        assert!(changed(8, 2).contains("version 2"));
        assert!(changed(15, 255).contains("samples"));
        assert!(changed(24, 200).contains("components"));
        assert!(changed(31, 0x7f).contains("finite") || changed(31, 0x7f).contains("nm"));
        // The checksum of the stream.
        changed(good.len() - 2, good[good.len() - 2] ^ 1);
    }
}
