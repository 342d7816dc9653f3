//! The plan of the seeds of results; parts of no other are read far.

use serde_json::json;
use smalti_io::dataset::{ColumnKind, ColumnSpec, Plan};

pub fn plan() -> Plan {
    let spec =
        |name: &str, kind| ColumnSpec { name: name.into(), kind, unit: "nm".into(), doc: String::new() };
    Plan {
        study: json!({"seed": 1}),
        schema: vec![
            spec("a", ColumnKind::Int),
            spec("b", ColumnKind::Float),
            spec("c", ColumnKind::Text),
            spec("d", ColumnKind::Floats),
        ],
        trials: 3,
        chunk: 3,
    }
}
