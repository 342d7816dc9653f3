//! Processing: from raw samples to a picture.
