//! Values of the library as Python objects, by way of JSON.

use pyo3::prelude::*;

use crate::error::OrRaise;

/// A value that serialises to a JSON object, as a dict.
pub(crate) fn dict_of<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    loads(py, &serde_json::to_string(value).or_raise()?)
}

/// JSON text as Python objects.
pub(crate) fn loads<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}
