//! The same work on several things: at once where each is small, otherwise one after another.

use rayon::prelude::*;

use crate::camera::Setup;

/// The most samples of a small scene. The work on a larger one fills the processors by itself, and several at once would take several times its memory.
const MOST_SAMPLES: usize = 1 << 20;

/// Whether the pictures of a scene are small.
pub(super) fn is_small(scene: &Setup) -> bool {
    let sensor = &scene.camera.sensor;
    sensor.rows.saturating_mul(sensor.cols) <= MOST_SAMPLES
}

/// The results for all items in their order, or the error of the first item in this order that fails.
pub(super) fn side_by_side<T, R, E>(
    items: impl IntoIterator<Item = T>,
    are_small: bool,
    work: impl Fn(T) -> Result<R, E> + Sync + Send,
) -> Result<Vec<R>, E>
where
    T: Send,
    R: Send,
    E: Send,
{
    if !are_small {
        return items.into_iter().map(work).collect();
    }
    let items: Vec<T> = items.into_iter().collect();
    items.into_par_iter().map(work).collect::<Vec<_>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_and_errors_come_in_the_order_of_the_items() {
        for are_small in [true, false] {
            let squares = side_by_side(0..100_u32, are_small, |i| Ok::<_, u32>(i * i));
            assert_eq!(squares, Ok((0..100).map(|i| i * i).collect()));
            let failing = side_by_side(0..100_u32, are_small, |i| if i % 30 == 29 { Err(i) } else { Ok(i) });
            assert_eq!(failing, Err(29));
        }
    }
}
