//! Files as a user might change them: a built-in file, with some of its values replaced. Its structure holds, so that its values reach the
//! computation behind the parser.

use smalti_io::TomlSource;
use toml::{Table, Value};

/// A file among `files`, chosen by the first byte of the data, with a value replaced for every two bytes that follow.
pub fn changed(files: &[smalti_io::BuiltinFile], data: &[u8]) -> Option<TomlSource> {
    let (&which, picks) = data.split_first()?;
    let file = files.get(usize::from(which) % files.len().max(1))?;
    let mut table: Table = file.toml.parse().ok()?;
    for pick in picks.chunks_exact(2).take(8) {
        let mut leaves = Vec::new();
        table.iter_mut().for_each(|(_, value)| collect(value, &mut leaves));
        let count = leaves.len().max(1);
        if let Some(leaf) = leaves.into_iter().nth(usize::from(pick[0]) % count) {
            *leaf = replaced(leaf, pick[1]);
        }
    }
    let text = toml::to_string(&table).ok()?;
    Some(TomlSource { name: "fuzz.toml".into(), folder: "absent".into(), text })
}

/// Every value that holds no others.
fn collect<'a>(value: &'a mut Value, leaves: &mut Vec<&'a mut Value>) {
    match value {
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| collect(value, leaves)),
        Value::Array(items) if items.is_empty() => {}
        Value::Array(items) => items.iter_mut().for_each(|value| collect(value, leaves)),
        leaf => leaves.push(leaf),
    }
}

/// Numbers grow or shrink by up to 2^32, or become one that often goes wrong. Other values change their type.
fn replaced(value: &Value, how: u8) -> Value {
    let numbers = [0.0, -1.0, 1.0, 0.5, 1e308, 1e-300, f64::NAN, f64::INFINITY, -0.0, 255.0];
    let how = usize::from(how);
    let number = match value {
        Value::Float(x) => *x,
        Value::Integer(i) => *i as f64,
        Value::Boolean(b) if how < 128 => return Value::Boolean(!b),
        Value::String(text) if how < 128 => return Value::String(text.chars().rev().collect()),
        _ => 1.0,
    };
    match how {
        0..=127 => {
            let scaled = number * (0.25 * (how as f64 - 64.0)).exp2();
            if value.is_integer() { Value::Integer(scaled as i64) } else { Value::Float(scaled) }
        }
        128..=191 => Value::Float(numbers[how % numbers.len()]),
        192..=223 => Value::Integer(numbers[how % numbers.len()] as i64),
        224..=239 => Value::String("text".into()),
        _ => Value::Array(Vec::new()),
    }
}
