//! Files from end to end: written, read, damaged, and judged by other programs.
#![allow(clippy::unwrap_used, clippy::panic)]

mod cubes;
mod dataset;
mod l3;
mod matlab_hdf5;
mod other_programs;
mod python;
mod ratings;
