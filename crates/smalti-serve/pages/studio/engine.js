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
// `sensor.rows` and `sensor.cols` say. Pipelines are learned from statistics of light, which hold for a mosaic without crosstalk and binning.
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
 * @property {Record<string, any>} [optics]
 * @property {{ quantum_efficiency?: Filter, pixel?: Record<string, number>, cfa?: { pattern?: string | string[],
 *   filters?: Record<string, Filter>, mixtures?: Record<string, Record<string, number>> }, [key: string]: any }} [sensor]
 * @property {Record<string, any>} [exposure]
 * @property {Record<string, any>} [isp]
 */

/** A scene; `file` is its light, if it came with the page. @typedef {{ id: string, name: string, set: "charts" | "natural" | "own", file?: string | null }} Scene */
/** @typedef {{ row: number, col: number, rows: number, cols: number }} Crop */

/** The camera whose light came with the page, without its mosaic. @typedef {{ id: string, name: string, camera: Design }} Setup */

/**
 * A warning about a design. `filter` is the letter of the filter that it is about.
 * @typedef {{ key: string, message: string, filter?: string }} Warning
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
 * that is shown. `exposure_ms` is the time of the exposure.
 * @typedef {object} Picture
 * @property {number} width @property {number} height
 * @property {Uint8ClampedArray} rgba @property {Uint8ClampedArray} reference
 * @property {PictureScores | null} scores @property {Float32Array | null} difference
 * @property {Crop} crop @property {number} exposure_ms @property {number} saturated_percent
 * @property {Warning[]} warnings
 * @property {{ learn: number, draw: number, score: number, total: number }} timings_ms
 */

/**
 * Expected figures of the best linear pipeline, in closed form (docs/designs.md), at a luminance.
 * @typedef {{ luminance_cd_m2: number, cpsnr_db: number, detail_db: number, delta_e_2000: number, scielab: number, time_s: number }} Expected
 */

/**
 * The derivatives of an expected figure with respect to the transmittance of each filter at each wavelength of `wavelengths_nm`, by letter.
 * @typedef {Record<string, number[]>} Derivative
 */

/**
 * Scores of a design without a picture. `array` has the figures of the array alone, as `smalti evaluate` prints them.
 * @typedef {object} Scores
 * @property {Expected[]} expected One for each luminance.
 * @property {{ vora_value: number, sensitivity_metamerism_index: number, metamer_mismatch_percent: number, photon_efficiency: number,
 *   condition_number: number | null, luminance_noise_gain: number }} array
 * @property {number[]} wavelengths_nm
 * @property {{ cpsnr_db: Derivative, delta_e_2000: Derivative } | null} derivatives At the first luminance.
 * @property {Warning[]} warnings
 */

/**
 * Curves over `wavelengths_nm`. `quantum_efficiency` is electrons per photon behind the filter, the infrared cut and the lens; `color` is
 * the filter as the standard observer sees it before the light, sRGB.
 * @typedef {object} Curves
 * @property {number[]} wavelengths_nm
 * @property {{ letter: string, transmittance: number[], quantum_efficiency: number[], color: string }[]} channels
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

const NOTHING_NEWER = null;
/** Lenses whose light a worker holds beside that of the start: those of the design and of the pinned one, and one more. */
const HELD_LENSES = 3;
/** References that are kept, about 0.5 MB each. */
const KEPT_REFERENCES = 24;


/** A worker with the module. Requests are answered in turn. */
class Bench {
  /** @type {Worker} */ #worker;
  /** @type {Map<number, { resolve: (value: any) => void, reject: (reason: Error) => void }>} */ #open = new Map();
  #next = 0;
  /** The light that was handed to the worker, by the name of its lens, the lens used last at the end. @type {Map<string, Set<string>>} */
  #lenses = new Map();

  constructor() {
    this.#worker = new Worker(new URL("engine-worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => {
      const waiting = this.#open.get(data.id);
      this.#open.delete(data.id);
      if (data.error === undefined) waiting?.resolve(data.result);
      else waiting?.reject(new Error(data.error));
    };
    this.#worker.onerror = (event) => this.#fail(event.message || "this browser does not allow Web Workers");
  }

  /** @param {string} message */
  #fail(message) {
    for (const { reject } of this.#open.values()) reject(new Error(message));
    this.#open.clear();
  }

  /**
   * @param {string} task @param {any} content @param {Transferable[]} [transfer]
   * @returns {Promise<any>}
   */
  ask(task, content, transfer = []) {
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#open.set(id, { resolve, reject });
      this.#worker.postMessage({ id, task, content }, transfer);
    });
  }

  /**
   * Hands light to the worker, unless it has it. Light behind lenses that were not used for long is forgotten.
   * @param {string} lens @param {LightOf} of @param {() => Promise<ArrayBuffer>} light
   */
  async supply(lens, of, light) {
    const held = this.#lenses.get(lens) ?? new Set();
    this.#lenses.delete(lens);
    this.#lenses.set(lens, held);
    for (const oldest of [...this.#lenses.keys()].filter((name) => name !== START).slice(0, -HELD_LENSES)) {
      this.#lenses.delete(oldest);
      await this.ask("forget", { lens: oldest });
    }
    const key = JSON.stringify(of);
    if (held.has(key)) return;
    await this.ask("put", { lens, kind: typeof of === "string" ? of : "scene", bytes: await light() });
    held.add(key);
  }

  stop() {
    this.#worker.terminate();
    this.#fail("stopped");
  }
}

/** One request at work and at most one that waits: a newer one takes its place. */
class Latest {
  /** @type {{ work: () => Promise<any>, resolve: (value: any) => void, reject: (reason: unknown) => void } | null} */ #waiting = null;
  #is_busy = false;

  /**
   * The result of `work`, or null when a newer request came before its turn.
   * @template T @param {() => Promise<T>} work @returns {Promise<T | null>}
   */
  run(work) {
    return new Promise((resolve, reject) => {
      this.#waiting?.resolve(NOTHING_NEWER);
      this.#waiting = { work, resolve, reject };
      if (!this.#is_busy) this.#go();
    });
  }

  async #go() {
    this.#is_busy = true;
    while (this.#waiting) {
      const { work, resolve, reject } = this.#waiting;
      this.#waiting = null;
      try {
        resolve(await work());
      } catch (error) {
        reject(error);
      }
    }
    this.#is_busy = false;
  }
}

/** Draws, scores and improves designs. */
export class Engine {
  /** @type {Bench} */ #pictures;
  /** @type {Bench} */ #figures;
  #latest_picture = new Latest();
  #latest_scores = new Latest();
  /** @type {Map<string, Uint8ClampedArray>} */ #references = new Map();
  /** Workers that gather light: for pictures, and statistics, which take longer. @type {Map<string, Promise<Bench>>} */
  #gatherers = new Map();
  /** @type {() => Promise<Bench>} */ #start_worker;
  /** @type {Lights} */ #lights;
  /** The file of the statistics, if it came with the page. @type {string | null} */ #statistics;

  /**
   * @param {Bench} pictures @param {Bench} figures @param {() => Promise<Bench>} start_worker
   * @param {{ scenes: Scene[], setups: Setup[], statistics: string | null, catalogue: any }} about
   */
  constructor(pictures, figures, start_worker, about) {
    this.#pictures = pictures;
    this.#figures = figures;
    this.#start_worker = start_worker;
    this.#lights = new Lights(about.setups[0].camera, async (of, design) => (await (await this.#gatherer(of)).ask("light", { of, design })).bytes);
    this.#statistics = about.statistics;
    /** The scenes, first the one that is ready first. @type {Scene[]} */
    this.scenes = about.scenes;
    /** The camera whose light came with the page. @type {Setup[]} */
    this.setups = about.setups;
    /**
     * Built-in mosaics with their other names, tiles and default filters, the built-in filters by name, the built-in cameras, the least and
     * the largest value of each key, and the smallest relevant difference of each score.
     * @type {{ cfas: { name: string, aliases?: string[], tile: string[], filters: Record<string, Filter> }[], filters: string[], cameras: Design[],
     *   ranges: Record<string, [number, number]>, relevances: Record<string, { absolute?: number, relative?: number }> }}
     */
    this.catalogue = about.catalogue;
  }

  /**
   * Loads the module and what the first picture needs; the other scenes follow in the background. `assets_url` ends with "/" and has
   * `manifest.json`, the files that it names, and `studio.wasm.deflate`.
   * @param {string | URL} assets_url @returns {Promise<Engine>}
   */
  static async start(assets_url) {
    if (typeof WebAssembly !== "object") throw new Error("this browser does not allow WebAssembly");
    const base = String(new URL(assets_url, document.baseURI));
    // The module is compiled once, for all workers.
    const compiled = inflated(new URL("studio.wasm.deflate", base)).then((bytes) => WebAssembly.compile(bytes));
    const manifest = await (await fetched(new URL("manifest.json", base))).json();
    const start_worker = async () => {
      const bench = new Bench();
      await bench.ask("start", { base, manifest, module: await compiled });
      return bench;
    };
    const [pictures, figures] = await Promise.all([start_worker(), start_worker()]);
    const catalogue = (await figures.ask("catalogue", {})).said;
    return new Engine(pictures, figures, start_worker, { ...manifest, catalogue });
  }

  /** The worker that gathers some light, started when it is first needed. @param {LightOf} of @returns {Promise<Bench>} */
  #gatherer(of) {
    const kind = of === "statistics" ? "statistics" : "pictures";
    const started = this.#gatherers.get(kind) ?? this.#start_worker();
    this.#gatherers.set(kind, started);
    return started;
  }

  /** Whether some light came with the page. @param {Design} design @param {LightOf} of */
  #came(design, of) {
    const file = typeof of === "object" ? this.scenes.find((s) => s.id === of.scene)?.file : of === "statistics" ? this.#statistics : true;
    return this.#lights.lens(design) === START && Boolean(file);
  }

  /**
   * Gathers the light behind the lens of a design, which takes seconds once for each lens; `undefined` when it need not be waited for.
   * @param {Design} design @param {LightOf[]} all @returns {Promise<void> | undefined}
   */
  light(design, all) {
    const missing = all.filter((of) => !this.#came(design, of) && !this.#lights.has(design, of));
    if (missing.length === 0) return undefined;
    return Promise.all(missing.map((of) => this.#lights.get(design, of))).then(() => {});
  }

  /** Hands light to a worker, and returns the name of its lens. @param {Bench} bench @param {Design} design @param {LightOf[]} all */
  async #supply(bench, design, all) {
    const lens = this.#lights.lens(design);
    for (const of of all) if (!this.#came(design, of)) await bench.supply(lens, of, () => this.#lights.get(design, of));
    return lens;
  }

  /**
   * What a design makes of a scene at a mean luminance, with the pipeline that is learned for it from statistics of light. Without
   * `crop`, the whole scene; with it, the same pixels of the same picture. `measure` asks for scores and the map of differences, which take longer than the picture. Resolves to
   * null when a newer call has taken its place. Rejects with a message that names the key when the design is impossible.
   * @param {{ design: Design, scene: string, luminance: number, crop?: Crop, measure?: boolean, noise?: boolean, seed?: number }} wanted
   * @returns {Promise<Picture | null>}
   */
  draw({ design, scene, luminance, crop, measure = false, noise = true, seed = 0 }) {
    return this.#latest_picture.run(async () => {
      const begun = performance.now();
      const lens = await this.#supply(this.#pictures, design, ["training", { scene }]);
      const key = JSON.stringify([scene, crop ?? null, lens]);
      const has_reference = this.#references.has(key);
      const request = { design, lens, scene, luminance_cd_m2: luminance, crop, measure, noise, seed, reference: !has_reference };
      const { said, bytes } = await this.#pictures.ask("draw", request);
      const pixels = 4 * said.width * said.height;
      const rgba = new Uint8ClampedArray(bytes, 0, pixels);
      if (!has_reference) this.#references.set(key, new Uint8ClampedArray(bytes.slice(pixels, 2 * pixels)));
      for (const oldest of [...this.#references.keys()].slice(0, -KEPT_REFERENCES)) this.#references.delete(oldest);
      const map_at = has_reference ? pixels : 2 * pixels;
      const difference = measure ? new Float32Array(bytes.slice(map_at, map_at + pixels)) : null;
      const reference = /** @type {Uint8ClampedArray} */ (this.#references.get(key));
      said.timings_ms.total = performance.now() - begun;
      return /** @type {Picture} */ ({ ...said, rgba, reference, difference });
    });
  }

  /**
   * Takes a photograph as a scene, one pixel of it on each pixel of the camera: at most 1024 pixels along a side and 400 000 in all. Its colours
   * become smooth reflectances in daylight (Jakob and Hanika 2019). The scene is added to `scenes`.
   * @param {string} name @param {ImageData} photograph @returns {Promise<Scene>}
   */
  async add_photograph(name, { width, height, data }) {
    const id = `photograph ${this.scenes.length + 1}`;
    await (await this.#gatherer({ scene: id })).ask("photograph", { id, width, height, rgba: data });
    /** @type {Scene} */
    const scene = { id, name, set: "own" };
    this.scenes.push(scene);
    return scene;
  }

  /**
   * Figures of a design without a picture; without a luminance, those of the array alone. Resolves to null when a newer call has taken its place.
   * @param {Design} design @param {number | number[]} luminance cd/m²
   * @param {{ derivatives?: boolean, family?: Family }} [wanted] Warnings name filters that are none of the `family`.
   * @returns {Promise<Scores | null>}
   */
  scores(design, luminance, { derivatives = false, family } = {}) {
    const luminances_cd_m2 = [luminance].flat();
    return this.#latest_scores.run(async () => {
      // The figures of the array alone need no statistics.
      const lens = await this.#supply(this.#figures, design, luminances_cd_m2.length > 0 ? ["statistics"] : []);
      return (await this.#figures.ask("scores", { design, lens, luminances_cd_m2, derivatives, family })).said;
    });
  }

  /** @param {Design} design @returns {Promise<Curves>} */
  async curves(design) {
    return (await this.#figures.ask("curves", { design })).said;
  }

  /**
   * Changes the filters and the cells of a design that are not locked so that it becomes better, starting from it. The filters that are
   * changed are any smooth curves (`free`), pigments, or dichroic bands. Calls `on_step` after each step; ends when no step makes it better, or with the best so
   * far when `signal` is aborted.
   * @param {Design} design @param {Locks} locks @param {number[]} luminances cd/m²
   * @param {(step: Step) => void} on_step @param {AbortSignal} [signal] @param {Family} [family]
   * @returns {Promise<Step>}
   */
  async improve(design, locks, luminances, on_step, signal, family = "free") {
    const lens = await this.#supply(this.#figures, design, ["statistics"]);
    const begin = { design, lens, locks, luminances_cd_m2: luminances, family };
    let { said: step } = await this.#figures.ask("improve", begin);
    on_step(step);
    while (!step.is_done && !signal?.aborted) {
      ({ said: step } = await this.#figures.ask("step", {}));
      on_step(step);
    }
    return step;
  }

  /** The camera file of a design, for all other commands. @param {Design} design @returns {Promise<string>} */
  async camera_toml(design) {
    return (await this.#figures.ask("camera_toml", { design })).said.toml;
  }

  /** The design of a camera file; rejects with a message that names line and key. @param {string} text @returns {Promise<Design>} */
  async parse(text) {
    return (await this.#figures.ask("parse", { text })).said.design;
  }

  /** Ends the workers. */
  stop() {
    this.#pictures.stop();
    this.#figures.stop();
    for (const started of this.#gatherers.values()) started.then((bench) => bench.stop(), () => {});
  }
}
