//! Runs the same work on several items: in parallel if they are small, otherwise in sequence.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::camera::Setup;

/// The largest number of values, samples × wavelengths, of the optical image of a small scene: 64 MiB. Work on a larger one occupies all processors by itself, and
/// several at once would take several times its memory.
const MOST_VALUES: usize = 1 << 24;

/// Whether a scene is so small that work on several of its kind runs in parallel.
pub(super) fn is_small(scene: &Setup) -> bool {
    scene.image.irradiance().planes().data().len() <= MOST_VALUES
}

/// The results for all items in their order, or the error of the first item in this order that fails. Items after one that has failed are not begun.
pub(super) fn in_parallel<T, R, E>(
    items: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> Result<R, E> + Sync + Send,
) -> Result<Vec<R>, E>
where
    T: Send,
    R: Send,
    E: Send,
{
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

/// [`in_parallel`] for small items, otherwise the same one after another.
pub(super) fn in_parallel_if<T, R, E>(
    are_small: bool,
    items: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> Result<R, E> + Sync + Send,
) -> Result<Vec<R>, E>
where
    T: Send,
    R: Send,
    E: Send,
{
    if are_small { in_parallel(items, work) } else { items.into_iter().map(work).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_and_errors_come_in_the_order_of_the_items() {
        for are_small in [true, false] {
            let squares = in_parallel_if(are_small, 0..100_u32, |i| Ok::<_, u32>(i * i));
            assert_eq!(squares, Ok((0..100).map(|i| i * i).collect()));
            let work = |i: u32| if i % 30 == 29 { Err(i) } else { Ok(i) };
            assert_eq!(in_parallel_if(are_small, 0..100_u32, work), Err(29));
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
        assert_eq!(one_thread.install(|| in_parallel(0..1000_u32, work)), Err(0));
        assert_eq!(begun.into_inner(), 1);
    }
}
