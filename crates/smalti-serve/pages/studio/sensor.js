// @ts-check
// The sensor, the exposure and the lens as fields, with the ranges of camera files.
import { byId, make, setOptions, tellRange } from "./dom.js";
import { withValue } from "./design.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./design.js").Camera} Camera */

/**
 * A number of a camera. `key` is that whose range it has. With `isLens`, the light of the scenes depends on it and must be gathered for a new value.
 * `factor` is the number shown for 1 in the unit of the key.
 * @typedef {{ id: string, label: string, unit: string, key: string, step: number, title?: string, isLens?: boolean, factor?: number, get: (c: Camera) => number, set: (c: Camera, value: number) => Camera }} Field
 */

/** A noise in electrons, from the key in electrons or that in millivolts. @param {Camera} c */
function readNoise(c) {
  const { read_noise_e, read_noise_mv, conversion_gain_uv_per_e } = c.sensor.pixel;
  return read_noise_e ?? read_noise_mv * 1000 / conversion_gain_uv_per_e;
}

/** @param {Camera} c @param {number} electrons @returns {Camera} */
function withReadNoise(c, electrons) {
  const { read_noise_e, conversion_gain_uv_per_e } = c.sensor.pixel;
  return read_noise_e === undefined
    ? withValue(c, ["sensor", "pixel", "read_noise_mv"], electrons * conversion_gain_uv_per_e / 1000)
    : withValue(c, ["sensor", "pixel", "read_noise_e"], electrons);
}

/** A field of one key. @param {Omit<Field, "get" | "set">} field @returns {Field} */
function ofKey(field) {
  const path = field.key.split(".");
  const factor = field.factor ?? 1;
  return {
    ...field,
    get: (c) => path.reduce((/** @type {any} */ at, key) => at[key], c) * factor,
    set: (c, v) => withValue(c, path, Number((v / factor).toPrecision(12))),
  };
}

/** @type {Field[]} */
const FIELDS = [
  ofKey({ id: "pitch", label: "Pixel pitch", unit: "µm", key: "sensor.pixel.pitch_um", step: 0.1, isLens: true }),
  ofKey({ id: "f-number", label: "f-number", unit: "", key: "optics.f_number", step: 0.1, isLens: true, title: "Focal length divided by the diameter of the entrance pupil" }),
  ofKey({ id: "fill-factor", label: "Fill factor", unit: "%", key: "sensor.pixel.fill_factor", step: 1, isLens: true, factor: 100, title: "Photodetector area divided by pixel area" }),
  { id: "read-noise", label: "Read noise", unit: "e⁻", key: "sensor.pixel.read_noise_e", step: 0.1, get: readNoise, set: withReadNoise },
  ofKey({ id: "full-well", label: "Full well", unit: "e⁻", key: "sensor.pixel.full_well_e", step: 100 }),
  ofKey({ id: "gain", label: "Conversion gain", unit: "µV/e⁻", key: "sensor.pixel.conversion_gain_uv_per_e", step: 1 }),
  ofKey({ id: "prnu", label: "PRNU", unit: "%", title: "Gain differences between pixels", key: "sensor.prnu_percent", step: 0.1 }),
  { ...ofKey({ id: "bits", label: "ADC resolution", unit: "bit", key: "sensor.adc_bits", step: 1 }), set: (c, v) => withValue(c, ["sensor", "adc_bits"], Math.round(v)) },
];

/** The text of a number with at most four significant digits, all of those before the point. @param {number} value */
const shown = (value) => String(Math.abs(value) >= 1000 ? Math.round(value) : Number(value.toPrecision(4)));

/** A choice of a curve by name, and a curve of another kind, which stays. @param {any} filter */
const curveName = (filter) => (filter === undefined || filter === null ? "none" : filter.builtin ?? "own");

/**
 * Sets up the fields. `adopt` opens a camera of the catalogue.
 * @param {Store} store @param {Engine} engine @param {(design: import("./engine.js").Design, what: string) => Promise<void>} adopt
 * @returns {() => void}
 */
export function setUpSensor(store, engine, adopt) {
  const place = byId("camera", HTMLDivElement);
  const preset = byId("preset", HTMLSelectElement);
  /** @type {(() => void)[]} */
  const refreshers = [];

  const cameras = engine.catalogue.cameras;
  // The fields take the places that were kept for them.
  place.replaceChildren();
  preset.append(make("optgroup", { label: "The whole camera, with mosaic, filters and name" }, ...cameras.map((c, i) => make("option", { value: i }, c.name ?? ""))));
  preset.addEventListener("change", async () => {
    const chosen = preset.value;
    const camera = chosen === "" ? undefined : cameras[Number(chosen)];
    if (camera) await adopt(camera, `the preset ${camera.name}`);
    // Another one may have been chosen meanwhile.
    if (preset.value === chosen) preset.value = "";
  });

  const cut = make("select", { id: "ir-cut", change: () => store.change(withValue(store.camera, ["optics", "ir_cut"], cut.value === "none" ? undefined : { builtin: cut.value }), "the infrared cut") });
  refreshers.push(() => {
    const current = curveName(store.camera.optics.ir_cut);
    /** @type {[string, string][]} */
    const options = [["none", "None"], ...engine.catalogue.filters.filter((f) => /^(ir-cut|hot-mirror)/.test(f)).map((f) => /** @type {[string, string]} */ ([f, f]))];
    setOptions(cut, current === "own" || !options.some(([v]) => v === current) ? [...options, [current, "Own curve"]] : options, current);
  });
  place.append(make("label", { class: "field wide" }, make("span", {}, "Infrared cut"), cut));

  const time = make("input", { id: "time", type: "number", min: 0, max: engine.catalogue.ranges["exposure.time_ms"][1], step: "any", input: () => {
    const value = time.valueAsNumber;
    if (value > 0 && time.validity.valid) store.change(withValue(withValue(withValue(store.camera, ["exposure", "auto"], undefined), ["exposure", "auto_target"], undefined), ["exposure", "time_ms"], value), "the exposure time", "time");
  }, change: () => store.end() });
  const automatic = make("input", { id: "automatic", type: "checkbox", change: () => {
    const exposure = automatic.checked
      ? withValue(withValue(store.camera, ["exposure", "time_ms"], undefined), ["exposure", "auto"], "specular")
      : withValue(withValue(withValue(store.camera, ["exposure", "auto"], undefined), ["exposure", "auto_target"], undefined), ["exposure", "time_ms"], 100);
    store.change(exposure, "the exposure");
  } });
  refreshers.push(() => {
    const own = store.camera.exposure.time_ms;
    automatic.checked = Boolean(store.camera.exposure.auto) || own === undefined || own === null;
    time.disabled = automatic.checked;
    if (store.jumps || document.activeElement !== time) time.value = automatic.checked ? "" : shown(Number(own));
  });
  place.append(make("label", { class: "field number" }, make("span", {}, "Exposure"), make("span", { class: "unit" }, time, "ms")), make("label", { class: "check" }, automatic, "Automatic exposure"));

  for (const { id, label, unit, key, title, step, isLens, factor = 1, get, set } of FIELDS) {
    const [min, max] = engine.catalogue.ranges[key].map((v) => Number((v * factor).toPrecision(12)));
    const isValid = () => input.valueAsNumber >= min && input.valueAsNumber <= max;
    const take = () => { if (isValid() && input.valueAsNumber !== get(store.camera)) store.change(set(store.camera, input.valueAsNumber), label, id); };
    // Light is gathered for a finished number and not for every digit.
    const input = make("input", { id, type: "number", min, max, step: "any", input: () => { if (!isLens) take(); }, change: () => {
      if (isLens) take();
      if (!isValid()) tellRange(label, min, max, unit);
      store.end();
    }, blur: () => { input.value = shown(get(store.camera)); }, keydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
      event.preventDefault();
      const by = (event.key === "ArrowUp" ? 1 : -1) * step * (event.shiftKey ? 10 : 1);
      store.change(set(store.camera, Number(Math.min(Math.max(get(store.camera) + by, min), max).toFixed(4))), label, id);
      input.value = shown(get(store.camera));
    } });
    refreshers.push(() => { if (store.jumps || document.activeElement !== input) input.value = shown(get(store.camera)); });
    place.append(make("label", { class: "field number", title }, make("span", {}, label), make("span", { class: "unit" }, input, unit)));
  }

  const show = () => { for (const refresh of refreshers) refresh(); };
  store.on(["design"], show);
  return show;
}

/** The conditions of a camera beside its mosaic: what they are called, and their values with units. @param {Camera} camera @param {number} exposureMs The time of the exposure of its picture. @returns {[label: string, value: string][]} */
export function conditions(camera, exposureMs) {
  const { time_ms } = camera.exposure;
  const isAutomatic = Boolean(camera.exposure.auto) || time_ms === undefined || time_ms === null;
  const curve = (/** @type {any} */ filter) => curveName(filter).replace(/^own$/, "own curve");
  return [
    ["Exposure", `${shown(exposureMs)}\u00a0ms${isAutomatic ? ", automatic" : ""}`], ["Quantum efficiency", curve(camera.sensor.quantum_efficiency)], ["Infrared cut", curve(camera.optics.ir_cut)],
    ...FIELDS.map(({ label, unit, get }) => /** @type {[string, string]} */ ([label, `${label === "f-number" ? "f/" : ""}${shown(get(camera))}${unit && `\u00a0${unit}`}`])),
  ];
}

/** A lens and pixel geometry in words. @param {Camera} camera */
export const lensText = ({ optics, sensor }) => `f/${shown(optics.f_number)}, ${shown(sensor.pixel.pitch_um)} µm`;

/** The wavelengths of a camera: the first, the step and the last, nm. @param {any} camera @returns {[number, number, number]} */
const gridOf = ({ wavelengths_nm }) => wavelengths_nm ?? [400, 10, 700];

/**
 * A camera as the engine of the page simulates it: at the wavelengths of its light, exposed by the brightest point where the camera meters a percentile, without
 * crosstalk and binning. `left` names what of the camera is not simulated.
 * @param {Engine} engine @param {Camera} camera @returns {{ camera: Camera, left: string[] }}
 */
export function simulated(engine, camera) {
  /** @type {string[]} */
  const left = [];
  let own = camera;
  const [{ camera: first }] = engine.setups;
  const words = (/** @type {number[]} */ [from, step, to]) => `${from} to ${to} nm in steps of ${step} nm`;
  if (JSON.stringify(gridOf(own)) !== JSON.stringify(gridOf(first))) {
    own = withValue(own, ["wavelengths_nm"], /** @type {any} */ (first).wavelengths_nm ?? undefined);
    left.push(`its wavelengths of ${words(gridOf(camera))} (here ${words(gridOf(first))})`);
  }
  if (own.exposure.auto === "luminance" && (own.exposure.time_ms ?? undefined) === undefined) {
    own = withValue(withValue(own, ["exposure", "auto"], "specular"), ["exposure", "auto_target"], undefined);
    left.push("exposure by a percentile of the illuminance (here the brightest point sets it)");
  }
  if (own.sensor.crosstalk_percent > 0) {
    own = withValue(own, ["sensor", "crosstalk_percent"], 0);
    left.push("crosstalk");
  }
  if (own.sensor.binning) {
    own = withValue(own, ["sensor", "binning"], undefined);
    left.push("binning");
  }
  return { camera: own, left };
}

/**
 * Why commands refuse a camera that the page simulates: curves in samples that end within its wavelengths. Empty if they do not.
 * @param {Camera} camera @returns {string}
 */
export function refusedByCommands(camera) {
  const [first, , last] = gridOf(camera);
  const ends = (/** @type {any} */ { samples }) => samples && (samples.start_nm > first || samples.start_nm + samples.step_nm * (samples.values.length - 1) < last);
  const short = Object.entries(camera.sensor.cfa.filters).filter(([, filter]) => ends(filter)).map(([letter]) => letter);
  if (short.length === 0) return "";
  const filters = short.length === 1 ? `the filter ${short[0]} is` : `the filters ${short.join(", ")} are`;
  return `commands and full computations refuse this design: they simulate it at ${first} to ${last} nm, and ${filters} in samples at fewer wavelengths. Give other shapes, or change wavelengths_nm in the saved file`;
}
