//! Terms that colours have beyond the linear ones.
//!
//! The colours of a camera whose filters are not colour matching functions are no linear function of X, Y, Z. Roots of products of two channels
//! correct them better on surfaces that were not learned from ([finlayson2015]), and scale with the light as the channels do.
//!
//! [finlayson2015]: https://doi.org/10.1109/TIP.2015.2405336

use super::super::blocks::LANES;
use crate::color::display::Matrices;
use crate::numeric::simd::{Kernel, dispatch};

/// Number of terms.
pub(super) const ROOTS: usize = 3;

/// Red, green and blue of the roots from X, Y, Z: linear ITU-R BT.2020, whose primaries are so wide that hardly any surface has a negative
/// channel.
pub const REFINEMENT_RGB_FROM_XYZ: [[f32; 3]; 3] = {
    let [r, g, b] = Matrices::BT2020.rgb_from_xyz;
    [single(r), single(g), single(b)]
};

const fn single([x, y, z]: [f64; 3]) -> [f32; 3] {
    [x as f32, y as f32, z as f32]
}

/// Binary places of the coefficients in integers, in which they are exact.
const PLACES: u32 = 30;

/// √(r g), √(g b) and √(b r) of a colour. Negative channels count as 0.
#[inline(always)]
pub(super) fn roots(x: f32, y: f32, z: f32) -> [f32; ROOTS] {
    let channel = |m: [f32; 3]| {
        let value = m[0] * x + m[1] * y + m[2] * z;
        if value > 0.0 { value } else { 0.0 }
    };
    let [r, g, b] = REFINEMENT_RGB_FROM_XYZ.map(channel);
    [(r * g).sqrt(), (g * b).sqrt(), (b * r).sqrt()]
}

/// [`REFINEMENT_RGB_FROM_XYZ`] with 30 binary places.
pub(super) fn fixed_rgb_from_xyz() -> [[i64; 3]; 3] {
    REFINEMENT_RGB_FROM_XYZ.map(|row| row.map(|m| (f64::from(m) * f64::from(1u32 << PLACES)) as i64))
}

/// The roots of a colour in integers of any one unit, rounded to the nearest integer. Channels are rounded as well, and negative ones count
/// as 0. The coefficients are those of [`fixed_rgb_from_xyz`].
pub(super) fn fixed_roots(rgb_from_xyz: &[[i64; 3]; 3], colour: [i32; 3]) -> [i32; ROOTS] {
    let [r, g, b] = rgb_from_xyz.map(|m| {
        let sum: i64 = m.into_iter().zip(colour).map(|(m, v)| m * i64::from(v)).sum();
        ((sum.max(0) + (1 << (PLACES - 1))) >> PLACES) as u64
    });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// Of colours whose channels are their X, Y and Z. A root r is the nearest to √p where (2 r − 1)² < 4 p < (2 r + 1)².
    #[test]
    fn integer_roots_are_the_nearest_integers() {
        let one = 1i64 << PLACES;
        let own = [[one, 0, 0], [0, one, 0], [0, 0, one]];
        let mut random = Stream::new(3, 5, 7);
        let mut wide = |bits: u32| (random.below(1 << bits) as i32) - (1 << (bits - 3));
        // Up to the 8 times white at which pictures saturate.
        let large = (0..3000).map(|i| [0; 3].map(|_| wide(3 + i % 21)));
        let small = (0..4096).map(|i| [i / 256, i / 16 % 16, i % 16]);
        for colour in small.chain(large) {
            let [r, g, b] = colour.map(|v| i64::from(v.max(0)));
            for (root, product) in fixed_roots(&own, colour).into_iter().zip([r * g, g * b, b * r]) {
                let twice = 2 * i64::from(root);
                let least = (twice - 1).max(0).pow(2);
                assert!((least..(twice + 1).pow(2)).contains(&(4 * product)), "{colour:?}: {root}");
            }
        }
    }

    #[test]
    fn a_row_has_the_roots_of_its_colours() {
        let mut random = Stream::new(4, 5, 7);
        let [x, y, z]: [Vec<f32>; 3] =
            std::array::from_fn(|_| (0..3 * LANES).map(|_| random.uniform() as f32 - 0.2).collect());
        let mut rows = [0; ROOTS].map(|_| vec![f32::NAN; 3 * LANES]);
        roots_of_row([&x, &y, &z], &mut rows);
        for i in 0..3 * LANES {
            assert_eq!(rows.each_ref().map(|row| row[i]), roots(x[i], y[i], z[i]));
        }
    }
}
