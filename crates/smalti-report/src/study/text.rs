//! The report in words and tables.

use smalti::design::statistics::{Estimate, Summary};
use smalti::design::{Design, FilterFamily};

use super::results::{MAIN, Measure, Results};
use super::sections::{Group, Section, label};
use crate::ReportError;
use crate::reliability::{mark, meanings};
use crate::words::{TextTable, plain};

/// Rows shown of the Pareto front.
const FRONT: usize = 10;
/// Conditions with tables of their own, unless others are chosen. The document has all.
pub(super) const TABLES: usize = 3;
/// Conditions in the table of all conditions.
const CONDITIONS: usize = 30;
/// Problems shown of a study.
const PROBLEMS: usize = 5;

/// The headings of the exposure of the targets.
const EXPOSURE: [&str; 2] = ["exposure ms", "saturated %"];

/// All tables of the results of studies. `shown` are the conditions of each study that have tables of their own.
pub(super) fn text(
    all: &[(&Results, Vec<Section<'_>>)],
    shown: &[Vec<&Section<'_>>],
    table: &TextTable<'_>,
) -> Result<String, ReportError> {
    let mut out = String::new();
    for ((results, sections), shown) in all.iter().zip(shown) {
        out += &head(results);
        out += &conditions(sections, shown.len(), table);
        for section in shown {
            if !section.name.is_empty() {
                out += &format!("\n── {} ──\n", section.name);
            }
            out += &format!("\n{}", means(section, table));
            for words in section.exposure_in_words().into_iter().chain(section.unreliable_in_words()) {
                out += &format!("{words}\n");
            }
            if !section.labels.is_empty() && results.has_plane() {
                let cloud = all.iter().filter(|(r, _)| !r.is_named()).find_map(|(_, s)| s.first());
                out += &format!("\n{}", by_label(section, cloud, table));
            }
            out += &format!(
                "\nBest designs: {}\n{}",
                section.choice.words(),
                designs(section, &best_rows(section), table)?
            );
            out += &front(section, table)?;
            out += &marks(section);
        }
        out.push('\n');
    }
    out += "Exposure and saturated: exposure times of ColorChecker and edge, and the larger share of their raw samples that saturate without noise; – where \
            results of an earlier version lack the share.\n";
    out += "Intervals in parentheses contain the mean with a confidence of 95 %. The interval of 90 % of the designs reaches from the 5th to the 95th percentile.\n";
    Ok(out)
}

/// A row for each condition of a study with several: the means over all designs. `detailed` of them have tables of their own.
fn conditions(sections: &[Section<'_>], detailed: usize, table: &TextTable<'_>) -> String {
    let [first, _, ..] = sections else { return String::new() };
    let measures = &first.results.measures;
    let header: Vec<&str> = ["condition", "designs"]
        .into_iter()
        .chain(measures.iter().map(|measure| measure.header.as_str()))
        .chain(EXPOSURE)
        .collect();
    let rows: Vec<Vec<String>> = sections.iter().take(CONDITIONS).map(condition_row).collect();
    let mut out = format!("\nMeans of all designs under each condition\n{}", table(&header, &rows));
    if sections.len() > CONDITIONS {
        out += &format!(
            "The first {CONDITIONS} of {} conditions are listed; report.json has all.\n",
            sections.len()
        );
    }
    if detailed < sections.len() {
        out += &format!(
            "Tables of {detailed} of the {} conditions follow. `--draw TEXT` prints those of the conditions whose name contains TEXT instead; report.json has all.\n",
            sections.len()
        );
    }
    out
}

/// The name of a condition, the number of its designs, the mean of each metric over those that have it, and their exposure.
pub(super) fn condition_row(section: &Section<'_>) -> Vec<String> {
    let mean = |measure: &Measure| {
        let values = section.rows.clone().map(|row| measure.at(row)).filter(|v| v.is_finite());
        let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
        if count == 0 { "–".into() } else { format!("{:.*}", measure.digits, sum / count as f64) }
    };
    let designs = section.rows.len().to_string();
    let means = section.results.measures.iter().map(mean);
    let exposure = section.exposure_cells(&section.rows.clone().collect::<Vec<_>>());
    [section.name.clone(), designs].into_iter().chain(means).chain(exposure).collect()
}

fn head(results: &Results) -> String {
    let data = &results.data;
    let (there, all) = (data.numbers.len() as u64, data.trials.len());
    let mut out = format!("{}: {all} trials\n", results.name());
    if !results.about().is_empty() {
        out += &format!("{}\n", results.about());
    }
    if there < all {
        out += &format!(
            "Incomplete: {} of {} parts are missing, {} trials. This report covers the {there} scored trials.\n",
            data.parts_missing,
            data.parts,
            all - there
        );
    }
    let mut problems: Vec<_> = results.problems.iter().collect();
    problems.sort_by_key(|(problem, count)| (std::cmp::Reverse(**count), (*problem).clone()));
    if results.has_no_scores() {
        out += "No trial has scores, so that the tables are empty.\n";
    }
    for (problem, count) in problems.iter().take(PROBLEMS) {
        out += &format!("{}\n", plain(&left_out(problem, **count)));
    }
    if problems.len() > PROBLEMS {
        out += &format!("Left out: {} more kinds of problems\n", problems.len() - PROBLEMS);
    }
    out
}

/// The number of trials that lack scores for one reason.
pub(super) fn left_out(problem: &str, count: u64) -> String {
    let trials = if count == 1 { "one trial".to_owned() } else { format!("{count} trials") };
    format!("Left out: {trials} without some or all scores. Reason: {problem}")
}

/// A value and its confidence interval.
fn estimate(e: &Estimate, digits: usize) -> String {
    if !e.value.is_finite() {
        return "–".into();
    }
    if !(e.low.is_finite() && e.high.is_finite()) {
        return format!("{:.digits$}", e.value);
    }
    format!("{:.digits$} ({})", e.value, interval(e.low, e.high, digits))
}

/// The ends of an interval, with "to" between them, since a dash before a minus sign cannot be read.
pub(super) fn interval(low: f64, high: f64, digits: usize) -> String {
    format!("{low:.digits$} to {high:.digits$}").replace('-', "−")
}

/// The interval that holds 90 % of the designs.
pub(super) fn spread(s: &Summary, digits: usize) -> String {
    if s.count == 0 { "–".into() } else { format!("{:.digits$}–{:.digits$}", s.p05.value, s.p95.value) }
}

/// The paper's table 2, with intervals.
fn means(section: &Section<'_>, table: &TextTable<'_>) -> String {
    let measures = &section.results.measures;
    let mut header = vec!["colours", "designs", "left out"];
    for measure in measures {
        header.push(&measure.header);
        header.extend(is_spread(&measure.name).then_some("90 %"));
    }
    let row = |g: &Group| {
        let (designs, left_out) = g.counts();
        let mut row = vec![g.colors.to_string(), designs.to_string(), left_out.to_string()];
        for (measure, summary) in measures.iter().zip(&g.summaries) {
            row.push(estimate(&summary.mean, measure.digits));
            row.extend(is_spread(&measure.name).then(|| spread(summary, measure.digits)));
        }
        row
    };
    table(&header, &section.groups.iter().map(row).collect::<Vec<_>>())
}

/// Whether the interval of 90 % of the designs is shown: for colour and resolution, as in the paper.
pub(super) fn is_spread(name: &str) -> bool {
    MAIN[..2].contains(&name)
}

/// Designs by name, and the means of a cloud of other designs.
fn by_label(section: &Section<'_>, cloud: Option<&Section<'_>>, table: &TextTable<'_>) -> String {
    let several = section.labels.values().flat_map(|g| g.values()).any(|rows| rows.len() > 1);
    let mut header = vec!["colours", "filters", "ΔE", "MTF50 cy/mm", "noise %"];
    header.extend(EXPOSURE);
    header.extend(several.then_some("designs"));
    let row = |colors: u8, name: &str, means: [f64; 3], mark: &str, exposure: [String; 2], count: usize| {
        let [d, m, n] = means;
        let mut row = vec![colors.to_string(), name.to_owned()];
        // A study need not score noise.
        let noise = if n.is_finite() { format!("{n:.2}") } else { "–".into() };
        row.extend([format!("{d:.2}"), format!("{m:.1}{mark}"), noise]);
        row.extend(exposure);
        row.extend(several.then(|| count.to_string()));
        row
    };
    let mut rows = Vec::new();
    for group in &section.groups {
        for (label, members) in &section.labels {
            let members = members.get(&group.colors).map_or(&[][..], Vec::as_slice);
            let scores: Vec<[f64; 3]> =
                members.iter().map(|&r| section.scores(r)).filter(|s| s[0].is_finite()).collect();
            let mean = |i: usize| scores.iter().map(|s| s[i]).sum::<f64>() / scores.len() as f64;
            if !scores.is_empty() {
                // The mark of a mean is that of any of its designs.
                let mark = members.iter().map(|&r| mark(section.reliability(r))).find(|m| !m.is_empty());
                let (mark, exposure) = (mark.unwrap_or_default(), section.exposure_cells(members));
                rows.push(row(group.colors, label, [0, 1, 2].map(mean), mark, exposure, scores.len()));
            }
        }
        let beside = cloud.and_then(|c| Some((c, c.groups.iter().find(|g| g.colors == group.colors)?)));
        if let Some((cloud, g)) = beside {
            let means = [&g.delta_e, &g.mtf50, &g.noise].map(|s| s.mean.value);
            let name = format!("mean of {}", cloud.results.name());
            let exposure = cloud.exposure_cells(&cloud.rows_of(group.colors).collect::<Vec<_>>());
            rows.push(row(group.colors, &name, means, "", exposure, g.delta_e.count));
        }
    }
    table(&header, &rows)
}

fn design_row(section: &Section<'_>, row: usize) -> Result<Vec<String>, ReportError> {
    let trial = section.results.trial(row)?;
    let mut cells = vec![trial.design.filters.filters.len().to_string(), trial.number.to_string()];
    let mark = mark(section.reliability(row));
    cells.extend(section.results.measures.iter().map(|m| {
        let is_resolution = m.name.starts_with("mtf50_") && m.at(row).is_finite();
        m.text(row) + if is_resolution { mark } else { "" }
    }));
    cells.extend(section.exposure_cells(&[row]));
    cells.extend([section.results.mosaic(&trial.design), filters(section, &trial.design)?]);
    Ok(cells)
}

/// Centre and width of each filter, nm.
pub(super) fn figures(design: &Design) -> Result<Vec<String>, ReportError> {
    let figures = design.filters.figures()?;
    Ok(figures.iter().map(|f| format!("{:.0}/{:.0}", f.center_nm, f.fwhm_nm)).collect())
}

fn filters(section: &Section<'_>, design: &Design) -> Result<String, ReportError> {
    let figures = figures(design)?.join(" ");
    Ok(match section.results.study().filters {
        FilterFamily::GaussianGrid(_) => figures,
        _ => format!("{figures} ({})", label(design)),
    })
}

fn designs(section: &Section<'_>, rows: &[usize], table: &TextTable<'_>) -> Result<String, ReportError> {
    let measures = section.results.measures.iter().map(|m| m.header.as_str());
    let header: Vec<&str> = ["colours", "trial"]
        .into_iter()
        .chain(measures)
        .chain(EXPOSURE)
        .chain(["mosaic", "filters: centre/FWHM nm"])
        .collect();
    let rows = rows.iter().map(|&r| design_row(section, r)).collect::<Result<Vec<_>, ReportError>>()?;
    Ok(table(&header, &rows))
}

/// The meaning of the marks at MTF50 that are shown.
fn marks(section: &Section<'_>) -> String {
    let shown = best_rows(section).into_iter().chain(section.some_of_front(FRONT));
    let shown = shown.chain(section.labels.values().flat_map(|g| g.values()).flatten().copied());
    meanings(shown.map(|row| section.reliability(row))).iter().map(|line| format!("{line}\n")).collect()
}

fn best_rows(section: &Section<'_>) -> Vec<usize> {
    section.groups.iter().flat_map(|g| g.best.iter().copied()).collect()
}

fn front(section: &Section<'_>, table: &TextTable<'_>) -> Result<String, ReportError> {
    let rows = section.some_of_front(FRONT);
    let all = section.front.len();
    let shown =
        if rows.len() < all { format!("; {} of them, evenly spread", rows.len()) } else { String::new() };
    Ok(format!(
        "\nPareto front: {all} designs that no other design beats in {}{shown}\n{}",
        section.compared_in_words(),
        designs(section, &rows, table)?
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_reach_below_zero_can_be_read() {
        assert_eq!(interval(-5.09, 17.1, 2), "−5.09 to 17.10");
        assert_eq!(interval(5.0, 7.0, 1), "5.0 to 7.0");
    }
}
