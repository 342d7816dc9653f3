// @ts-check
// Files that are opened and saved.
import { designIn } from "./designs.js";

/** Saves a file as the browser saves downloads. @param {string} name @param {Blob} content */
export function save(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name for files: letters without accents and digits, of any script. @param {string} name @param {string} extension */
export function fileName(name, extension) {
  const plain = name.normalize("NFKD").replace(/[\u0300-\u036f]/g, "").normalize("NFC").replace(/[^\p{L}\p{M}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "").toLowerCase();
  return `${plain || "camera"}.${extension}`;
}

/** The curves of a design as a table. @param {import("./engine.js").Curves} curves @returns {string} */
export function curvesCsv(curves) {
  const columns = [
    ["wavelength_nm", curves.wavelengths_nm],
    ...curves.channels.map((c) => [`transmittance_${c.letter}`, c.transmittance]),
    ...curves.channels.map((c) => [`quantum_efficiency_${c.letter}`, c.quantum_efficiency]),
    ["lens_transmittance", curves.lens_transmittance], ["light_relative", curves.light],
  ].map(([name, values]) => ({ name: String(name), values: /** @type {number[]} */ (values) }));
  const rows = curves.wavelengths_nm.map((_, i) => columns.map((c) => Number(c.values[i].toPrecision(9))).join(","));
  return `${[columns.map((c) => c.name).join(","), ...rows].join("\n")}\n`;
}

/** The largest results that are read, bytes. */
const MOST_RESULTS = 64_000_000;

/**
 * The cameras in `results.json` of `smalti compare`; or the design in that of `smalti design` or in `report.json` of `smalti report`, with what is to be said of it.
 * @param {File} file @param {import("./engine.js").Design} shown The camera of the page.
 * @returns {Promise<{ cameras: import("./engine.js").Design[], note?: string, family?: string }>}
 */
export async function camerasOfResults(file, shown) {
  if (file.size > MOST_RESULTS) throw new Error("it is larger than any results that the page opens");
  /** @type {any} */
  let results;
  try {
    results = JSON.parse(await file.text());
  } catch {
    throw new Error("it is no JSON");
  }
  const found = designIn(results, shown);
  if (found) return { ...found, cameras: [found.design] };
  const cameras = results?.cameras;
  if (!Array.isArray(cameras) || cameras.length === 0) throw new Error("it holds no camera. Open results.json of `smalti compare` or `smalti design`, or report.json of `smalti report`");
  return { cameras };
}

/** The step of a curve from a file, nm. */
const STEP_NM = 5;

/**
 * The filter of a table of wavelengths in nm and one curve, interpolated linearly; it is zero beyond the table.
 * @param {string} text @returns {{ filter: import("./design.js").Filter, isPercent: boolean }}
 */
export function filterOfCsv(text) {
  const rows = text.split(/\r?\n/).map((line) => line.trim()).filter((line) => line !== "" && !line.startsWith("#"))
    .map((line) => line.split(/[,;\t]\s*|\s+/).map(Number));
  // The first line may name the columns.
  const table = rows.filter((row, i) => i > 0 || row.every(Number.isFinite)).sort((a, b) => a[0] - b[0]);
  if (table.length < 2 || table.some((row) => row.length !== 2 || !row.every(Number.isFinite))) {
    throw new Error("expected two columns, wavelengths in nm and transmittance, with a point in decimals");
  }
  const twice = table.find((row, i) => i > 0 && row[0] === table[i - 1][0]);
  if (twice) throw new Error(`the wavelength ${twice[0]} nm is given twice`);
  const largest = Math.max(...table.map((row) => row[1]));
  const isPercent = largest > 1.5;
  if (table.some((row) => row[1] < 0) || largest > (isPercent ? 100 : 1)) throw new Error("expected transmittance from 0 to 1, or from 0 to 100 %");
  const start = Math.ceil(table[0][0] / STEP_NM) * STEP_NM;
  const count = Math.floor((table[table.length - 1][0] - start) / STEP_NM) + 1;
  if (start < 200 || count < 2 || count > 400) throw new Error("expected wavelengths in nm, such as 400 to 700");
  let at = 0;
  const values = Array.from({ length: count }, (_, i) => {
    const nm = start + i * STEP_NM;
    while (at + 2 < table.length && table[at + 1][0] < nm) at += 1;
    const [[x0, y0], [x1, y1]] = [table[at], table[at + 1]];
    return Number(((y0 + (y1 - y0) * (nm - x0) / (x1 - x0)) / (isPercent ? 100 : 1)).toPrecision(6));
  });
  return { filter: { samples: { start_nm: start, step_nm: STEP_NM, values } }, isPercent };
}
