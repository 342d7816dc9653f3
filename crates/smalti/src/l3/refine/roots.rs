//! Terms that colours have beyond the linear ones.
//!
//! The colours of a camera whose filters are not colour matching functions are no linear function of X, Y, Z. Roots of products of two channels
//! correct them better on surfaces that were not learned from ([finlayson2015]), and scale with the light as the channels do.
//!
//! [finlayson2015]: https://doi.org/10.1109/TIP.2015.2405336

use super::super::blocks::LANES;
use crate::numeric::simd::{Kernel, dispatch};

/// Number of terms.
pub(super) const ROOTS: usize = 3;

/// Linear red, green and blue of ITU-R BT.2020 from X, Y, Z: primaries so wide that hardly any surface has a negative channel.
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [1.716_651_2, -0.355_670_78, -0.253_366_3],
    [-0.666_684_3, 1.616_481_2, 0.015_768_547],
    [0.017_639_857, -0.042_770_613, 0.942_103_1],
];

/// √(r g), √(g b) and √(b r) of a colour. Negative channels count as 0.
#[inline(always)]
pub(super) fn roots(x: f32, y: f32, z: f32) -> [f32; ROOTS] {
    let channel = |m: [f32; 3]| {
        let value = m[0] * x + m[1] * y + m[2] * z;
        if value > 0.0 { value } else { 0.0 }
    };
    let [r, g, b] = RGB_FROM_XYZ.map(channel);
    [(r * g).sqrt(), (g * b).sqrt(), (b * r).sqrt()]
}

/// The roots of a colour in integers of any one unit, rounded to the nearest integer. Channels are rounded to the nearest integer, and negative ones count as 0.
pub(super) fn fixed_roots(colour: [i32; 3]) -> [i32; ROOTS] {
    let channel = |m: [f32; 3]| {
        // The coefficients have 30 binary places, so that they are exact.
        let products = m.map(|m| (f64::from(m) * f64::from(1u32 << 30)) as i64).into_iter().zip(colour);
        let sum: i64 = products.map(|(m, v)| m * i64::from(v)).sum();
        ((sum.max(0) + (1 << 29)) >> 30) as u64
    };
    let [r, g, b] = RGB_FROM_XYZ.map(channel);
    [r * g, g * b, b * r].map(|product| ((4 * product).isqrt() as i32 + 1) / 2)
}

/// The roots of a row: X, Y, Z and the terms, each in a line. All lines are equally long.
pub(super) fn roots_of_row(colours: [&[f32]; 3], out: &mut [Vec<f32>; ROOTS]) {
    dispatch(Row { colours, out });
}

struct Row<'a> {
    colours: [&'a [f32]; 3],
    out: &'a mut [Vec<f32>; ROOTS],
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [x, y, z] = self.colours.map(|line| line.as_chunks::<LANES>().0);
        let [a, b, c] = self.out.each_mut().map(|line| line.as_chunks_mut::<LANES>().0);
        let blocks = x.len().min(y.len()).min(z.len()).min(a.len()).min(b.len()).min(c.len());
        for block in 0..blocks {
            let (x, y, z) = (&x[block], &y[block], &z[block]);
            let (a, b, c) = (&mut a[block], &mut b[block], &mut c[block]);
            for i in 0..LANES {
                [a[i], b[i], c[i]] = roots(x[i], y[i], z[i]);
            }
        }
    }
}
