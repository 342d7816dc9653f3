// @ts-check
// The scores: each with what the change from the pinned design did, also as a bar, and expected figures over light.
import { byId, draw, make, textScale } from "./dom.js";
import { SEED } from "./engine.js";
import { LUMINANCES } from "./work.js";

/** @typedef {import("./engine.js").Picture} Picture */
/** @typedef {import("./engine.js").Scores} Scores */
/** What is known of a design. @typedef {{ picture?: Picture, figures?: Scores }} Known */

/**
 * A score: where it is, how it is written, which direction is better, its name in the catalogue of metrics, and whether it is one of the picture or of the figures of the array.
 * @typedef {{ label: string, metric: string, unit: string, title: string, better: 1 | -1, digits: number, of: import("./work.js").Loop, get: (known: Known) => number | null | undefined }} Score
 */
/** @type {Score[]} */
const SCORES = [
  { label: "CPSNR", metric: "cpsnr_db", unit: "dB", title: "Peak signal-to-noise ratio of the picture against the reference", better: 1, digits: 2, of: "pictures", get: (k) => k.picture?.scores?.cpsnr_db },
  { label: "ΔE2000", metric: "pixel_delta_e_2000_mean", unit: "", title: "Mean CIEDE2000 over the pixels of the picture", better: -1, digits: 2, of: "pictures", get: (k) => k.picture?.scores?.pixel_delta_e_2000_mean },
  { label: "ΔE2000, 95 %", metric: "pixel_delta_e_2000_p95", unit: "", title: "CIEDE2000 that 95 % of the pixels do not exceed", better: -1, digits: 2, of: "pictures", get: (k) => k.picture?.scores?.pixel_delta_e_2000_p95 },
  { label: "S-CIELAB", metric: "scielab_mean", unit: "", title: "Mean colour difference after filtering by the spatial response of the eye", better: -1, digits: 2, of: "pictures", get: (k) => k.picture?.scores?.scielab_mean },
  {
    label: "MTF50 4:1", metric: "mtf50_low_contrast_cy_per_px", unit: "cy/px", title: "Spatial frequency at which the response of an edge of contrast 4:1 falls to one half, without noise", better: 1, digits: 3, of: "pictures",
    get: (k) => k.picture?.scores?.targets.mtf50_low_contrast_cy_per_px,
  },
  {
    label: "Noise", metric: "luminance_noise_percent", unit: "%", title: "Luminance noise on the grey patches of the ColorChecker, mean over four captures", better: -1, digits: 2, of: "pictures",
    get: (k) => k.picture?.scores?.targets.luminance_noise_percent,
  },
  { label: "Saturated", metric: "saturated_percent", unit: "%", title: "Share of the samples that are saturated", better: -1, digits: 2, of: "pictures", get: (k) => k.picture?.saturated_percent },
  { label: "Photon efficiency", metric: "photon_efficiency", unit: "%", title: "Share of the light on the pixels that becomes electrons", better: 1, digits: 1, of: "figures", get: (k) => scaled(k.figures?.array.photon_efficiency, 100) },
  { label: "Noise gain", metric: "luminance_noise_gain", unit: "×", title: "Standard deviation of the luminance after the colour matrix, relative to that of independent, equal noise in the channels", better: -1, digits: 2, of: "figures", get: (k) => k.figures?.array.luminance_noise_gain },
  { label: "Vora value", metric: "vora_value", unit: "", title: "How well the channels span the space of the observer, 0 to 1", better: 1, digits: 3, of: "figures", get: (k) => k.figures?.array.vora_value },
  { label: "SMI", metric: "sensitivity_metamerism_index", unit: "", title: "Sensitivity metamerism index, ISO 17321-1; 100 is an observer", better: 1, digits: 1, of: "figures", get: (k) => k.figures?.array.sensitivity_metamerism_index },
  { label: "Condition number", metric: "condition_number", unit: "", title: "Largest singular value of the channels divided by the smallest; noise is amplified where it is large", better: -1, digits: 2, of: "figures", get: (k) => k.figures?.array.condition_number },
];
/**
 * By how much a change of a score on this page differs from that between pipelines that are learned from all training scenes: not more in 95 % of 405 changes, those between ten
 * designs on three scenes at 1, 10 and 80 cd/m² (docs/how-to/studio.md). Smaller changes count as neither better nor worse. Where a picture clips,
 * none is judged: the largest differences are several times as large.
 * @type {Record<string, number>}
 */
const DOUBTS = { cpsnr_db: 0.9, pixel_delta_e_2000_mean: 0.6, pixel_delta_e_2000_p95: 1.3, scielab_mean: 1.8 };

/** What stands before everything that is of the state before a change that could not be computed. */
export const OUT_OF_DATE = "Out of date: ";
/** Bars end at this many of the smallest relevant differences. */
const BAR_END = 10;

/** @param {number | undefined} value @param {number} by */
const scaled = (value, by) => (value === undefined ? undefined : value * by);

/** @typedef {Exclude<keyof import("./engine.js").Expected, "luminance_cd_m2" | "time_s">} Figure */
/** @type {Record<Figure, { label: string, better: 1 | -1 }>} */
const FIGURES = {
  cpsnr_db: { label: "CPSNR, dB", better: 1 }, delta_e_2000: { label: "ΔE2000", better: -1 }, scielab: { label: "S-CIELAB", better: -1 }, detail_db: { label: "Detail, dB", better: 1 },
};

/** A number with a minus sign, but zero without a sign. @param {number} value @param {number} digits */
export function text(value, digits) {
  const shown = value.toFixed(digits);
  return shown.replace("-", Number(shown) === 0 ? "" : "−");
}

/** A change with its sign. @param {number} value @param {number} digits */
export function signed(value, digits) {
  const amount = text(Math.abs(value), digits);
  return `${Number(amount) === 0 ? "±" : value < 0 ? "−" : "+"}${amount}`;
}

/**
 * Words for a change of a score, of which the bar is that of `bar`. A change below the smallest relevant one, or within the doubt of the page, is neither better nor worse.
 * @param {Score} score @param {number} from @param {number} to @param {number} length @param {number} doubt
 */
function change(score, from, to, length, doubt) {
  const by = Number((to - from).toFixed(score.digits));
  if (by === 0) return { shown: "±0", said: "as pinned", kind: "same" };
  const amount = text(Math.abs(by), score.digits);
  const shown = `${by > 0 ? "+" : "−"}${amount}`;
  const directed = `${amount} ${by > 0 ? "more" : "less"} than pinned`;
  if (Math.abs(length) * BAR_END < 1) return { shown, said: `${directed}, which is not relevant`, kind: "same" };
  if (doubt === Infinity) return { shown: `${shown}, clipped`, said: `${directed}, not judged where the picture clips`, kind: "same" };
  if (Math.abs(by) < doubt) return { shown: `${shown} ± ${doubt}`, said: `${directed}, within the doubt of this page, ${doubt}`, kind: "same" };
  const kind = length > 0 ? "better" : "worse";
  return { shown: `${shown} ${kind}`, said: `${amount} ${kind} than pinned`, kind };
}

/**
 * The length of the bar of a change, -1 to 1, positive for the better: the share of `BAR_END` of the smallest relevant differences.
 * @param {Score} score @param {number} from @param {number} to @param {{ absolute?: number, relative?: number } | undefined} relevance
 */
function bar(score, from, to, relevance) {
  const least = relevance?.absolute ?? (relevance?.relative ?? 0.05) * Math.min(Math.abs(from), Math.abs(to));
  const by = to === from ? 0 : (to - from) * score.better / Math.max(least, Number.MIN_VALUE) / BAR_END;
  return Math.min(Math.max(by, -1), 1);
}

/** A message as a sentence. @param {string} message */
const sentence = (message) => `${message[0].toUpperCase()}${message.slice(1).replace(/\.$/, "")}.`;

/** @param {import("./engine.js").Engine["catalogue"]} catalogue */
export function setUpScores({ relevances, saturated_percent: most }) {
  const tiles = byId("tiles", HTMLElement);
  const metric = byId("metric", HTMLSelectElement);
  const place = byId("light-curve", HTMLDivElement);
  const warnings = byId("warnings", HTMLDetailsElement);
  // The tiles take the places that were kept for them.
  tiles.replaceChildren();
  const parts = SCORES.map((score) => {
    const [value, delta] = [make("span", { class: "value" }, "–"), make("span", { class: "delta" })];
    const before = make("span", { class: "unseen", hidden: true }, "out of date");
    const fill = draw("rect", { y: 0, height: 4 });
    const gauge = draw("svg", { class: "bar-of", viewBox: "0 0 100 4", preserveAspectRatio: "none", "aria-hidden": "true" }, draw("rect", { class: "track", width: 100, height: 4 }), fill, draw("rect", { class: "zero", x: 49.5, width: 1, height: 4 }));
    tiles.append(make("div", { class: "tile", "data-of": score.of, title: score.title }, make("dt", {}, score.label), make("dd", {}, make("span", { class: "amount" }, value, make("span", { class: "unit" }, score.unit)), gauge, delta, before)));
    return { score, value, delta, before, gauge, fill };
  });
  byId("definitions", HTMLElement).append(...SCORES.flatMap(({ label, title, better }) => [make("dt", {}, label), make("dd", {}, `${title}. ${better > 0 ? "Higher" : "Lower"} is better.`)]));
  byId("seed", HTMLElement).textContent = String(SEED);
  metric.append(...Object.entries(FIGURES).map(([value, { label }]) => make("option", { value }, label)));

  const svg = draw("svg", { role: "img" });
  place.append(svg);
  let [width, height] = [320, 150];
  /** @type {{ own: import("./engine.js").Expected[], pin: import("./engine.js").Expected[], luminance: number }} */
  let over = { own: [], pin: [], luminance: 10 };

  /** The greatest luminance without noticeable clipping of the design, `undefined` until it is known, and of the pinned one, cd/m². @type {{ own: number | undefined, pin: number }} */
  let clips = { own: undefined, pin: Infinity };
  const clipping = byId("clipping", HTMLElement);
  const [darkest, brightest] = [LUMINANCES[0], LUMINANCES[LUMINANCES.length - 1]];
  /** What is said of clipping. */
  function clippingText() {
    const { own } = clips;
    const what = `the design clips more than ${most} % of the samples of this scene`;
    const limit = own === undefined ? "." : own < darkest ? `: at every luminance shown (dotted), ${what}.`
      : own >= brightest ? `. Up to ${brightest} cd/m², the design clips at most ${most} % of the samples of this scene.`
        : `: beyond ${Number(own.toPrecision(3))} cd/m² (dotted), ${what}.`;
    return `Expected figures do not include clipping${limit}`;
  }

  /** What stands in place of curves. */
  let note = "";
  /** What is known to be of the state before a change. @type {Set<import("./work.js").Loop>} */
  const earlier = new Set();
  const isEarlier = (/** @type {import("./work.js").Loop} */ loop) => earlier.has(loop);
  /** The warnings that are shown. @type {string[]} */
  let warned = [];
  /** Whether all that could warn has been computed. */
  let isJudged = false;

  function showWarnings() {
    const [summary, list] = [/** @type {HTMLElement} */ (warnings.querySelector("summary")), /** @type {HTMLElement} */ (warnings.querySelector("ul"))];
    const count = warned.length > 1 ? `${warned.length} warnings: ${warned[0]}` : warned[0] ?? (isJudged ? "No warnings" : "");
    const text = earlier.size > 0 && count ? OUT_OF_DATE + count.replace(/^No/, "no") : count;
    if (summary.textContent === text && list.children.length === warned.length && warned.every((message, i) => list.children[i].textContent === message)) return;
    summary.textContent = text;
    list.replaceChildren(...warned.map((message) => make("li", {}, message)));
    warnings.toggleAttribute("data-some", warned.length > 0 || earlier.size > 0);
    if (warned.length === 0) warnings.open = false;
  }

  function showCurve() {
    const key = /** @type {Figure} */ (metric.value || "cpsnr_db");
    const all = [...over.own, ...over.pin].map((e) => e[key]).filter(Number.isFinite);
    if (all.length === 0) {
      svg.replaceChildren(draw("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, note));
      svg.setAttribute("aria-label", note);
      return;
    }
    const scale = textScale();
    const margin = { left: 36 * scale, right: 18 * scale, top: 10, bottom: 24 * scale };
    const [low, high] = nice(Math.min(...all), Math.max(...all));
    const [first, last] = [over.own[0].luminance_cd_m2, over.own[over.own.length - 1].luminance_cd_m2].map(Math.log10);
    const x = (/** @type {number} */ luminance) => margin.left + (Math.log10(luminance) - first) / (last - first) * (width - margin.left - margin.right);
    const y = (/** @type {number} */ v) => height - margin.bottom - (v - low) / (high - low) * (height - margin.top - margin.bottom);
    const path = (/** @type {[number, number][]} */ points) => points.map(([px, py], i) => `${i === 0 ? "M" : "L"}${px.toFixed(1)} ${py.toFixed(1)}`).join("");
    /** A curve, dotted where the design clips. @param {string} kind @param {import("./engine.js").Expected[]} curve @param {number} limit */
    const drawn = (kind, curve, limit) => {
      const points = curve.map((e) => /** @type {[number, number]} */ ([x(e.luminance_cd_m2), y(e[key])]));
      const [sound, clipped] = cut(points, x(limit));
      return [...(clipped.length > 1 ? [draw("path", { class: `${kind} clips`, d: path(clipped) })] : []), ...(sound.length > 1 ? [draw("path", { class: kind, d: path(sound) })] : [])];
    };
    const decades = Array.from({ length: Math.round(last - first) + 1 }, (_, i) => 10 ** (Math.round(first) + i));
    svg.replaceChildren(
      ...[low, (low + high) / 2, high].flatMap((v) => [
        draw("line", { class: "rule", x1: margin.left, x2: width - margin.right, y1: y(v), y2: y(v) }),
        draw("text", { class: "tick", x: margin.left - 6, y: y(v) + 4, "text-anchor": "end" }, text(v, (high - low) % 2 === 0 ? 0 : 1)),
      ]),
      ...decades.map((d) => draw("text", { class: "tick", x: x(d), y: height - 7, "text-anchor": "middle" }, String(Number(d.toPrecision(1))))),
      draw("line", { class: "here", x1: x(over.luminance), x2: x(over.luminance), y1: margin.top, y2: height - margin.bottom }),
      ...drawn("pinned", over.pin, clips.pin),
      ...drawn("own", over.own, clips.own ?? Infinity),
    );
    const ends = over.own.length > 0 ? `from ${text(over.own[0][key], 1)} at ${over.own[0].luminance_cd_m2} cd/m² to ${text(over.own[over.own.length - 1][key], 1)} at ${over.own[over.own.length - 1].luminance_cd_m2} cd/m²` : "";
    svg.setAttribute("aria-label", `Expected ${FIGURES[key].label} over luminance, ${ends}. ${clippingText()}`);
  }
  metric.addEventListener("change", showCurve);
  new ResizeObserver(() => {
    [width, height] = [Math.max(place.clientWidth, 160), Math.max(place.clientHeight, 90)];
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    showCurve();
  }).observe(place);

  return {
    isEarlier,
    /**
     * Shows the scores of a design and how they differ from those of the pinned one.
     * @param {Known} own @param {Known | undefined} pin @returns {string} The main scores in words.
     */
    show(own, pin) {
      /** @type {string[]} */
      const said = [];
      const isClipped = [own, pin].some((k) => (k?.picture?.saturated_percent ?? 0) > most);
      for (const { score, value, delta, gauge, fill } of parts) {
        const now = score.get(own);
        const before = pin && score.get(pin);
        const isKnown = typeof now === "number" && Number.isFinite(now);
        value.textContent = isKnown ? text(now, score.digits) : "–";
        const isCompared = isKnown && typeof before === "number" && Number.isFinite(before);
        const length = isCompared ? bar(score, before, now, relevances[score.metric]) : 0;
        const doubt = DOUBTS[score.metric] ?? 0;
        const difference = isCompared ? change(score, before, now, length, isClipped && doubt > 0 ? Infinity : doubt) : undefined;
        delta.replaceChildren(...(difference ? [make("span", { "aria-hidden": "true" }, difference.shown), make("span", { class: "unseen" }, difference.said)] : []));
        delta.dataset.kind = difference?.kind ?? "";
        fill.setAttribute("x", String(50 + Math.min(length, 0) * 50));
        fill.setAttribute("width", String(Math.abs(length) * 50));
        gauge.dataset.kind = difference?.kind ?? "same";
        if (isKnown && said.length < 3) said.push(`${score.label} ${text(now, score.digits)}${score.unit && ` ${score.unit}`}${difference && difference.kind !== "same" ? `, ${difference.said}` : ""}`);
      }
      return said.join("; ");
    },
    /** @param {import("./engine.js").Expected[]} own @param {import("./engine.js").Expected[]} pin @param {number} luminance */
    showOverLight(own, pin, luminance) {
      over = { own, pin, luminance };
      showCurve();
    },
    /** Shows up to which luminance the design and the pinned one do not clip the scene, cd/m². @param {number | undefined} own @param {number} pin */
    showClipping(own, pin) {
      clips = { own, pin };
      clipping.textContent = clippingText();
      showCurve();
    },
    /** Says why there are no curves. @param {string} text */
    waits(text) {
      note = text;
      showCurve();
    },
    /** Shows warnings, which are not announced: they change with every step of a drag. @param {import("./engine.js").Warning[]} all @param {boolean} areAll Whether no others can follow. */
    warn(all, areAll) {
      isJudged = areAll;
      warned = [...new Set(all.map((w) => sentence(w.message)))];
      showWarnings();
    },
    /** Marks what a loop computes as of the state before the last change, or no longer. @param {import("./work.js").Loop} loop @param {boolean} is */
    mark(loop, is) {
      if (earlier.has(loop) === is) return;
      if (is) earlier.add(loop);
      else earlier.delete(loop);
      document.documentElement.dataset.earlier = [...earlier].join(" ");
      for (const { score, before } of parts) before.hidden = !earlier.has(score.of);
      showWarnings();
    },
    /** The warnings in words. */
    warned: () => /** @type {HTMLElement} */ (warnings.querySelector("summary")).textContent ?? "",
  };
}

/**
 * A line in two: up to a place and beyond it, which share the point there.
 * @param {[number, number][]} points @param {number} at @returns {[[number, number][], [number, number][]]}
 */
function cut(points, at) {
  const after = points.findIndex(([x]) => x > at);
  if (after < 0) return [points, []];
  if (after === 0) return [[], points];
  const [[x0, y0], [x1, y1]] = [points[after - 1], points[after]];
  const middle = /** @type {[number, number]} */ ([at, y0 + (y1 - y0) * (at - x0) / (x1 - x0)]);
  return [[...points.slice(0, after), middle], [middle, ...points.slice(after)]];
}

/** Round numbers around a range. @param {number} low @param {number} high @returns {[number, number]} */
function nice(low, high) {
  const span = Math.max(high - low, 0.5);
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100].find((s) => span / s <= 6) ?? 200;
  return [Math.floor(low / step) * step, Math.max(Math.ceil(high / step) * step, Math.floor(low / step) * step + step)];
}
