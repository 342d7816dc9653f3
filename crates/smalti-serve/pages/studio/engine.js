// @ts-check
// The engine of the studio: designs go in, pictures, scores and curves come out. Everything is computed by the library, as WebAssembly in
// Web Workers; nothing here knows any physics.
//
// A design is a camera description, as JSON: the keys are those of a camera file (`smalti list camera-keys`), and every key has its
// default. The tile is `sensor.cfa.pattern`, the filters are `sensor.cfa.filters`.
//
// The light of the scenes on the pixels is gathered once for each lens and pixel geometry: for `optics` (except `transmittance` and `ir_cut`),
// `sensor.pixel.pitch_um` and `sensor.pixel.fill_factor`. That of the camera with which the page begins came with the page; that of another
// lens takes seconds (`light`). `wavelengths_nm` of a design are those of this camera; a design with others is refused with a message that
// names the key. Pictures have the size of the scene, whatever
// `sensor.rows` and `sensor.cols` say. Pipelines are learned from statistics of light or from patches, for a mosaic without crosstalk and binning.
import { Bench, Latest, again } from "./bench.js";
import { fetched, inflated } from "./fetched.js";
import { Lights, START } from "./lights.js";

/** @typedef {import("./lights.js").LightOf} LightOf */

/**
 * The transmittance of a filter: one key, such as `{ gaussian: { center_nm: 540, sigma_nm: 35, peak: 0.9 } }`.
 * @typedef {{ flat: number } | { gaussian: { center_nm: number, sigma_nm: number, peak?: number } }
 *   | { box: { low_nm: number, high_nm: number, peak?: number } }
 *   | { raised_cosine: { center_nm: number, fwhm_nm: number, peak?: number } }
 *   | { long_pass: { edge_nm: number, width_nm: number, peak?: number } }
 *   | { short_pass: { edge_nm: number, width_nm: number, peak?: number } }
 *   | { butterworth: { center_nm: number, fwhm_nm: number, order: number, peak?: number } }
 *   | { dye: { bands: { center_nm: number, fwhm_nm: number, absorbance: number }[], peak?: number, leakage?: number } }
 *   | { builtin: string }
 *   | { samples: { start_nm: number, step_nm: number, values: number[] } }} Filter
 */

/**
 * A camera description. `pattern` is the name of a built-in mosaic or its lines, one letter a cell; `filters` has a filter for each letter.
 * @typedef {object} Design
 * @property {string} [name]
 * @property {number[]} [wavelengths_nm] First, step and last.
 * @property {Record<string, any>} [optics]
 * @property {{ quantum_efficiency?: Filter, pixel?: Record<string, number>, cfa?: ColorArray, [key: string]: any }} [sensor]
 * @property {Record<string, any>} [exposure]
 * @property {Record<string, any>} [isp]
 */

/** The colour filter array of a camera description. @typedef {{ pattern?: string | string[], filters?: Record<string, Filter>, mixtures?: Record<string, Record<string, number>> }} ColorArray */
/** An array with its tile in letters and with all of its filters. @typedef {{ pattern: string[], filters: Record<string, Filter> }} FullArray */

/** A scene; `catalogue` is its name in commands, `file` its light, if it came with the page. @typedef {{ id: string, name: string, catalogue?: string, set: "charts" | "natural" | "own", file?: string | null }} Scene */
/** @typedef {{ row: number, col: number, rows: number, cols: number }} Crop */

/** The camera whose light came with the page, without its mosaic. @typedef {{ id: string, name: string, camera: Design }} Setup */

/**
 * A warning about a design: the key of the camera description that it is about, and what it says.
 * @typedef {{ key: string, message: string }} Warning
 */

/**
 * Resolution and noise on the targets, as `smalti compare` measures them; null where they cannot be measured.
 * @typedef {{ mtf50_cy_per_mm: number | null, mtf50_cy_per_px: number | null, mtf50_low_contrast_cy_per_mm: number | null,
 *   mtf50_low_contrast_cy_per_px: number | null, luminance_noise_percent: number | null }} TargetScores
 */
/**
 * The differences of the picture from the reference, as `smalti compare` scores them.
 * @typedef {{ cpsnr_db: number, pixel_delta_e_2000_mean: number, pixel_delta_e_2000_p95: number, scielab_mean: number, targets: TargetScores }} PictureScores
 */

/**
 * A picture of a scene by a design with the pipeline that was learned for it. `rgba` has four bytes a pixel, row by row; `reference` is
 * what the standard observer sees; `difference` has CIEDE2000 at every pixel if scores were asked for. `crop` is the part of the scene
 * that is shown. `exposure_ms` is the time of the exposure, `gain` that of the display.
 * @typedef {object} Picture
 * @property {number} width @property {number} height
 * @property {Uint8ClampedArray} rgba @property {Uint8ClampedArray} reference
 * @property {PictureScores | null} scores @property {Float32Array | null} difference
 * @property {Crop} crop @property {number} exposure_ms @property {number} saturated_percent @property {number} gain
 * @property {Warning[]} warnings
 * @property {{ learn: number, draw: number, score: number, total: number }} timings_ms
 */

/**
 * Expected figures of the best linear pipeline, in closed form (docs/designs.md), at a luminance.
 * @typedef {{ luminance_cd_m2: number, cpsnr_db: number, detail_db: number, delta_e_2000: number, scielab: number, time_s: number }} Expected
 */

/**
 * Scores of a design without a picture. `array` has the figures of the array alone, as `smalti evaluate` prints them.
 * @typedef {object} Scores
 * @property {Expected[]} expected One for each luminance.
 * @property {{ vora_value: number, sensitivity_metamerism_index: number, metamer_mismatch_percent: number, photon_efficiency: number,
 *   condition_number: number | null, luminance_noise_gain: number }} array
 * @property {Warning[]} warnings
 */

/** A pigment in a filter, and its thickness relative to the built-in filter. @typedef {{ name: string, thickness: number }} Layer */

/**
 * Curves over `wavelengths_nm`. `quantum_efficiency` is electrons per photon behind the filter, the infrared cut and the lens; `color` is
 * the filter as the standard observer sees it before the light, sRGB. `pigments` are the layers of which a filter in samples is made, of a thickness relative to the
 * built-in filters, null if none make it.
 * @typedef {object} Curves
 * @property {number[]} wavelengths_nm
 * @property {{ letter: string, transmittance: number[], quantum_efficiency: number[], color: string, pigments: Layer[] | null }[]} channels
 * @property {number[]} sensor_quantum_efficiency
 * @property {number[]} lens_transmittance Of the lens with its infrared cut.
 * @property {number[]} light Relative, its largest value is 1.
 * @property {{ x: number[], y: number[], z: number[] }} observer
 * @property {string[][]} mosaic The letters of the tile, row by row.
 */

/** Filters: any smooth curves, layers of pigments, or bands between two edges. @typedef {"free" | "pigments" | "dichroic"} Family */

/**
 * What stays as it is: filters by letter, and cells as [row, column] of the tile. `mosaic: true` keeps all cells.
 * @typedef {{ filters?: string[], cells?: [number, number][], mosaic?: boolean }} Locks
 */

/**
 * A step of an improvement: the design so far, what is expected of it, and the cost, which is negative once it is better than the
 * first design in every figure everywhere. `own_cost` is that of the first design. The first step may cost more than it, where the filters are none of the family.
 * @typedef {{ design: Design, step: number, cost: number, own_cost: number, expected: Expected[], is_done: boolean }} Step
 */

/** References that are kept, about 0.5 MB each. */
const KEPT_REFERENCES = 24;

/** The seed of the noise of pictures, that of the command. */
export const SEED = 1;

/** Draws, scores and improves designs. */
export class Engine {
  /** @type {Bench} */ #pictures;
  /** @type {Bench} */ #figures;
  #latestPicture = new Latest();
  #latestScores = new Latest();
  /** @type {Map<string, Uint8ClampedArray>} */ #references = new Map();
  /** Workers that gather light: for pictures, and statistics, which take longer. @type {Map<string, Bench>} */
  #gatherers = new Map();
  /** @type {() => Bench} */ #newBench;
  /** @type {Lights} */ #lights;
  /** The file of the statistics, if it came with the page. @type {string | null} */ #statistics;

  /**
   * @param {Bench} pictures @param {Bench} figures @param {() => Bench} newBench
   * @param {{ scenes: Scene[], setups: Setup[], statistics: string | null, catalogue: any }} about
   */
  constructor(pictures, figures, newBench, about) {
    this.#pictures = pictures;
    this.#figures = figures;
    this.#newBench = newBench;
    this.#lights = new Lights(about.setups[0].camera, (of, design) => again(async () => (await this.#gatherer(of).ask("light", { of, design })).bytes));
    this.#statistics = about.statistics;
    /** The scenes, first the one that is ready first. @type {Scene[]} */
    this.scenes = about.scenes;
    /** The camera whose light came with the page. @type {Setup[]} */
    this.setups = about.setups;
    /**
     * Built-in mosaics with their other names, tiles and default filters, the built-in filters by name, the built-in cameras, the least and
     * the largest value of each key, the smallest relevant difference of each score, and the share of the samples beyond which a design clips noticeably, percent.
     * @type {{ cfas: { name: string, aliases?: string[], tile: string[], filters: Record<string, Filter> }[], filters: string[], cameras: Design[],
     *   ranges: Record<string, [number, number]>, relevances: Record<string, { absolute?: number, relative?: number }>, saturated_percent: number }}
     */
    this.catalogue = about.catalogue;
  }

  /**
   * Loads the module and what the first picture needs; the other scenes follow in the background. `assetsUrl` ends with "/" and has
   * `manifest.json`, the files that it names, and `studio.wasm.deflate`. `told` hears of a worker that failed, in place of which another is started.
   * @param {string | URL} assetsUrl @param {(message: string) => void} [told] @returns {Promise<Engine>}
   */
  static async start(assetsUrl, told = () => {}) {
    if (typeof WebAssembly !== "object") throw new Error("this browser does not allow WebAssembly");
    const base = String(new URL(assetsUrl, document.baseURI));
    // The module is compiled once, for all workers.
    const compiled = inflated(new URL("studio.wasm.deflate", base)).then((bytes) => WebAssembly.compile(bytes));
    const manifest = await (await fetched(new URL("manifest.json", base))).json();
    const newBench = () => new Bench(async () => ({ base, manifest, module: await compiled }), told);
    const [pictures, figures] = [newBench(), newBench()];
    const [{ said: catalogue }] = await Promise.all([figures.ask("catalogue", {}), pictures.start()]);
    return new Engine(pictures, figures, newBench, { ...manifest, catalogue });
  }

  /** The worker that gathers some light, made when it is first needed. @param {LightOf} of @returns {Bench} */
  #gatherer(of) {
    const kind = of === "statistics" ? "statistics" : "pictures";
    const bench = this.#gatherers.get(kind) ?? this.#newBench();
    this.#gatherers.set(kind, bench);
    return bench;
  }

  /** Whether some light came with the page. @param {Design} design @param {LightOf} of */
  #came(design, of) {
    const file = typeof of === "object" ? this.scenes.find((s) => s.id === of.scene)?.file : of === "statistics" ? this.#statistics : true;
    return this.#lights.lens(design) === START && Boolean(file);
  }

  /** The light that must be gathered for a design. @param {Design} design @param {LightOf[]} all */
  #missing(design, all) {
    return all.filter((of) => !this.#came(design, of) && !this.#lights.has(design, of));
  }

  /** Whether the light of a design need not be waited for. @param {Design} design @param {LightOf[]} all */
  hasLight(design, all) {
    return this.#missing(design, all).length === 0;
  }

  /** Gathers the light behind the lens of a design, which takes seconds once for each lens. @param {Design} design @param {LightOf[]} all */
  async light(design, all) {
    await Promise.all(this.#missing(design, all).map((of) => this.#lights.get(design, of)));
  }

  /** Hands light to a worker, and returns the name of its lens. @param {Bench} bench @param {Design} design @param {LightOf[]} all */
  async #supply(bench, design, all) {
    const lens = this.#lights.lens(design);
    for (const of of all) if (!this.#came(design, of)) await bench.supply(lens, of, () => this.#lights.get(design, of));
    return lens;
  }

  /**
   * What a design makes of a scene at a mean luminance, with the pipeline that is learned for it. Without `crop`, the whole scene; with it, the same
   * pixels of the same picture. `measure` asks for scores and the map of differences, with a pipeline that is learned at several exposures, all of which
   * take longer than the picture with a pipeline from statistics of light. Resolves to null when a newer call has taken its place. Rejects with a
   * message that names the key when the design is impossible.
   * @param {{ design: Design, scene: string, luminance: number, crop?: Crop, measure?: boolean, noise?: boolean, seed?: number }} wanted
   * @returns {Promise<Picture | null>}
   */
  draw({ design, scene, luminance, crop, measure = false, noise = true, seed = SEED }) {
    return this.#latestPicture.run(async () => {
      const begun = performance.now();
      const lens = await this.#supply(this.#pictures, design, ["training", { scene }]);
      const key = JSON.stringify([scene, crop ?? null, lens]);
      const hasReference = this.#references.has(key);
      const request = { design, lens, scene, luminance_cd_m2: luminance, crop, measure, thorough: measure, noise, seed, reference: !hasReference };
      const { said, bytes } = await this.#pictures.ask("draw", request);
      const pixels = 4 * said.width * said.height;
      const rgba = new Uint8ClampedArray(bytes, 0, pixels);
      if (!hasReference) this.#references.set(key, new Uint8ClampedArray(bytes.slice(pixels, 2 * pixels)));
      for (const oldest of [...this.#references.keys()].slice(0, -KEPT_REFERENCES)) this.#references.delete(oldest);
      const mapAt = hasReference ? pixels : 2 * pixels;
      const difference = measure ? new Float32Array(bytes.slice(mapAt, mapAt + pixels)) : null;
      const reference = /** @type {Uint8ClampedArray} */ (this.#references.get(key));
      said.timings_ms.total = performance.now() - begun;
      return /** @type {Picture} */ ({ ...said, rgba, reference, difference });
    });
  }

  /**
   * CIEDE2000 at every pixel between the pictures of two designs, whole and with noise. Resolves to null as `draw` does.
   * @param {Design} design @param {Design} other @param {string} scene @param {number} luminance @returns {Promise<Float32Array | null>}
   */
  difference(design, other, scene, luminance) {
    return this.#latestPicture.run(async () => {
      const request = async (/** @type {Design} */ of) => ({ design: of, lens: await this.#supply(this.#pictures, of, ["training", { scene }]), scene, luminance_cd_m2: luminance, seed: SEED, thorough: true });
      const [picture, rival] = [await request(design), await request(other)];
      const { bytes } = await this.#pictures.ask("difference", { picture, other: rival });
      return new Float32Array(bytes);
    });
  }

  /**
   * Takes a photograph as a scene, one pixel of it on each pixel of the camera: at most 1024 pixels along a side and 400 000 in all. Its colours
   * become smooth reflectances in daylight (Jakob and Hanika 2019). The scene is added to `scenes`.
   * @param {string} name @param {ImageData} photograph @returns {Promise<Scene>}
   */
  async addPhotograph(name, { width, height, data }) {
    const id = `photograph ${this.scenes.length + 1}`;
    await again(() => this.#gatherer({ scene: id }).keep("photograph", { id, width, height, rgba: data }));
    /** @type {Scene} */
    const scene = { id, name, set: "own" };
    this.scenes.push(scene);
    return scene;
  }

  /**
   * Figures of a design without a picture; without a luminance, those of the array alone. Resolves to null when a newer call of the same asker has taken its
   * place.
   * @param {Design} design @param {number | number[]} luminance cd/m²
   * @param {{ family?: Family, asker?: string }} [wanted] Warnings name filters that are none of the `family`.
   * @returns {Promise<Scores | null>}
   */
  scores(design, luminance, { family, asker } = {}) {
    const luminances_cd_m2 = [luminance].flat();
    return this.#latestScores.run(async () => {
      // The figures of the array alone need no statistics.
      const lens = await this.#supply(this.#figures, design, luminances_cd_m2.length > 0 ? ["statistics"] : []);
      return (await this.#figures.ask("scores", { design, lens, luminances_cd_m2, family })).said;
    }, asker);
  }

  /** @param {Design} design @returns {Promise<Curves>} */
  async curves(design) {
    return (await again(() => this.#figures.ask("curves", { design }))).said;
  }

  /** The transmittances of filters alone. @param {Filter[]} filters @param {[first: number, step: number, last: number]} wavelengths_nm @returns {Promise<number[][]>} */
  async transmittances(filters, wavelengths_nm) {
    const letters = filters.map((_, i) => String.fromCharCode("A".charCodeAt(0) + i));
    const cfa = { pattern: [letters.join("")], filters: Object.fromEntries(letters.map((letter, i) => [letter, filters[i]])) };
    const optics = { transmittance: { flat: 1 }, ir_cut: { flat: 1 } };
    const { channels } = await this.curves({ name: "filters", wavelengths_nm, optics, sensor: { quantum_efficiency: { flat: 1 }, cfa } });
    return letters.map((letter) => channels.find((c) => c.letter === letter)?.transmittance ?? []);
  }

  /**
   * The mean luminance of a scene beyond which a design saturates more than `catalogue.saturated_percent` of the samples, by their mean signals without noise, cd/m²: 0 if
   * it does in any light, infinite if it never does.
   * @param {Design} design @param {string} scene @returns {Promise<number>}
   */
  clipping(design, scene) {
    return again(async () => {
      const lens = await this.#supply(this.#pictures, design, ["training", { scene }]);
      return (await this.#pictures.ask("clipping", { design, lens, scene })).said.luminance_cd_m2 ?? Infinity;
    });
  }

  /**
   * Changes the filters and the cells of a design that are not locked so that it becomes better, starting from it. The filters that are
   * changed are any smooth curves (`free`), pigments, or dichroic bands. Calls `onStep` after each step; ends when no step makes it better, or with the best so
   * far when `signal` is aborted.
   * @param {Design} design @param {Locks} locks @param {number[]} luminances cd/m²
   * @param {(step: Step) => void} onStep @param {AbortSignal} [signal] @param {Family} [family]
   * @returns {Promise<Step>}
   */
  async improve(design, locks, luminances, onStep, signal, family = "free") {
    const lens = await this.#supply(this.#figures, design, ["statistics"]);
    const begin = { design, lens, locks, luminances_cd_m2: luminances, family };
    let { said: step } = await this.#figures.ask("improve", begin);
    onStep(step);
    while (!step.is_done && !signal?.aborted) {
      ({ said: step } = await this.#figures.ask("step", {}));
      onStep(step);
    }
    return step;
  }

  /** The pipeline of a picture as a table (`.l3`), as it was learned for the picture. @param {{ design: Design, luminance: number, seed?: number }} wanted @returns {Promise<Blob>} */
  table({ design, luminance, seed = SEED }) {
    return again(async () => {
      const lens = await this.#supply(this.#pictures, design, ["training"]);
      return new Blob([(await this.#pictures.ask("table", { design, lens, luminance_cd_m2: luminance, seed })).bytes]);
    });
  }

  /** The raw image of a picture as DNG. @param {{ design: Design, scene: string, luminance: number, seed?: number }} wanted @returns {Promise<Blob>} */
  raw({ design, scene, luminance, seed = SEED }) {
    return again(async () => {
      const lens = await this.#supply(this.#pictures, design, ["training", { scene }]);
      return new Blob([(await this.#pictures.ask("raw", { design, lens, scene, luminance_cd_m2: luminance, seed })).bytes]);
    });
  }

  /**
   * The array of a design with another mosaic of the catalogue: that of `CAMERA@MOSAIC` for the camera that was opened, and the same with the filters that were changed by hand.
   * `base` is the array of that camera, `given` the same with the mosaic that was chosen last, `changed` the filters that were changed before that, `array` the present one.
   * `missing` has the letters for which the camera, which has curves of its own, has no filter.
   * @param {{ base: ColorArray, given: ColorArray, changed: object[], array: ColorArray, mosaic: string }} wanted
   * @returns {Promise<{ missing: string[] } | { given: ColorArray, in_full: FullArray, array: FullArray, changed: object[], is_own: boolean }>}
   */
  async mosaic(wanted) {
    return (await again(() => this.#figures.ask("mosaic", wanted))).said;
  }

  /** An array with its tile in letters and with all of its filters. @param {ColorArray} array @returns {Promise<FullArray>} */
  async inFull(array) {
    return (await again(() => this.#figures.ask("in_full", { array }))).said;
  }

  /** The camera file of a design, for all other commands. @param {Design} design @returns {Promise<string>} */
  async cameraToml(design) {
    return (await again(() => this.#figures.ask("camera_toml", { design }))).said.toml;
  }

  /** The design of a camera file; rejects with a message that names line and key. @param {string} text @returns {Promise<Design>} */
  async parse(text) {
    return (await again(() => this.#figures.ask("parse", { text }))).said.design;
  }
}
