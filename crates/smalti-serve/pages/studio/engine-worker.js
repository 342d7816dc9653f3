// @ts-check
// A worker with the library as WebAssembly. It sees nothing of the page.

/** @type {any} */
let wasm;
/** @type {string} */
let base;
/** @type {{ scenes: { id: string, file: string }[], [key: string]: any }} */
let manifest;
/** Files that are loaded or on their way. @type {Map<string, Promise<void>>} */
const loaded = new Map();

/** @param {string} name @returns {Promise<ArrayBuffer>} */
async function inflated(name) {
  const response = await fetch(new URL(name, base));
  if (!response.ok || !response.body) throw new Error(`${name} is missing: ${response.status}`);
  return new Response(response.body.pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
}

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

const [TRAINING, SCENE, STATISTICS] = [0, 1, 2];

/** Hands a file of the assets to the module, once. @param {string} name @param {number} kind */
function load(name, kind) {
  let loading = loaded.get(name);
  if (!loading) {
    loading = inflated(name).then((bytes) => {
      put(new Uint8Array(bytes));
      checked(wasm.load(kind));
    });
    loading.catch(() => loaded.delete(name));
    loaded.set(name, loading);
  }
  return loading;
}

/** @param {ArrayBuffer} a @param {ArrayBuffer} b @returns {ArrayBuffer} */
function joined(a, b) {
  const all = new Uint8Array(a.byteLength + b.byteLength);
  all.set(new Uint8Array(a));
  all.set(new Uint8Array(b), a.byteLength);
  return all.buffer;
}

/** Photographs of the visitor, by name. @type {Set<string>} */
const photographs = new Set();

/** Hands the light of a scene to the module. @param {string} id */
async function load_scene(id) {
  if (photographs.has(id)) return;
  const scene = manifest.scenes.find((s) => s.id === id);
  if (!scene) throw new Error(`there is no scene ${id}`);
  await load(scene.file, SCENE);
}

/** @type {Record<string, (content: any) => Promise<any>>} */
const tasks = {
  start: async (content) => {
    base = content.base;
    const [text, module] = await Promise.all([fetch(new URL("manifest.json", base)), inflated("studio.wasm.deflate")]);
    if (!text.ok) throw new Error(`manifest.json is missing: ${text.status}`);
    manifest = await text.json();
    wasm = (await WebAssembly.instantiate(module)).instance.exports;
    return { ...manifest, catalogue: ask("catalogue", {}).said };
  },
  draw: async ({ measure, ...content }) => {
    await Promise.all([load(manifest.training, TRAINING), load_scene(content.scene)]);
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
    return { said: { ...learned, ...said, scores: measured?.said ?? null, timings_ms: { learn, draw, score: score ?? 0 } }, bytes: all };
  },
  photograph: async ({ id, width, height, rgba }) => {
    await load(manifest.training, TRAINING);
    const name = new TextEncoder().encode(id);
    put(name, rgba);
    checked(wasm.photograph(name.byteLength, height, width));
    photographs.add(id);
    return {};
  },
  scores: async (content) => {
    await load(manifest.statistics, STATISTICS);
    return ask("scores", content);
  },
  curves: async (content) => ask("curves", content),
  improve: async (content) => {
    await load(manifest.statistics, STATISTICS);
    return ask("improve", content);
  },
  step: async (content) => ask("step", content),
  camera_toml: async (content) => ask("camera_toml", content),
  parse: async (content) => ask("parse", content),
};

self.onmessage = async ({ data }) => {
  try {
    const result = await tasks[data.task](data.content);
    self.postMessage({ id: data.id, result }, { transfer: result?.bytes ? [result.bytes] : [] });
  } catch (error) {
    self.postMessage({ id: data.id, error: error instanceof Error ? error.message : String(error) });
  }
};
