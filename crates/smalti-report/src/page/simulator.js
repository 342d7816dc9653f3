// The simulator in a worker: WebAssembly that draws what a design makes of a scene, as the command does, bit by bit.

// What the worker runs; it sees nothing of the page.
function simulate() {
  let wasm;
  const put = (...parts) => {
    let at = wasm.reserve(parts.reduce((sum, part) => sum + part.byteLength, 0));
    for (const part of parts) {
      new Uint8Array(wasm.memory.buffer).set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), at);
      at += part.byteLength;
    }
  };
  const output = () => new Uint8Array(wasm.memory.buffer).slice(wasm.output(), wasm.output() + wasm.output_bytes());
  const checked = (result) => {
    if (result < 0) throw new Error(new TextDecoder().decode(output()));
    return result;
  };
  const text = (value) => new TextEncoder().encode(JSON.stringify(value));
  const tasks = {
    start: async ({ module }) => { wasm = (await WebAssembly.instantiate(module)).instance.exports; },
    study: ({ study }) => {
      put(text(study));
      return checked(wasm.study());
    },
    setup: ({ study, condition, isLearned, light, planes }) => {
      const words = text(light);
      put(words, ...planes);
      return checked(wasm.setup(study, condition, isLearned, words.byteLength));
    },
    draw: ({ number, scene, isNoisy }) => {
      const start = performance.now();
      checked(wasm.draw(number, scene, isNoisy));
      return { rgba: output(), ms: performance.now() - start };
    },
  };
  self.onmessage = async ({ data }) => {
    try {
      self.postMessage({ result: await tasks[data.task](data) });
    } catch (error) {
      self.postMessage({ error: error.message });
    }
  };
}

// One at a time, in turn. Studies and setups are handed over when first needed.
class Simulator {
  constructor(trials) {
    this.trials = trials;
    this.last = Promise.resolve();
    this.studies = new Map();
    this.section = null;
  }

  // What a design makes of a scene, RGBA, and how long it took; null where it is no longer wanted when its turn comes.
  draw(row, scene, isNoisy, isWanted) {
    const picture = this.last.then(async () => {
      if (!isWanted()) return null;
      this.worker ??= await Simulator.started();
      const section = this.trials.section[row];
      if (section !== this.section) await this.enter(section);
      return Simulator.asked(this.worker, { task: "draw", number: this.trials.number[row], scene, isNoisy });
    });
    this.last = picture.catch(() => {});
    return picture;
  }

  static async started() {
    if (typeof WebAssembly !== "object") throw new Error("this browser does not allow WebAssembly");
    const url = URL.createObjectURL(new Blob([`(${simulate})()`], { type: "text/javascript" }));
    const worker = new Worker(url);
    try {
      const module = await inflated(JSON.parse(document.getElementById("simulator").textContent));
      await Simulator.asked(worker, { task: "start", module });
    } catch (error) {
      worker.terminate();
      throw error;
    } finally {
      URL.revokeObjectURL(url);
    }
    return worker;
  }

  static asked(worker, message) {
    return new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => (data.error === undefined ? resolve(data.result) : reject(new Error(data.error)));
      worker.onerror = () => reject(new Error("this browser does not allow Web Workers"));
      worker.postMessage(message);
    });
  }

  async enter(section) {
    this.section = null;
    const { study, drawn } = this.trials.data.sections[section];
    const { light, condition, is_learned: isLearned, optical_setup: opticalSetup } = drawn;
    if (!this.studies.has(study)) this.studies.set(study, await Simulator.asked(this.worker, { task: "study", study: this.trials.data.studies[study].study }));
    const count = light.scenes.length + (light.training ? 3 : 0);
    const planes = await Promise.all(this.trials.opticalSetups[opticalSetup].planes.slice(0, count).map(unpackPictures));
    await Simulator.asked(this.worker, { task: "setup", study: this.studies.get(study), condition, isLearned, light, planes });
    this.section = section;
  }
}
