//! Arrays that functions of Python give.

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Array that a function has given, whose shape begins with the number of nodes or points.
pub struct Given<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    is_coarse: bool,
}

/// Kinds of numbers of NumPy, and what they are called.
const OTHER_KINDS: [(char, &str); 8] = [
    ('b', "truth values"),
    ('c', "complex numbers"),
    ('U', "text"),
    ('S', "text"),
    ('T', "text"),
    ('m', "time differences"),
    ('M', "times"),
    ('V', "structured records"),
];

impl<'py> Given<'py> {
    /// Result of a function as an array of a shape, of real numbers.
    ///
    /// # Errors
    /// It is no such array.
    pub fn new(what: &str, value: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Self> {
        let py = value.py();
        let numpy = py.import("numpy")?;
        let no_numbers = |cause: Option<PyErr>| {
            let kind = value.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string());
            let error = PyValueError::new_err(format!("{what}: a {kind} is given, and no array of numbers"));
            error.set_cause(py, cause);
            error
        };
        let found = numpy.call_method1("asarray", (value,)).map_err(|cause| no_numbers(Some(cause)))?;
        let dtype = found.getattr("dtype")?;
        let kind: char = dtype.getattr("kind")?.extract()?;
        if !"iuf".contains(kind) {
            let other = OTHER_KINDS.iter().find(|(of, _)| *of == kind && found.len().is_ok());
            return Err(other.map_or_else(
                || no_numbers(None),
                |(_, name)| {
                    PyTypeError::new_err(format!(
                        "{what}: an array of {name} is given, and one of real numbers is expected"
                    ))
                },
            ));
        }
        // The array has the numbers below the mask, too.
        if numpy.getattr("ma")?.call_method1("is_masked", (value,))?.is_truthy()? {
            return Err(PyValueError::new_err(format!(
                "{what}: an array with masked entries is given, which have no values: fill them"
            )));
        }
        let is_coarse = kind == 'f' && dtype.getattr("itemsize")?.extract::<usize>()? < size_of::<f64>();
        // Rows one after another, whatever the strides of the caller are.
        let array = numpy.call_method1("ascontiguousarray", (found, "float64"))?;
        let array: PyReadonlyArrayDyn<'py, f64> = array.extract()?;
        if array.shape() != shape {
            let of = |shape: &[usize]| {
                let sizes: Vec<_> = shape.iter().map(ToString::to_string).collect();
                if sizes.len() == 1 { format!("({},)", sizes[0]) } else { format!("({})", sizes.join(", ")) }
            };
            return Err(PyValueError::new_err(format!(
                "{what}: the shape is {}, and {} is expected",
                of(array.shape()),
                of(shape)
            )));
        }
        Ok(Self { array, is_coarse })
    }

    /// Whether the numbers have less than double precision.
    pub fn is_coarse(&self) -> bool {
        self.is_coarse
    }

    /// Values, row after row.
    ///
    /// # Errors
    /// None: the rows follow each other.
    pub fn values(&self) -> PyResult<&[f64]> {
        Ok(self.array.as_slice()?)
    }

    /// Values, all of which have to be finite; a row has `each` of them.
    ///
    /// # Errors
    /// One is not finite.
    pub fn finite(&self, what: &str, each: usize) -> PyResult<&[f64]> {
        let values = self.values()?;
        match values.iter().position(|x| !x.is_finite()) {
            None => Ok(values),
            Some(at) => Err(PyValueError::new_err(format!(
                "{what}: row {} has the value {}, which is not a finite number",
                at / each,
                values[at]
            ))),
        }
    }
}
