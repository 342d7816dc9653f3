//! Every file format Smalti reads and writes. This crate is the only one that opens files.
//!
//! | module | formats | to and from |
//! |---|---|---|
//! | [`spectrum_csv`] | CSV | [`smalti::spectrum::Spectrum`] |
//! | [`envi`] | ENVI header and samples | [`SpectralFile`] |
//! | [`exr`] | spectral OpenEXR (PBRT and Fichet et al. 2021 layouts) | [`SpectralFile`], [`smalti::scene::Scene`] |
//! | [`matlab`] | MAT-files of level 5 and version 7.3: scenes of ISETCam; ICVL, ARAD in | [`SpectralFile`] |
//! | [`hdf5`] | HDF5: any cube with its wavelengths, KAUST | [`SpectralFile`] |
//! | [`picture`] | PNG, TIFF, JPEG, OpenEXR RGB in; PNG, TIFF out | [`smalti::color::Image`] |
//! | [`dng`] | DNG | [`smalti::sensor::RawImage`] |
//! | [`l3`] | `.l3` (safetensors) in and out; `.npz`, C header out | [`smalti::l3::Pipeline`], [`smalti::l3::Statistics`] |
//! | [`light`] | `.light` (safetensors) | [`smalti::design::light::LightStatistics`] |
//! | [`npz`] | `.npy` and `.npz` that hold a cube | [`SpectralFile`] |
//! | [`spectral_tiff`] | TIFF of many bands | [`SpectralFile`] |
//! | [`bands`] | folder of PNG, one a band (CAVE) | [`SpectralFile`] |
//! | [`npy`], [`stages`] | NumPy arrays and a JSON of their units | slices |
//! | [`cache`] | own | [`smalti::optics::OpticalImage`] |
//! | [`dataset`] | folders of Parquet files, and their manifest | [`dataset::Column`] |
//! | [`cameras`] | TOML | [`smalti::camera::Camera`] |
//! | [`studies`] | TOML | [`smalti::design::Trials`] |
//! | [`studio`] | own | [`smalti::design::live::LiveScene`], [`smalti::design::live::LiveTraining`] |
//! | [`sweeps`] | a study and its folder of results | [`dataset::Plan`], [`dataset::Run`] |
//! | [`comparisons`] | the folder of a comparison | [`comparisons::ComparisonFiles`] |
//! | [`ratings`] | the folder of a rating experiment | [`smalti::experiment::RatedScene`], [`smalti::rating::Trial`] |
//! | [`lights`] | a name, or CSV | [`smalti::spectrum::Illuminant`] |
//! | [`scene_file`] | whatever holds a scene | [`smalti::scene::Scene`] |
//! | [`scenes`] | a name, or a scene file | [`smalti::scene::Scene`] |
//! | [`rendered`] | the built-in path-traced scenes and photographs | [`smalti::scene::Scene`] |
//! | [`text`] | UTF-8 | `String` |
//! | [`memory`] | `/proc/meminfo` | bytes |
//!
//! Every reader has a function for a path (`read`, or `open` for spectral images that are read by parts) and one for bytes in memory,
//! `from_bytes`. `open` reads samples as they are needed, and ignores the part that its options ask for: [`scene_file::load`] takes
//! it. No reader panics on any input, and none takes memory for what a header declares before that has been compared with
//! what the file can hold. Every writer writes to a temporary file beside the target and renames it: a target is either whole or as it
//! was.
//!
//! The features `hdf5` and `parquet` are on by default. A build without one of them is smaller and sooner made, and refuses files in that
//! format with [`IoError::LeftOut`].

// What only a format that is left out needs stays, so that its features need no mark.
#![cfg_attr(not(all(feature = "hdf5", feature = "parquet")), allow(dead_code))]

pub mod bands;
pub mod cache;
mod camera_toml;
pub mod cameras;
pub mod comparisons;
mod container;
pub mod dataset;
pub mod designs;
mod diagnostic;
pub mod dng;
pub mod envi;
mod error;
pub mod exr;
mod file;
pub mod hdf5;
mod icc;
pub mod l3;
pub mod light;
pub mod lights;
pub mod matlab;
pub mod memory;
pub mod npy;
pub mod npz;
mod orientation;
pub mod picture;
mod raster;
pub mod ratings;
pub mod rendered;
pub mod scene_file;
pub mod scenes;
pub mod spectral_tiff;
pub mod spectrum_csv;
pub mod stages;
pub mod studies;
pub mod studio;
pub mod sweeps;
pub mod test_scenes;
pub mod text;
mod tiff;
mod toml_source;
mod variables;
mod wavelengths;
pub mod write;

pub use camera_toml::Override;
pub use diagnostic::Diagnostic;
pub use error::{ContentError, IoError, UnstatedProperty};
pub use file::Limits;
pub use orientation::Orientation;
pub use scene_file::{Quantity, ReadOptions, SpectralFile};
pub use scenes::SceneRequest;
pub use toml_source::{BuiltinFile, TomlSource};
