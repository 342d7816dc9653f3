// What the plots of uPlot on a page have in common, and where their axes end.

const FONT_FAMILY = "system-ui, -apple-system, \"Segoe UI\", Roboto, \"Helvetica Neue\", Arial, sans-serif";
const FONT = `12px ${FONT_FAMILY}`;

// An axis in the colours of the page.
function axisOf(options) {
  return {
    stroke: () => themeColor("--soft"), grid: { stroke: () => themeColor("--faint"), width: 1 }, ticks: { show: false }, font: FONT,
    values: (u, ticks) => ticks.map((v) => (v === null ? "" : tickText(v))), ...options,
  };
}
// As wide as its labels.
function widthOf(side) {
  return side === 2 ? 26 : (u, labels) => 14 + 7 * Math.max(2, ...(labels || []).map((t) => t.length));
}
// The box in which a plot is drawn; none while it is not laid out, or is on paper.
function sizeOf(element) {
  const { clientWidth: width, clientHeight: height } = element;
  return width < 10 || height < 10 || onPaper ? null : { width, height };
}
// Ticks of a logarithmic axis: uPlot's begin at its end, whatever that is.
function decades(u, axis, low, high) {
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power += 1) {
    for (let digit = 1; digit < 10; digit += 1) {
      const v = Number(`${digit}e${power}`);
      if (v >= low && v <= high) ticks.push(v);
    }
  }
  return ticks;
}
function tickText(v) {
  const size = Math.abs(v);
  if (size >= 1e5 || (size > 0 && size < 1e-3)) return v.toExponential(0);
  return String(Number(v.toPrecision(6))).replace("-", "−");
}

// The ends of an axis: all but few trials that would press the others together, unless those are near or among the best.
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
// Rows that no other kept row beats in both columns, by rising x; none where a column has no better end.
function frontOf(x, y, keep) {
  if (!x.better || !y.better || x === y) return [];
  const [sx, sy] = [x, y].map((c) => (c.better === "higher" ? -1 : 1));
  const rows = [];
  for (let i = 0; i < keep.length; i += 1) if (keep[i] && Number.isFinite(x.values[i]) && Number.isFinite(y.values[i])) rows.push(i);
  rows.sort((a, b) => sx * (x.values[a] - x.values[b]) || sy * (y.values[a] - y.values[b]));
  const front = [];
  let best = Infinity;
  for (const row of rows) {
    const v = sy * y.values[row];
    if (v < best) {
      best = v;
      front.push(row);
    }
  }
  return front.sort((a, b) => x.values[a] - x.values[b]);
}
