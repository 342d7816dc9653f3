//! Decoding.

use super::bits::BitReader;
use super::huffman::Decoder;
use super::{MAX_COMPONENTS, predict};

/// The content of the header of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Frame {
    precision: u32,
    rows: usize,
    cols: usize,
    /// Their identifiers.
    components: Vec<u8>,
}

/// Segments up to the scan.
#[derive(Debug, Default)]
struct Headers {
    frame: Option<Frame>,
    tables: [Option<Decoder>; MAX_COMPONENTS],
    restart_interval: usize,
}

/// The scan's own header.
#[derive(Debug)]
struct Scan {
    predictor: u8,
    point_transform: u32,
    /// Huffman table of every component.
    tables: Vec<Decoder>,
}

/// Samples in their order in the frame: row by row, the components of a pixel side by side. `allowed` is how many
/// there may be; memory is taken only for a frame within it that its bytes can hold.
///
/// # Errors
/// A message, when the bytes are not such a frame.
pub(in crate::dng) fn decode(
    bytes: &[u8],
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<Vec<u16>, String> {
    if !bytes.starts_with(&[0xff, 0xd8]) {
        return Err("it does not begin as a JPEG does".into());
    }
    let mut headers = Headers::default();
    let mut at = 2;
    loop {
        let &[mark, marker] = array(bytes, at)?;
        if mark != 0xff {
            return Err(format!("byte {at} is not a marker"));
        }
        // Fill bytes before a marker.
        if marker == 0xff {
            at += 1;
            continue;
        }
        let length = usize::from(u16::from_be_bytes(*array(bytes, at + 2)?));
        let segment = bytes.get(at + 4..at + 2 + length).ok_or("a segment ends after the data")?;
        at += 2 + length;
        match marker {
            0xc3 => headers.frame = Some(frame(segment)?),
            0xc4 => tables(segment, &mut headers.tables)?,
            0xdd => headers.restart_interval = usize::from(u16::from_be_bytes(*array(segment, 0)?)),
            0xda => {
                let scan = scan(segment, &headers)?;
                let frame = headers.frame.ok_or("the scan comes before the frame")?;
                let samples = frame.rows.saturating_mul(frame.cols).saturating_mul(frame.components.len());
                if !allowed.contains(&samples) {
                    let (least, most) = allowed.into_inner();
                    return Err(format!("it has {samples} samples; the strip or tile {least} to {most}"));
                }
                // A sample takes a bit at least.
                if samples / 8 > bytes.len() {
                    return Err("it ends too early".into());
                }
                return entropy_coded(bytes, at, &frame, &scan, headers.restart_interval);
            }
            0xc0..=0xc2 => return Err("it is lossy JPEG; expected lossless (SOF3)".into()),
            0xc5..=0xc7 | 0xc9..=0xcf => {
                return Err(format!(
                    "its coding process (SOF{}) is not supported; expected SOF3",
                    marker - 0xc0
                ));
            }
            // Application data and comments.
            0xe0..=0xef | 0xfe => {}
            _ => return Err(format!("unexpected marker ff{marker:02x}")),
        }
    }
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> Result<&[u8; N], String> {
    bytes.get(at..at + N).and_then(|b| b.try_into().ok()).ok_or_else(|| "it ends too early".into())
}

fn frame(segment: &[u8]) -> Result<Frame, String> {
    let &[precision, r1, r0, c1, c0, count] = array(segment, 0)?;
    let (rows, cols) = (u16::from_be_bytes([r1, r0]), u16::from_be_bytes([c1, c0]));
    let list = segment.get(6..6 + 3 * usize::from(count)).ok_or("the frame header ends too early")?;
    let components = list.as_chunks::<3>().0;
    if rows == 0 || cols == 0 || !(2..=16).contains(&precision) {
        return Err(format!("its frame is {cols} × {rows} of {precision} bits"));
    }
    if components.is_empty() || components.len() > MAX_COMPONENTS {
        return Err(format!("it has {count} components; expected 1 to {MAX_COMPONENTS}"));
    }
    if components.iter().any(|c| c[1] != 0x11) {
        return Err("its components are subsampled".into());
    }
    Ok(Frame {
        precision: precision.into(),
        rows: rows.into(),
        cols: cols.into(),
        components: components.iter().map(|c| c[0]).collect(),
    })
}

fn tables(mut segment: &[u8], tables: &mut [Option<Decoder>; MAX_COMPONENTS]) -> Result<(), String> {
    while let Some((&place, rest)) = segment.split_first() {
        let counts: &[u8; 16] = array(rest, 0)?;
        let symbols: usize = counts.iter().map(|&c| usize::from(c)).sum();
        let list = rest.get(16..16 + symbols).ok_or("a Huffman table ends too early")?;
        let slot = tables.get_mut(usize::from(place)).ok_or(format!("there is no Huffman table {place}"))?;
        *slot = Some(Decoder::new(counts, list)?);
        segment = rest.get(16 + symbols..).unwrap_or_default();
    }
    Ok(())
}

fn scan(segment: &[u8], headers: &Headers) -> Result<Scan, String> {
    let frame = headers.frame.as_ref().ok_or("the scan comes before the frame")?;
    let count = usize::from(*segment.first().ok_or("the scan header is empty")?);
    let list = segment.get(1..1 + 2 * count).ok_or("the scan header ends too early")?.as_chunks::<2>().0;
    if !list.iter().map(|c| c[0]).eq(frame.components.iter().copied()) {
        return Err("its components are not in one scan".into());
    }
    let &[predictor, _, transform] = array(segment, 1 + 2 * count)?;
    let point_transform = u32::from(transform & 15);
    if !(1..=7).contains(&predictor) || point_transform >= frame.precision {
        return Err(format!("it has predictor {predictor}, point transform {point_transform}"));
    }
    let table = |c: &[u8; 2]| {
        let place = usize::from(c[1] >> 4);
        let table = headers.tables.get(place).and_then(Option::as_ref);
        table.cloned().ok_or(format!("Huffman table {place} is missing"))
    };
    Ok(Scan { predictor, point_transform, tables: list.iter().map(table).collect::<Result<_, _>>()? })
}

fn entropy_coded(
    bytes: &[u8],
    start: usize,
    frame: &Frame,
    scan: &Scan,
    restart_interval: usize,
) -> Result<Vec<u16>, String> {
    if !restart_interval.is_multiple_of(frame.cols) {
        return Err(format!("its restart interval {restart_interval} is not of whole rows"));
    }
    let restart_rows = restart_interval / frame.cols;
    let n = frame.components.len();
    let mut samples = vec![0u16; frame.rows * frame.cols * n];
    let mut bits = BitReader::new(bytes, start);
    let middle = 1i32 << (frame.precision - scan.point_transform - 1);
    let mut above: &mut [u16] = &mut [];
    for (r, row) in samples.chunks_exact_mut(frame.cols * n).enumerate() {
        let mut first = r == 0;
        if restart_rows > 0 && r > 0 && r.is_multiple_of(restart_rows) {
            let at = bits.marker_at();
            let number = (r / restart_rows - 1) % 8;
            match array(bytes, at) {
                Ok(&[0xff, m]) if usize::from(m) == 0xd0 + number => {}
                _ => return Err(format!("restart marker {number} is missing")),
            }
            bits = BitReader::new(bytes, at + 2);
            first = true;
        }
        for i in 0..row.len() {
            let c = i % n;
            let table = scan.tables.get(c).ok_or("a component has no table")?;
            let difference = table.difference(&mut bits).ok_or("it has a code of no table")?;
            let predicted = predict(scan.predictor, (row, above), i, n, first.then_some(middle));
            if let Some(v) = row.get_mut(i) {
                *v = (predicted + difference) as u16;
            }
        }
        if bits.exhausted() {
            return Err("it ends too early".into());
        }
        above = row;
    }
    if scan.point_transform > 0 {
        samples.iter_mut().for_each(|v| *v <<= scan.point_transform);
    }
    Ok(samples)
}
