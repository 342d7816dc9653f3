//! DNG files as cameras write them: a preview first, the raw image as a sub-image with masked borders, in either byte order.

/// Content of a field.
#[derive(Clone)]
pub(crate) enum Value {
    Byte(Vec<u8>),
    Ascii(&'static str),
    Short(Vec<u16>),
    Long(Vec<u32>),
    SignedRational(Vec<[i32; 2]>),
    Double(Vec<f64>),
    Undefined(Vec<u8>),
}

/// A raw image and what its camera states about it.
#[derive(Clone)]
pub(crate) struct CameraDng {
    /// Samples of the active area, row by row.
    pub(crate) samples: Vec<u16>,
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    pub(crate) big_endian: bool,
    /// 16, or fewer, which are packed.
    pub(crate) bits: usize,
    /// Masked rows above and columns left of the active area. Half as many follow it.
    pub(crate) masked: [usize; 2],
    /// What lies beneath the light of each cell of 2 × 2; subtracted from the black level of the samples.
    pub(crate) darker: [u16; 4],
    pub(crate) black: u16,
    pub(crate) white: u16,
    pub(crate) orientation: u16,
    /// Row, column, rows and columns of the active area that make the picture.
    pub(crate) crop: [usize; 4],
    /// Further fields of the raw image, its mosaic among them.
    pub(crate) fields: Vec<(u16, Value)>,
}

impl Value {
    /// Type, count and bytes.
    fn encoded(&self, big: bool) -> (u16, usize, Vec<u8>) {
        fn all<T: Copy, const N: usize>(v: &[T], big: bool, ends: [fn(T) -> [u8; N]; 2]) -> Vec<u8> {
            v.iter().flat_map(|x| ends[usize::from(big)](*x)).collect()
        }
        match self {
            Self::Byte(v) => (1, v.len(), v.clone()),
            Self::Ascii(s) => (2, s.len() + 1, [s.as_bytes(), &[0]].concat()),
            Self::Short(v) => (3, v.len(), all(v, big, [u16::to_le_bytes, u16::to_be_bytes])),
            Self::Long(v) => (4, v.len(), all(v, big, [u32::to_le_bytes, u32::to_be_bytes])),
            Self::Undefined(v) => (7, v.len(), v.clone()),
            Self::SignedRational(v) => {
                (10, v.len(), all(v.as_flattened(), big, [i32::to_le_bytes, i32::to_be_bytes]))
            }
            Self::Double(v) => (12, v.len(), all(v, big, [f64::to_le_bytes, f64::to_be_bytes])),
        }
    }
}

/// A directory at an offset, followed by the content of its fields.
fn directory(fields: &[(u16, Value)], at: usize, big: bool) -> Vec<u8> {
    let mut fields = fields.to_vec();
    fields.sort_by_key(|(tag, _)| *tag);
    let short = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let long = |v: usize| if big { (v as u32).to_be_bytes() } else { (v as u32).to_le_bytes() };
    let values_at = at + 2 + 12 * fields.len() + 4;
    let (mut out, mut values) = (short(fields.len() as u16).to_vec(), Vec::new());
    for (tag, value) in &fields {
        let (kind, count, mut bytes) = value.encoded(big);
        out.extend([short(*tag), short(kind)].concat());
        out.extend(long(count));
        if bytes.len() <= 4 {
            bytes.resize(4, 0);
            out.extend(bytes);
        } else {
            out.extend(long(values_at + values.len()));
            bytes.resize(bytes.len().next_multiple_of(2), 0);
            values.extend(bytes);
        }
    }
    out.extend(long(0));
    out.extend(values);
    out
}

impl CameraDng {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let big = self.big_endian;
        let [top, left] = self.masked;
        let (rows, cols) = (self.rows + top + top / 2, self.cols + left + left / 2);
        let data = self.coded(rows, cols);
        let long = |v: &[usize]| Value::Long(v.iter().map(|v| *v as u32).collect());
        let [crop_row, crop_col, crop_rows, crop_cols] = self.crop;
        let raw = |data_at: usize| {
            let mut fields = vec![
                (254, long(&[0])),
                (256, long(&[cols])),
                (257, long(&[rows])),
                (258, Value::Short(vec![self.bits as u16])),
                (259, Value::Short(vec![1])),
                (262, Value::Short(vec![32803])),
                (273, long(&[data_at])),
                (277, Value::Short(vec![1])),
                (278, long(&[rows])),
                (279, long(&[data.len()])),
                (284, Value::Short(vec![1])),
                (50711, Value::Short(vec![1])),
                (50713, Value::Short(vec![2, 2])),
                (50714, Value::Short(self.darker.map(|d| self.black - d).to_vec())),
                (50717, Value::Long(vec![self.white.into()])),
                (50719, long(&[crop_col, crop_row])),
                (50720, long(&[crop_cols, crop_rows])),
                (50829, long(&[top, left, top + self.rows, left + self.cols])),
            ];
            fields.extend(self.fields.iter().cloned());
            fields
        };
        let preview = vec![90u8; 3 * 16 * 12];
        let first = |sub: usize, preview_at: usize| {
            vec![
                (254, long(&[1])),
                (256, long(&[16])),
                (257, long(&[12])),
                (258, Value::Short(vec![8; 3])),
                (259, Value::Short(vec![1])),
                (262, Value::Short(vec![2])),
                (271, Value::Ascii("Maker")),
                (272, Value::Ascii("Camera")),
                (273, long(&[preview_at])),
                (274, Value::Short(vec![self.orientation])),
                (277, Value::Short(vec![3])),
                (278, long(&[12])),
                (279, long(&[preview.len()])),
                (330, long(&[sub])),
                (50706, Value::Byte(vec![1, 4, 0, 0])),
                (50707, Value::Byte(vec![1, 3, 0, 0])),
                (50708, Value::Ascii("Maker Camera")),
                (50721, Value::SignedRational([9, -2, -1, -5, 13, 2, -1, 2, 6].map(|n| [n, 10]).to_vec())),
            ]
        };
        // Lengths do not depend on the places.
        let sub_at = 8 + directory(&first(0, 0), 8, big).len();
        let preview_at = sub_at + directory(&raw(0), sub_at, big).len();
        let data_at = preview_at + preview.len();
        let head: &[u8] = if big { b"MM\0*\0\0\0\x08" } else { b"II*\0\x08\0\0\0" };
        let directories =
            [directory(&first(sub_at, preview_at), 8, big), directory(&raw(data_at), sub_at, big)];
        [head, &directories.concat(), &preview, &data].concat()
    }

    /// The samples with their masked borders, row by row.
    fn coded(&self, rows: usize, cols: usize) -> Vec<u8> {
        let [top, left] = self.masked;
        let sample = |r: usize, c: usize| {
            let (row, col) = (r.wrapping_sub(top), c.wrapping_sub(left));
            // Masked samples have nothing to do with the picture.
            if row >= self.rows || col >= self.cols {
                return self.black / 2;
            }
            self.samples[row * self.cols + col] - self.darker[row % 2 * 2 + col % 2]
        };
        let mut out = Vec::new();
        for r in 0..rows {
            let row = (0..cols).map(|c| sample(r, c));
            if self.bits == 16 {
                let bytes = |v: u16| if self.big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
                out.extend(row.flat_map(bytes));
            } else {
                let bits: Vec<u8> =
                    row.flat_map(|v| (0..self.bits).rev().map(move |b| (v >> b & 1) as u8)).collect();
                out.extend(bits.chunks(8).map(|b| (0..8).fold(0u8, |a, i| a << 1 | b.get(i).unwrap_or(&0))));
            }
        }
        out
    }
}

/// An opcode list, of the numbers and parameters of its opcodes.
pub(crate) fn opcode_list(opcodes: &[(u32, Vec<u8>)]) -> Value {
    let mut out = (opcodes.len() as u32).to_be_bytes().to_vec();
    for (number, data) in opcodes {
        for v in [*number, 0x0103_0000, 0, data.len() as u32] {
            out.extend(v.to_be_bytes());
        }
        out.extend(data);
    }
    Value::Undefined(out)
}

/// A gain map for every sample of an image of one plane, with `points` × `points` gains over the whole image.
pub(crate) fn gain_map(
    rows: usize,
    cols: usize,
    points: usize,
    gain: impl Fn(usize, usize) -> f32,
) -> Vec<u8> {
    let whole = [0, 0, rows as u32, cols as u32, 0, 1, 1, 1, points as u32, points as u32];
    let spacing = 1.0 / (points - 1) as f64;
    let mut out: Vec<u8> = whole.iter().flat_map(|v| v.to_be_bytes()).collect();
    out.extend([spacing, spacing, 0.0, 0.0].iter().flat_map(|v: &f64| v.to_be_bytes()));
    out.extend(1u32.to_be_bytes());
    for r in 0..points {
        out.extend((0..points).flat_map(|c| gain(r, c).to_be_bytes()));
    }
    out
}
