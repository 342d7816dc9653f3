// @ts-check
// A worker with the module, which is started again when it fails, and the order of requests to it.
import { START } from "./lights.js";

/** @typedef {import("./lights.js").LightOf} LightOf */

const NOTHING_NEWER = null;
/** Lenses whose light a worker holds beside that of the start: those of the design and of the pinned one, and one more. */
const HELD_LENSES = 3;

/** The end of a worker: its module trapped, for example without memory, or its script failed. */
export class WorkerEnded extends Error {}

/**
 * A worker with the module. Requests are answered in turn. When the module traps, nothing that it holds can be trusted: the worker is ended, what waits for it
 * is rejected with `WorkerEnded`, and the next request starts another worker, which receives the light and the photographs again.
 */
export class Bench {
  /** @type {() => Promise<any>} */ #content;
  /** @type {(message: string) => void} */ #told;
  /** @type {Worker | undefined} */ #worker;
  /** Fulfilled once the worker has its module. @type {Promise<void> | undefined} */ #ready;
  /** @type {Map<number, { resolve: (value: any) => void, reject: (reason: Error) => void }>} */ #open = new Map();
  #next = 0;
  /** The light that was handed to the worker, by the name of its lens, the lens used last at the end. @type {Map<string, Set<string>>} */
  #lenses = new Map();
  /** Requests whose effect another worker needs as well. @type {{ task: string, content: any }[]} */
  #kept = [];

  /** @param {() => Promise<any>} content What the worker starts with. @param {(message: string) => void} told Hears of the end of a worker that had started. */
  constructor(content, told) {
    this.#content = content;
    this.#told = told;
  }

  /** @param {Error} error */
  #end(error) {
    this.#worker?.terminate();
    this.#worker = undefined;
    this.#ready = undefined;
    this.#lenses.clear();
    const open = [...this.#open.values()];
    this.#open.clear();
    for (const { reject } of open) reject(error);
  }

  async #begin() {
    const worker = new Worker(new URL("engine-worker.js", import.meta.url), { type: "module" });
    this.#worker = worker;
    let hasStarted = false;
    const end = (/** @type {Error} */ error) => {
      if (this.#worker !== worker) return;
      this.#end(error);
      if (hasStarted) this.#told(error.message);
    };
    worker.onmessage = ({ data }) => {
      if (data.isTrap) return end(new WorkerEnded(`the simulator failed: ${data.error}`));
      const waiting = this.#open.get(data.id);
      this.#open.delete(data.id);
      if (data.error === undefined) waiting?.resolve(data.result);
      else waiting?.reject(new Error(data.error));
    };
    worker.onerror = (event) => end(new WorkerEnded(`the simulator failed: ${event.message || "this browser does not allow Web Workers"}`));
    try {
      await this.#send("start", await this.#content());
      for (const { task, content } of this.#kept) await this.#send(task, content);
    } catch (error) {
      end(error instanceof Error ? error : new Error(String(error)));
      throw error;
    }
    hasStarted = true;
  }

  /** Starts a worker, if there is none. @returns {Promise<void>} */
  start() {
    this.#ready ??= this.#begin();
    return this.#ready;
  }

  /** @param {string} task @param {any} content @returns {Promise<any>} */
  #send(task, content) {
    return new Promise((resolve, reject) => {
      if (!this.#worker) return reject(new WorkerEnded("the simulator failed"));
      const id = this.#next++;
      this.#open.set(id, { resolve, reject });
      this.#worker.postMessage({ id, task, content });
    });
  }

  /** The answer to a request, from a worker that is started if there is none. @param {string} task @param {any} content @returns {Promise<any>} */
  async ask(task, content) {
    await this.start();
    return this.#send(task, content);
  }

  /** As `ask`, for a request that is repeated when another worker has to be started. @param {string} task @param {any} content */
  async keep(task, content) {
    const result = await this.ask(task, content);
    this.#kept.push({ task, content });
    return result;
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
}

/** One request at work and, for each asker, at most one that waits: a newer one of the same asker takes its place. */
export class Latest {
  /** @type {Map<string, { work: () => Promise<any>, resolve: (value: any) => void, reject: (reason: unknown) => void }>} */ #waiting = new Map();
  #isBusy = false;

  /**
   * The result of `work`, or null when a newer request of the same asker came before its turn. Work that the end of a worker interrupts is done once more.
   * @template T @param {() => Promise<T>} work @param {string} [asker] @returns {Promise<T | null>}
   */
  run(work, asker = "") {
    return new Promise((resolve, reject) => {
      this.#waiting.get(asker)?.resolve(NOTHING_NEWER);
      this.#waiting.set(asker, { work, resolve, reject });
      if (!this.#isBusy) this.#go();
    });
  }

  async #go() {
    this.#isBusy = true;
    for (;;) {
      const [next] = this.#waiting;
      if (!next) break;
      const [asker, { work, resolve, reject }] = next;
      this.#waiting.delete(asker);
      try {
        resolve(await again(work));
      } catch (error) {
        reject(error);
      }
    }
    this.#isBusy = false;
  }
}

/** The result of `work`, which is done once more when a worker ended meanwhile. @template T @param {() => Promise<T>} work @returns {Promise<T>} */
export async function again(work) {
  try {
    return await work();
  } catch (error) {
    if (!(error instanceof WorkerEnded)) throw error;
    return work();
  }
}
