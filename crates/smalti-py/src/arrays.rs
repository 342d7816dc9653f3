//! NumPy arrays as arguments and results. Results are read-only views of the memory of an object, which they keep alive. Arguments are
//! copied once, since the library owns its memory.

use numpy::ndarray::{ArrayView, Axis, Dimension, Ix3, IxDyn, ShapeBuilder};
use numpy::{
    Element, PyArray, PyArrayDescr, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use smalti::numeric::Planes;
use smalti::spectrum::WavelengthGrid;

use crate::error::{OrRaise, wrong};

/// Tolerance of a wavelength on an even grid, as a share of the step.
const EVEN: f64 = 1e-3;

/// An array of a type; other types are converted by NumPy.
pub(crate) fn array<'py, T: Element>(
    value: &Bound<'py, PyAny>,
    what: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = value.py();
    let made = py.import("numpy")?.call_method1("asarray", (value, PyArrayDescr::of::<T>(py)))?;
    let array = made
        .cast_into::<PyArrayDyn<T>>()
        .map_err(|_| wrong(format!("{what}: expected an array of numbers")))?;
    Ok(array.try_readonly()?)
}

/// One-dimensional numbers.
pub(crate) fn numbers(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<f64>> {
    let array = array::<f64>(value, what)?;
    expect_axes(array.shape(), what, &["count"])?;
    Ok(array.as_array().iter().copied().collect())
}

/// An array \[rows, columns, planes\] as planes; the last axis may be missing where there is one plane.
pub(crate) fn planes(value: &Bound<'_, PyAny>, what: &str, last: &str) -> PyResult<Planes> {
    let array = array::<f32>(value, what)?;
    let view = array.as_array();
    let view = if view.ndim() == 2 { view.insert_axis(Axis(2)) } else { view };
    let view = view.into_dimensionality::<Ix3>();
    let view = view.map_err(|_| expected(what, &["rows", "columns", last], array.shape()))?;
    let (rows, cols, count) = view.dim();
    let samples = view.permuted_axes([2, 0, 1]).iter().copied().collect();
    Planes::new(rows, cols, count, samples).or_raise()
}

/// Checks the number of axes of an array.
pub(crate) fn expect_axes(shape: &[usize], what: &str, axes: &[&str]) -> PyResult<()> {
    if shape.len() == axes.len() { Ok(()) } else { Err(expected(what, axes, shape)) }
}

/// The exception for an array of other axes.
pub(crate) fn expected(what: &str, axes: &[&str], shape: &[usize]) -> PyErr {
    wrong(format!("{what}: expected an array [{}]; got shape {shape:?}", axes.join(", ")))
}

/// Wavelengths in nm, ascending in even steps, as a grid.
pub(crate) fn grid(wavelengths_nm: &[f64]) -> PyResult<WavelengthGrid> {
    let (Some(&first), Some(&last)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Err(wrong("wavelengths_nm: expected at least one wavelength"));
    };
    let steps = wavelengths_nm.len() - 1;
    let step = if steps == 0 { 1.0 } else { (last - first) / steps as f64 };
    for (i, nm) in wavelengths_nm.iter().enumerate() {
        let place = first + i as f64 * step;
        let off = (nm - place).abs();
        if off.is_nan() || off > EVEN * step.abs() {
            return Err(wrong(format!(
                "wavelengths_nm: {nm} nm at place {i} where even steps have {place:.6} nm; resample the values on even steps \
                 first (numpy.interp)"
            )));
        }
    }
    WavelengthGrid::new(first, step, wavelengths_nm.len()).map_err(|e| wrong(format!("wavelengths_nm: {e}")))
}

/// A view of memory that `owner` owns.
fn view<'py, T: Element, D: Dimension>(
    owner: Bound<'py, PyAny>,
    view: &ArrayView<'_, T, D>,
) -> PyResult<Bound<'py, PyAny>> {
    // SAFETY: the array holds a reference to `owner`, a frozen object that neither changes nor frees the memory while it lives.
    let array = unsafe { PyArray::borrow_from_array(view, owner) };
    let array = array.try_readwrite()?.make_nonwriteable();
    Ok(array.as_any().clone())
}

/// Planes as \[rows, columns, planes\], float32.
pub(crate) fn planes_view<'py>(owner: Bound<'py, PyAny>, planes: &Planes) -> PyResult<Bound<'py, PyAny>> {
    let (rows, cols, count) = (planes.rows(), planes.cols(), planes.count());
    image_view(owner, planes.data(), rows, cols, count)
}

/// Samples ordered plane, row, column as \[rows, columns, planes\].
pub(crate) fn image_view<'py, T: Element>(
    owner: Bound<'py, PyAny>,
    data: &[T],
    rows: usize,
    cols: usize,
    count: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = (rows, cols, count).strides((cols, 1, rows * cols));
    let seen = ArrayView::from_shape(shape, data).map_err(|e| wrong(e.to_string()))?;
    view(owner, &seen)
}

/// Values with these axes, the last one fastest.
pub(crate) fn slice_view<'py, T: Element>(
    owner: Bound<'py, PyAny>,
    shape: &[usize],
    data: &[T],
) -> PyResult<Bound<'py, PyAny>> {
    let seen = ArrayView::from_shape(IxDyn(shape), data).map_err(|e| wrong(e.to_string()))?;
    view(owner, &seen)
}
