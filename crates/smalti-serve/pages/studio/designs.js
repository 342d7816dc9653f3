// @ts-check
// Designs in the results of searches and studies. Their names are shown, so characters that would steer the text around them are replaced.
import { inOneLine } from "./dom.js";

/** @typedef {import("./engine.js").Design} Design */

/** A design that was opened, what is to be said of it, and the family of its filters. @typedef {{ design: Design, note: string, family?: string }} Opened */

/**
 * The best design in `results.json` of `smalti design`, on a camera: the results state its array alone. Its transmittances are in the order of the letters of its tile, from a on; camera files have capitals.
 * @param {any} results @param {Design} camera @returns {Opened | undefined}
 */
function ofSearch(results, camera) {
  const [best] = Array.isArray(results?.searched) ? results.searched : [];
  const nm = results?.wavelengths_nm;
  if (typeof best?.tile !== "string" || !Array.isArray(best.transmittances) || !Array.isArray(nm) || nm.length < 2) return undefined;
  const filter = (/** @type {number[]} */ values) => ({ samples: { start_nm: nm[0], step_nm: nm[1] - nm[0], values } });
  const letter = (/** @type {number} */ channel) => String.fromCharCode("A".charCodeAt(0) + channel);
  const filters = Object.fromEntries(best.transmittances.map((/** @type {number[]} */ values, /** @type {number} */ i) => [letter(i), filter(values)]));
  const cfa = { pattern: best.tile.toUpperCase().split("/"), filters };
  const name = inOneLine(String(results.name));
  const design = { ...camera, name, sensor: { ...camera.sensor, cfa } };
  return { design, note: `${name} is open with the sensor and the lens of this page. camera.toml in the same folder has its own.`, family: Object.keys(results.family ?? {})[0] };
}

/**
 * The design in the first row of the tables of `smalti report`, in its `report.json`.
 * @param {any} report @returns {Opened | undefined}
 */
function ofStudy(report) {
  const [study] = Array.isArray(report?.studies) ? report.studies : [];
  const [section] = Array.isArray(study?.sections) ? study.sections : [];
  const best = section?.colors?.find?.((/** @type {any} */ group) => group?.best?.length > 0)?.best[0];
  if (!best?.cfa || !section.description) return undefined;
  const name = inOneLine(`${study.name}, trial ${best.trial}`);
  const design = { ...section.description, name, sensor: { ...section.description.sensor, cfa: best.cfa } };
  return { design, note: `${name} is open, the best of the fewest colours under the first condition.` };
}

/** The design in results of `smalti design` or `smalti report`; `undefined` if they are of another kind. @param {any} results @param {Design} camera The camera of the page. */
export const designIn = (results, camera) => ofSearch(results, camera) ?? ofStudy(results);
