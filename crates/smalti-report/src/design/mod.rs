//! The page of a design: the array that was found beside others, its proof, what it depends on and what limits it.

mod arrays;
mod document;
mod limits;
mod page;
mod proof;
mod proof_text;
mod proof_words;
mod results;
mod robustness;
mod search;
mod sensitivity;
#[cfg(test)]
mod tests;

pub use document::{Array, Document};
pub use page::page;
pub use proof::Proved;
pub use proof_text::text as proof_text;
pub use results::results;
