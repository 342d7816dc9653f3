//! The keys of camera and study files, from the JSON Schema that the code reading them generates.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};
use smalti::camera::KeyRange;

/// An item or key in a list.
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) summary: String,
    pub(crate) details: Vec<String>,
    pub(crate) json: serde_json::Value,
}

/// The keys of a schema in the order of the code; keys of inner tables have their path. Definitions that several keys share, such as
/// the shapes of a filter, are explained at the first key only.
pub(crate) fn keys(schema: &schemars::Schema) -> Vec<Entry> {
    let root = schema.as_value();
    let mut walk = Walk { definitions: &root["$defs"], explained: BTreeSet::new(), entries: Vec::new() };
    walk.table(root, "");
    walk.entries
}

/// As [`keys`], each key of a number with its range.
pub(crate) fn camera_keys(schema: &schemars::Schema) -> Vec<Entry> {
    let mut entries = keys(schema);
    for entry in &mut entries {
        let Some(range) = KeyRange::of(&entry.name) else { continue };
        entry.summary = format!("{} Range: {range}.", entry.summary);
        if let Value::Object(json) = &mut entry.json {
            json.insert("range".into(), json!([range.low, range.high]));
        }
    }
    entries
}

struct Walk<'a> {
    definitions: &'a Value,
    explained: BTreeSet<&'a str>,
    entries: Vec<Entry>,
}

impl<'a> Walk<'a> {
    /// The schema behind a reference, with the name of its definition; for an optional value, the schema of the value.
    fn resolved(&self, schema: &'a Value) -> (&'a Value, Option<&'a str>) {
        if let Some(there) = schema["anyOf"].as_array().and_then(|a| a.iter().find(|s| s["type"] != "null"))
            && schema["anyOf"].as_array().is_some_and(|a| a.iter().any(|s| s["type"] == "null"))
        {
            return self.resolved(there);
        }
        match schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            Some(name) => (&self.definitions[name], Some(name)),
            None => (schema, None),
        }
    }

    fn table(&mut self, schema: &'a Value, prefix: &str) {
        for (key, value) in properties(schema).into_iter().flatten() {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            self.key(&path, value);
        }
    }

    fn key(&mut self, path: &str, schema: &'a Value) {
        let (own, name) = self.resolved(schema);
        if properties(own).is_some() && own["oneOf"].is_null() {
            return self.table(own, path);
        }
        // The choices of a list are those of its items.
        let (item, item_name) =
            if own["items"].is_object() { self.resolved(&own["items"]) } else { (own, name) };
        let variants = ["oneOf", "anyOf"].iter().find_map(|k| item[k].as_array());
        let first = item_name.is_none_or(|n| self.explained.insert(n));
        let words = variants.into_iter().flatten().filter(|v| v["const"].is_string());
        let mut details: Vec<String> = Vec::new();
        if first {
            details.extend(words.map(|v| format!("{}  {}", v["const"], text(&v["description"]))));
        }
        let default = &schema["default"];
        let doc = text(&schema["description"]);
        let doc = if doc.is_empty() { text(&own["description"]) } else { doc };
        let shown = if default.is_null() { String::new() } else { format!("{}  ", toml_text(default)) };
        self.entries.push(Entry {
            name: path.to_owned(),
            summary: format!("{shown}{doc}"),
            details,
            json: json!({"key": path, "default": default, "doc": doc}),
        });
        // The tables that the value may be.
        for variant in variants.into_iter().flatten().filter(|_| first) {
            let (variant, _) = self.resolved(variant);
            let doc = text(&variant["description"]);
            for (key, value) in properties(variant).into_iter().flatten() {
                let path = format!("{path}.{key}");
                self.entries.push(Entry {
                    name: path.clone(),
                    summary: doc.clone(),
                    details: Vec::new(),
                    json: json!({"key": path, "doc": doc}),
                });
                let (inner, _) = self.resolved(value);
                self.table(inner, &path);
            }
        }
    }
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema["properties"].as_object()
}

/// The first paragraph of a documentation comment as one line; links become their text.
fn text(doc: &Value) -> String {
    let first = doc.as_str().unwrap_or_default().split("\n\n").next().unwrap_or_default();
    let mut line = first.split_whitespace().collect::<Vec<_>>().join(" ");
    while let Some((before, rest)) = line.split_once("`](") {
        let after = rest.split_once(')').map_or("", |(_, after)| after);
        line = format!("{before}`{after}");
    }
    line.replace("[`", "`").replace("`]", "`")
}

/// A default value as TOML.
fn toml_text(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let fields: Vec<String> = map.iter().map(|(k, v)| format!("{k} = {}", toml_text(v))).collect();
            if fields.is_empty() { "{}".into() } else { format!("{{ {} }}", fields.join(", ")) }
        }
        Value::Array(items) => {
            format!("[{}]", items.iter().map(toml_text).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}
