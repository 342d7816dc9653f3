//! What the page of a report is made of.

use smalti::experiment::Progress;

use crate::study::figures::MAX_MARKS;
use crate::study::results::Results;
use crate::study::sections::Section;

/// A cloud has this many times as many designs as a study whose designs are marked.
const CLOUD: usize = 8;

/// What a page is made of.
pub(in crate::study) struct Sources<'a> {
    pub(in crate::study) all: &'a [(&'a Results, Vec<Section<'a>>)],
    /// How many trials with learned pipelines have embedded pictures.
    pub(in crate::study) pictures: usize,
    /// Trials of the first study that have embedded pictures in any case.
    pub(in crate::study) requested: &'a [u64],
    pub(in crate::study) progress: &'a dyn Progress,
}

impl<'a> Sources<'a> {
    /// The conditions and processings of all studies.
    pub(super) fn sections(&self) -> impl Iterator<Item = &'a Section<'a>> {
        self.all.iter().flat_map(|(_, sections)| sections)
    }

    /// Whether the designs of a study are marked: there are few of them beside a cloud of many.
    pub(super) fn is_marked(&self, results: &Results) -> bool {
        let designs = results.data.numbers.len();
        let cloud = self.all.iter().map(|(r, _)| r.data.numbers.len()).max().unwrap_or(0);
        designs <= MAX_MARKS && cloud >= CLOUD * designs.max(1)
    }
}
