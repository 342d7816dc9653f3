//! The path-traced scenes of Smalti, apart from the code that reads them because a crate of the registry may have 10 MiB.
//!
//! Each constant is a file of spectral radiance as principal components, which `smalti-io` decodes. `tools/scenes` in the repository makes
//! them, and its README states sources and errors.
#![no_std]
#![forbid(unsafe_code)]

/// A head with measured skin, hair and fabrics.
pub const PORTRAIT: &[u8] = include_bytes!("../data/portrait.spc");
/// A garden under sun and sky.
pub const FOLIAGE: &[u8] = include_bytes!("../data/foliage.spc");
/// Fabrics and food on a table.
pub const TABLE: &[u8] = include_bytes!("../data/table.spc");
/// A street at night.
pub const STREET: &[u8] = include_bytes!("../data/street.spc");
/// A shop shelf with packaging.
pub const SHELF: &[u8] = include_bytes!("../data/shelf.spc");
/// A living room.
pub const INTERIOR: &[u8] = include_bytes!("../data/interior.spc");
/// Objects of many reflectances, to learn from.
pub const CLUTTER_1: &[u8] = include_bytes!("../data/clutter-1.spc");
/// Others of the same kind.
pub const CLUTTER_2: &[u8] = include_bytes!("../data/clutter-2.spc");
