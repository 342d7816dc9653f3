//! Columns: names, types and values.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use super::error::DatasetError;

/// Maximum length of a column name, bytes.
const MAX_NAME: usize = 128;

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColumnKind {
    /// 64-bit integers (`INT64`).
    Int,
    /// 64-bit floating-point numbers (`DOUBLE`). NaN is stored as null.
    Float,
    /// Text (`STRING`), stored with a dictionary.
    Text,
    /// Lists of 64-bit floating-point numbers (`LIST` of `DOUBLE`), of any length in each row. NaN is stored as null.
    Floats,
}

impl ColumnKind {
    fn name(self) -> &'static str {
        match self {
            Self::Int => "integers",
            Self::Float => "numbers",
            Self::Text => "text",
            Self::Floats => "lists of numbers",
        }
    }
}

/// Description of a column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnSpec {
    /// Name: 1 to 128 ASCII letters, digits and underscores, not beginning with a digit. Names that differ only in case are refused, since
    /// SQL ignores case.
    pub name: String,
    /// Type of the values.
    pub kind: ColumnKind,
    /// Unit; empty for none.
    pub unit: String,
    /// Meaning of the values.
    pub doc: String,
}

/// The values of a column, one per row.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// [`ColumnKind::Int`].
    Int(Vec<i64>),
    /// [`ColumnKind::Float`].
    Float(Vec<f64>),
    /// [`ColumnKind::Text`].
    Text(Vec<String>),
    /// [`ColumnKind::Floats`].
    Floats(Vec<Vec<f64>>),
}

impl Column {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Int(v) => v.len(),
            Self::Float(v) => v.len(),
            Self::Text(v) => v.len(),
            Self::Floats(v) => v.len(),
        }
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Type of the values.
    #[must_use]
    pub fn kind(&self) -> ColumnKind {
        match self {
            Self::Int(_) => ColumnKind::Int,
            Self::Float(_) => ColumnKind::Float,
            Self::Text(_) => ColumnKind::Text,
            Self::Floats(_) => ColumnKind::Floats,
        }
    }
}

/// Refuses column names that differ only in case, or that need quotes in some program.
pub(super) fn check(schema: &[ColumnSpec]) -> Result<(), DatasetError> {
    let error = |what: String, found: String, expected: &str| {
        Err(DatasetError::Plan { what, found, expected: expected.to_owned() })
    };
    if schema.is_empty() {
        return error("the list of columns".into(), "empty".into(), "at least one");
    }
    let mut seen = HashSet::new();
    for (i, ColumnSpec { name, .. }) in schema.iter().enumerate() {
        let plain = name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
            && !name.bytes().next().is_none_or(|b| b.is_ascii_digit())
            && name.len() <= MAX_NAME;
        if !plain {
            let expected = "at most 128 ASCII letters, digits and underscores, not beginning with a digit";
            return error(format!("the name of column {i}"), format!("{name:?}"), expected);
        }
        if !seen.insert(name.to_ascii_lowercase()) {
            let expected = "a name that no other column has, ignoring case";
            return error(format!("the name of column {i}"), format!("{name:?}"), expected);
        }
    }
    Ok(())
}

/// Refuses columns that do not match the schema or the number of rows, or that exceed a limit.
pub(super) fn check_columns(
    schema: &[ColumnSpec],
    rows: usize,
    chunk: u64,
    columns: &[Column],
) -> Result<(), DatasetError> {
    let error = |what: String, found: String, expected: String| {
        Err(DatasetError::Columns { chunk, what, found, expected })
    };
    if columns.len() != schema.len() {
        let [found, expected] = [columns.len(), schema.len()].map(|n| n.to_string());
        return error("the number of columns".into(), found, expected);
    }
    for (spec, column) in schema.iter().zip(columns) {
        if column.kind() != spec.kind {
            let [found, expected] = [column.kind(), spec.kind].map(|k| k.name().to_owned());
            return error(format!("column {}", spec.name), found, expected);
        }
        if column.len() != rows {
            let [found, expected] = [column.len(), rows].map(|n| n.to_string());
            return error(format!("the number of rows of column {}", spec.name), found, expected);
        }
        let (amount, limit, what) = match column {
            Column::Text(v) => (v.iter().map(String::len).sum(), super::MAX_TEXT_BYTES, "bytes"),
            // Parquet stores one level for an empty list, as for a value.
            Column::Floats(v) => {
                (v.iter().map(|list| list.len().max(1)).sum(), super::MAX_LIST_VALUES, "values")
            }
            _ => (0, 0, ""),
        };
        if amount > limit {
            let expected = format!("at most {limit}; choose smaller chunks");
            return error(format!("column {}", spec.name), format!("{amount} {what}"), expected);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Vec<ColumnSpec> {
        let spec = |name: &&str| ColumnSpec {
            name: (*name).to_owned(),
            kind: ColumnKind::Int,
            unit: String::new(),
            doc: String::new(),
        };
        names.iter().map(spec).collect()
    }

    #[test]
    fn names_are_plain_and_unique() {
        check(&named(&["a", "_b", "delta_E2"])).unwrap();
        for names in [&[][..], &[""], &["a.b"], &["2a"], &["ΔE"], &["a b"], &["a", "A"], &[&"a".repeat(129)]]
        {
            assert!(matches!(check(&named(names)), Err(DatasetError::Plan { .. })), "{names:?}");
        }
    }

    #[test]
    fn columns_that_do_not_fit_are_named() {
        let schema = named(&["n", "m"]);
        let ints = |n: i64| Column::Int((0..n).collect());
        check_columns(&schema, 2, 0, &[ints(2), ints(2)]).unwrap();
        for (columns, message) in [
            (vec![ints(2)], "part 7: the number of columns is 1; expected 2"),
            (vec![ints(2), ints(3)], "part 7: the number of rows of column m is 3; expected 2"),
            (vec![ints(2), Column::Float(vec![0.0; 2])], "part 7: column m is numbers; expected integers"),
        ] {
            assert_eq!(check_columns(&schema, 2, 7, &columns).unwrap_err().to_string(), message);
        }
        let schema = [ColumnSpec { kind: ColumnKind::Floats, ..schema[0].clone() }];
        let long = [Column::Floats(vec![vec![0.0; super::super::MAX_LIST_VALUES + 1]])];
        let error = check_columns(&schema, 1, 0, &long).unwrap_err().to_string();
        assert!(error.ends_with("at most 16777216; choose smaller chunks"), "{error}");
    }
}
