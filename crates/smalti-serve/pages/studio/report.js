// @ts-check
// The report that the page makes itself, with or without a server: what it shows, as one HTML file.
import { announce, byId, inOneLine, message, tell } from "./dom.js";
import { asRival, withAllFilters } from "./design.js";
import { SEED } from "./engine.js";
import { fetched } from "./fetched.js";
import { fileName, save } from "./files.js";
import { offered } from "./native.js";
import { reportPage } from "./report-page.js";
import { isClipped } from "./scores.js";
import { fragmentOf } from "./share.js";

/** @typedef {import("./design.js").Camera} Camera */
/** @typedef {import("./engine.js").Picture} Picture */
/** @typedef {import("./scores.js").Known} Known */
/**
 * What the page shows. Designs have the names with which they are saved; `simulated` makes of one what the engine simulates of it.
 * @typedef {{
 *   camera: Camera, pinned: Camera | undefined, simulated: (camera: Camera) => Camera, own: Known, pin: Known, layers: { own?: HTMLCanvasElement, pin?: HTMLCanvasElement, reference?: HTMLCanvasElement },
 *   scores: { rows: import("./scores.js").Row[], warnings: string[], over: import("./light-plot.js").OverLight, clips: import("./light-plot.js").Clips },
 *   scene: string, sceneInCommands: string | undefined, photograph: string | undefined, sceneFile: string, luminance: number, limits: string, shared: import("./share.js").Shared, toml: (camera: Camera) => Promise<string>,
 * }} Shown
 */

const STYLES = ["tokens.css", "drawings.css", "report.css"];

/** @param {HTMLCanvasElement} canvas @returns {import("./report-page.js").Image} */
const imageOf = (canvas) => ({ source: canvas.toDataURL("image/png"), width: canvas.width, height: canvas.height });

/**
 * Sets up the item of the menu that saves the report.
 * @param {import("./engine.js").Engine} engine
 * @param {() => boolean | Promise<boolean>} settled Whether picture and figures of the latest change are there, once they are or cannot be.
 * @param {() => Shown} shown
 */
export function setUpReport(engine, settled, shown) {
  const item = byId("save-report", HTMLButtonElement);
  // They are read at once: a server that ends later does not deliver them.
  const styles = Promise.all(STYLES.map(async (name) => (await fetched(name)).text()));
  styles.catch(() => {});

  async function make() {
    const isThere = settled();
    if (typeof isThere !== "boolean") tell("The report is saved once the picture and its scores are there.");
    if (!(await isThere)) throw new Error("The report needs the picture and the figures of the design, which cannot be computed");
    const now = shown();
    const { own, pin, layers, scores } = now;
    if (!own.picture || !layers.own || !layers.reference) throw new Error("The report needs a picture");
    const [image, reference] = [imageOf(layers.own), imageOf(layers.reference)];
    const rival = now.pinned && pin.picture && layers.pin ? { camera: asRival(now.pinned, now.camera.name), image: imageOf(layers.pin), exposureMs: pin.picture.exposure_ms } : undefined;
    const names = [now.camera, ...(rival ? [rival.camera] : [])].map(({ name }) => fileName(name, "toml"));
    if (names[1] === names[0]) names[1] = `pinned-${names[1]}`;
    const side = async (/** @type {Camera} */ camera, /** @type {import("./report-page.js").Image} */ picture, /** @type {number} */ exposureMs, /** @type {string} */ file) => (
      { camera, picture, exposureMs, file, curves: await engine.curves(withAllFilters(now.simulated(camera))), toml: await now.toml(camera) });
    const offer = await offered();
    const page = reportPage({
      own: await side(now.camera, image, own.picture.exposure_ms, names[0]),
      pin: rival && await side(rival.camera, rival.image, rival.exposureMs, names[1]),
      reference, ...scores, isClipped: isClipped([own, rival && pin], engine.catalogue.saturated_percent), scene: inOneLine(now.scene), sceneInCommands: now.sceneInCommands, photograph: now.photograph, luminance: now.luminance, seed: SEED, limits: now.limits,
      version: offer?.version ?? "of an unknown version", date: new Date().toLocaleDateString("en-GB", { day: "numeric", month: "long", year: "numeric" }),
      // The address of a server of the command has its token, and answers to one machine.
      fragment: await fragmentOf(now.shared), studio: offer?.native ? undefined : location.href.split("#")[0],
      brand: /** @type {Element} */ (document.querySelector(".brand svg")).cloneNode(true), style: (await styles).join(""),
    });
    const name = fileName(`${now.camera.name} ${now.sceneFile} ${now.luminance} report`, "html");
    save(name, new Blob([page], { type: "text/html" }));
    announce(`The report ${name} was saved.`);
  }
  item.addEventListener("click", () => make().catch((error) => tell(`${message(error)}.`, "trouble")));
}
