//! The page of a rating experiment and its requests.
//!
//! | request | answer |
//! |---|---|
//! | `GET api/experiment` | the number of pairs, the size of the pictures |
//! | `POST api/observers` | a new observer: a number and a secret, which later requests send as `Authorization: Bearer` |
//! | `GET api/pair` | the number of the pair to judge, or the end |
//! | `GET api/picture/NUMBER/left`, `right`, `reference` | a picture of this pair as PNG |
//! | `POST api/answer` | the answer to this pair; the next one |
//!
//! A page learns neither which conditions a pair shows nor whether it is a repeat or a trap, and nothing of other observers.

mod experiment;
mod requests;

pub use experiment::Experiment;
pub use requests::routes;
