// Axes: linear or logarithmic, with ticks at round values.

function scaleOf(low, high, log, from, to) {
  const code = log ? Math.log10 : (v) => v;
  const [a, b] = [code(low), code(high)];
  const slope = (to - from) / (b - a || 1);
  return {
    low, high, log, from, to,
    at: (v) => from + (code(v) - a) * slope,
    value: (p) => {
      const v = a + (p - from) / slope;
      return log ? 10 ** v : v;
    },
  };
}
function ticksOf(scale, most) {
  if (scale.log) {
    for (const steps of [[1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 3, 5, 7], [1, 2, 5], [1, 3], [1]]) {
      const ticks = [];
      for (let power = Math.floor(Math.log10(scale.low)); power <= Math.log10(scale.high); power += 1) {
        for (const s of steps) {
          const v = s * 10 ** power;
          if (v >= scale.low * 0.999 && v <= scale.high * 1.001) ticks.push(v);
        }
      }
      if (ticks.length <= most || steps.length === 1) return ticks.slice(0, 4 * most);
    }
  }
  const rough = (scale.high - scale.low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((s) => s * power).find((s) => s >= rough) || 10 * power;
  const ticks = [];
  for (let i = Math.ceil(scale.low / step - 1e-6); i * step <= scale.high + 1e-6 * step && ticks.length < 100; i += 1) ticks.push(i * step);
  return ticks;
}
function tickText(v) {
  const size = Math.abs(v);
  if (size >= 1e5 || (size > 0 && size < 1e-3)) return v.toExponential(0);
  return String(Number(v.toPrecision(6))).replace("-", "−");
}

// The ends of an axis: all but few designs that would press the others together, unless those are near or among the best.
function endsOf(values, keep, whole, best) {
  const [first, last] = extent(values, keep);
  if (!(first <= last)) return [0, 1];
  let [low, high] = whole ? [first, last] : quantiles(values, keep, [0.002, 0.99]);
  for (const row of best) {
    if (!keep[row] || !Number.isFinite(values[row])) continue;
    low = Math.min(low, values[row]);
    high = Math.max(high, values[row]);
  }
  const reach = 0.25 * (high - low);
  if (first > low - reach) low = first;
  if (last < high + reach) high = last;
  if (low === high) return [low - Math.max(0.5, Math.abs(low) * 0.1), high + Math.max(0.5, Math.abs(high) * 0.1)];
  return [low, high];
}
