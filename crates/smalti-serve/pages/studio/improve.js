// @ts-check
// Improvement: the design becomes better step by step, under locks, until it is stopped or no step helps.
import { announce, byId, make } from "./dom.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./engine.js").Step} Step */

/** The family of which filters should be. @returns {import("./engine.js").Family} */
export const familyOf = () => /** @type {any} */ (byId("family", HTMLSelectElement).value);

/**
 * Sets up the panel. `luminance` is the light shown, `own` makes the design of a step one of the page.
 * @param {Store} store @param {Engine} engine @param {() => number} luminance @param {(design: import("./engine.js").Design) => import("./design.js").Camera} own
 * @param {(error: unknown) => void} fail
 */
export function setUpImprove(store, engine, luminance, own, fail) {
  const place = byId("improve", HTMLDivElement);
  const light = make("select", {}, make("option", { value: "here" }, "at the light shown"), make("option", { value: "range" }, "from 1 to 100 cd/m²"));
  const family = make("select", { id: "family" }, make("option", { value: "free" }, "any smooth curves"), make("option", { value: "pigments" }, "pigments"), make("option", { value: "dichroic" }, "dichroic bands"));
  const keepMosaic = make("input", { type: "checkbox" });
  const button = make("button", { type: "button", class: "primary", "data-improve": "" }, "Improve");
  const discard = make("button", { type: "button", hidden: true }, "Discard");
  const state = make("p", { class: "hint progress", role: "status" }, "Starts from this design. Locked filters and cells stay as they are.");
  place.append(
    make("div", { class: "fields" }, make("label", { class: "field wide" }, make("span", {}, "Make it best"), light), make("label", { class: "field wide" }, make("span", {}, "Filters are"), family)),
    make("label", { class: "check" }, keepMosaic, "Keep the mosaic"),
    make("div", { class: "row" }, button, discard), state,
  );

  /** @type {AbortController | undefined} */
  let stop;
  let runs = 0;
  /** Whether the change of the design comes from here. */
  let isOwn = false;
  /** The step of the history with the result, while it can be discarded. @type {number | undefined} */
  let result;

  /** @param {Step} step @param {import("./engine.js").Expected[]} before */
  function words(step, before) {
    if (step.cost >= step.own_cost) return `Step ${step.step}. Not yet better than the design that it began with`;
    const gains = step.expected.map((e, i) => {
      const by = e.cpsnr_db - before[i].cpsnr_db;
      const color = e.delta_e_2000 - before[i].delta_e_2000;
      const signed = (/** @type {number} */ v) => `${v < 0 ? "−" : "+"}${Math.abs(v).toFixed(2)}`;
      return `${step.expected.length > 1 ? `${Number(e.luminance_cd_m2.toPrecision(3))} cd/m²: ` : ""}${signed(by)} dB, ${signed(color)} ΔE2000`;
    });
    return `Step ${step.step}. Expected: ${gains.join("; ")}`;
  }

  async function run() {
    stop = new AbortController();
    runs += 1;
    result = undefined;
    const key = `improvement ${runs}`;
    const begun = store.camera;
    const locks = {
      filters: [...store.lockedFilters], mosaic: keepMosaic.checked,
      cells: [...store.lockedCells].map((cell) => /** @type {[number, number]} */ (cell.split(",").map(Number))),
    };
    const luminances = light.value === "here" ? [luminance()] : [1, 10, 100];
    button.textContent = "Stop and keep";
    discard.hidden = true;
    state.textContent = "Gathering what is known of the light…";
    const { signal } = stop;
    try {
      // A newer request of the page may come before this one.
      let before = null;
      while (before === null) before = await engine.scores(begun, luminances);
      const { expected } = before;
      const last = await engine.improve(begun, locks, luminances, (step) => {
        if (signal.aborted) return;
        isOwn = true;
        if (step.cost < step.own_cost) store.change(own(step.design), "the improvement", key);
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
