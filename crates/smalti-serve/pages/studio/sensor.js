// @ts-check
// The sensor, the exposure and the lens as fields. Lens and pixel geometry are chosen together, among those that the page has light for.
import { announce, byId, make, setOptions } from "./dom.js";
import { withValue } from "./design.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Engine} Engine */
/** @typedef {import("./design.js").Camera} Camera */

/** @typedef {{ id: string, label: string, unit: string, min: number, max: number, step: number, title?: string, get: (c: Camera) => number, set: (c: Camera, value: number) => Camera }} Field */

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

/** @type {Field[]} */
const FIELDS = [
  { id: "read-noise", label: "Read noise", unit: "e⁻", min: 0, max: 1000, step: 0.1, get: readNoise, set: withReadNoise },
  { id: "full-well", label: "Full well", unit: "e⁻", min: 100, max: 1e6, step: 100, get: (c) => c.sensor.pixel.full_well_e, set: (c, v) => withValue(c, ["sensor", "pixel", "full_well_e"], v) },
  {
    id: "gain", label: "Gain", title: "Conversion gain of a pixel", unit: "µV/e⁻", min: 0.1, max: 2000, step: 1, get: (c) => c.sensor.pixel.conversion_gain_uv_per_e,
    set: (c, v) => withValue(c, ["sensor", "pixel", "conversion_gain_uv_per_e"], v),
  },
  { id: "prnu", label: "PRNU", unit: "%", title: "Gain differences between pixels", min: 0, max: 20, step: 0.1, get: (c) => c.sensor.prnu_percent, set: (c, v) => withValue(c, ["sensor", "prnu_percent"], v) },
  { id: "bits", label: "Converter", unit: "bit", min: 4, max: 16, step: 1, get: (c) => c.sensor.adc_bits, set: (c, v) => withValue(c, ["sensor", "adc_bits"], Math.round(v)) },
];

/** The text of a number with at most four significant digits, all of those before the point. @param {number} value */
const shown = (value) => String(Math.abs(value) >= 1000 ? Math.round(value) : Number(value.toPrecision(4)));

/** @param {Engine["setups"][number]} setup */
function setupName({ camera }) {
  const { optics, sensor } = /** @type {Camera} */ (/** @type {unknown} */ (camera));
  return `f/${optics.f_number}, ${sensor.pixel.pitch_um} µm`;
}

/** A choice of a curve by name, and a curve of another kind, which stays. @param {any} filter */
const curveName = (filter) => (filter === undefined || filter === null ? "none" : filter.builtin ?? "own");

/**
 * Sets up the fields. `adopt` opens a camera of the catalogue.
 * @param {Store} store @param {Engine} engine @param {(design: import("./engine.js").Design, what: string) => void} adopt
 * @returns {() => void}
 */
export function setUpSensor(store, engine, adopt) {
  const place = byId("camera", HTMLDivElement);
  const preset = byId("preset", HTMLSelectElement);
  /** @type {(() => void)[]} */
  const refreshers = [];

  const cameras = engine.catalogue.cameras;
  preset.append(...cameras.map((c, i) => make("option", { value: i }, c.name ?? "")));
  preset.addEventListener("change", () => {
    const camera = cameras[Number(preset.value)];
    preset.value = "";
    if (camera) adopt(camera, `the preset ${camera.name}`);
  });

  const setup = make("select", { id: "setup", title: "The light of the scenes was gathered behind this lens, on these pixels", change: () => {
    const chosen = engine.setups.find((s) => s.id === setup.value);
    if (!chosen) return;
    store.change(withSetup(store.camera, chosen), "lens and pixel");
    announce(`Lens and pixel: ${setupName(chosen)}`);
  } });
  refreshers.push(() => setOptions(setup, engine.setups.map((s) => [s.id, setupName(s)]), setupOf(engine, store.camera)?.id ?? ""));
  place.append(make("label", { class: "field wide" }, make("span", {}, "Lens and pixel"), setup));

  const cut = make("select", { id: "ir-cut", change: () => store.change(withValue(store.camera, ["optics", "ir_cut"], cut.value === "none" ? undefined : { builtin: cut.value }), "the infrared cut") });
  refreshers.push(() => {
    const current = curveName(store.camera.optics.ir_cut);
    /** @type {[string, string][]} */
    const options = [["none", "None"], ...engine.catalogue.filters.filter((f) => /^(ir-cut|hot-mirror)/.test(f)).map((f) => /** @type {[string, string]} */ ([f, f]))];
    setOptions(cut, current === "own" || !options.some(([v]) => v === current) ? [...options, [current, "Own curve"]] : options, current);
  });
  place.append(make("label", { class: "field wide" }, make("span", {}, "Infrared cut"), cut));

  const time = make("input", { id: "time", type: "number", min: 0.01, max: 60000, step: "any", input: () => {
    const value = time.valueAsNumber;
    if (value > 0 && value <= 60000) store.change(withValue(withValue(withValue(store.camera, ["exposure", "auto"], undefined), ["exposure", "auto_target"], undefined), ["exposure", "time_ms"], value), "the exposure time", "time");
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

  for (const { id, label, unit, title, min, max, step, get, set } of FIELDS) {
    const input = make("input", { id, type: "number", min, max, step: "any", input: () => {
      const value = input.valueAsNumber;
      if (value >= min && value <= max) store.change(set(store.camera, value), label.toLowerCase(), id);
    }, change: () => store.end(), keydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
      event.preventDefault();
      const by = (event.key === "ArrowUp" ? 1 : -1) * step * (event.shiftKey ? 10 : 1);
      store.change(set(store.camera, Number(Math.min(Math.max(get(store.camera) + by, min), max).toFixed(4))), label.toLowerCase(), id);
      input.value = shown(get(store.camera));
    } });
    refreshers.push(() => { if (store.jumps || document.activeElement !== input) input.value = shown(get(store.camera)); });
    place.append(make("label", { class: "field number", title }, make("span", {}, label), make("span", { class: "unit" }, input, unit)));
  }

  const show = () => { for (const refresh of refreshers) refresh(); };
  store.on(["design"], show);
  return show;
}

const isEqual = (/** @type {unknown} */ a, /** @type {unknown} */ b) => JSON.stringify(a ?? null) === JSON.stringify(b ?? null);

/** The camera with the lens and the pixel geometry of a setup. Transmittance and infrared cut stay. @param {Camera} camera @param {Engine["setups"][number]} setup @returns {Camera} */
export function withSetup(camera, setup) {
  const fixed = /** @type {any} */ (setup.camera);
  const { transmittance, ir_cut } = camera.optics;
  const { pitch_um, fill_factor } = fixed.sensor.pixel;
  const lens = { ...fixed.optics, ...(transmittance === undefined ? {} : { transmittance }), ir_cut };
  return withValue({ ...camera, optics: lens, sensor: { ...camera.sensor, pixel: { ...camera.sensor.pixel, pitch_um, fill_factor } } }, ["wavelengths_nm"], fixed.wavelengths_nm);
}

/** The setup of a camera, if the page has its light. @param {Engine} engine @param {Camera} camera */
export function setupOf(engine, camera) {
  const sorted = (/** @type {any} */ o) => Object.entries(o).filter(([, v]) => v !== undefined && v !== null).sort(([a], [b]) => (a < b ? -1 : 1));
  const key = (/** @type {Camera} */ c) => [sorted(c.optics), c.sensor.pixel.pitch_um, c.sensor.pixel.fill_factor, c.wavelengths_nm];
  return engine.setups.find((setup) => isEqual(key(camera), key(withSetup(camera, setup))));
}

/**
 * A camera as the page can draw it: with lens and pixel geometry that it has light for, its own or those with the nearest pitch, and with
 * exposure by the brightest point in place of a percentile, without crosstalk and binning. `changed` says what was changed.
 * @param {Engine} engine @param {Camera} camera @returns {{ camera: Camera, changed: string }}
 */
export function fitted(engine, camera) {
  /** @type {string[]} */
  const changed = [];
  let fits = camera;
  if (!setupOf(engine, fits)) {
    const pitch = (/** @type {any} */ c) => Math.log(c.sensor.pixel.pitch_um);
    const nearest = engine.setups.reduce((a, b) => (Math.abs(pitch(b.camera) - pitch(camera)) < Math.abs(pitch(a.camera) - pitch(camera)) ? b : a));
    fits = withSetup(fits, nearest);
    const range = camera.wavelengths_nm ? `, ${camera.wavelengths_nm[0]} to ${camera.wavelengths_nm[2]} nm` : "";
    changed.push(`lens and pixels of ${setupName(nearest)}, since the page has no light for its own (f/${camera.optics.f_number}, ${camera.sensor.pixel.pitch_um} µm${range})`);
  }
  if (fits.exposure.auto === "luminance" && fits.exposure.time_ms === undefined) {
    fits = withValue(withValue(fits, ["exposure", "auto"], "specular"), ["exposure", "auto_target"], undefined);
    changed.push("exposure by the brightest point in place of a percentile");
  }
  if (fits.sensor.crosstalk_percent > 0) {
    fits = withValue(fits, ["sensor", "crosstalk_percent"], 0);
    changed.push("pixels without crosstalk");
  }
  if (fits.sensor.binning) {
    fits = withValue(fits, ["sensor", "binning"], undefined);
    changed.push("pixels that are read one by one");
  }
  return { camera: fits, changed: changed.length === 0 ? "" : `${camera.name} is shown with ${changed.join(", and with ")}.` };
}
