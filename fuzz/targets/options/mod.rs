//! What the readers of spectral files are tried with: as it is, and with all that may be given by hand.

use smalti::scene::Setting;
use smalti::spectrum::WavelengthGrid;
use smalti_io::scene_file::Crop;
use smalti_io::{IoError, Limits, Quantity, ReadOptions, SpectralFile};

pub fn each(read: impl Fn(&ReadOptions) -> Result<SpectralFile, IoError>) {
    let limits = Limits { file_bytes: 1 << 20, decoded_bytes: 64 << 20 };
    let plain = ReadOptions { limits, ..ReadOptions::default() };
    let given = ReadOptions {
        clamp_negative: true,
        grid: WavelengthGrid::new(400.0, 50.0, 3).ok(),
        quantity: Some(Quantity::Reflectance),
        crop: Some(Crop { row: 1, col: 0, rows: 1, cols: 2 }),
        ..plain.clone()
    };
    if let Ok(file) = read(&plain) {
        let _ = file.into_scene(&Setting::default());
    }
    let _ = read(&given);
}
