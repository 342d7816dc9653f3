//! Tables that a click or a key on a heading sorts.

use super::markup::{Element, Markup, el};

/// A table in the making.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    caption: Markup,
    head: Vec<(Markup, bool)>,
    rows: Vec<Markup>,
}

impl Table {
    /// A table with a caption, which names it for those who do not see it.
    #[must_use]
    pub fn new(caption: impl Into<Markup>) -> Self {
        Self { caption: caption.into(), ..Self::default() }
    }

    /// Adds a column of numbers, with its heading.
    #[must_use]
    pub fn number(mut self, heading: impl Into<Markup>) -> Self {
        self.head.push((heading.into(), true));
        self
    }

    /// Adds a column of text, with its heading.
    #[must_use]
    pub fn text(mut self, heading: impl Into<Markup>) -> Self {
        self.head.push((heading.into(), false));
        self
    }

    /// Adds a row; its first cell is its heading. `marked` sets it apart: the best of its kind.
    #[must_use]
    pub fn row<T: Into<Markup>>(mut self, cells: impl IntoIterator<Item = T>, marked: bool) -> Self {
        let numeric = self.head.iter().map(|(_, n)| *n).chain(std::iter::repeat(false));
        let cell = |(i, (content, numeric)): (usize, (T, bool))| {
            let cell = if i == 0 { el("th").attr("scope", "row") } else { el("td") };
            filled(cell, numeric, content)
        };
        let cells: Markup = cells.into_iter().zip(numeric).enumerate().map(cell).collect();
        let row = if marked { el("tr").class("marked") } else { el("tr") };
        self.rows.push(row.child(cells).into());
        self
    }
}

fn filled(cell: Element, numeric: bool, content: impl Into<Markup>) -> Element {
    if numeric { cell.class("number") } else { cell }.child(content)
}

impl From<Table> for Markup {
    fn from(Table { caption, head, rows }: Table) -> Self {
        let heading = |(heading, numeric)| filled(el("th").attr("scope", "col"), numeric, heading);
        let table = el("table")
            .attr("data-sortable", "")
            .child(el("caption").child(caption))
            .child(el("thead").child(el("tr").children(head.into_iter().map(heading))))
            .child(el("tbody").children(rows));
        // Wide tables scroll by themselves; what scrolls must be reachable by keys.
        el("div")
            .class("scrolls")
            .attr("tabindex", "0")
            .attr("role", "region")
            .attr("aria-label", "Table")
            .child(table)
            .into()
    }
}
