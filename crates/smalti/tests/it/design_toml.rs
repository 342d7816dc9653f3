//! How families are written in the file of a study.
#![allow(clippy::unwrap_used, clippy::panic)]

use smalti::design::{FilterFamily, GaussianGrid, MosaicFamily};

#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Study {
    filters: FilterFamily,
    mosaics: MosaicFamily,
}

#[test]
fn families_are_read_from_toml_and_written_back() {
    let text = r#"
        mosaics = { given = [["cb", "ba"], ["ab", "cd"]] }
        [filters.gaussian-grid]
        centers_nm = [420, 5, 680]
    "#;
    let study: Study = toml::from_str(text).unwrap();
    let expected = GaussianGrid { centers_nm: [420.0, 5.0, 680.0], ..GaussianGrid::default() };
    assert_eq!(study.filters, FilterFamily::GaussianGrid(expected));
    for text in [
        text,
        "mosaics = \"catalogue\"\nfilters.gaussian_grid = {}",
        "[mosaics.tile]\nrows = 4\ncols = 4\nsymmetry = \"shift-mirror\"\n[filters.rule]\nrules = [\"all-scaled\"]\ntargets = \
         [\"cones\", { gaussian = { center_nm = 540 } }]\nmax_sigma_nm = 40",
        "mosaics.tile = { rows = 2, cols = 2 }\n[filters.library]\nseries = [\"measured\", { dyes = { at_most = 3 } }, { \
         raised_cosine = { centers_nm = [430, 10, 660], fwhms_nm = [60, 20, 120] } }]\n[filters.library.filters]\ngreen = { \
         file = \"green.csv\" }\nr = { dye = { bands = [{ center_nm = 450, fwhm_nm = 90, absorbance = 2 }], leakage = 0.01 } }",
        "mosaics = \"catalogue\"\n[[filters.list]]\nlabel = \"x\"\nfilters = [{ flat = 0.5 }]\n[[filters.list]]\nfilters = []",
    ] {
        let study: Study = toml::from_str(text).unwrap_or_else(|e| panic!("{text}\n{e}"));
        let again: Study = toml::from_str(&toml::to_string(&study).unwrap()).unwrap();
        assert_eq!(again, study);
    }
}

#[test]
fn wrong_keys_are_shown_at_their_line() {
    for (line, what, text) in [
        (
            4,
            "unknown field `centres_nm`",
            "mosaics = \"catalogue\"\n[filters.gaussian_grid]\nmin_spacing_nm = 10\ncentres_nm = [1, 2, 3]",
        ),
        (
            3,
            "found 2 numbers; expected three: [first, step, last]",
            "mosaics = \"catalogue\"\n[filters.gaussian_grid]\ncenters_nm = [400, 700]",
        ),
        (2, "unknown variant `gauss`", "mosaics = \"catalogue\"\n[filters.gauss]\n"),
        (4, "unknown field `column`", "filters.rule = {}\n[mosaics.tile]\nrows = 2\ncolumn = 2"),
        (
            3,
            "centre_nm, available keys: center_nm, sigma_nm",
            "mosaics = \"catalogue\"\n[filters.rule]\ntargets = [{ gaussian = { centre_nm = 540 } }]",
        ),
        (
            3,
            "unknown field `fwhm`",
            "mosaics = \"catalogue\"\n[filters.library]\nseries = [{ dyes = { fwhm = 540 } }]",
        ),
    ] {
        let error = toml::from_str::<Study>(text).unwrap_err();
        assert!(error.message().contains(what), "{error}");
        let at = text[..error.span().unwrap().start].lines().count().max(1);
        let starts_line = text[..error.span().unwrap().start].ends_with('\n');
        assert_eq!(at + usize::from(starts_line), line, "{error}");
    }
}
