// @ts-check
// Heavy work behind the page: the server of the command does it with the native library, over a WebSocket. Messages are JSON, an object with one key;
// files follow the message that announces them, each as a binary message. Without a server, as in an exported folder, there is none of this.
import { announce, byId, make, message, tell } from "./dom.js";
import { asRival } from "./design.js";
import { fileName, save } from "./files.js";
import { text } from "./numbers.js";

/** @typedef {import("./engine.js").Design} Design */
/** A result: what was found, and files by kind. @typedef {{ said: any, files: Record<string, Blob> }} Result */
/** How far a job is. @typedef {{ step: string, done: number, of: number }} Progress */
/**
 * A job at work: its result once it is announced, and the kinds of the files that are still to come.
 * @typedef {{ id: number, result?: Result, kinds: string[], onProgress: (progress: Progress) => void, resolve: (result: Result) => void, reject: (error: Error) => void }} Work
 */
/** What comes with the page: the path of the connection and of the pinned camera, the version of Smalti, and the family of the filters. @typedef {{ native: string | null, most_message_bytes: number, pinned: string | null, version: string, family: import("./engine.js").Family | null }} Offer */

/** What the end of a job by the page is called. */
const CANCELLED = "cancelled";
const LOST = "The server has ended. The page goes on with its own engine; save the design, and start `smalti studio` again for full computations. The menu File still saves a report of this picture";

/** @type {Promise<Offer | undefined> | undefined} */
let known;
/** What comes with the page. @returns {Promise<Offer | undefined>} */
export function offered() {
  known ??= fetch("server.json").then((response) => response.ok ? response.json() : undefined, () => undefined);
  return known;
}

/** The connection. One job is at work at a time. */
export class Native {
  /** @type {WebSocket} */ #socket;
  #limit;
  #next = 1;
  /** @type {Work | undefined} */ #job;

  /** @param {WebSocket} socket @param {number} limit The longest message, bytes. @param {() => void} onLost */
  constructor(socket, limit, onLost) {
    this.#socket = socket;
    this.#limit = limit;
    this.isOpen = true;
    socket.binaryType = "blob";
    socket.onmessage = ({ data }) => this.#receive(data);
    socket.onclose = () => {
      this.isOpen = false;
      this.#end((job) => job.reject(new Error(LOST)));
      onLost();
    };
  }

  /** Connects, if there is a server that offers it. @param {() => void} onLost @returns {Promise<Native | undefined>} */
  static async connect(onLost) {
    const offer = await offered();
    if (!offer?.native) return undefined;
    const address = new URL(offer.native, document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    const socket = new WebSocket(address);
    await new Promise((resolve, reject) => {
      socket.onopen = resolve;
      socket.onerror = () => reject(new Error("The server does not answer"));
    });
    return new Native(socket, offer.most_message_bytes, onLost);
  }

  get isBusy() { return this.#job !== undefined; }

  /** @param {(job: Work) => void} how */
  #end(how) {
    const job = this.#job;
    this.#job = undefined;
    if (job) how(job);
  }

  /** @param {string | Blob} data */
  #receive(data) {
    const job = this.#job;
    if (typeof data !== "string") {
      if (!job?.result) return;
      job.result.files[String(job.kinds.shift())] = data;
      if (job.kinds.length === 0) this.#end(({ resolve, result }) => resolve(/** @type {Result} */ (result)));
      return;
    }
    const { progress, result, cancelled, failed, refused } = JSON.parse(data);
    if (refused) return this.#end(({ reject }) => reject(new Error(refused.message)));
    const said = progress ?? result ?? cancelled ?? failed;
    if (!job || said?.id !== job.id) return;
    if (progress) job.onProgress(progress);
    else if (cancelled) this.#end(({ reject }) => reject(new Error(CANCELLED)));
    else if (failed) this.#end(({ reject }) => reject(new Error(failed.message)));
    else {
      job.result = { said: result.said, files: {} };
      job.kinds = result.files.map((/** @type {{ kind: string }} */ f) => f.kind);
      if (job.kinds.length === 0) this.#end(({ resolve }) => resolve(/** @type {Result} */ (job.result)));
    }
  }

  /**
   * Does a job. Rejects with the reason when it fails, and with "cancelled" once `signal` has ended it.
   * @param {Record<string, any>} job @param {(progress: Progress) => void} onProgress @param {AbortSignal} signal @returns {Promise<Result>}
   */
  run(job, onProgress, signal) {
    if (!this.isOpen) return Promise.reject(new Error(LOST));
    if (this.#job) return Promise.reject(new Error("Another job is at work; one runs at a time"));
    const id = this.#next++;
    const message = JSON.stringify({ start: { id, job } });
    if (new TextEncoder().encode(message).length > this.#limit) return Promise.reject(new Error("The design is larger than the server takes"));
    return new Promise((resolve, reject) => {
      this.#job = { id, kinds: [], onProgress, resolve, reject };
      this.#socket.send(message);
      signal.addEventListener("abort", () => { if (this.isOpen) this.#socket.send(JSON.stringify({ cancel: { id } })); });
    });
  }
}

/** A design as text, whatever its name is. @param {Design | undefined} design */
export const contentOf = (design) => JSON.stringify({ ...design, name: undefined });

/**
 * A line above a result, which shows once the result is out of date. `of` is the text of what the result depends on, `onChange` calls whenever it may be another one.
 * @param {string} text @param {() => string} of @param {(work: () => void) => void} onChange @returns {{ line: HTMLElement, stamp: (made: string | undefined) => void }}
 */
export function outdated(text, of, onChange) {
  const line = make("p", { class: "outdated", hidden: true }, `Out of date: ${text}`);
  /** @type {string | undefined} */
  let last;
  const show = () => { line.hidden = last === undefined || last === of(); };
  onChange(show);
  return { line, stamp(made) { last = made; show(); } };
}

/** @param {unknown} error */
const isCancelled = (error) => error instanceof Error && error.message === CANCELLED;

/**
 * Sets up the panel of full computations and the items of the menu. `shown` is what the page shows, `isOwn` whether its scene is a photograph of the visitor.
 * @param {() => { camera: Design & { name: string }, pinned: (Design & { name: string }) | undefined, scene: string, luminance: number, isOwn: boolean }} shown
 * @param {(work: () => void) => void} onChange Calls when the design or the pinned design has changed.
 * @returns {Promise<{ work: (title: string, job: Record<string, any>) => Promise<Result | undefined>, onChange: (work: () => void) => void } | undefined>}
 */
export async function setUpNative(shown, onChange) {
  const panel = byId("native-panel", HTMLElement);
  const place = byId("native", HTMLDivElement);
  const items = [...document.querySelectorAll("[data-native]")].filter((item) => item instanceof HTMLButtonElement);
  /** @type {AbortController | undefined} */
  let stop;
  // Its begin and end are announced; every step would be too much.
  const state = make("p", { class: "hint", "data-state": "" });
  const bar = make("progress", { "aria-label": "Progress of the computation", hidden: true });
  const cancel = make("button", { type: "button", hidden: true }, "Cancel");
  const show = () => {
    const isIdle = native !== undefined && native.isOpen && stop === undefined;
    for (const item of document.querySelectorAll("[data-native], [data-job]")) item.setAttribute("aria-disabled", String(!isIdle));
    cancel.hidden = stop === undefined;
    bar.hidden = stop === undefined;
  };
  const lost = () => {
    state.textContent = `${LOST}.`;
    tell(`${LOST}.`, "trouble");
    show();
  };
  /** @type {Native | undefined} */
  let native;
  try {
    native = await Native.connect(lost);
  } catch {
    // The server ended in between.
    native = undefined;
  }
  for (const item of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-without-server]"))) item.hidden = native !== undefined;
  if (!native) return undefined;
  panel.hidden = false;
  for (const item of items) item.hidden = false;

  /**
   * Does a job, and tells how far it is. `keep` saves what came of it, and returns the name of the file.
   * @param {string} title @param {Record<string, any>} job @param {(result: Result) => string} [keep] @returns {Promise<Result | undefined>}
   */
  async function work(title, job, keep) {
    if (!native || stop) return undefined;
    if (!native.isOpen) {
      lost();
      return undefined;
    }
    stop = new AbortController();
    const { signal } = stop;
    show();
    bar.removeAttribute("value");
    state.textContent = `${title}…`;
    panel.scrollIntoView({ block: "nearest" });
    announce(`${title} has begun`);
    /** @type {Result | undefined} */
    let result;
    try {
      result = await native.run(job, ({ step, done, of }) => {
        // The job goes on until its present step is done; the page says that it ends.
        if (signal.aborted) return;
        if (of > 0) {
          bar.max = of;
          bar.value = done;
        }
        state.textContent = `${title}: ${[step, of > 0 && `${done} of ${of}`].filter(Boolean).join(", ") || "…"}`;
      }, signal);
      const notes = result.said.notes.map((/** @type {string} */ note) => ` ${note}.`).join("");
      state.textContent = `${title} is done.${keep ? ` The file ${keep(result)} was downloaded.` : ""}${notes}`;
    } catch (error) {
      if (isCancelled(error)) state.textContent = `${title} was cancelled.`;
      else if (native.isOpen) {
        state.textContent = `${title} failed.`;
        tell(`${title}: ${message(error)}.`, "trouble");
      }
    }
    stop = undefined;
    show();
    announce(state.textContent ?? "");
    return result;
  }
  cancel.addEventListener("click", () => {
    stop?.abort();
    state.textContent = "Cancelling…";
  });

  const quality = make("select", {}, make("option", { value: "fast" }, "Fast: one stage"), make("option", { value: "best" }, "Best: two stages"));
  const extent = make("select", {},
    make("option", { value: "here" }, "this scene in this light"),
    make("option", { value: "range" }, "this scene from 1 to 100 cd/m²"),
    make("option", { value: "all" }, "all natural scenes in this light"),
  );
  const button = (/** @type {string} */ label, /** @type {() => void} */ click) => make("button", { type: "button", "data-job": "", click }, label);
  const verdict = make("pre", { class: "verdict", hidden: true });
  const picture = make("figure", { class: "full", hidden: true });
  const ofPicture = () => contentOf(shown().camera);
  const ofReport = () => [shown().camera, shown().pinned].map(contentOf).join();
  const verdictAge = outdated("the design or the pinned design has changed since this report.", ofReport, onChange);
  const pictureAge = outdated("the design has changed since this picture.", ofPicture, onChange);
  place.append(
    make("div", { class: "fields" }, make("label", { class: "field wide" }, make("span", {}, "Pipeline"), quality), make("label", { class: "field wide" }, make("span", {}, "Report on"), extent)),
    make("div", { class: "row" }, button("Full-size picture", takePicture), button("Report", () => saves.report()), cancel),
    bar, state, verdictAge.line, verdict, pictureAge.line, picture,
  );
  state.textContent = "All processors of this computer, the whole simulation and all training scenes.";
  show();

  function refuse() {
    tell("The photograph is in this browser alone. Choose a built-in scene, or save camera.toml and use `smalti simulate camera.toml --scene FILE --luminance LUMINANCE`.", "trouble");
  }

  /** @param {string | null} pipeline */
  function capture(pipeline) {
    const { camera, scene, luminance, isOwn } = shown();
    if (isOwn) {
      refuse();
      return undefined;
    }
    const job = { capture: { design: camera, scene, luminance_cd_m2: luminance, pipeline } };
    const about = `${camera.name}, ${scene}, ${luminance} cd/m²`;
    return { job, about, name: (/** @type {string} */ extension) => fileName(`${camera.name} ${scene} ${luminance}`, extension) };
  }

  async function takePicture() {
    const wanted = capture(quality.value);
    const made = ofPicture();
    const result = wanted && await work("The full-size picture", wanted.job);
    if (!wanted || !result) return;
    const { said, files } = result;
    const address = URL.createObjectURL(files.picture);
    const old = picture.querySelector("img");
    if (old) URL.revokeObjectURL(old.src);
    const { about } = wanted;
    const scores = said.cpsnr_db === null ? "" : ` CPSNR ${text(said.cpsnr_db, 2)} dB, ΔE2000 ${text(said.pixel_delta_e_2000_mean, 2)}, S-CIELAB ${text(said.scielab_mean, 2)}.`;
    const keep = (/** @type {string} */ label, /** @type {string} */ kind, /** @type {string} */ extension) => make("button", { type: "button", click: () => save(wanted.name(extension), files[kind]) }, label);
    picture.replaceChildren(
      make("a", { href: address, target: "_blank", rel: "noopener" }, make("img", { src: address, width: said.cols, height: said.rows, alt: `Full-size picture: ${about}` })),
      make("figcaption", {}, `${about}: ${said.cols} × ${said.rows} pixels, exposed for ${Number(said.exposure_ms.toPrecision(3))} ms.${scores}`),
      make("div", { class: "row" }, keep("Save PNG", "picture", "png"), keep("Save DNG", "raw", "dng"), keep("Save .l3", "table", "l3")),
    );
    picture.hidden = false;
    pictureAge.stamp(made);
    picture.scrollIntoView({ block: "nearest" });
  }

  /** Saves a file, and returns its name. @param {string} name @param {Blob} content */
  function kept(name, content) {
    save(name, content);
    return name;
  }

  /** @type {Record<string, () => Promise<void>>} */
  const saves = {
    async table() {
      const { camera } = shown();
      await work("Learning the table", { table: { design: camera, quality: quality.value } }, ({ files }) => kept(fileName(camera.name, "l3"), files.table));
    },
    async raw() {
      const wanted = capture(null);
      if (wanted) await work("The raw capture", wanted.job, ({ files }) => kept(wanted.name("dng"), files.raw));
    },
    async report() {
      const { camera, pinned, luminance, scene, isOwn } = shown();
      const made = ofReport();
      if (isOwn && extent.value !== "all") return refuse();
      const rival = pinned && asRival(pinned, camera.name);
      const report = {
        design: camera, rival, scene: extent.value === "all" ? null : scene, luminances_cd_m2: extent.value === "range" ? [1, 10, 100] : [luminance],
        quality: quality.value,
      };
      const result = await work("The report", { report }, ({ files }) => kept(fileName(`${camera.name} report`, "html"), files.page));
      if (!result) return;
      verdict.textContent = result.said.verdict.replaceAll(/ {2,}/g, " ");
      verdict.hidden = result.said.verdict === "";
      verdictAge.stamp(verdict.hidden ? undefined : made);
    },
  };
  for (const item of items) item.addEventListener("click", () => saves[String(item.getAttribute("data-native"))]());
  return { work, onChange };
}
