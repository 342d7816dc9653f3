// @ts-check
// The scores: each with what the change from the pinned design did, also as a bar, and expected figures over light.
import { byId, draw, make, textScale } from "./dom.js";
import { SEED } from "./engine.js";
import { FIGURES, clippingText, hasCurve, lightPlot } from "./light-plot.js";
import { signed, text } from "./numbers.js";

/** @typedef {import("./engine.js").Picture} Picture */
/** @typedef {import("./engine.js").Scores} Scores */
/** What is known of a design: its picture, at a luminance in cd/m², and its figures. @typedef {{ picture?: Picture, luminance?: number, figures?: Scores }} Known */

/**
 * A score: where it is, how it is written, which direction is better, its name in the catalogue of metrics, and whether it is one of the picture or of the figures of the array.
 * @typedef {{ label: string, metric: string, unit: string, title: string, better: 1 | -1, digits: number, of: import("./work.js").Loop, get: (known: Known) => number | null | undefined }} Score
 */
/** How a score differs from that of the pinned design: as it is shown and said, and the doubt of the page, as text, if the change is within it. @typedef {{ shown: string, said: string, kind: "same" | "better" | "worse", doubt?: string }} Change */
/** A score as it is shown: in numbers, with that of the pinned design, what changed, the doubt of that as text if there is one, and the length of its bar. @typedef {{ score: Score, value: string | undefined, before: string | undefined, change: Change | undefined, doubt: string | undefined, length: number }} Row */
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
 * The doubt of each score: 95 % of the changes on this page differ by no more from those of pipelines learned from all training scenes. The changes are those between ten designs at 1, 10 and
 * 80 cd/m² (docs/how-to/studio.md). It is absolute, in dim light where that is larger, or relative to the larger of two values. Smaller changes count as neither better nor worse. Changes of
 * scores `ofScene` are not judged where a picture clips: the 95th percentile of ΔE2000 then differs by up to four times as much. The other scores are those of targets.
 * @type {Record<string, { absolute: number, dim?: number, ofScene: boolean } | { relative: number, ofScene: boolean }>}
 */
const DOUBTS = {
  cpsnr_db: { absolute: 0.9, ofScene: true }, pixel_delta_e_2000_mean: { absolute: 0.6, ofScene: true }, pixel_delta_e_2000_p95: { absolute: 1.3, ofScene: true },
  scielab_mean: { absolute: 1.8, ofScene: true },
  mtf50_low_contrast_cy_per_px: { absolute: 0.03, dim: 0.1, ofScene: false }, luminance_noise_percent: { relative: 0.35, ofScene: false },
};
/** The luminance below which light is dim, cd/m². */
const DIM = 10;
/** What stands before everything that is of the state before a change that could not be computed. */
export const OUT_OF_DATE = "Out of date: ";
/** Bars end at this many of the smallest relevant differences. */
const BAR_END = 10;

/** @param {number | undefined} value @param {number} by */
const scaled = (value, by) => (value === undefined ? undefined : value * by);

/** The doubt of a change of a score, in its unit; 0 for a score without one. @param {Score} score @param {number} from @param {number} to @param {number} luminance cd/m² */
function doubtOf({ metric }, from, to, luminance) {
  const doubt = DOUBTS[metric];
  if (!doubt) return 0;
  return "relative" in doubt ? doubt.relative * Math.max(from, to) : luminance < DIM ? doubt.dim ?? doubt.absolute : doubt.absolute;
}

/** A doubt as it is shown, with the digits that it has or those of its score. @param {Score} score @param {number} doubt */
const doubtShown = ({ metric, digits }, doubt) => ("relative" in DOUBTS[metric] ? text(doubt, digits) : String(doubt));

/** The doubts in words. */
export function doubtsText() {
  const all = SCORES.filter(({ metric }) => metric in DOUBTS).map(({ label, unit, metric }) => {
    const doubt = DOUBTS[metric];
    if ("relative" in doubt) return `${doubt.relative * 100} % of the larger value (${label})`;
    return `${doubt.absolute}${unit && ` ${unit}`} (${label}${doubt.dim ? `; ${doubt.dim} below ${DIM} cd/m²` : ""})`;
  });
  return `${all.slice(0, -1).join(", ")} and ${all.slice(-1)}`;
}

/**
 * Words for a change of a score, of which the bar is that of `bar`. A change below the smallest relevant one, or within the doubt of the page, is neither better nor worse.
 * @param {Score} score @param {number} from @param {number} to @param {number} length @param {number} doubt @returns {Change}
 */
function change(score, from, to, length, doubt) {
  const by = Number((to - from).toFixed(score.digits));
  if (by === 0) return { shown: "±0", said: "as pinned", kind: "same" };
  const amount = text(Math.abs(by), score.digits);
  const shown = signed(by, score.digits);
  const directed = `${amount} ${by > 0 ? "more" : "less"} than pinned`;
  if (Math.abs(length) * BAR_END < 1) return { shown, said: `${directed}, which is not relevant`, kind: "same" };
  if (doubt === Infinity) return { shown: `${shown}, clipped`, said: `${directed}, not judged where the picture clips`, kind: "same" };
  if (Math.abs(by) < doubt) return { shown, said: `${directed}, within the doubt of this page, ${doubtShown(score, doubt)}`, kind: "same", doubt: doubtShown(score, doubt) };
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

/** Whether more than `most` percent of the samples of a picture saturate, so that the page does not judge changes of its scores. @param {(Known | undefined)[]} all @param {number} most */
export const isClipped = (all, most) => all.some((k) => (k?.picture?.saturated_percent ?? 0) > most);

/**
 * The scores of a design, and how they differ from those of the pinned one.
 * @param {Known} own @param {Known | undefined} pin @param {import("./engine.js").Engine["catalogue"]} catalogue @returns {Row[]}
 */
function rowsOf(own, pin, { relevances, saturated_percent: most }) {
  const isSceneClipped = isClipped([own, pin], most);
  return SCORES.map((score) => {
    const [now, before] = [own, pin].map((known) => known && score.get(known)).map((v) => (typeof v === "number" && Number.isFinite(v) ? v : undefined));
    const isCompared = now !== undefined && before !== undefined;
    const length = isCompared ? bar(score, before, now, relevances[score.metric]) : 0;
    const doubt = isCompared ? doubtOf(score, before, now, own.luminance ?? DIM) : 0;
    const clips = isSceneClipped && Boolean(DOUBTS[score.metric]?.ofScene);
    return {
      score, length, doubt: doubt > 0 && !clips ? doubtShown(score, doubt) : undefined, value: now === undefined ? undefined : text(now, score.digits), before: before === undefined ? undefined : text(before, score.digits),
      change: isCompared ? change(score, before, now, length, clips ? Infinity : doubt) : undefined,
    };
  });
}

/** What a score means. @param {Score} score */
export const definition = ({ title, better }) => `${title}. ${better > 0 ? "Higher" : "Lower"} is better.`;

/** A message as a sentence. @param {string} message */
const sentence = (message) => `${message[0].toUpperCase()}${message.slice(1).replace(/\.$/, "")}.`;

/** @param {import("./engine.js").Engine["catalogue"]} catalogue */
export function setUpScores(catalogue) {
  const most = catalogue.saturated_percent;
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
  byId("definitions", HTMLElement).append(...SCORES.flatMap((score) => [make("dt", {}, score.label), make("dd", {}, definition(score))]));
  byId("seed", HTMLElement).textContent = String(SEED);
  metric.append(...Object.entries(FIGURES).map(([value, label]) => make("option", { value }, label)));

  const svg = draw("svg", { role: "img" });
  place.append(svg);
  let [width, height] = [320, 150];
  /** @type {import("./light-plot.js").OverLight} */
  let over = { own: [], pin: [], luminance: 10 };
  /** @type {import("./light-plot.js").Clips} */
  let clips = { own: undefined, pin: Infinity, most };
  const clipping = byId("clipping", HTMLElement);

  /** The scores that are shown. @type {Row[]} */
  let rows = [];
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
    const key = /** @type {import("./light-plot.js").Figure} */ (metric.value || "cpsnr_db");
    const { drawn, label } = hasCurve(over, key) ? lightPlot({ width, height, scale: textScale() }, over, clips, key)
      : { drawn: [draw("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, note)], label: note };
    svg.replaceChildren(...drawn);
    svg.setAttribute("aria-label", label);
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
      rows = rowsOf(own, pin, catalogue);
      for (const [i, { value, delta, gauge, fill }] of parts.entries()) {
        const { score, value: now, change: difference, length } = rows[i];
        value.textContent = now ?? "–";
        delta.replaceChildren(...(difference ? [make("span", { "aria-hidden": "true" }, difference.shown, difference.doubt !== undefined && ` ± ${difference.doubt}`), make("span", { class: "unseen" }, difference.said)] : []));
        delta.dataset.kind = difference?.kind ?? "";
        fill.setAttribute("x", String(50 + Math.min(length, 0) * 50));
        fill.setAttribute("width", String(Math.abs(length) * 50));
        gauge.dataset.kind = difference?.kind ?? "same";
        if (now !== undefined && said.length < 3) said.push(`${score.label} ${now}${score.unit && ` ${score.unit}`}${difference && difference.kind !== "same" ? `, ${difference.said}` : ""}`);
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
      clips = { own, pin, most };
      clipping.textContent = clippingText(clips);
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
    /** What is shown: scores, warnings, and expected figures over luminance. */
    shown: () => ({ rows, warnings: warned, over, clips }),
    /** The warnings in words. */
    warned: () => /** @type {HTMLElement} */ (warnings.querySelector("summary")).textContent ?? "",
  };
}
