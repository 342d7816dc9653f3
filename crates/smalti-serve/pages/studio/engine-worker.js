// @ts-check
// A worker with the library as WebAssembly. It sees nothing of the page.
import { fetched, inflated } from "./fetched.js";

/** @type {any} */
let wasm;
/** @type {string} */
let base;
/** @type {{ scenes: { id: string, file: string | null, source: string | null }[], training_sources: Record<string, string>, [key: string]: any }} */
let manifest;
/** Files that are loaded or on their way. @type {Map<string, Promise<void>>} */
const loaded = new Map();

/** @param {(Uint8Array | Uint8ClampedArray)[]} parts */
function put(...parts) {
  let at = wasm.reserve(parts.reduce((sum, part) => sum + part.byteLength, 0));
  for (const part of parts) {
    new Uint8Array(wasm.memory.buffer).set(part, at);
    at += part.byteLength;
  }
}

/** The answer of the module: JSON, and bytes behind it. @returns {{ said: any, bytes: ArrayBuffer }} */
function answer() {
  const all = new Uint8Array(wasm.memory.buffer, wasm.output(), wasm.output_bytes());
  const length = new DataView(all.buffer, all.byteOffset).getUint32(0, true);
  const said = JSON.parse(new TextDecoder().decode(all.slice(4, 4 + length)));
  return { said, bytes: all.slice(4 + length).buffer };
}

/** @param {number} result */
function checked(result) {
  if (result < 0) throw new Error(new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, wasm.output(), wasm.output_bytes()).slice()));
}

/** @param {string} task @param {any} content */
function ask(task, content) {
  put(new TextEncoder().encode(JSON.stringify({ [task]: content })));
  checked(wasm.ask());
  return answer();
}

/** The kinds of files of the module. */
const KINDS = { training: 0, scene: 1, statistics: 2 };

/** Work on a file that is done once. @param {string} name @param {() => Promise<void>} work */
function once(name, work) {
  let loading = loaded.get(name);
  if (!loading) {
    loading = work();
    loading.catch(() => loaded.delete(name));
    loaded.set(name, loading);
  }
  return loading;
}

/** Hands light behind a lens to the module. @param {string} lens @param {keyof typeof KINDS} kind @param {ArrayBuffer} bytes */
function take(lens, kind, bytes) {
  const name = new TextEncoder().encode(lens);
  put(name, new Uint8Array(bytes));
  checked(wasm.load(KINDS[kind], name.byteLength));
}

/** Hands a file of the page to the module. @param {string} file @param {keyof typeof KINDS} kind */
const load = (file, kind) => once(file, async () => take("", kind, await inflated(new URL(file, base))));

/** Hands what light is gathered from to the module. @param {string} name @param {string} file */
const source = (name, file) => once(file, async () => {
  const bytes = new Uint8Array(await (await fetched(new URL(file, base))).arrayBuffer());
  const text = new TextEncoder().encode(name);
  put(text, bytes);
  checked(wasm.source(text.byteLength));
});

/** @param {ArrayBuffer} a @param {ArrayBuffer} b @returns {ArrayBuffer} */
function joined(a, b) {
  const all = new Uint8Array(a.byteLength + b.byteLength);
  all.set(new Uint8Array(a));
  all.set(new Uint8Array(b), a.byteLength);
  return all.buffer;
}

/** A scene of the page; `undefined` for a photograph of the visitor. @param {string} id */
const sceneOf = (id) => manifest.scenes.find((s) => s.id === id);

/** Hands the statistics to the module that came with the page; others were put here before. @param {string} lens */
async function loadStatistics(lens) {
  if (lens === "" && manifest.statistics) await load(manifest.statistics, "statistics");
}

/** Hands to the module what pictures of a scene are made from. @param {{ lens: string, scene: string }} wanted */
async function loadPictures({ lens, scene }) {
  // Light that did not come with the page was put here before.
  if (lens !== "") return;
  const file = sceneOf(scene)?.file;
  await Promise.all([load(manifest.training, "training"), file && load(file, "scene")]);
}

/** @type {Record<string, (content: any) => Promise<any>>} */
const tasks = {
  start: async (content) => {
    ({ base, manifest } = content);
    wasm = (await WebAssembly.instantiate(/** @type {WebAssembly.Module} */ (content.module))).exports;
  },
  catalogue: async (content) => ask("catalogue", content),
  put: async ({ lens, kind, bytes }) => take(lens, kind, bytes),
  forget: async (content) => ask("forget", content),
  light: async ({ of, design }) => {
    if (of === "statistics") await Promise.all(Object.entries(manifest.training_sources).map(([name, file]) => source(name, file)));
    const file = of.scene && sceneOf(of.scene)?.source;
    if (file) await source(of.scene, file);
    return ask("light", { of, design });
  },
  draw: async ({ measure, ...content }) => {
    await loadPictures(content);
    const times = [performance.now()];
    const timed = (/** @type {string} */ part) => {
      const result = ask(part, content);
      times.push(performance.now());
      return result;
    };
    const { said: learned } = timed("learn");
    const { said, bytes } = timed("draw");
    const measured = measure ? timed("measure") : null;
    const [learn, draw, score] = times.slice(1).map((time, i) => time - times[i]);
    const all = measured ? joined(bytes, measured.bytes) : bytes;
    const warnings = [...said.warnings, ...measured?.said.warnings ?? []];
    return { said: { ...learned, ...said, warnings, scores: measured?.said ?? null, timings_ms: { learn, draw, score: score ?? 0 } }, bytes: all };
  },
  clipping: async (content) => {
    await loadPictures(content);
    return ask("clipping", content);
  },
  difference: async ({ picture, other }) => {
    await Promise.all([loadPictures(picture), loadPictures(other)]);
    return ask("difference", { picture, other });
  },
  table: async (content) => {
    if (content.lens === "") await load(manifest.training, "training");
    return ask("table", content);
  },
  raw: async (content) => {
    await loadPictures(content);
    return ask("raw", content);
  },
  photograph: async ({ id, width, height, rgba }) => {
    const name = new TextEncoder().encode(id);
    put(name, rgba);
    checked(wasm.photograph(name.byteLength, height, width));
  },
  scores: async (content) => {
    if (content.luminances_cd_m2.length > 0) await loadStatistics(content.lens);
    return ask("scores", content);
  },
  curves: async (content) => ask("curves", content),
  improve: async (content) => {
    await loadStatistics(content.lens);
    return ask("improve", content);
  },
  step: async (content) => ask("step", content),
  mosaic: async (content) => ask("mosaic", content),
  in_full: async (content) => ask("in_full", content),
  camera_toml: async (content) => ask("camera_toml", content),
  parse: async (content) => ask("parse", content),
};

self.onmessage = async ({ data }) => {
  try {
    const result = await tasks[data.task](data.content);
    self.postMessage({ id: data.id, result: result ?? {} }, { transfer: result?.bytes ? [result.bytes] : [] });
  } catch (error) {
    // After a trap, such as that of an allocation without memory, the module is in no known state.
    self.postMessage({ id: data.id, error: error instanceof Error ? error.message : String(error), isTrap: error instanceof WebAssembly.RuntimeError });
  }
};
