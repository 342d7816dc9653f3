//! How a picture is turned for viewing.

use smalti::color::Image;
use smalti::numeric::Planes;

/// The orientation of a stored picture by its Exif code, which TIFF, JPEG and DNG share: how it is turned and mirrored to be seen
/// upright.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Orientation(u8);

impl Default for Orientation {
    fn default() -> Self {
        Self(1)
    }
}

impl Orientation {
    /// The orientation with an Exif code, 1 (as stored) to 8; as stored for any other.
    #[must_use]
    pub fn from_exif(code: u64) -> Self {
        if (1..=8).contains(&code) { Self(code as u8) } else { Self::default() }
    }

    /// Its Exif code.
    #[must_use]
    pub fn exif(self) -> u8 {
        self.0
    }

    /// The orientation that undoes it.
    #[must_use]
    pub fn inverse(self) -> Self {
        match self.0 {
            6 => Self(8),
            8 => Self(6),
            code => Self(code),
        }
    }

    /// The picture as it is to be seen.
    #[must_use]
    pub fn apply(self, picture: Image) -> Image {
        // Rows and columns are exchanged first; then rows, then columns are reversed.
        let (exchange, reverse_rows, reverse_cols) = match self.0 {
            2 => (false, false, true),
            3 => (false, true, true),
            4 => (false, true, false),
            5 => (true, false, false),
            6 => (true, false, true),
            7 => (true, true, true),
            8 => (true, true, false),
            _ => return picture,
        };
        let stored = picture.planes();
        let (stored_rows, stored_cols) = (stored.rows(), stored.cols());
        let (rows, cols) = if exchange { (stored_cols, stored_rows) } else { (stored_rows, stored_cols) };
        let mut data = Vec::with_capacity(stored.data().len());
        for plane in stored.planes() {
            for row in 0..rows {
                let row = if reverse_rows { rows - 1 - row } else { row };
                data.extend((0..cols).filter_map(|col| {
                    let col = if reverse_cols { cols - 1 - col } else { col };
                    let (row, col) = if exchange { (col, row) } else { (row, col) };
                    plane.get(row * stored_cols + col)
                }));
            }
        }
        let turned = Planes::new(rows, cols, stored.count(), data).map(|p| Image::new(picture.space(), p));
        match turned {
            Ok(Ok(turned)) => turned,
            // The same values in another order are valid.
            _ => picture,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smalti::color::ColorSpace;

    fn picture(rows: usize, cols: usize, values: &[f32]) -> Image {
        Image::new(ColorSpace::Srgb, Planes::new(rows, cols, 3, values.repeat(3)).unwrap()).unwrap()
    }

    /// The codes as the Exif standard draws them: row 0 and column 0 of the stored picture are top and left, top and right and so on.
    #[test]
    fn every_orientation_is_as_exif_states_and_is_undone_by_its_inverse() {
        let stored = picture(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for (code, rows, seen) in [
            (1, 2, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            (2, 2, [3.0, 2.0, 1.0, 6.0, 5.0, 4.0]),
            (3, 2, [6.0, 5.0, 4.0, 3.0, 2.0, 1.0]),
            (4, 2, [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]),
            (5, 3, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]),
            (6, 3, [4.0, 1.0, 5.0, 2.0, 6.0, 3.0]),
            (7, 3, [6.0, 3.0, 5.0, 2.0, 4.0, 1.0]),
            (8, 3, [3.0, 6.0, 2.0, 5.0, 1.0, 4.0]),
        ] {
            let orientation = Orientation::from_exif(code);
            assert_eq!(u64::from(orientation.exif()), code);
            let turned = orientation.apply(stored.clone());
            assert_eq!(turned, picture(rows, 6 / rows, &seen), "{code}");
            assert_eq!(orientation.inverse().apply(turned), stored, "{code}");
        }
        assert_eq!(Orientation::from_exif(9), Orientation::default());
    }
}
