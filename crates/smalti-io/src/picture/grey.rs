//! Grey PNG, unpacked row by row.

use std::io::{self, BufReader, Read};
use std::path::Path;

use png::{BitDepth, Decoder, DecodingError, Reader, Transformations};

use crate::file::{guarded, plausible};
use crate::raster::{Axis, Kind, Raster, Shared, Span};
use crate::{IoError, Limits};

/// Of a picture that is unpacked row by row; more is refused.
const ROW_LIMIT_BYTES: usize = 1 << 28;

/// How the samples that [`rows`] gives lie; only the header of the picture is looked at.
///
/// # Errors
/// When it is no PNG, or declares more than its file can hold. One that is interlaced is unpacked whole: the limits bound it.
pub(crate) fn raster(source: &Shared<'_>, path: &Path, limits: Limits) -> Result<Raster, IoError> {
    guarded(path, "PNG", || {
        let reader = reader(source).map_err(|e| IoError::decode(path, "PNG", e))?;
        let info = reader.info();
        let (rows, cols) = (info.height as usize, info.width as usize);
        let sixteen = reader.output_color_type().1 == BitDepth::Sixteen;
        let raw = (info.raw_row_length() as u64).saturating_mul(u64::from(info.height));
        plausible(path, "the picture", raw, source.len())?;
        let bytes = reader.output_buffer_size().map_or(u64::MAX, |n| n as u64);
        if info.interlaced {
            limits.check_memory(path, "an interlaced picture", bytes)?;
        }
        Ok(Raster {
            kind: if sixteen { Kind::U16 } else { Kind::U8 },
            big_endian: true,
            bands: 1,
            rows,
            cols,
            order: [Axis::Band, Axis::Row, Axis::Col],
        })
    })
}

/// The samples of a picture, one after another. One of colour is taken where its channels are equal; alpha is ignored.
pub(crate) fn rows<'a>(source: &Shared<'a>) -> io::Result<Box<dyn Read + Send + 'a>> {
    let mut reader = reader(source).map_err(io_error)?;
    let (color, depth) = reader.output_color_type();
    let sample = if depth == BitDepth::Sixteen { 2 } else { 1 };
    // Palettes are expanded: 1 to 4, of which the second of two and the fourth are alpha.
    let channels = color.samples();
    let (pixel, colors) = (channels * sample, if channels < 3 { 1 } else { 3 });
    let mut line = Vec::new();
    let mut rows_left = reader.info().height;
    if reader.info().interlaced {
        line.resize(reader.output_buffer_size().ok_or(io::ErrorKind::InvalidData)?, 0);
        reader.next_frame(&mut line).map_err(io_error)?;
        let len = gray(&mut line, pixel, sample, colors)?;
        line.truncate(len);
        rows_left = 0;
    }
    Ok(Box::new(Rows { reader, pixel, sample, colors, line, at: 0, rows_left }))
}

fn reader<'a>(source: &Shared<'a>) -> Result<Reader<BufReader<Span<'a>>>, DecodingError> {
    let mut decoder =
        Decoder::new_with_limits(BufReader::new(Span::whole(source)), png::Limits { bytes: ROW_LIMIT_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.read_info()
}

fn io_error(error: DecodingError) -> io::Error {
    match error {
        DecodingError::IoError(e) => e,
        e => io::Error::new(io::ErrorKind::InvalidData, e.to_string()),
    }
}

struct Rows<'a> {
    reader: Reader<BufReader<Span<'a>>>,
    /// Bytes of a pixel and of a sample.
    pixel: usize,
    sample: usize,
    /// Samples of a pixel that have to be equal.
    colors: usize,
    /// Samples that are unpacked; those before `at` have been read.
    line: Vec<u8>,
    at: usize,
    rows_left: u32,
}

impl Read for Rows<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.at >= self.line.len() && self.rows_left > 0 {
            let width = self.reader.info().width;
            let len = self.reader.output_line_size(width).ok_or(io::ErrorKind::InvalidData)?;
            self.line.resize(len, 0);
            self.reader.read_row(&mut self.line).map_err(io_error)?.ok_or(io::ErrorKind::UnexpectedEof)?;
            let len = gray(&mut self.line, self.pixel, self.sample, self.colors)?;
            self.line.truncate(len);
            self.at = 0;
            self.rows_left -= 1;
            if self.rows_left == 0 {
                // Check sums stand at the end.
                self.reader.read_row(&mut []).map_err(io_error)?;
            }
        }
        let from = self.line.get(self.at..).unwrap_or_default();
        let count = from.len().min(out.len());
        out.iter_mut().zip(from).for_each(|(to, byte)| *to = *byte);
        self.at += count;
        Ok(count)
    }
}

/// Moves the first sample of each pixel to the front, where the samples of its colours are equal; the bytes that they take.
fn gray(line: &mut [u8], pixel: usize, sample: usize, colors: usize) -> io::Result<usize> {
    if pixel == sample {
        return Ok(line.len());
    }
    let pixels = line.len() / pixel;
    for i in 0..pixels {
        let from = line.get(i * pixel..(i + 1) * pixel).unwrap_or_default();
        let mut samples = from.chunks_exact(sample).take(colors);
        let first = samples.next();
        if !samples.all(|s| Some(s) == first) {
            let message = "it is of colour; expected grey, or equal red, green and blue";
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        line.copy_within(i * pixel..i * pixel + sample, i * sample);
    }
    Ok(pixels * sample)
}
