// @ts-check
// The camera that is designed: a camera file as an object, and changes of its mosaic and filters. A change makes a new object.

/**
 * A filter as in a camera file: one key, the name of its shape.
 * @typedef {any} Filter
 */
/**
 * A camera with the keys of a camera file. The page reads those named here and keeps all others.
 * @typedef {{
 *   name: string,
 *   optics: { f_number: number, ir_cut?: Filter, [key: string]: any },
 *   sensor: {
 *     quantum_efficiency: Filter,
 *     pixel: { pitch_um: number, full_well_e: number, conversion_gain_uv_per_e: number, read_noise_mv: number, read_noise_e?: number, [key: string]: any },
 *     cfa: { pattern: string[], filters: Record<string, Filter>, mixtures?: Record<string, any> },
 *     [key: string]: any,
 *   },
 *   exposure: { time_ms?: number, auto?: string, [key: string]: any },
 *   [key: string]: any,
 * }} Camera
 */
/** @typedef {"none" | "columns" | "rows" | "both" | "turn" | "diagonal"} Symmetry */

/** The largest side of a tile. */
export const MAX_SIDE = 16;
/** Letters for new filters: first those of usual colours. */
const LETTERS = [..."RGBWCMYEOIKXVTPNQSUADFHJLZ"];

/** @param {Camera} camera @returns {[rows: number, cols: number]} */
export function size(camera) {
  const { pattern } = camera.sensor.cfa;
  return [pattern.length, pattern[0].length];
}

/** The letters of all filters in their order. @param {Camera} camera */
export function letters(camera) {
  return Object.keys(camera.sensor.cfa.filters);
}

/** The letter of a cell. @param {Camera} camera @param {number} row @param {number} col */
export function letterAt(camera, row, col) {
  return camera.sensor.cfa.pattern[row][col];
}

/** How many cells a letter has, and how many there are. @param {Camera} camera @param {string} letter @returns {[number, number]} */
export function share(camera, letter) {
  const cells = camera.sensor.cfa.pattern.join("");
  return [[...cells].filter((c) => c === letter).length, cells.length];
}

/** @param {Camera} camera @param {Partial<Camera["sensor"]["cfa"]>} cfa @returns {Camera} */
function withCfa(camera, cfa) {
  return { ...camera, sensor: { ...camera.sensor, cfa: { ...camera.sensor.cfa, ...cfa } } };
}

/** The cells that a symmetry makes equal to one. @param {number} rows @param {number} cols @param {number} row @param {number} col @param {Symmetry} symmetry @returns {[number, number][]} */
export function images(rows, cols, row, col, symmetry) {
  const [down, right] = [rows - 1 - row, cols - 1 - col];
  switch (symmetry) {
    case "columns": return [[row, col], [row, right]];
    case "rows": return [[row, col], [down, col]];
    case "both": return [[row, col], [row, right], [down, col], [down, right]];
    case "turn": return [[row, col], [down, right]];
    case "diagonal": return rows === cols ? [[row, col], [col, row]] : [[row, col]];
    default: return [[row, col]];
  }
}

/** @param {Camera} camera @param {[number, number][]} cells @param {string} letter @returns {Camera} */
export function paint(camera, cells, letter) {
  const grid = camera.sensor.cfa.pattern.map((line) => [...line]);
  for (const [row, col] of cells) grid[row][col] = letter;
  return withCfa(camera, { pattern: grid.map((line) => line.join("")) });
}

/** Another size: a larger tile repeats the cells that are there. @param {Camera} camera @param {number} rows @param {number} cols @returns {Camera} */
export function resize(camera, rows, cols) {
  const { pattern } = camera.sensor.cfa;
  const [fromRows, fromCols] = size(camera);
  const line = (/** @type {number} */ row) => Array.from({ length: cols }, (_, col) => pattern[row % fromRows][col % fromCols]).join("");
  return withCfa(camera, { pattern: Array.from({ length: rows }, (_, row) => line(row)) });
}

/** @param {Camera} camera @param {string} letter @param {Filter} filter @returns {Camera} */
export function withFilter(camera, letter, filter) {
  return withCfa(camera, { filters: { ...camera.sensor.cfa.filters, [letter]: filter } });
}

/** A camera whose tile has every filter, for their curves: also of those without a cell in the mosaic. @param {Camera} camera @returns {Camera} */
export function withAllFilters(camera) {
  return withCfa(camera, { pattern: [[...new Set([...camera.sensor.cfa.pattern.join(""), ...letters(camera)])].join("")] });
}

/** A camera with one more filter, and its letter; `undefined` without a letter left. @param {Camera} camera @param {Filter} filter @returns {[Camera, string] | undefined} */
export function addFilter(camera, filter) {
  const used = letters(camera);
  const letter = LETTERS.find((l) => !used.includes(l));
  return letter === undefined ? undefined : [withFilter(camera, letter, filter), letter];
}

/** Without a filter; its cells get another letter. @param {Camera} camera @param {string} letter @param {string} instead @returns {Camera} */
export function removeFilter(camera, letter, instead) {
  const filters = Object.fromEntries(Object.entries(camera.sensor.cfa.filters).filter(([l]) => l !== letter));
  return withCfa(camera, { filters, pattern: camera.sensor.cfa.pattern.map((line) => line.replaceAll(letter, instead)) });
}

/** The pinned design. If it has the same name as the design, "(pinned)" is added, since reports number designs of one name. @template {{ name: string }} T @param {T} pinned @param {string} name That of the design. @returns {T} */
export const asRival = (pinned, name) => (pinned.name === name ? { ...pinned, name: `${pinned.name} (pinned)` } : pinned);

/** Another value at a path of keys; `undefined` removes the key. @template T @param {T} object @param {string[]} path @param {any} value @returns {T} */
export function withValue(object, [key, ...rest], value) {
  const copy = /** @type {any} */ ({ ...object });
  const next = rest.length > 0 ? withValue(copy[key] ?? {}, rest, value) : value;
  if (next === undefined) delete copy[key];
  else copy[key] = next;
  return copy;
}
