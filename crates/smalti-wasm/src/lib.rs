//! The simulator in a page: WebAssembly that draws what any design of a study makes of a scene.
//!
//! A page embeds the study and the light of its scenes on the pixels ([`PreviewLight`](smalti::design::PreviewLight)); the module
//! captures and processes it with the code of `smalti sweep`, and learns the pipelines of designs that have their own. The native
//! library gives the same bytes for the same input.
//!
//! The functions of the module take numbers, and bytes through a buffer in its memory:
//!
//! | function | input | gives |
//! |---|---|---|
//! | `reserve(bytes)` | | the address for the input |
//! | `study()` | a study, resolved, as JSON | its index |
//! | `setup(study, condition, is_learned, text_bytes)` | the light as JSON, then the numbers of its planes, 32 bits each | 0 |
//! | `draw(number, scene, is_noisy)` | | 0; the output is RGBA, four bytes a pixel |
//! | `output()`, `output_bytes()` | | where the output lies |
//!
//! Below 0 an error happened, and the output is its message in UTF-8. One setup is kept at a time, and the processing of the last
//! design.

mod exports;
mod studio;

pub use studio::{Studio, StudioError};
