// @ts-check
// What the page opens: the design of the address or of the server, camera files, results of commands, curves and photographs, chosen or dropped on the page.
import { byId, message, tell } from "./dom.js";
import { inFull, originOf } from "./exchange.js";
import { fetched } from "./fetched.js";
import { camerasOfResults } from "./files.js";
import { excerpt, kindOf, shortened } from "./kinds.js";
import { offered } from "./native.js";
import { sharedIn } from "./share.js";

/** @typedef {import("./design.js").Camera} Camera */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Design} Design */
/** A design that is opened with the one that it is compared with, and the conditions of an address. @typedef {{ origin: import("./exchange.js").Origin, pinned?: Camera, shared?: import("./share.js").Shared }} Opened */

/** The design in the address, if there is one; it is read as strictly as a file. @param {Engine} engine @returns {Promise<Opened | undefined>} */
async function inAddress(engine) {
  const shared = await sharedIn(location.hash);
  if (!shared) return undefined;
  const checked = async (/** @type {Camera} */ camera) => engine.parse(await engine.cameraToml(camera));
  return { shared, origin: await originOf(engine, await checked(shared.camera)), pinned: shared.pinned && await inFull(engine, await checked(shared.pinned)) };
}

/** @param {unknown} error */
const tellAddress = (error) => tell(`The design in the address cannot be opened: ${excerpt(message(error))}.`, "trouble");

/** The design with which the page opens: that of the address, else that of the server. @param {Engine} engine @returns {Promise<Opened>} */
export async function opened(engine) {
  try {
    const found = await inAddress(engine);
    if (found) return found;
  } catch (error) {
    tellAddress(error);
  }
  const file = async (/** @type {string} */ name) => engine.parse(await (await fetched(name)).text());
  const pinned = (await offered())?.pinned;
  return { origin: await originOf(engine, await file("start.toml")), pinned: pinned ? await inFull(engine, await file(pinned)) : undefined };
}

/**
 * Sets up what opens further designs. `showConditions` shows scene, luminance and view of an address and says what is missing, `judgeBy` judges filters as those of a family.
 * @param {import("./store.js").Store} store @param {Engine} engine
 * @param {{
 *   takeCurve: (name: string, text: string) => void, takePhotograph: (file: File) => Promise<void>, judgeBy: (family: string | null | undefined) => void,
 *   showConditions: (shared: import("./share.js").Shared) => string,
 * }} page
 * @returns {{ openPreset: (camera: Design) => Promise<void> }}
 */
export function setUpOpening(store, engine, { takeCurve, takePhotograph, judgeBy, showConditions }) {
  let openings = 0;
  /** What asks whether another design was opened since. */
  function latest() {
    openings += 1;
    const own = openings;
    return () => own === openings;
  }

  /** Shows a design as a step that can be undone, and pins the one that came with it or, unless somebody chose what is pinned, itself. @param {Opened} found @param {string} what @param {string} [from] @returns {string} What is said of it. */
  function take({ origin, pinned }, what, from = "") {
    const { camera } = origin;
    store.change(camera, what, undefined, origin);
    if (pinned || !store.isPinChosen) store.pin(pinned ?? camera, { isChosen: pinned !== undefined });
    const named = `${camera.name}${from} is open`;
    if (pinned) return `${named}, and ${pinned.name} is pinned for comparison.`;
    return store.isPinChosen ? `${named} and compared with the pinned ${store.pinned?.name}.` : `${named} and pinned: later changes are compared with it.`;
  }

  /** Opens a camera. Fails when it cannot be in full. @param {Design} design @param {string} what @param {Design} [other] What is pinned with it. @param {string} [note] What else is to be said. */
  async function adopt(design, what, other, note) {
    const isLatest = latest();
    const found = { origin: await originOf(engine, design), pinned: other && await inFull(engine, other) };
    if (!isLatest()) return;
    const said = take(found, what);
    tell(note ?? said);
  }

  /** Opens the cameras of a comparison: the first one, with the second one pinned. @param {File} file */
  async function openResults(file) {
    const { cameras: [own, other], note, family } = await camerasOfResults(file, store.camera);
    judgeBy(family);
    const read = async (/** @type {Design} */ design) => engine.parse(await engine.cameraToml(design));
    await adopt(await read(own), `opening ${file.name}`, other && await read(other), note);
  }

  /** @param {File} file */
  async function open(file) {
    const kind = await kindOf(file);
    const name = shortened(file.name);
    const failed = (/** @type {string} */ how) => (/** @type {unknown} */ error) => tell(`${name}${how}: ${excerpt(message(error)).replace(/\.?$/, ".")}`, "trouble");
    if (kind === "photograph") return takePhotograph(file);
    if (kind === "results") return openResults(file).catch(failed(""));
    if (typeof kind === "object") return tell(`${name} ${kind.refused}`, "trouble");
    const text = await file.text();
    if (kind === "curve") return takeCurve(name, text);
    return engine.parse(text).then((design) => adopt(design, `opening ${file.name}`)).catch(failed(" is no camera file"));
  }

  /** Opens the file that is chosen with an input. @param {string} button @param {string} input @param {(file: File) => unknown} work */
  function onChoice(button, input, work) {
    const chooser = byId(input, HTMLInputElement);
    byId(button, HTMLButtonElement).addEventListener("click", () => chooser.click());
    chooser.addEventListener("change", () => {
      const [file] = chooser.files ?? [];
      if (file) work(file);
      chooser.value = "";
    });
  }
  onChoice("add-photo", "photo", takePhotograph);
  onChoice("open-file", "file", open);
  // While a file is over the page, the page shows that it takes it.
  const showDrop = (/** @type {boolean} */ is) => document.documentElement.toggleAttribute("data-drop", is);
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    showDrop(event.dataTransfer?.types.includes("Files") ?? false);
  });
  document.addEventListener("dragleave", (event) => { if (event.relatedTarget === null) showDrop(false); });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    showDrop(false);
    const [file] = event.dataTransfer?.files ?? [];
    if (file) open(file);
  });
  // A design is pasted into the address of the open page.
  addEventListener("hashchange", async () => {
    const isLatest = latest();
    try {
      const found = await inAddress(engine);
      if (!found?.shared || !isLatest()) return;
      const missing = showConditions(found.shared);
      const said = take(found, "opening the address", " of the address");
      tell(missing || said);
    } catch (error) {
      tellAddress(error);
    }
  });

  return {
    openPreset: (camera) => adopt(camera, `the preset ${camera.name}`).catch((error) => tell(`${excerpt(message(error))}.`, "trouble")),
  };
}
