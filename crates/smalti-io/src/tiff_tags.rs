//! The container of TIFF and DNG: tagged fields, byte orders, one strip of samples.

use std::collections::BTreeMap;
use std::io::{self, Write};

pub(crate) const NEW_SUBFILE_TYPE: u16 = 254;
pub(crate) const IMAGE_WIDTH: u16 = 256;
pub(crate) const IMAGE_LENGTH: u16 = 257;
pub(crate) const BITS_PER_SAMPLE: u16 = 258;
pub(crate) const COMPRESSION: u16 = 259;
pub(crate) const PHOTOMETRIC: u16 = 262;
pub(crate) const IMAGE_DESCRIPTION: u16 = 270;
pub(crate) const MAKE: u16 = 271;
pub(crate) const MODEL: u16 = 272;
pub(crate) const STRIP_OFFSETS: u16 = 273;
pub(crate) const ORIENTATION: u16 = 274;
pub(crate) const SAMPLES_PER_PIXEL: u16 = 277;
pub(crate) const ROWS_PER_STRIP: u16 = 278;
pub(crate) const STRIP_BYTE_COUNTS: u16 = 279;
pub(crate) const PLANAR_CONFIGURATION: u16 = 284;
pub(crate) const SOFTWARE: u16 = 305;
pub(crate) const PREDICTOR: u16 = 317;
pub(crate) const TILE_WIDTH: u16 = 322;
pub(crate) const TILE_LENGTH: u16 = 323;
pub(crate) const TILE_OFFSETS: u16 = 324;
pub(crate) const TILE_BYTE_COUNTS: u16 = 325;
pub(crate) const SUB_IFDS: u16 = 330;
pub(crate) const SAMPLE_FORMAT: u16 = 339;
pub(crate) const CFA_REPEAT_PATTERN_DIM: u16 = 33421;
pub(crate) const CFA_PATTERN: u16 = 33422;
pub(crate) const ICC_PROFILE: u16 = 34675;
pub(crate) const DNG_VERSION: u16 = 50706;
pub(crate) const DNG_BACKWARD_VERSION: u16 = 50707;
pub(crate) const UNIQUE_CAMERA_MODEL: u16 = 50708;
pub(crate) const CFA_PLANE_COLOR: u16 = 50710;
pub(crate) const CFA_LAYOUT: u16 = 50711;
pub(crate) const LINEARIZATION_TABLE: u16 = 50712;
pub(crate) const BLACK_LEVEL_REPEAT_DIM: u16 = 50713;
pub(crate) const BLACK_LEVEL: u16 = 50714;
pub(crate) const BLACK_LEVEL_DELTA_H: u16 = 50715;
pub(crate) const BLACK_LEVEL_DELTA_V: u16 = 50716;
pub(crate) const WHITE_LEVEL: u16 = 50717;
pub(crate) const DEFAULT_CROP_ORIGIN: u16 = 50719;
pub(crate) const DEFAULT_CROP_SIZE: u16 = 50720;
pub(crate) const COLOR_MATRIX_1: u16 = 50721;
pub(crate) const AS_SHOT_NEUTRAL: u16 = 50728;
pub(crate) const CALIBRATION_ILLUMINANT_1: u16 = 50778;
pub(crate) const ACTIVE_AREA: u16 = 50829;
pub(crate) const ROW_INTERLEAVE_FACTOR: u16 = 50975;
pub(crate) const OPCODE_LIST_1: u16 = 51008;
pub(crate) const OPCODE_LIST_2: u16 = 51009;
pub(crate) const OPCODE_LIST_3: u16 = 51022;
pub(crate) const COLUMN_INTERLEAVE_FACTOR: u16 = 52547;

/// Content of a field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Byte(Vec<u8>),
    Ascii(String),
    Short(Vec<u16>),
    Long(Vec<u32>),
    Rational(Vec<(u32, u32)>),
    SignedRational(Vec<(i32, i32)>),
    Undefined(Vec<u8>),
}

impl Value {
    fn type_code(&self) -> u16 {
        match self {
            Self::Byte(_) => 1,
            Self::Ascii(_) => 2,
            Self::Short(_) => 3,
            Self::Long(_) => 4,
            Self::Rational(_) => 5,
            Self::Undefined(_) => 7,
            Self::SignedRational(_) => 10,
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Byte(v) | Self::Undefined(v) => v.len(),
            Self::Ascii(s) => s.len() + 1,
            Self::Short(v) => v.len(),
            Self::Long(v) => v.len(),
            Self::Rational(v) => v.len(),
            Self::SignedRational(v) => v.len(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Byte(v) | Self::Undefined(v) => v.clone(),
            Self::Ascii(s) => s.bytes().chain([0]).collect(),
            Self::Short(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Long(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Rational(v) => {
                v.iter().flat_map(|(n, d)| [n.to_le_bytes(), d.to_le_bytes()].concat()).collect()
            }
            Self::SignedRational(v) => {
                v.iter().flat_map(|(n, d)| [n.to_le_bytes(), d.to_le_bytes()].concat()).collect()
            }
        }
    }
}

/// Writes header and fields of a little-endian file with one image in one strip of `rows` rows and `data_len`
/// bytes, which the caller writes next.
pub(crate) fn write_header(
    out: &mut impl Write,
    mut fields: BTreeMap<u16, Value>,
    rows: u32,
    data_len: u64,
) -> io::Result<()> {
    let too_long = || io::Error::new(io::ErrorKind::FileTooLarge, "a TIFF file ends at 4 GiB");
    fields.insert(ROWS_PER_STRIP, Value::Long(vec![rows]));
    fields.insert(STRIP_BYTE_COUNTS, Value::Long(vec![u32::try_from(data_len).map_err(|_| too_long())?]));
    fields.insert(STRIP_OFFSETS, Value::Long(vec![0]));

    let values_start = 8 + 2 + 12 * fields.len() + 4;
    let outside = |v: &Value| v.bytes().len().next_multiple_of(2);
    let values_len: usize = fields.values().map(outside).filter(|&n| n > 4).sum();
    let data_start = (values_start + values_len).next_multiple_of(16);
    u32::try_from(data_start as u64 + data_len).map_err(|_| too_long())?;
    fields.insert(STRIP_OFFSETS, Value::Long(vec![data_start as u32]));

    let mut head = b"II*\0\x08\0\0\0".to_vec();
    let mut values = Vec::with_capacity(values_len);
    head.extend((fields.len() as u16).to_le_bytes());
    for (tag, value) in &fields {
        head.extend(tag.to_le_bytes());
        head.extend(value.type_code().to_le_bytes());
        head.extend((value.count() as u32).to_le_bytes());
        let mut bytes = value.bytes();
        bytes.resize(bytes.len().next_multiple_of(2), 0);
        if bytes.len() <= 4 {
            bytes.resize(4, 0);
            head.extend(bytes);
        } else {
            head.extend(((values_start + values.len()) as u32).to_le_bytes());
            values.extend(bytes);
        }
    }
    head.extend([0; 4]);
    head.extend(values);
    head.resize(data_start, 0);
    out.write_all(&head)
}

/// A file to read fields from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tiff<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    kind: u16,
    count: usize,
    at: usize,
}

/// The fields of one image.
#[derive(Debug, Clone)]
pub(crate) struct Ifd<'a> {
    tiff: Tiff<'a>,
    entries: BTreeMap<u16, Entry>,
    next: usize,
}

impl<'a> Tiff<'a> {
    /// `None` when the file does not begin as a TIFF file does.
    pub(crate) fn new(bytes: &'a [u8]) -> Option<Self> {
        match bytes.get(..4)? {
            b"II*\0" => Some(Self { bytes, big_endian: false }),
            b"MM\0*" => Some(Self { bytes, big_endian: true }),
            _ => None,
        }
    }

    pub(crate) fn bytes(self) -> &'a [u8] {
        self.bytes
    }

    pub(crate) fn big_endian(self) -> bool {
        self.big_endian
    }

    fn array<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        let mut a: [u8; N] = self.bytes.get(at..at.checked_add(N)?)?.try_into().ok()?;
        if self.big_endian {
            a.reverse();
        }
        Some(a)
    }

    fn u16(self, at: usize) -> Option<u16> {
        self.array(at).map(u16::from_le_bytes)
    }

    fn u32(self, at: usize) -> Option<u32> {
        self.array(at).map(u32::from_le_bytes)
    }

    /// The fields at an offset; `None` where the file is cut short.
    pub(crate) fn ifd(self, at: usize) -> Option<Ifd<'a>> {
        let count = usize::from(self.u16(at)?);
        let mut entries = BTreeMap::new();
        for i in 0..count {
            let entry = at.checked_add(2 + 12 * i)?;
            let (tag, kind) = (self.u16(entry)?, self.u16(entry + 2)?);
            let count = self.u32(entry + 4)? as usize;
            let inside = size_of_type(kind).and_then(|s| s.checked_mul(count)).is_some_and(|n| n <= 4);
            let at = if inside { entry + 8 } else { self.u32(entry + 8)? as usize };
            entries.insert(tag, Entry { kind, count, at });
        }
        let next = self.u32(at.checked_add(2 + 12 * count)?).unwrap_or(0) as usize;
        Some(Ifd { tiff: self, entries, next })
    }

    /// The images of the file and their sub-images, at most 64.
    pub(crate) fn ifds(self) -> Vec<Ifd<'a>> {
        const MOST: usize = 64;
        let mut found: Vec<Ifd<'a>> = Vec::new();
        let mut seen = Vec::new();
        let mut pending = vec![self.u32(4).unwrap_or(0) as usize];
        while let Some(at) = pending.pop() {
            // Zero ends a chain; an offset seen before would never end.
            if at == 0 || seen.contains(&at) || found.len() >= MOST {
                continue;
            }
            seen.push(at);
            if let Some(ifd) = self.ifd(at) {
                pending.push(ifd.next);
                let subs = ifd.numbers(SUB_IFDS).unwrap_or_default();
                pending.extend(subs.iter().take(MOST).map(|&v| v as usize));
                found.push(ifd);
            }
        }
        found
    }
}

fn size_of_type(kind: u16) -> Option<usize> {
    match kind {
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 9 | 11 | 13 => Some(4),
        5 | 10 | 12 => Some(8),
        _ => None,
    }
}

impl<'a> Ifd<'a> {
    /// The content of a field as it lies in the file; `None` when it is absent or reaches beyond the end.
    pub(crate) fn raw(&self, tag: u16) -> Option<&'a [u8]> {
        let e = self.entries.get(&tag)?;
        let len = size_of_type(e.kind)?.checked_mul(e.count)?;
        self.tiff.bytes.get(e.at..e.at.checked_add(len)?)
    }

    /// A text up to its first zero byte.
    pub(crate) fn text(&self, tag: u16) -> Option<String> {
        let bytes = self.raw(tag)?;
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        Some(String::from_utf8_lossy(bytes.get(..end)?).into_owned())
    }

    /// All numbers of a field, whatever their type; fractions divided out.
    pub(crate) fn numbers(&self, tag: u16) -> Option<Vec<f64>> {
        self.raw(tag)?;
        let e = *self.entries.get(&tag)?;
        let size = size_of_type(e.kind)?;
        let t = self.tiff;
        (0..e.count)
            .map(|i| {
                let at = e.at + i * size;
                let second = |at: usize| t.array::<4>(at + 4);
                Some(match e.kind {
                    3 => f64::from(t.u16(at)?),
                    4 | 13 => f64::from(t.u32(at)?),
                    5 => f64::from(t.u32(at)?) / f64::from(u32::from_le_bytes(second(at)?)),
                    6 => f64::from(i8::from_le_bytes(t.array(at)?)),
                    8 => f64::from(i16::from_le_bytes(t.array(at)?)),
                    9 => f64::from(i32::from_le_bytes(t.array(at)?)),
                    10 => {
                        f64::from(i32::from_le_bytes(t.array(at)?))
                            / f64::from(i32::from_le_bytes(second(at)?))
                    }
                    11 => f64::from(f32::from_le_bytes(t.array(at)?)),
                    12 => f64::from_le_bytes(t.array(at)?),
                    _ => f64::from(*t.bytes.get(at)?),
                })
            })
            .collect()
    }

    /// The first number of a field.
    pub(crate) fn number(&self, tag: u16) -> Option<f64> {
        self.numbers(tag)?.first().copied()
    }

    /// The first number of a field where it is a count or size.
    pub(crate) fn size(&self, tag: u16) -> Option<usize> {
        self.number(tag).filter(|v| *v >= 0.0 && v.fract() == 0.0).map(|v| v as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_read_back() {
        let fields = BTreeMap::from([
            (IMAGE_WIDTH, Value::Long(vec![7])),
            (MAKE, Value::Ascii("Smalti".into())),
            (BITS_PER_SAMPLE, Value::Short(vec![8, 8, 8])),
            (50714, Value::Rational(vec![(1, 4)])),
            (50721, Value::SignedRational(vec![(-1, 2), (3, 1)])),
        ]);
        let mut out = Vec::new();
        write_header(&mut out, fields, 5, 3).unwrap();
        out.extend([1, 2, 3]);
        let tiff = Tiff::new(&out).unwrap();
        let ifds = tiff.ifds();
        assert_eq!(ifds.len(), 1);
        let i = &ifds[0];
        assert_eq!(i.size(IMAGE_WIDTH), Some(7));
        assert_eq!(i.text(MAKE).unwrap(), "Smalti");
        assert_eq!(i.numbers(BITS_PER_SAMPLE).unwrap(), [8.0; 3]);
        assert_eq!(i.number(50714), Some(0.25));
        assert_eq!(i.numbers(50721).unwrap(), [-0.5, 3.0]);
        let at = i.size(STRIP_OFFSETS).unwrap();
        assert_eq!(&out[at..], [1, 2, 3]);
    }

    #[test]
    fn a_chain_that_bites_its_tail_ends() {
        let mut bytes = b"II*\0\x08\0\0\0\0\0".to_vec();
        bytes.extend(8u32.to_le_bytes());
        assert_eq!(Tiff::new(&bytes).unwrap().ifds().len(), 1);
    }
}
