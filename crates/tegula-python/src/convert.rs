//! Values of Python as values of a model file, and back.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use toml::{Table, Value};

/// Deepest nesting of a model: a list that contains itself has no end.
const DEEPEST: usize = 64;

/// The table of a dictionary. Numbers and arrays of NumPy become numbers and lists; keys with the value `None` are left out.
///
/// # Errors
/// A key is not a string, or a value has no counterpart in a model file.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    table_at(dict, "", 0)
}

fn table_at(dict: &Bound<'_, PyDict>, at: &str, depth: usize) -> PyResult<Table> {
    let mut out = Table::new();
    for (key, value) in dict {
        let key = key
            .cast::<PyString>()
            .map_err(|_| PyTypeError::new_err(format!("{}: the key {key:?} is not a string", place(at))))?
            .to_cow()?
            .into_owned();
        if !value.is_none() {
            let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            out.insert(key, value_at(&value, &at, depth + 1)?);
        }
    }
    Ok(out)
}

fn value_at(value: &Bound<'_, PyAny>, at: &str, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!("{}: nested too deeply", place(at))));
    }
    let list = |items: Vec<Bound<'_, PyAny>>| {
        let values =
            items.iter().enumerate().map(|(i, item)| value_at(item, &format!("{at}[{i}]"), depth + 1));
        Ok(Value::Array(values.collect::<PyResult<_>>()?))
    };
    if let Ok(flag) = value.cast::<PyBool>() {
        Ok(Value::Boolean(flag.is_true()))
    } else if let Ok(number) = value.cast::<PyInt>() {
        let fits = number
            .extract()
            .map_err(|_| PyValueError::new_err(format!("{}: the number has more than 64 bits", place(at))));
        Ok(Value::Integer(fits?))
    } else if let Ok(number) = value.cast::<PyFloat>() {
        Ok(Value::Float(number.value()))
    } else if let Ok(text) = value.cast::<PyString>() {
        Ok(Value::String(text.to_cow()?.into_owned()))
    } else if let Ok(dict) = value.cast::<PyDict>() {
        Ok(Value::Table(table_at(dict, at, depth)?))
    } else if let Ok(items) = value.cast::<PyList>() {
        list(items.iter().collect())
    } else if let Ok(items) = value.cast::<PyTuple>() {
        list(items.iter().collect())
    } else if value.hasattr("tolist")? {
        // Numbers and arrays of NumPy.
        let plain = value.call_method0("tolist")?;
        if plain.get_type().is(value.get_type()) {
            // Numbers with more digits than Python's.
            return Ok(Value::Float(value.extract()?));
        }
        value_at(&plain, at, depth + 1)
    } else if value.hasattr("__fspath__")? {
        value_at(&value.call_method0("__fspath__")?, at, depth + 1)
    } else {
        let kind = value.get_type().name()?;
        Err(PyTypeError::new_err(format!("{}: a model file has no values of type {kind}", place(at))))
    }
}

fn place(at: &str) -> &str {
    if at.is_empty() { "the model" } else { at }
}

/// The dictionary of a table.
pub fn dictionary<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (key, value) in table {
        out.set_item(key, object(py, value)?)?;
    }
    Ok(out)
}

fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Float(number) => PyFloat::new(py, *number).into_any(),
        Value::Boolean(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::Datetime(date) => PyString::new(py, &date.to_string()).into_any(),
        Value::Array(items) => {
            let items = items.iter().map(|item| object(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
        Value::Table(table) => dictionary(py, table)?.into_any(),
    })
}
