// Histograms of a few columns: all that is shown in grey, the selection in colour, each as shares of its own. The bin below the pointer, or
// chosen by arrow keys, is told in words.

const BINS = 40;

class Histogram {
  constructor(column) {
    this.column = column;
    this.chart = null;
    this.bin = -1;
    this.plane = make("div", { class: "plane", tabindex: "0", role: "application", "aria-roledescription": "histogram", keydown: (event) => this.walk(event), blur: () => this.tell(-1) });
    this.words = make("figcaption", { "aria-live": "polite" });
    this.element = make("figure", { class: "histogram" }, make("h3", {}, withUnit(column)), this.plane, this.words);
    new ResizeObserver(() => {
      const size = sizeOf(this.plane);
      if (!size || !this.all) return;
      if (!this.chart) this.chart = this.build(size);
      else if (size.width !== this.chart.width || size.height !== this.chart.height) this.chart.setSize(size);
    }).observe(this.plane);
  }

  // Which bin each row is in, whenever other rows are shown; -1 for none.
  prepare(keep) {
    const { values } = this.column;
    const [low, high, median] = quantiles(values, keep, [0.003, 0.985, 0.5]);
    const step = (high - low || 1) / BINS;
    this.bins = Int8Array.from(values, (v) => {
      const bin = Math.floor((v - low) / step);
      return bin >= 0 && bin < BINS ? bin : -1;
    });
    Object.assign(this, { low, step, median, edges: Array.from({ length: BINS }, (_, i) => low + i * step), all: this.count(keep) });
  }

  count(mask) {
    const { bins, column: { values } } = this;
    const shares = new Array(BINS).fill(0);
    let n = 0;
    for (let i = 0; i < bins.length; i += 1) {
      if (!mask[i] || Number.isNaN(values[i])) continue;
      n += 1;
      if (bins[i] >= 0) shares[bins[i]] += 1;
    }
    return shares.map((v) => v / Math.max(1, n));
  }

  show(selected, brushed) {
    this.some = brushed ? this.count(selected) : null;
    this.mine = brushed ? quantiles(this.column.values, selected, [0.5])[0] : NaN;
    this.chart?.setData(this.data());
    this.tell(this.bin);
    this.plane.setAttribute("aria-label",
      `Histogram of ${withUnit(this.column)}, ${shown(this.low)} to ${shown(this.low + BINS * this.step)}. ${this.summary()}. Arrow keys tell the share of each bin.`);
  }
  summary() {
    return this.some ? `Median ${shown(this.median)}; of the selection ${shown(this.mine)}` : `Median ${shown(this.median)}`;
  }

  data() {
    return [this.edges, this.all, this.some ?? this.all.map(() => null)];
  }
  build(size) {
    const bars = (color, alpha) => ({
      fill: () => themeColor(color), alpha, width: 0, points: { show: false }, paths: uPlot.paths.bars({ size: [0.88, Infinity], align: 1 }),
    });
    const top = () => Math.max(1e-9, ...this.all, ...(this.some ?? []));
    return new uPlot({
      ...size, padding: [4, 12, 0, 12], legend: { show: false },
      scales: { x: { time: false, range: () => [this.low, this.low + BINS * this.step] }, y: { range: () => [0, 1.02 * top()] } },
      axes: [axisOf({ size: 24, gap: 3, space: 48, grid: { show: false }, border: { show: true, width: 1, stroke: () => themeColor("--line") } }), { show: false }],
      series: [{}, bars("--shares", 1), bars("--accent", 0.78)],
      cursor: { x: false, y: false, points: { show: false }, drag: { x: false, y: false }, bind: { dblclick: () => null } },
      hooks: { setCursor: [({ cursor: { left } }) => this.tell(left < 0 ? -1 : this.binAt(left))] },
    }, this.data(), this.plane);
  }

  binAt(left) {
    return Math.min(BINS - 1, Math.max(0, Math.floor((this.chart.posToVal(left, "x") - this.low) / this.step)));
  }
  walk(event) {
    const step = { ArrowLeft: -1, ArrowRight: 1, Home: -BINS, End: BINS }[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    this.tell(Math.min(BINS - 1, Math.max(0, this.bin < 0 && step === -1 ? BINS - 1 : this.bin + step)));
    event.preventDefault();
  }
  tell(bin) {
    this.bin = bin;
    const percent = (v) => `${shown(Number((100 * v).toPrecision(3)))} %`;
    const [from, to] = [this.low + bin * this.step, this.low + (bin + 1) * this.step];
    const words = bin < 0 ? this.summary() : `${shown(from)} to ${shown(to)}: ${percent(this.all[bin])}${this.some ? `; of the selection ${percent(this.some[bin])}` : ""}`;
    if (this.words.textContent !== words) this.words.textContent = words;
    if (!this.chart || (bin < 0 && this.chart.select.width === 0)) return;
    const left = bin < 0 ? 0 : this.chart.valToPos(from, "x");
    this.chart.setSelect({ left, top: 0, width: bin < 0 ? 0 : this.chart.valToPos(to, "x") - left, height: this.chart.bbox.height / uPlot.pxRatio }, false);
  }
}
