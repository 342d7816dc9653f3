//! MAT-files of level 5, which MATLAB writes with `-v6` (plain) and `-v7` (compressed), Octave with the same options and
//! SciPy with `savemat`. After "MAT-File Format", The MathWorks (R2023b).

pub(super) mod read;
pub(super) mod write;

/// Types of data elements.
mod tag {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT8: u32 = 2;
    pub(super) const INT16: u32 = 3;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const INT64: u32 = 12;
    pub(super) const UINT64: u32 = 13;
    pub(super) const MATRIX: u32 = 14;
    pub(super) const COMPRESSED: u32 = 15;
    pub(super) const UTF8: u32 = 16;
    pub(super) const UTF16: u32 = 17;
    pub(super) const UTF32: u32 = 18;
}

/// Classes of arrays.
mod class {
    pub(super) const CELL: u8 = 1;
    pub(super) const STRUCT: u8 = 2;
    pub(super) const OBJECT: u8 = 3;
    pub(super) const CHAR: u8 = 4;
    pub(super) const SPARSE: u8 = 5;
    pub(super) const DOUBLE: u8 = 6;
    pub(super) const SINGLE: u8 = 7;
    pub(super) const UINT64: u8 = 15;
}

/// Bits of the flags of an array.
mod flag {
    pub(super) const COMPLEX: u8 = 0x08;
}

const HEADER_BYTES: u64 = 128;
