// @ts-check
// The sweep: how a design scores over light on all scenes of a set, and what deviations of its filters change. The server computes it.
import { byId, make } from "./dom.js";
import { fileName, save } from "./files.js";
import { familyOf } from "./improve.js";
import { contentOf, outdated } from "./native.js";
import { signed, text } from "./numbers.js";

/** A number with its 95 % interval over scenes. @typedef {{ value: number, interval: { low: number, high: number } | null }} Estimate */
/**
 * Scores of a design at a luminance: means over scenes, and how much larger they are than as designed.
 * @typedef {{ name: string, luminance_cd_m2: number, means: Estimate[], changes: Estimate[] | null }} Row
 */

/** The columns of the table, in the order of the figures. */
const COLUMNS = [{ label: "CPSNR dB", digits: 2 }, { label: "ΔE2000", digits: 2 }, { label: "S-CIELAB", digits: 2 }];
const LIGHTS = { range: [1, 10, 100], wide: [0.1, 1, 10, 100, 1000] };

/** @param {Row[]} rows @returns {HTMLTableElement} */
function table(rows) {
  const head = make("tr", {}, make("th", { scope: "col" }, "Filters"), ...COLUMNS.map(({ label }) => make("th", { scope: "col" }, label)));
  const cell = (/** @type {Row} */ row, /** @type {number} */ i) => {
    const { digits } = COLUMNS[i];
    const [{ value, interval }, shown] = row.changes ? [row.changes[i], signed] : [row.means[i], text];
    const range = interval && `${shown(interval.low, digits)} to ${shown(interval.high, digits)}`;
    return make("td", {}, shown(value, digits), range ? make("small", {}, range) : undefined);
  };
  const body = [...new Set(rows.map((row) => row.luminance_cd_m2))].map((luminance) => make("tbody", {},
    make("tr", {}, make("th", { scope: "rowgroup", colspan: COLUMNS.length + 1 }, `${luminance} cd/m²`)),
    ...rows.filter((row) => row.luminance_cd_m2 === luminance).map((row) =>
      make("tr", {}, make("th", { scope: "row" }, row.name), ...COLUMNS.map((_, i) => cell(row, i)))),
  ));
  return make("table", {}, make("thead", {}, head), ...body);
}

/**
 * Sets up the sweep in the panel of full computations.
 * @param {ReturnType<typeof import("./native.js").setUpNative>} connecting
 * @param {() => { camera: import("./design.js").Camera, luminance: number }} shown
 */
export async function setUpSweep(connecting, shown) {
  const native = await connecting;
  if (!native) return;
  const set = make("select", {},
    make("option", { value: "natural" }, "all natural scenes"), make("option", { value: "charts" }, "all charts"), make("option", { value: "all" }, "natural scenes and charts"));
  const light = make("select", {},
    make("option", { value: "range" }, "1, 10 and 100 cd/m²"), make("option", { value: "wide" }, "0.1 to 1000 cd/m²"), make("option", { value: "here" }, "this light"));
  const found = make("figure", { hidden: true });
  const ofSweep = () => contentOf(shown().camera);
  const age = outdated("the design has changed since this sweep.", ofSweep, native.onChange);
  async function sweep() {
    const { camera, luminance } = shown();
    const made = ofSweep();
    const luminances_cd_m2 = light.value === "here" ? [luminance] : LIGHTS[/** @type {keyof typeof LIGHTS} */ (light.value)];
    const where = set.selectedOptions[0].text;
    const result = await native?.work("The sweep", { sweep: { design: camera, set: set.value, luminances_cd_m2, family: familyOf() } });
    if (!result) return;
    const keep = make("button", { type: "button", click: () => save(fileName(`${camera.name} sweep`, "csv"), result.files.csv) }, "Save CSV");
    found.replaceChildren(
      make("figcaption", {}, `${camera.name} on ${where} (${result.said.scenes}): means as designed, and changes when all filters deviate, each with its 95 % interval over scenes. That of a mean states how much scenes differ; that of a change is paired. The pipeline is that of the filters as designed.`),
      table(result.said.rows), make("div", { class: "row" }, keep),
    );
    found.hidden = false;
    age.stamp(made);
    found.scrollIntoView({ block: "nearest" });
  }
  byId("native-panel", HTMLElement).append(make("div", { class: "sweep" },
    make("div", { class: "fields" },
      make("label", { class: "field wide" }, make("span", {}, "Sweep on"), set), make("label", { class: "field wide" }, make("span", {}, "Luminance"), light)),
    make("div", { class: "row" }, make("button", { type: "button", "data-job": "", click: sweep }, "Light and tolerances")),
    age.line, found,
  ));
}
