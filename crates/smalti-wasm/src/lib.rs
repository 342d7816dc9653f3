//! The simulator in a page, as WebAssembly.
//!
//! Two modules are made of this crate. That of studies ([`StudyPictures`]) draws what any design of a study makes of a scene: a page embeds the study and the
//! light of its scenes on the pixels ([`PreviewLight`](smalti::design::PreviewLight)); the module
//! captures and processes it with the code of `smalti sweep`, and learns the pipelines of designs that have their own. That of the studio (the feature
//! `engine`) draws, scores and improves designs that a page invents. The native library gives the same bytes for the same input.
//!
//! The functions of the modules take numbers, and bytes through a buffer in their memory:
//!
//! | function | input | gives |
//! |---|---|---|
//! | `reserve(bytes)` | | the address for the input |
//! | `study()` | a study, resolved, as JSON | its index |
//! | `setup(study, condition, is_learned, text_bytes)` | the light as JSON, then the numbers of its planes, 32 bits each | 0 |
//! | `draw(number, scene, is_noisy)` | | 0; the output is RGBA, four bytes a pixel |
//! | `load(kind, name_bytes)` | the name of a lens, then a file of the studio, inflated: 0 training, 1 scene, 2 statistics | 0 |
//! | `source(name_bytes)` | the name of a file from which light is gathered, then the file | 0 |
//! | `photograph(name_bytes, rows, cols)` | the name of a photograph, then RGBA | 0 |
//! | `ask()` | a request as JSON | 0; the output is an [`Answer`](Engine) as bytes |
//! | `output()`, `output_bytes()` | | where the output lies |
//!
//! Below 0 an error happened, and the output is its message in UTF-8. After a call that trapped, all others fail with a message that says so, and the host
//! makes a new instance. Of studies, one setup is kept at a time, and the processing of the last
//! design.

#[cfg(feature = "engine")]
mod engine;
mod exports;
mod study_pictures;

#[cfg(feature = "engine")]
pub use engine::{Answer, Engine, EngineError, StudioFile};
pub use study_pictures::{StudyPictureError, StudyPictures};
