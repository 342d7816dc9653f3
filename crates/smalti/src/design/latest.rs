//! What was computed last, a bounded number of results.

use std::collections::VecDeque;

/// Keeps a result in place of the oldest one, if there are `limit` already.
pub(super) fn keep_latest<T>(kept: &mut VecDeque<T>, limit: usize, result: T) {
    if kept.len() >= limit {
        kept.pop_front();
    }
    kept.push_back(result);
}
