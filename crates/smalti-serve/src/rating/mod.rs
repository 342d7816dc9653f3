//! The page of a rating experiment and its requests.
//!
//! | request | answer |
//! |---|---|
//! | `GET api/experiment` | the number of pairs, the size of the pictures |
//! | `POST api/observers` | the number of a new observer; the request has consent, the display and a secret, which later requests send as `Authorization: Bearer` |
//! | `GET api/pair` | the numbers of the observer and of the pair to judge, or the end |
//! | `GET api/picture/NUMBER/left`, `right`, `reference` | a picture of this pair as PNG |
//! | `POST api/answer` | the answer to this pair; the next one |
//!
//! Requests may be repeated when their answer was lost: neither a second observer nor a second answer is recorded.
//!
//! A page learns neither which conditions a pair shows nor whether it is a repeat or a trap, and nothing of other observers.

mod experiment;
mod requests;

pub use experiment::Experiment;
pub use requests::routes;
