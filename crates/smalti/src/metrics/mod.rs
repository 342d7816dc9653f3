//! What a picture is worth, in numbers: plain functions on images.
