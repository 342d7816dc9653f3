//! Counting and numbering of combinations, so that any combination can be computed from its number.

/// The number of ways to choose `k` of `n`; `None` when it is above 2¹²⁸ − 1.
#[must_use]
pub fn binomial(n: u128, k: u32) -> Option<u128> {
    let k = u128::from(k);
    if k > n {
        return Some(0);
    }
    let mut value: u128 = 1;
    for i in 1..=k.min(n - k) {
        // value × factor / i is an integer. Dividing by the common divisor first makes the product overflow only when the
        // result does.
        let shared = gcd(value, i);
        value = (value / shared).checked_mul((n - (i - 1)) / (i / shared))?;
    }
    Some(value)
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The `index`-th set of `k` numbers below `n`, ascending; `None` when there is none. Sets are ordered by their largest
/// member, then by the next (combinatorial number system). The cost is O(k² log n).
#[must_use]
pub fn combination(n: u64, k: u32, index: u128) -> Option<Vec<u64>> {
    if binomial(n.into(), k).is_some_and(|count| index >= count) {
        return None;
    }
    let (mut above, mut rest) = (n, index);
    let mut members = Vec::with_capacity(k as usize);
    for i in (1..=k).rev() {
        // The largest member with at most `rest` sets below it. `None` stands for a number of sets above 2¹²⁸ − 1.
        let (mut low, mut high) = (u64::from(i) - 1, above);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            match binomial(middle.into(), i) {
                Some(below) if below <= rest => low = middle,
                _ => high = middle,
            }
        }
        rest -= binomial(low.into(), i)?;
        members.push(low);
        above = low;
    }
    members.reverse();
    Some(members)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pascal_and_known_values() {
        for n in 1..60 {
            for k in 1..=n as u32 {
                let sum = binomial(n - 1, k - 1).unwrap() + binomial(n - 1, k).unwrap();
                assert_eq!(binomial(n, k), Some(sum));
            }
        }
        assert_eq!(binomial(52, 5), Some(2_598_960));
        assert_eq!(
            (binomial(0, 0), binomial(3, 4), binomial(u128::MAX, 1)),
            (Some(1), Some(0), Some(u128::MAX))
        );
        // C(131, 66) is the largest middle one below 2¹²⁸.
        assert!(binomial(131, 66).is_some() && binomial(132, 66).is_none());
        assert_eq!(binomial(u128::MAX, 2), None);
    }

    #[test]
    fn all_sets_in_order() {
        let sets: Vec<_> = (0..20).map_while(|i| combination(5, 3, i)).collect();
        assert_eq!(sets.len(), 10);
        assert_eq!(sets[..4], [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]);
        assert_eq!(combination(5, 0, 0), Some(vec![]));
        assert_eq!((combination(5, 0, 1), combination(2, 3, 0)), (None, None));
    }

    proptest! {
        #[test]
        fn numbering_and_its_inverse(n in 1u64..5000, k in 1u32..9, index: u128) {
            let count = binomial(n.into(), k).unwrap();
            prop_assume!(count > 0);
            let index = index % count;
            let set = combination(n, k, index).unwrap();
            prop_assert!(set.len() == k as usize && set.windows(2).all(|w| w[0] < w[1]) && set[k as usize - 1] < n);
            let rank: u128 = (1..).zip(&set).map(|(i, &member)| binomial(member.into(), i).unwrap()).sum();
            prop_assert_eq!(rank, index);
            prop_assert_eq!(combination(n, k, count), None);
        }
    }
}
