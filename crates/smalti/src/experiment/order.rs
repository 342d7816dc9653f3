//! The order of the same work on several items: in parallel if they are small, otherwise in sequence.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::camera::Setup;

/// The largest number of values, samples × wavelengths, of the optical image of a small scene: 64 MiB. Work on a larger one occupies all processors by itself, and
/// several at once would take several times its memory.
const MOST_VALUES: usize = 1 << 24;

/// The order of the same work on several items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Parallel,
    Sequence,
}

impl Order {
    /// The order of work on scenes of this kind. Without any, their size is not known, and they come in sequence.
    pub(super) fn of(scenes: &[Setup]) -> Self {
        let is_small = |scene: &Setup| scene.image.irradiance().planes().data().len() <= MOST_VALUES;
        if !scenes.is_empty() && scenes.iter().all(is_small) { Self::Parallel } else { Self::Sequence }
    }

    /// The results for all items in the order of these, or the error of the first item that fails. Items after one that has failed are not begun.
    pub(super) fn map<T, R, E>(
        self,
        items: impl IntoIterator<Item = T>,
        work: impl Fn(T) -> Result<R, E> + Sync + Send,
    ) -> Result<Vec<R>, E>
    where
        T: Send,
        R: Send,
        E: Send,
    {
        if self == Self::Sequence {
            return items.into_iter().map(work).collect();
        }
        let failed = AtomicUsize::new(usize::MAX);
        let at = |(number, item): (usize, T)| {
            if failed.load(Ordering::Relaxed) < number {
                return None;
            }
            let result = work(item);
            if result.is_err() {
                failed.fetch_min(number, Ordering::Relaxed);
            }
            Some(result)
        };
        let items: Vec<T> = items.into_iter().collect();
        let results: Vec<Option<Result<R, E>>> = items.into_par_iter().enumerate().map(at).collect();
        results.into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_and_errors_come_in_the_order_of_the_items() {
        for order in [Order::Parallel, Order::Sequence] {
            let squares = order.map(0..100_u32, |i| Ok::<_, u32>(i * i));
            assert_eq!(squares, Ok((0..100).map(|i| i * i).collect()));
            let work = |i: u32| if i % 30 == 29 { Err(i) } else { Ok(i) };
            assert_eq!(order.map(0..100_u32, work), Err(29));
        }
    }

    #[test]
    fn no_item_begins_after_one_that_failed() {
        let begun = AtomicUsize::new(0);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let work = |i: u32| {
            begun.fetch_add(1, Ordering::Relaxed);
            if i == 0 { Err(i) } else { Ok(i) }
        };
        assert_eq!(one_thread.install(|| Order::Parallel.map(0..1000_u32, work)), Err(0));
        assert_eq!(begun.into_inner(), 1);
    }
}
