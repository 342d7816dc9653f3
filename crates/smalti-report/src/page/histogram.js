// Histograms of a few columns: all that is shown in grey, the selection in colour, each as shares of its own.

const BINS = 40;

class Histogram {
  constructor(column) {
    this.column = column;
    this.all = draw("path", { class: "all" });
    this.some = draw("path", { class: "some" });
    this.low = make("span");
    this.high = make("span");
    this.title = draw("title");
    this.words = make("figcaption");
    const base = draw("path", { d: "M0 84.5H240", class: "base" });
    this.element = make("figure", { class: "histogram" }, make("h3", {}, withUnit(column)),
      draw("svg", { viewBox: "0 0 240 86", role: "img" }, this.title, this.all, this.some, base),
      make("div", { class: "ends", "aria-hidden": "true" }, this.low, this.high), this.words);
  }

  // Which bin each row is in, whenever other rows are shown; -1 for none.
  prepare(keep) {
    const { values } = this.column;
    const [low, high, median] = quantiles(values, keep, [0.003, 0.985, 0.5]);
    const slope = BINS / (high - low || 1);
    this.bins = Int8Array.from(values, (v) => {
      const bin = Math.floor((v - low) * slope);
      return bin >= 0 && bin < BINS ? bin : -1;
    });
    Object.assign(this, { rangeLow: low, rangeHigh: high, median, shares: this.count(keep) });
    this.low.textContent = tickText(Number(low.toPrecision(3)));
    this.high.textContent = tickText(Number(high.toPrecision(3)));
  }

  count(mask) {
    const { bins, column: { values } } = this;
    const shares = new Float64Array(BINS);
    let n = 0;
    for (let i = 0; i < bins.length; i += 1) {
      if (!mask[i] || Number.isNaN(values[i])) continue;
      n += 1;
      if (bins[i] >= 0) shares[bins[i]] += 1;
    }
    return shares.map((v) => v / Math.max(1, n));
  }

  show(selected, brushed) {
    const some = brushed ? this.count(selected) : [];
    const top = Math.max(1e-9, ...this.shares, ...some);
    this.all.setAttribute("d", steps(this.shares, top));
    this.some.setAttribute("d", brushed ? steps(some, top) : "");
    const mine = brushed ? quantiles(this.column.values, selected, [0.5])[0] : NaN;
    const words = brushed ? `Median ${shown(this.median)}; of the selection ${shown(mine)}` : `Median ${shown(this.median)}`;
    this.words.textContent = words;
    this.title.textContent = `Histogram of ${this.column.label}, ${shown(this.rangeLow)} to ${shown(this.rangeHigh)}. ${words}.`;
  }
}

function steps(bins, top) {
  const wide = 240 / BINS;
  return bins.reduce((d, v, i) => d + `M${i * wide + 0.4} 84V${(84 - (80 * v) / top).toFixed(1)}h${wide - 0.8}V84Z`, "");
}
