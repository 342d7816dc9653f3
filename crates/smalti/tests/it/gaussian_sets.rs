//! Sets of Gaussian filters of which ISETCam's figures are known. The tests of the command use them too.

/// Gaussian filters, centres and deviations in nm, and the tile that goes with them.
pub(crate) type Set = (&'static [(f64, f64)], &'static [&'static str]);

/// Sets of which ISETCam's figures are known.
pub(crate) const SETS: [Set; 5] = [
    (&[(629.9, 37.5), (579.5, 29.1), (451.8, 34.5)], &["BA", "CB"]),
    (&[(453.4, 51.8), (533.6, 22.7), (556.9, 43.6), (651.6, 50.0)], &["AB", "CD"]),
    (&[(436.3, 38.5), (459.4, 20.1), (541.4, 52.7), (577.5, 49.1), (650.9, 31.2)], &["ABC", "DEB", "CAD"]),
    (
        &[(435.2, 22.1), (466.2, 40.3), (516.7, 37.3), (550.8, 44.0), (605.9, 48.9), (659.6, 19.4)],
        &["ABC", "DEF", "BCD"],
    ),
    (
        &[
            (435.3, 46.8),
            (460.2, 30.1),
            (492.0, 53.4),
            (526.7, 29.2),
            (609.4, 41.1),
            (634.8, 46.4),
            (656.4, 28.7),
        ],
        &["ABC", "DEF", "GCE"],
    ),
];
