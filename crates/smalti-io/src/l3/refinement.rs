//! The second stage of a learned table.

use serde_json::json;
use smalti::l3::{REFINEMENT_INPUTS, Refinement, RefinementAxes, RefinementClass};

use crate::IoError;
use crate::container::{Content, Opened};
use crate::error::At;

/// The string that states the axes of the second stage; tables of one stage lack it.
const AXES: &str = "refinement";
/// X, Y, Z.
const OUTPUTS: usize = 3;

/// Adds all that `read` needs.
pub(super) fn put(content: &mut Content, refinement: &Refinement) {
    let axes = refinement.axes();
    content.text(AXES, json!(axes));
    let classes = [axes.levels().count(), axes.structures()];
    let of_classes = |more: &[usize]| [&classes, more].concat();
    content.tensor("refinement_weights", &of_classes(&[OUTPUTS, REFINEMENT_INPUTS]), refinement.weights());
    content.tensor("refinement_offsets", &of_classes(&[OUTPUTS]), refinement.offsets().iter().copied());
    content.tensor("refinement_counts", &classes, refinement.classes().iter().map(|c| c.count));
    let learned = refinement.classes().iter().map(|c| u8::from(c.is_learned));
    content.tensor("refinement_learned", &classes, learned);
}

/// The second stage, if there is one, exactly as it was put.
pub(super) fn read(opened: &Opened<'_>) -> Result<Option<Refinement>, IoError> {
    if !opened.has(AXES) {
        return Ok(None);
    }
    let axes: RefinementAxes = opened.json(AXES)?;
    let classes = [axes.levels().count(), axes.structures()];
    let of_classes = |more: &[usize]| [&classes, more].concat();
    let weights = opened.shaped("refinement_weights", &of_classes(&[OUTPUTS, REFINEMENT_INPUTS]))?;
    let offsets = opened.shaped("refinement_offsets", &of_classes(&[OUTPUTS]))?;
    let counts: Vec<u64> = opened.shaped("refinement_counts", &classes)?;
    let learned: Vec<u8> = opened.shaped("refinement_learned", &classes)?;
    let class = |(i, (count, learned)): (usize, (u64, u8))| match learned {
        0 | 1 => Ok(RefinementClass { count, is_learned: learned == 1 }),
        other => {
            let found = format!("{other} at class {i} (counted from 0)");
            Err(opened.wrong("tensor 'refinement_learned'", found, "0 or 1"))
        }
    };
    let classes = counts.into_iter().zip(learned).enumerate().map(class).collect::<Result<_, _>>()?;
    Refinement::new(axes, classes, weights, offsets).map(Some).at(opened.path())
}
