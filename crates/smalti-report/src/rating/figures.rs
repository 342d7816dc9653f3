//! Figures of an experiment.

use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{Level, PsychometricFit, ScaledConditions};

use crate::comparison::figures::{drawn, look};
use crate::page::Markup;
use crate::{Line, Plot, Points};

/// Width and least height of figures, which phones shall show legibly.
const SIZE: (f64, f64) = (460.0, 400.0);
/// Height of a name in a legend.
const NAME: f64 = 26.0;
/// Points of a curve.
const CURVE: usize = 121;
/// The 0.975 quantile of the normal distribution.
const NORMAL: f64 = 1.96;

/// The scores of all conditions with their intervals, the best first.
pub(super) fn scale(conditions: &[String], scale: &ScaledConditions, order: &[usize]) -> Markup {
    let ends = |e: &Estimate| e.interval.map_or((e.value, e.value), |i| (i.low, i.high));
    let ranks: Vec<f64> = (1..=conditions.len()).map(|rank| rank as f64).collect();
    let mut plot = Plot::new("Rank", "Score (JOD)")
        .title("Scale of the choices")
        .x_range(0.5, conditions.len() as f64 + 0.5)
        .x_ticks(&ranks)
        .size(SIZE.0, SIZE.1 + NAME * conditions.len() as f64);
    for (&rank, &i) in ranks.iter().zip(order) {
        let (color, symbol) = look(i);
        let points = Points::new(&conditions[i], &[rank], &[scale.jod[i].value]);
        plot = plot.points(
            points.color(color).symbol(symbol).radius(6.0).marks().y_intervals(&[ends(&scale.jod[i])]),
        );
    }
    drawn(&plot)
}

/// The shares of choices in each amount of light, and the psychometric function.
pub(super) fn light(levels: &[Level], fit: Option<&PsychometricFit>) -> Markup {
    let asked: Vec<&Level> = levels.iter().filter(|l| l.asked > 0.0).collect();
    let x: Vec<f64> = asked.iter().map(|l| l.level).collect();
    let y: Vec<f64> = asked.iter().map(|l| 100.0 * l.chosen / l.asked).collect();
    // Wilson's interval of a share.
    let wilson = |l: &&Level| {
        let (n, p, z) = (l.asked, l.chosen / l.asked, NORMAL * NORMAL);
        let (middle, half) = (p + z / (2.0 * n), NORMAL * (p * (1.0 - p) / n + z / (4.0 * n * n)).sqrt());
        let scale = 100.0 / (1.0 + z / n);
        (scale * (middle - half), scale * (middle + half))
    };
    let intervals: Vec<(f64, f64)> = asked.iter().map(wilson).collect();
    let (color, symbol) = look(0);
    let mut plot = Plot::new("Light (stops)", "Preferred (%)")
        .title("Choices against light")
        .y_range(0.0, 100.0)
        .size(SIZE.0, SIZE.1);
    if let (Some(fit), Some(low), Some(high)) = (fit, x.first(), x.last()) {
        let at = |i: usize| low + (high - low) * i as f64 / (CURVE - 1) as f64;
        let curve: Vec<f64> = (0..CURVE).map(at).collect();
        let values: Vec<f64> = curve.iter().map(|s| 100.0 * fit.function.probability(*s)).collect();
        plot = plot.line(Line::new("psychometric function", &curve, &values).color(color).width(2.2));
        if fit.is_within {
            let equality = [fit.equality.value; 2];
            plot =
                plot.line(Line::new("point of equality", &equality, &[0.0, 50.0]).color(look(1).0).dashed());
        }
    }
    let points = Points::new("choices", &x, &y).color(color).symbol(symbol).radius(5.0).marks();
    drawn(&plot.points(points.y_intervals(&intervals)))
}
