//! Polynomials of the second degree in 64 bits.

/// `c[0] + (x (c[1] + (x c[2] >> places[1])) >> places[0])` of a number x from 0 on, in 64 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Polynomial {
    /// Coefficients, none negative. The second has `places[0]` binary places, the third `places[0] + places[1]`.
    pub coefficients: [i64; 3],
    /// Binary places.
    pub places: [u32; 2],
}

/// Most binary places of a coefficient beyond those of the one before.
const MAX_PLACES: u32 = 40;
/// What a product may reach.
const LIMIT: f64 = (1u64 << 62) as f64;

impl Polynomial {
    /// From coefficients for x up to `most`, with as many binary places as 64 bits allow. `None` where its values need more than `bits` bits.
    pub(super) fn new([c0, c1, c2]: [f64; 3], most: f64, bits: u32) -> Option<Self> {
        let power = |places: u32| (1u64 << places) as f64;
        let whole = c0 + (c1 + c2 * most) * most;
        // No number is below what is not one.
        let fits = whole + 1.0 < power(bits);
        if !fits {
            return None;
        }
        // One is left for rounding.
        let first = (0..=MAX_PLACES).rev().find(|&p| ((c1 + c2 * most) * power(p) + 2.0) * most < LIMIT)?;
        let second = (0..=MAX_PLACES).rev().find(|&p| (c2 * power(first) * power(p) + 1.0) * most < LIMIT)?;
        let scaled = [c0, c1 * power(first), c2 * power(first) * power(second)];
        Some(Self { coefficients: scaled.map(|v| v.round() as i64), places: [first, second] })
    }

    /// The value at a number that is not negative and within the range.
    #[inline]
    pub(super) fn at(&self, x: i64) -> i64 {
        let ([c0, c1, c2], [first, second]) = (self.coefficients, self.places);
        c0 + ((x * (c1 + ((x * c2) >> second))) >> first)
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomial;

    #[test]
    fn values_are_those_of_the_coefficients() {
        let most = f64::from(1u32 << 27);
        for c in [[1e9, 0.0, 0.0], [3.0, 1e-3, 1e-12], [1e12, 54.2, 1e-6], [5e5, 1e4, 2e-2]] {
            let p = Polynomial::new(c, most, 62).unwrap();
            for x in [0.0, 1.0, 1e3, 1e6, most] {
                let exact = c[0] + (c[1] + c[2] * x) * x;
                let found = p.at(x as i64) as f64;
                assert!((found - exact).abs() <= 1.5 + 1e-6 * exact, "{c:?} at {x}: {found}, {exact}");
            }
        }
        assert_eq!(Polynomial::new([1e13, 0.0, 0.0], most, 40), None);
        assert_eq!(Polynomial::new([f64::NAN, 0.0, 0.0], most, 40), None);
    }
}
