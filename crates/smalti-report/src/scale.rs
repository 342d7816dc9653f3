//! Axes: positions of values, and ticks.

/// The scale of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Linear: equal steps.
    #[default]
    Linear,
    /// Logarithmic: equal ratios; only positive values have a place.
    Log,
}

/// An axis with its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    pub(crate) scale: Scale,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// A tick and its label.
pub(crate) type Tick = (f64, String);

impl Axis {
    /// The axis for values from `low` to `high` with a margin, a share `air` of the range. The margin of values that are not negative
    /// ends at 0.
    pub(crate) fn around(scale: Scale, low: f64, high: f64, air: f64) -> Self {
        let (mut a, mut b) = (low, high);
        match scale {
            Scale::Linear => {
                if b - a <= 1e-9 * a.abs().max(b.abs()) || b - a < 1e-290 {
                    let half = if a == 0.0 { 0.5 } else { 0.1 * a.abs().max(b.abs()) };
                    (a, b) = (a - half, b + half);
                }
                let pad = (b - a) * air;
                a = if low >= 0.0 { (a - pad).max(0.0) } else { a - pad };
                b += pad;
            }
            Scale::Log => {
                let factor = if b / a < 1.0 + 1e-9 { 2.0 } else { libm::pow(b / a, air) };
                (a, b) = (a / factor, b * factor);
            }
        }
        Self { scale, low: a, high: b }
    }

    /// The place of a value, 0 at the low end and 1 at the high end; `None` for values without a place.
    pub(crate) fn place(&self, value: f64) -> Option<f64> {
        let t = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value > 0.0 => libm::log(value / self.low) / libm::log(self.high / self.low),
            Scale::Log => return None,
        };
        t.is_finite().then_some(t)
    }

    /// About `count` ticks at round values within the range.
    pub(crate) fn ticks(&self, count: usize) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => linear_ticks(self.low, self.high, count),
            Scale::Log => log_ticks(self.low, self.high, count),
        }
    }
}

/// A round step, 1, 2 or 5 times a power of ten, that divides a span into about `count` parts ([heckbert1990]).
pub(crate) fn round_step(span: f64, count: usize) -> f64 {
    let (mantissa, exponent) = round_parts(span, count);
    scaled(mantissa, exponent)
}

fn round_parts(span: f64, count: usize) -> (f64, i32) {
    let raw = span / count.max(1) as f64;
    let mut exponent = libm::floor(libm::log10(raw)) as i32;
    let fraction = raw / scaled(1.0, exponent);
    let mantissa = match fraction {
        f if f < 1.5 => 1.0,
        f if f < 3.5 => 2.0,
        f if f < 7.5 => 5.0,
        _ => {
            exponent += 1;
            1.0
        }
    };
    (mantissa, exponent)
}

/// `m · 10^e`, divided where that is exact.
fn scaled(m: f64, e: i32) -> f64 {
    let power = libm::pow(10.0, f64::from(e.abs()));
    if e < 0 { m / power } else { m * power }
}

fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<Tick> {
    let (mantissa, exponent) = round_parts(high - low, count);
    let step = scaled(mantissa, exponent);
    let slack = 1e-9 * (high - low);
    let first = libm::ceil((low - slack) / step);
    let last = libm::floor((high + slack) / step);
    if !(last - first).is_finite() || last - first > 1000.0 {
        return Vec::new();
    }
    (0..=(last - first).max(-1.0) as i64)
        .map(|i| {
            let value = scaled((first + i as f64) * mantissa, exponent);
            (value, label(value, exponent, low.abs().max(high.abs())))
        })
        .collect()
}

fn log_ticks(low: f64, high: f64, count: usize) -> Vec<Tick> {
    let decades = libm::log10(high / low);
    if decades < 0.7 {
        return linear_ticks(low, high, count);
    }
    let (from, to) = (libm::floor(libm::log10(low)) as i32, libm::ceil(libm::log10(high)) as i32);
    let within = |v: f64| v >= low * (1.0 - 1e-9) && v <= high * (1.0 + 1e-9);
    let steps: &[f64] = if decades * 3.0 <= count as f64 * 1.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = ((decades / count.max(1) as f64).ceil() as i32).max(1);
    (from..=to)
        .filter(|e| e.rem_euclid(every) == 0)
        .flat_map(|e| steps.iter().map(move |m| (scaled(*m, e), e)))
        .filter(|(v, _)| within(*v))
        .map(|(v, e)| (v, label(v, e, v)))
        .collect()
}

/// The value with the digits that a step of `10^exponent` needs, and a true minus sign.
fn label(value: f64, exponent: i32, largest: f64) -> String {
    let text = if value == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&largest) {
        let e = libm::floor(libm::log10(value.abs()) + 1e-9) as i32;
        let mantissa = value / scaled(1.0, e);
        let decimals = (e - exponent).clamp(0, 6) as usize;
        let power: String = e.to_string().chars().map(superscript).collect();
        match format!("{mantissa:.decimals$}").as_str() {
            "1" => format!("10{power}"),
            m => format!("{m}×10{power}"),
        }
    } else {
        format!("{value:.*}", (-exponent).clamp(0, 12) as usize)
    };
    text.replace('-', "−")
}

fn superscript(c: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    c.to_digit(10).and_then(|d| DIGITS.get(d as usize).copied()).unwrap_or('⁻')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, low: f64, high: f64, count: usize) -> Vec<String> {
        Axis { scale, low, high }.ticks(count).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(Scale::Linear, 0.0, 16.4, 8), ["0", "2", "4", "6", "8", "10", "12", "14", "16"]);
        assert_eq!(labels(Scale::Linear, -0.31, 0.3, 6), ["−0.3", "−0.2", "−0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(
            labels(Scale::Linear, 0.0, 2.1e-5, 2),
            ["0", "1×10⁻⁵", "2×10⁻⁵"].map(|l| l.replace("1×", ""))
        );
        assert_eq!(labels(Scale::Linear, 0.0, 3e6, 3), ["0", "10⁶", "2×10⁶", "3×10⁶"]);
        assert_eq!(labels(Scale::Log, 0.9, 110.0, 8), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(labels(Scale::Log, 0.01, 1e5, 4), ["0.01", "1", "100", "10000"]);
    }

    #[test]
    fn ranges_hold_what_they_show() {
        for (scale, low, high) in [
            (Scale::Linear, 3.0, 3.0),
            (Scale::Linear, 0.0, 0.0),
            (Scale::Linear, -5.0, 2.0),
            (Scale::Log, 1e-3, 1e-3),
            (Scale::Log, 1.0, 1e4),
        ] {
            let axis = Axis::around(scale, low, high, 0.04);
            for v in [low, high] {
                let t = axis.place(v).unwrap();
                assert!((0.0..=1.0).contains(&t), "{axis:?} {v}");
            }
            assert!(axis.ticks(5).len() < 20, "{axis:?}");
        }
        assert_eq!(Axis::around(Scale::Linear, 0.2, 9.0, 0.04).low, 0.0);
        assert_eq!(Axis { scale: Scale::Log, low: 1.0, high: 2.0 }.place(0.0), None);
    }
}
