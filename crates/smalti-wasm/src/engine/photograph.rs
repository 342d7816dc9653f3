//! A photograph of the visitor as the source of a scene.

use smalti::camera::{CameraError, TestScene};
use smalti::color::jakob_hanika2019::Uplift;
use smalti::color::{ColorSpace, Image};
use smalti::design::live::{LiveScene, LiveSetup};
use smalti::numeric::Planes;
use smalti::scene::Setting;
use smalti::sensor::SensorError;
use smalti::spectrum::Observer;
use smalti_io::studio::COMPONENTS;
use smalti_io::{Quantity, SpectralFile};

use super::EngineError;

/// Pixels along a side of a photograph.
const SIDES: std::ops::RangeInclusive<usize> = 32..=1024;
/// The most pixels of a photograph.
const MAX_PIXELS: usize = 400_000;

/// A photograph, RGBA in sRGB.
pub(super) struct Photograph {
    size: [usize; 2],
    pixels: Vec<[u8; 4]>,
}

impl Photograph {
    pub(super) fn new(size: [usize; 2], rgba: &[u8]) -> Result<Self, EngineError> {
        let [rows, cols] = size;
        let fits = SIDES.contains(&rows) && SIDES.contains(&cols) && rows * cols <= MAX_PIXELS;
        let (pixels, rest) = rgba.as_chunks::<4>();
        if !fits || pixels.len() != rows * cols || !rest.is_empty() {
            return Err(EngineError::Photograph(format!(
                "{rows} × {cols} pixels in {} bytes; expected sides of {} to {} pixels, at most {MAX_PIXELS} pixels, four bytes each",
                rgba.len(),
                SIDES.start(),
                SIDES.end()
            )));
        }
        if pixels.iter().all(|[r, g, b, _]| [*r, *g, *b] == [0; 3]) {
            return Err(EngineError::Photograph("every pixel is black; expected one that is not".into()));
        }
        Ok(Self { size, pixels: pixels.to_vec() })
    }

    /// The light of the photograph behind the lens and on the pixels of a setup, one pixel of the photograph on each. Its pixels become smooth
    /// reflectances under the illuminant of the setup (Jakob and Hanika 2019), as for `smalti simulate` with a picture.
    pub(super) fn light(&self, id: &str, setup: &LiveSetup) -> Result<LiveScene, EngineError> {
        let image = linear(self.size, &self.pixels)?;
        let uplift = Uplift::new(setup.bare.grid()?, Observer::Cie1931);
        let cube = uplift.and_then(|u| u.uplift_image(&image));
        let file = SpectralFile {
            name: id.to_owned(),
            cube: cube.map_err(|e| EngineError::Photograph(e.to_string()))?,
            quantity: Quantity::Reflectance,
            illuminant: None,
            distance_m: None,
            horizontal_fov_deg: None,
        };
        let setting =
            Setting { luminance_cd_m2: 1.0, illuminant: setup.illuminant.clone(), ..Setting::default() };
        Ok(setup.scene(&TestScene::relit(id, file.into_scene(&setting)?, 1), COMPONENTS)?)
    }
}

fn linear([rows, cols]: [usize; 2], pixels: &[[u8; 4]]) -> Result<Image, CameraError> {
    let values = (0..3).flat_map(|c| pixels.iter().map(move |p| f32::from(p[c]) / 255.0)).collect();
    let planes = Planes::new(rows, cols, 3, values).map_err(SensorError::from)?;
    Ok(Image::new(ColorSpace::Srgb, planes)?.converted(ColorSpace::LinearSrgb)?)
}
