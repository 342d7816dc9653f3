//! The results of a study as plain data: a row for each scored trial, a column for each quantity.

use std::sync::Arc;

use super::study::Trials;

/// The name of the column for the key of a condition or the name of a scene: `optics.f_number` becomes `optics_f_number`.
#[must_use]
pub fn column_of_key(key: &str) -> String {
    key.replace(|c: char| !c.is_ascii_alphanumeric(), "_")
}

/// The results of a study, complete or not, with what is known of their origin.
#[derive(Debug, Clone)]
pub struct StudyResults {
    /// The trials of the study. The rows are those that have been scored.
    pub trials: Trials,
    /// What the study investigates, in the words of its file. Empty where the file has none.
    pub about: String,
    /// The study as JSON, as it was recorded with the results.
    pub study_json: String,
    /// Whether the study is built in: then its name alone identifies it.
    pub is_built_in: bool,
    /// The version of Smalti that scored the trials.
    pub smalti_version: String,
    /// BLAKE3 hash of the plan of the results, hexadecimal.
    pub plan_blake3: String,
    /// Where the results were read, as text for readers.
    pub origin: String,
    /// Number of parts of complete results.
    pub parts: u64,
    /// Number of parts that are absent.
    pub parts_missing: u64,
    /// The number of the trial of each row, ascending.
    pub numbers: Vec<u64>,
    /// One value per row in each column. Columns of lists are left out: their values follow from the trials.
    pub columns: Vec<ResultColumn>,
}

/// A column of the results of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultColumn {
    /// Its name, such as `delta_e_76`.
    pub name: String,
    /// The unit of its values. Empty where they have none.
    pub unit: String,
    /// What it means, in a sentence.
    pub doc: String,
    /// One value per row.
    pub values: ColumnValues,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnValues {
    /// Whole numbers.
    Integers(Vec<i64>),
    /// Numbers. NaN marks a trial without this score.
    Numbers(Vec<f64>),
    /// Texts. Equal texts share their memory.
    Texts(Vec<Arc<str>>),
}

impl StudyResults {
    /// A column by its name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&ResultColumn> {
        self.columns.iter().find(|c| c.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::super::study::tests::study;
    use super::*;

    #[test]
    fn columns_are_found_by_their_names() {
        let column = |name: &str, values| ResultColumn {
            name: name.into(),
            unit: String::new(),
            doc: String::new(),
            values,
        };
        let columns = vec![
            column("trial", ColumnValues::Integers(vec![0, 1])),
            column(&column_of_key("optics.f_number"), ColumnValues::Numbers(vec![2.0, 4.0])),
        ];
        let results = StudyResults {
            trials: Trials::new(study()).unwrap(),
            about: String::new(),
            study_json: String::new(),
            is_built_in: false,
            smalti_version: String::new(),
            plan_blake3: String::new(),
            origin: String::new(),
            parts: 1,
            parts_missing: 0,
            numbers: vec![0, 1],
            columns: columns.clone(),
        };
        assert_eq!(results.column("trial"), Some(&columns[0]));
        assert_eq!(results.column("optics_f_number"), Some(&columns[1]));
        assert_eq!(results.column("optics.f_number"), None);
    }
}
