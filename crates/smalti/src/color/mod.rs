//! Colour: tristimulus values, uniform colour spaces, colour differences, adaptation, display spaces, S-CIELAB.
//!
//! Functions of single colours take `[f64; 3]`. Images are `f32` planes in an [`Image`] and are processed in
//! parallel; results do not depend on the number of threads.

pub mod adaptation;
pub mod cct;
pub mod cie1976;
mod convert;
pub mod difference;
pub mod display;
mod image;
pub mod jakob_hanika2019;
pub mod matrix;
pub mod repaint;
pub mod scielab;
mod sigmoid;
mod viewing;

pub use cie1976::{lab_from_xyz, upvp_from_xyz, uv_from_xyz, xyz_from_lab, xyz_from_xy};
pub use difference::{DeltaE, DifferenceMap};
pub use image::{ColorSpace, Image, ImageError};
pub use viewing::{SRGB_WHITE, srgb8_from_lab};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::jakob_hanika2019::Uplift;
    use crate::color::repaint::Repaint;
    use crate::numeric::Planes;
    use crate::spectrum::{Observer, WavelengthGrid};

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let picture = |seed: usize| {
            let data = (0..3 * 131 * 257).map(|i| ((i * 7919 + seed * 31) % 1021) as f32 / 1020.0).collect();
            Image::new(ColorSpace::LinearSrgb, Planes::new(131, 257, 3, data).unwrap()).unwrap()
        };
        let (a, b) = (picture(0), picture(1));
        let run = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                let [x, y] = [&a, &b].map(|i| i.converted(ColorSpace::Xyz).unwrap());
                let map = scielab::scielab(&x, &y, [0.95047, 1.0, 1.08883], 40.0, DeltaE::Ciede2000).unwrap();
                let uplift = Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
                let repaint = Repaint::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
                let spectra = (uplift.uplift_image(&a).unwrap(), repaint.repaint_image(&a).unwrap());
                (map, a.converted(ColorSpace::DisplayP3).unwrap(), spectra)
            })
        };
        assert!(run(1) == run(3));
    }
}
