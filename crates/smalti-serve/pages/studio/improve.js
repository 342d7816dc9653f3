// @ts-check
// Improvement: the design becomes better step by step, under locks, until it is stopped or no step helps. With a server, the native library also searches
// all mosaics of the tile from many starts.
import { announce, byId, make } from "./dom.js";
import { withValue } from "./design.js";
import { inOrder } from "./exchange.js";
import { signed } from "./numbers.js";
import { keptEqual } from "./thickness.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Step} Step */
/** @typedef {import("./design.js").Camera} Camera */

/** The family of which filters should be. @returns {import("./engine.js").Family} */
export const familyOf = () => /** @type {any} */ (byId("family", HTMLSelectElement).value);

/**
 * Sets up the panel. `luminance` is that of the scene shown, `simulated` makes a camera one that the engine simulates.
 * @param {Store} store @param {Engine} engine
 * @param {{
 *   luminance: () => number, simulated: (camera: Camera) => Camera, fail: (error: unknown) => void,
 *   native: ReturnType<typeof import("./native.js").setUpNative>,
 * }} page
 */
export function setUpImprove(store, engine, { luminance, simulated, fail, native }) {
  const place = byId("improve", HTMLDivElement);
  const light = make("select", {}, make("option", { value: "here" }, "the luminance shown"), make("option", { value: "range" }, "1, 10 and 100 cd/m²"));
  const family = make("select", { id: "family" }, make("option", { value: "free" }, "any smooth curves"), make("option", { value: "pigments" }, "pigments"), make("option", { value: "dichroic" }, "dichroic bands"));
  const keepMosaic = make("input", { type: "checkbox" });
  const button = make("button", { type: "button", class: "primary", "data-improve": "" }, "Improve");
  const wide = make("button", { type: "button", "data-job": "", hidden: true, title: "Searches all mosaics of the tile, each from many starts, with all processors of this computer" }, "Global search");
  const discard = make("button", { type: "button", hidden: true }, "Discard");
  // Begin and end are announced; every step would be too much.
  const state = make("p", { class: "hint progress" }, "Starts from this design. Locked filters and cells stay as they are.");
  place.append(
    make("div", { class: "fields" }, make("label", { class: "field wide" }, make("span", {}, "Optimise for"), light), make("label", { class: "field wide" }, make("span", {}, "Filters are"), family)),
    make("label", { class: "check" }, keepMosaic, "Keep the mosaic"),
    make("div", { class: "row" }, button, wide, discard), state,
  );

  /** @type {AbortController | undefined} */
  let stop;
  let runs = 0;
  /** Whether the change of the design comes from here. */
  let isOwn = false;
  /** The step of the history with the result, while it can be discarded. @type {number | undefined} */
  let result;

  /** @typedef {Pick<import("./engine.js").Expected, "luminance_cd_m2" | "cpsnr_db" | "delta_e_2000">} Figures */
  /** What is expected of a change. @param {Figures[]} after @param {Figures[]} before */
  function gains(after, before) {
    const all = after.map((e, i) => {
      const by = e.cpsnr_db - before[i].cpsnr_db;
      const color = e.delta_e_2000 - before[i].delta_e_2000;
      return `${after.length > 1 ? `${Number(e.luminance_cd_m2.toPrecision(3))} cd/m²: ` : ""}${signed(by, 2)} dB, ${signed(color, 2)} ΔE2000`;
    });
    return `Expected: ${all.join("; ")}`;
  }

  /** @param {Step} step @param {import("./engine.js").Expected[]} before */
  function words(step, before) {
    if (step.cost >= step.own_cost) return `Step ${step.step}. Not yet better than the design that it began with`;
    return `Step ${step.step}. ${gains(step.expected, before)}`;
  }

  const luminances = () => light.value === "here" ? [luminance()] : [1, 10, 100];
  /** @returns {[number, number][]} */
  const lockedCells = () => [...store.lockedCells].map((cell) => /** @type {[number, number]} */ (cell.split(",").map(Number)));
  /** The cells of the locked filters. @returns {[number, number][]} */
  const cellsOfLocked = () => store.camera.sensor.cfa.pattern.flatMap((line, row) =>
    [...line].flatMap((letter, col) => (store.lockedFilters.has(letter) ? [/** @type {[number, number]} */ ([row, col])] : [])));

  async function run() {
    stop = new AbortController();
    runs += 1;
    result = undefined;
    const key = `improvement ${runs}`;
    const begun = store.camera;
    const start = simulated(begun);
    const locks = { filters: [...store.lockedFilters], mosaic: keepMosaic.checked, cells: [...lockedCells(), ...cellsOfLocked()] };
    const lights = luminances();
    button.textContent = "Stop and keep";
    discard.hidden = true;
    state.textContent = "Gathering what is known of the light…";
    announce("The improvement has begun");
    const { signal } = stop;
    try {
      // No newer improvement takes the place of this one, which ends first.
      const { expected } = /** @type {import("./engine.js").Scores} */ (await engine.scores(start, lights, { asker: "improvement" }));
      const last = await engine.improve(start, locks, lights, (step) => {
        if (signal.aborted) return;
        isOwn = true;
        const { cfa } = inOrder(step.design).sensor;
        const filters = keptEqual(cfa.filters, begun.sensor.cfa.filters);
        if (step.cost < step.own_cost) store.change(withValue(begun, ["sensor", "cfa"], { ...cfa, filters }), "the improvement", key);
        isOwn = false;
        state.textContent = `${words(step, expected)}.`;
      }, signal, familyOf());
      const isChanged = store.camera !== begun && store.steps[store.at].what === "the improvement";
      if (isChanged) result = store.at;
      const told = `${words(last, expected)}. ${!isChanged ? "Nothing was changed" : last.is_done ? "No step makes it better" : "Stopped and kept"}.`;
      state.textContent = told;
      announce(told);
    } catch (error) {
      state.textContent = "";
      fail(error);
    }
    stop = undefined;
    isOwn = false;
    store.end();
    button.textContent = "Improve";
    discard.hidden = result === undefined;
  }

  /** @param {NonNullable<Awaited<typeof native>>} server */
  async function search(server) {
    const begun = store.camera;
    const found = await server.work("The search", { search: {
      design: begun, filters: [...store.lockedFilters], cells: lockedCells(), mosaic: keepMosaic.checked, luminances_cd_m2: luminances(), family: family.value,
    } });
    if (!found) return;
    const { said } = found;
    const among = said.mosaics === 1 ? "The mosaic was kept, and its filters were searched" : `${said.mosaics} mosaics with their filters were searched`;
    if (!said.is_better) {
      state.textContent = `${among}. None is better than this design.`;
      announce(state.textContent);
      return;
    }
    const isChanged = store.camera !== begun;
    stop?.abort();
    isOwn = true;
    store.change(inOrder(said.design), "the search");
    isOwn = false;
    result = store.at;
    discard.hidden = false;
    state.textContent = `${among}. ${gains(said.expected, said.own_expected)}.${isChanged ? " Undo brings back what was changed meanwhile." : ""}`;
    announce(state.textContent);
  }
  native.then((server) => {
    if (!server) return;
    wide.hidden = false;
    wide.addEventListener("click", () => search(server));
  });

  button.addEventListener("click", () => {
    if (stop) stop.abort();
    else run();
  });
  discard.addEventListener("click", () => {
    if (result !== undefined && store.at === result) store.undo();
    button.focus();
    state.textContent = "Discarded. Redo brings it back.";
  });
  store.on(["design"], () => {
    if (isOwn) return;
    // A change by hand ends the improvement, which began with another design.
    stop?.abort();
    result = undefined;
    discard.hidden = true;
  });
}
