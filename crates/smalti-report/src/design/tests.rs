//! Tests of the page of a design.
