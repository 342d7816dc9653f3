// @ts-check
// What a file is that is opened, by its first bytes and its name; and what is said of one that the page does not open.
import { inOneLine } from "./dom.js";

/** @typedef {{ refused: string }} Refused Why a file is not opened, to follow its name. */
/** @typedef {"photograph" | "results" | "curve" | "camera" | Refused} Kind */

/** The first bytes that are looked at. */
const HEAD = 512;
/** The largest camera file or table of a filter, bytes. */
const MOST_TEXT = 4_000_000;
/** The most characters of a file, or of its name, that are shown at once. */
const MOST_SHOWN = 80;

const OPENS = "The page opens camera.toml, results.json, report.json, curves as CSV, PNG and JPEG.";
const SPECTRAL = "may be a spectral image. Smalti opens it as a scene: `smalti simulate camera.toml --scene FILE`.";
const RAW = "is a TIFF file or a raw image (DNG). The page opens PNG and JPEG; `smalti render` processes a raw image with a learned table.";
const PICTURE = "is a picture or film that the page does not read. Convert it to PNG or JPEG.";
/** Files that begin with some bytes, as Latin 1, from a place on. @type {[at: number, bytes: string, kind: Kind][]} */
const SIGNATURES = [
  [0, "\x89PNG", "photograph"],
  [0, "\xff\xd8\xff", "photograph"],
  [8, '{"__metadata__"', { refused: "is a learned table (.l3), which has a pipeline and no design. Use it with `smalti render raw.dng --pipeline FILE`." }],
  [0, "II*\0", { refused: RAW }],
  [0, "MM\0*", { refused: RAW }],
  [0, "GIF8", { refused: PICTURE }],
  [0, "BM", { refused: PICTURE }],
  [8, "WEBP", { refused: PICTURE }],
  [4, "ftyp", { refused: PICTURE }],
  [0, "\x76\x2f\x31\x01", { refused: `is an OpenEXR image, which ${SPECTRAL}` }],
  [0, "\x89HDF", { refused: `is an HDF5 file, which ${SPECTRAL}` }],
  [0, "MATLAB 5.0", { refused: `is a MATLAB file, which ${SPECTRAL}` }],
  [0, "\x93NUMPY", { refused: `is a NumPy array, which ${SPECTRAL}` }],
  [0, "PAR1", { refused: "is a table of a sweep (Parquet). `smalti report STUDY` writes report.json beside it, which the page opens." }],
  [0, "PK\x03\x04", { refused: "is an archive (ZIP or .npz). Unpack it, and open a file in it." }],
  [0, "%PDF", { refused: `is a PDF document. ${OPENS}` }],
];
const UNKNOWN = `is a file of an unknown kind. ${OPENS}`;

/** What a file is. Its first bytes count more than its name. @param {File} file @returns {Promise<Kind>} */
export async function kindOf(file) {
  const bytes = new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  const head = String.fromCharCode(...bytes);
  const signed = SIGNATURES.find(([at, start]) => head.startsWith(start, at));
  // Two bytes are the beginning of many texts.
  if (signed && (signed[1].length > 2 || head.includes("\0"))) return signed[2];
  if (/\.(png|jpe?g)$/i.test(file.name) || /^image\//.test(file.type)) return "photograph";
  if (/[\0-\x08\x0e-\x1f]/.test(head)) return { refused: UNKNOWN };
  if (/\.json$/i.test(file.name) || /^\s*\{/.test(head)) return "results";
  if (file.size > MOST_TEXT) return { refused: "is larger than a camera file or a table of a filter." };
  if (head.startsWith("wavelength_nm,transmittance_")) return { refused: "has all curves of a design, as this page saves them. The page opens camera.toml, and the curve of one filter: two columns, wavelength and transmittance." };
  if (/\.(csv|txt|tsv)$/i.test(file.name)) return "curve";
  if (/^\s*</.test(head)) return { refused: `is a page or another file in HTML or XML. ${OPENS}` };
  return "camera";
}

/** A text of a file in one line, at most as long as is shown. @param {string} text */
export function shortened(text) {
  const shown = [...inOneLine(text)];
  return shown.length > MOST_SHOWN ? `${shown.slice(0, MOST_SHOWN - 1).join("")}…` : shown.join("");
}

/** The most characters of a message of the engine. */
const MOST_MESSAGE = 300;

/**
 * A message of the engine about a file, in one line: it states the place, what is wrong, the line of the file, which is shortened, and what to do. The marks below
 * the line need a typeface of one width, which messages do not have.
 * @param {string} message
 */
export function excerpt(message) {
  const [first, ...lines] = message.split("\n");
  const said = first.replace(/^camera\.toml:(\d+):(\d+): /, "line $1, column $2: ");
  const shown = lines.filter((line) => !/^ +\| +\^+$/.test(line)).map((line) => {
    const source = /^ \d+ \| (.*)$/.exec(line);
    return source ? `The line is “${shortened(source[1].trim())}”.` : inOneLine(line.trim());
  });
  const all = [shown.length > 0 ? `${said.replace(/[.]$/, "")}.` : said, ...shown].join(" ").replace(/\S{81,}/g, shortened);
  return all.length > MOST_MESSAGE ? `${all.slice(0, MOST_MESSAGE - 1)}…` : all;
}
