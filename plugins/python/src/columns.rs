//! Conversion of tables of the library to columns for NumPy and astropy.

use hifitime::{Epoch, TimeScale};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use streakcast::output::{Column, Kind, Table, Value};

use crate::exposures::two_parts;

/// Nanoseconds from 1900-01-01 to 1970-01-01.
const UNIX_ZERO_NS: i128 = 25_567 * 86_400 * 1_000_000_000;
/// Value of NumPy's `NaT` (a missing time).
const NOT_A_TIME: i64 = i64::MIN;

/// Returns one dictionary per column with `name`, `unit`, `description`, `kind` and the data.
pub fn columns<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyList>> {
    let result = PyList::empty(py);
    for (index, column) in table.columns.iter().enumerate() {
        let cells = table.rows.iter().filter_map(|row| row.get(index));
        result.append(column_of(py, column, cells)?)?;
    }
    Ok(result)
}

fn column_of<'py, 'a>(
    py: Python<'py>,
    column: &Column,
    cells: impl Iterator<Item = &'a Value>,
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("name", column.name)?;
    result.set_item("unit", column.unit)?;
    result.set_item("description", column.description)?;
    let kind = match column.kind {
        Kind::Real { .. } | Kind::Small { .. } => {
            result.set_item("values", cells.map(real).collect::<Vec<f64>>().into_pyarray(py))?;
            "real"
        }
        Kind::Integer => {
            let (values, missing): (Vec<i64>, Vec<bool>) = cells.map(integer).unzip();
            result.set_item("values", values.into_pyarray(py))?;
            result.set_item("missing", missing.into_pyarray(py))?;
            "integer"
        }
        Kind::Boolean => {
            let cells = cells.map(|cell| match cell {
                Value::Boolean(truth) => (*truth, false),
                _ => (false, true),
            });
            let (values, missing): (Vec<bool>, Vec<bool>) = cells.unzip();
            result.set_item("values", values.into_pyarray(py))?;
            result.set_item("missing", missing.into_pyarray(py))?;
            "boolean"
        }
        Kind::Time { .. } => {
            let epochs: Vec<Option<Epoch>> = cells
                .map(|cell| match cell {
                    Value::Time(epoch) => Some(*epoch),
                    _ => None,
                })
                .collect();
            let (jd1, jd2, utc_ns) = times(py, &epochs);
            result.set_item("jd1", jd1)?;
            result.set_item("jd2", jd2)?;
            result.set_item("utc_ns", utc_ns)?;
            "time"
        }
        Kind::Text => {
            let texts: Vec<String> = cells.map(|cell| column.text(cell)).collect();
            result.set_item("values", texts)?;
            "text"
        }
        Kind::List { .. } | Kind::Rows(_) => {
            let values = PyList::empty(py);
            for cell in cells {
                values.append(nested(py, column, cell)?)?;
            }
            result.set_item("values", values)?;
            "list"
        }
    };
    result.set_item("kind", kind)?;
    Ok(result)
}

/// Two-part Julian dates (TAI), and nanoseconds since 1970 (UTC).
type Times<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>);

/// Converts times for astropy and NumPy; missing values become NaN and NaT.
pub fn times<'py>(py: Python<'py>, epochs: &[Option<Epoch>]) -> Times<'py> {
    let (jd1, jd2): (Vec<f64>, Vec<f64>) =
        epochs.iter().map(|epoch| epoch.map_or((f64::NAN, f64::NAN), two_parts)).unzip();
    let utc_ns = |epoch: Epoch| {
        let since_1900 = epoch.to_duration_in_time_scale(TimeScale::UTC).total_nanoseconds();
        i64::try_from(since_1900 - UNIX_ZERO_NS).unwrap_or(NOT_A_TIME)
    };
    let utc: Vec<i64> = epochs.iter().map(|epoch| epoch.map_or(NOT_A_TIME, utc_ns)).collect();
    (jd1.into_pyarray(py), jd2.into_pyarray(py), utc.into_pyarray(py))
}

fn real(cell: &Value) -> f64 {
    match cell {
        Value::Real(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => f64::NAN,
    }
}

fn integer(cell: &Value) -> (i64, bool) {
    match cell {
        Value::Integer(number) => (*number, false),
        _ => (0, true),
    }
}

/// Converts a cell to a list of strings or numbers, or to a list of dictionaries.
fn nested<'py>(py: Python<'py>, column: &Column, cell: &Value) -> PyResult<Bound<'py, PyList>> {
    match (cell, column.kind) {
        (Value::List(items), _) => PyList::new(py, items),
        (Value::Integers(items), _) => PyList::new(py, items),
        (Value::Rows(rows), Kind::Rows(columns)) => {
            let result = PyList::empty(py);
            for row in rows {
                let entry = PyDict::new(py);
                for (column, cell) in columns.iter().zip(row) {
                    match cell {
                        Value::Real(number) => entry.set_item(column.name, number)?,
                        Value::Integer(number) => entry.set_item(column.name, number)?,
                        Value::Boolean(truth) => entry.set_item(column.name, truth)?,
                        Value::Null => entry.set_item(column.name, py.None())?,
                        other => entry.set_item(column.name, column.text(other))?,
                    }
                }
                result.append(entry)?;
            }
            Ok(result)
        }
        _ => Ok(PyList::empty(py)),
    }
}
