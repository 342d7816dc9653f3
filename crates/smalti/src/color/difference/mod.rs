//! Colour differences in CIELAB, one file per formula, and difference maps of images.

mod cie76;
mod cie94;
mod ciede2000;

use std::marker::PhantomData;

use rayon::prelude::*;

pub use cie76::delta_e_76;
pub use cie94::delta_e_94;
pub use ciede2000::delta_e_2000;

use super::cie1976::lab_from_xyz;
use super::{ColorSpace, Image, ImageError};
use crate::numeric::simd::{Kernel, dispatch};

/// Pixels per task, fixed so that results do not depend on the number of threads.
const CHUNK: usize = 4096;

/// A colour difference formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum DeltaE {
    /// Euclidean distance in CIELAB.
    Cie1976,
    /// CIE 1994 for graphic arts; the first colour is the standard.
    Cie1994,
    /// CIEDE2000.
    #[default]
    Ciede2000,
}

impl DeltaE {
    /// The difference between two colours in CIELAB.
    #[must_use]
    pub fn between(self, lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        match self {
            Self::Cie1976 => delta_e_76(lab1, lab2),
            Self::Cie1994 => delta_e_94(lab1, lab2),
            Self::Ciede2000 => delta_e_2000(lab1, lab2),
        }
    }
}

/// The colour difference at every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct DifferenceMap {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
    /// ΔE in row order.
    pub values: Vec<f32>,
}

impl DifferenceMap {
    /// The mean over all pixels; 0 for an empty map.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// The largest value; 0 for an empty map.
    #[must_use]
    pub fn max(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }
}

/// ΔE at every pixel of two images of equal size in [`ColorSpace::Xyz`], relative to a white in the same
/// scale.
///
/// # Errors
/// When an image is not in XYZ, or the sizes differ.
pub fn delta_e_map(
    reference: &Image,
    test: &Image,
    white: [f64; 3],
    formula: DeltaE,
) -> Result<DifferenceMap, ImageError> {
    check_pair(reference, test)?;
    let size = (reference.rows(), reference.cols());
    Ok(LabReference::new(size, reference.channels(), white).map(test.channels(), formula))
}

/// Checks that two images can be compared.
pub(crate) fn check_pair(reference: &Image, test: &Image) -> Result<(), ImageError> {
    reference.check_space(ColorSpace::Xyz)?;
    test.check_space(ColorSpace::Xyz)?;
    let (left, right) = ((reference.rows(), reference.cols()), (test.rows(), test.cols()));
    if left == right { Ok(()) } else { Err(ImageError::Size { left, right }) }
}

/// A reference in CIELAB, to which several images are compared.
#[derive(Debug, Clone)]
pub(crate) struct LabReference {
    size: (usize, usize),
    white: [f64; 3],
    /// Planes of L*, a*, b*.
    lab: [Vec<f64>; 3],
}

impl LabReference {
    /// Converts planes of X, Y, Z of `size` rows and columns, whose lengths have been checked.
    pub(crate) fn new(size: (usize, usize), xyz: [&[f32]; 3], white: [f64; 3]) -> Self {
        let mut lab = [(); 3].map(|()| vec![0.0; size.0 * size.1]);
        let [l, a, b] = &mut lab;
        let parts = l.par_chunks_mut(CHUNK).zip(a.par_chunks_mut(CHUNK)).zip(b.par_chunks_mut(CHUNK));
        parts.enumerate().for_each(|(chunk, ((l, a), b))| {
            dispatch(ToLab { xyz: xyz.map(|p| &p[chunk * CHUNK..][..l.len()]), white, lab: [l, a, b] });
        });
        Self { size, white, lab }
    }

    /// X, Y, Z of white.
    pub(crate) fn white(&self) -> [f64; 3] {
        self.white
    }

    /// ΔE of planes of X, Y, Z, whose lengths have been checked.
    pub(crate) fn map(&self, test: [&[f32]; 3], formula: DeltaE) -> DifferenceMap {
        let (rows, cols) = self.size;
        let mut values = vec![0.0f32; rows * cols];
        values.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
            let (at, len) = (chunk * CHUNK, out.len());
            let (xyz, white) = (test.map(|p| &p[at..][..len]), self.white);
            let reference = self.lab.each_ref().map(|p| &p[at..][..len]);
            let pair = Pair { xyz, white, reference, out };
            match formula {
                DeltaE::Cie1976 => dispatch(Differences::<Cie1976>(pair, PhantomData)),
                DeltaE::Cie1994 => dispatch(Differences::<Cie1994>(pair, PhantomData)),
                DeltaE::Ciede2000 => dispatch(Differences::<Ciede2000>(pair, PhantomData)),
            }
        });
        DifferenceMap { rows, cols, values }
    }
}

/// Pixels that are computed at once, in vectors.
const LANES: usize = 16;

/// Some values of three planes from an index on, with zeros after their end.
#[inline(always)]
fn lanes<T: Copy + Default>(planes: [&[T]; 3], at: usize, count: usize) -> [[T; LANES]; 3] {
    let mut out = [[T::default(); LANES]; 3];
    for (out, plane) in out.iter_mut().zip(planes) {
        out[..count].copy_from_slice(&plane[at..at + count]);
    }
    out
}

/// CIELAB of one of the lanes.
#[inline(always)]
fn lab_of([x, y, z]: &[[f32; LANES]; 3], lane: usize, white: [f64; 3]) -> [f64; 3] {
    lab_from_xyz([f64::from(x[lane]), f64::from(y[lane]), f64::from(z[lane])], white)
}

/// CIELAB of some pixels; all slices have one length.
struct ToLab<'a> {
    xyz: [&'a [f32]; 3],
    white: [f64; 3],
    lab: [&'a mut [f64]; 3],
}

impl Kernel for ToLab<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { xyz, white, mut lab } = self;
        for at in (0..xyz[0].len()).step_by(LANES) {
            let count = LANES.min(xyz[0].len() - at);
            let of = lanes(xyz, at, count);
            let [mut l, mut a, mut b] = [[0.0; LANES]; 3];
            for i in 0..LANES {
                [l[i], a[i], b[i]] = lab_of(&of, i, white);
            }
            for (out, values) in lab.iter_mut().zip([l, a, b]) {
                out[at..at + count].copy_from_slice(&values[..count]);
            }
        }
    }
}

/// A formula that loops over lanes contain: a function that is passed on would be called for every pixel.
trait Formula {
    fn between(lab1: [f64; 3], lab2: [f64; 3]) -> f64;
}

struct Cie1976;
struct Cie1994;
struct Ciede2000;

impl Formula for Cie1976 {
    #[inline(always)]
    fn between(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        delta_e_76(lab1, lab2)
    }
}

impl Formula for Cie1994 {
    #[inline(always)]
    fn between(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        delta_e_94(lab1, lab2)
    }
}

impl Formula for Ciede2000 {
    #[inline(always)]
    fn between(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        delta_e_2000(lab1, lab2)
    }
}

/// Some pixels and a reference in CIELAB; all slices have one length.
struct Pair<'a> {
    xyz: [&'a [f32]; 3],
    white: [f64; 3],
    reference: [&'a [f64]; 3],
    out: &'a mut [f32],
}

/// ΔE of a pair.
struct Differences<'a, F>(Pair<'a>, PhantomData<F>);

impl<F: Formula> Kernel for Differences<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Pair { xyz, white, reference, out } = self.0;
        for (chunk, out) in out.chunks_mut(LANES).enumerate() {
            let at = chunk * LANES;
            let (of, [l, a, b]) = (lanes(xyz, at, out.len()), lanes(reference, at, out.len()));
            let mut differences = [0.0; LANES];
            for i in 0..LANES {
                differences[i] = F::between([l[i], a[i], b[i]], lab_of(&of, i, white)) as f32;
            }
            out.copy_from_slice(&differences[..out.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Planes;

    /// XYZ of ISETCam's reference pairs against (95.047, 100, 108.883), and its ΔE 76, 94, 2000.
    const PAIRS: [([f64; 3], [f64; 3], [f64; 3]); 3] = [
        (
            [30.764112659150424, 42.451918914251394, 15.14678375253094],
            [31.59658942395125, 43.91297783763098, 15.999875935482336],
            [1.5634726777210028, 1.1604994275750429, 0.9357689797998079],
        ),
        (
            [61.83877493878611, 12.380196114964559, 32.390591530703105],
            [60.114838243365185, 13.271894932179265, 33.339451396224476],
            [10.0558612815655, 1.7299197389551637, 1.6492863458197207],
        ),
        (
            [6.881447233416562, 22.323896460701455, 85.6932677076033],
            [6.969765650754653, 21.044957457546232, 86.9062971789474],
            [7.646734996164636, 2.8461401880434836, 2.49810131643714],
        ),
    ];
    const WHITE: [f64; 3] = [95.047, 100.0, 108.883];
    const ALL: [DeltaE; 3] = [DeltaE::Cie1976, DeltaE::Cie1994, DeltaE::Ciede2000];

    #[test]
    fn agrees_with_isetcam() {
        for (xyz1, xyz2, expected) in PAIRS {
            for (formula, expected) in ALL.into_iter().zip(expected) {
                let got = formula.between(lab_from_xyz(xyz1, WHITE), lab_from_xyz(xyz2, WHITE));
                // ISETCam rounds (6/29)³, so the last digits differ.
                assert!((got - expected).abs() < 1e-6, "{formula:?}: {got} is not {expected}");
            }
        }
    }

    #[test]
    fn a_map_holds_the_difference_of_each_pixel() {
        let image = |second: bool| {
            let data = (0..3)
                .flat_map(|c| PAIRS.iter().map(move |p| if second { p.1[c] } else { p.0[c] } as f32))
                .collect();
            Image::new(ColorSpace::Xyz, Planes::new(1, 3, 3, data).unwrap()).unwrap()
        };
        for (k, formula) in ALL.into_iter().enumerate() {
            let map = delta_e_map(&image(false), &image(true), WHITE, formula).unwrap();
            for (got, pair) in map.values.iter().zip(PAIRS) {
                assert!((f64::from(*got) - pair.2[k]).abs() < 1e-4);
            }
            let mean = PAIRS.iter().map(|p| p.2[k]).sum::<f64>() / 3.0;
            assert!((map.mean() - mean).abs() < 1e-4);
        }
    }

    #[test]
    fn pictures_that_cannot_be_compared_are_refused() {
        let image = |space, cols| Image::new(space, Planes::zeros(2, cols, 3)).unwrap();
        let compare = |a: &Image, b: &Image| delta_e_map(a, b, WHITE, DeltaE::Cie1976);
        let xyz = image(ColorSpace::Xyz, 2);
        assert!(matches!(compare(&xyz, &image(ColorSpace::Xyz, 3)), Err(ImageError::Size { .. })));
        assert!(matches!(compare(&xyz, &image(ColorSpace::Srgb, 2)), Err(ImageError::Space { .. })));
    }
}
