//! Colour science on arrays.

use numpy::ndarray::ArrayViewD;
use numpy::{IntoPyArray, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use smalti::color::scielab::scielab;
use smalti::color::{DeltaE, lab_from_xyz, xyz_from_lab};

use crate::arrays;
use crate::error::{OrRaise, one_of, wrong};
use crate::image::PyImage;
use crate::work::{detached, watched};

const FORMULAS: [(&str, DeltaE); 3] =
    [("2000", DeltaE::Ciede2000), ("1994", DeltaE::Cie1994), ("1976", DeltaE::Cie1976)];

/// The colour difference ΔE*ab or ΔE00.
///
/// Args:
///     lab1: L*, a*, b* in the last axis, float64 […, 3].
///     lab2: an array of the same shape; for the method "1994", lab1 is the reference.
///     method: "2000" (CIEDE2000, ISO/CIE 11664-6), "1994" or "1976".
///
/// Returns:
///     ΔE, float64 […].
#[pyfunction]
#[pyo3(signature = (lab1, lab2, method="2000"))]
pub(crate) fn delta_e<'py>(
    py: Python<'py>,
    lab1: &Bound<'py, PyAny>,
    lab2: &Bound<'py, PyAny>,
    method: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let formula = one_of("method", method, &FORMULAS)?;
    let (a, b) = (arrays::array::<f64>(lab1, "lab1")?, arrays::array::<f64>(lab2, "lab2")?);
    if a.shape() != b.shape() {
        return Err(wrong(format!(
            "lab1 has shape {:?}, lab2 {:?}; expected the same",
            a.shape(),
            b.shape()
        )));
    }
    let (x, y) = (triples(&a.as_array(), "lab1")?, triples(&b.as_array(), "lab2")?);
    let shape = a.shape()[..a.shape().len() - 1].to_vec();
    let values =
        detached(py, || Ok(x.iter().zip(&y).map(|(&a, &b)| formula.between(a, b)).collect::<Vec<f64>>()))?;
    Ok(values.into_pyarray(py).reshape(shape)?.into_any())
}

/// L*, a*, b* of X, Y, Z (ISO/CIE 11664-4).
///
/// Args:
///     xyz: X, Y, Z in the last axis, float64 […, 3].
///     white: X, Y, Z of white, on the same scale.
#[pyfunction(name = "lab_from_xyz")]
pub(crate) fn lab<'py>(
    py: Python<'py>,
    xyz: &Bound<'py, PyAny>,
    white: [f64; 3],
) -> PyResult<Bound<'py, PyAny>> {
    each(py, xyz, "xyz", |v| lab_from_xyz(v, white))
}

/// X, Y, Z of L*, a*, b*, on the scale of white.
#[pyfunction(name = "xyz_from_lab")]
pub(crate) fn xyz<'py>(
    py: Python<'py>,
    lab: &Bound<'py, PyAny>,
    white: [f64; 3],
) -> PyResult<Bound<'py, PyAny>> {
    each(py, lab, "lab", |v| xyz_from_lab(v, white))
}

/// S-CIELAB (Zhang and Wandell 1997): the colour difference at every pixel after the spatial filtering of the eye.
///
/// Args:
///     picture: in XYZ.
///     reference: in XYZ, of the same size.
///     white: X, Y, Z of white on the scale of the pictures, to which the eye is adapted.
///     samples_per_degree: viewing condition, pixels per degree of visual angle, 1 to 2000.
///     method: "1976", "1994" or "2000".
///
/// Returns:
///     ΔE, float32 [rows, columns].
#[pyfunction(name = "scielab")]
#[pyo3(signature = (picture, reference, white, samples_per_degree=60.0, method="1976"))]
pub(crate) fn scielab_map<'py>(
    py: Python<'py>,
    picture: &PyImage,
    reference: &PyImage,
    white: [f64; 3],
    samples_per_degree: f64,
    method: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let formula = one_of("method", method, &FORMULAS)?;
    let map = watched(py, None, |_| {
        scielab(&reference.image, &picture.image, white, samples_per_degree, formula).or_raise()
    })?;
    Ok(map.values.into_pyarray(py).reshape((map.rows, map.cols))?.into_any())
}

fn each<'py>(
    py: Python<'py>,
    value: &Bound<'py, PyAny>,
    what: &str,
    convert: impl Fn([f64; 3]) -> [f64; 3] + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = arrays::array::<f64>(value, what)?;
    let values = triples(&array.as_array(), what)?;
    let out = detached(py, || Ok(values.into_iter().flat_map(convert).collect::<Vec<f64>>()))?;
    Ok(out.into_pyarray(py).reshape(array.shape().to_vec())?.into_any())
}

fn triples(view: &ArrayViewD<'_, f64>, what: &str) -> PyResult<Vec<[f64; 3]>> {
    if view.shape().last() != Some(&3) {
        return Err(wrong(format!(
            "{what}: expected an array whose last axis is 3; got shape {:?}",
            view.shape()
        )));
    }
    let flat: Vec<f64> = view.iter().copied().collect();
    Ok(flat.as_chunks::<3>().0.to_vec())
}
