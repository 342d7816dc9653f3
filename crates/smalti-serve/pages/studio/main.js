// @ts-check
// The studio: starts the engine, opens a design, and joins the parts of the page.
import { announce, atFrame, byId, make, message, setUpMessages, tell, untell } from "./dom.js";
import { withValue } from "./design.js";
import { Engine } from "./engine.js";
import { curvesCsv, fileName, save } from "./files.js";
import { setUpFilters } from "./filters.js";
import { familyOf, setUpImprove } from "./improve.js";
import { setUpMosaic } from "./mosaic.js";
import { shortened } from "./kinds.js";
import { offered, setUpNative } from "./native.js";
import { readPhotograph } from "./photographs.js";
import { opened, setUpOpening } from "./opening.js";
import { setUpOwnFiles } from "./own-files.js";
import { setUpPicture } from "./picture.js";
import { setUpReport } from "./report.js";
import { setUpScores } from "./scores.js";
import { lensText, refusedByCommands, setUpSensor, simulated } from "./sensor.js";
import { PHOTOGRAPH, fragmentOf } from "./share.js";
import { Store } from "./store.js";
import { setUpSweep } from "./sweep.js";
import { setUpTheme } from "./theme.js";
import { thicknessComments } from "./thickness.js";
import { setUpWork } from "./work.js";

/** @typedef {import("./design.js").Camera} Camera */

/** @param {number} luminance */
const lightText = (luminance) => `${Number(luminance.toPrecision(luminance < 1 ? 2 : 3))} cd/m²`;

async function start() {
  setUpTheme();
  setUpMessages();
  const wait = byId("wait", HTMLElement);
  wait.textContent = "Starting the simulator…";
  const engine = await Engine.start("engine/", () => tell("The simulator of this page failed, for example for lack of memory, and was started again.", "trouble"));
  const first = await opened(engine);
  const store = new Store(first.origin);
  store.pin(first.pinned ?? store.camera, { isChosen: first.pinned !== undefined });

  const scene = byId("scene", HTMLSelectElement);
  const light = byId("luminance", HTMLInputElement);
  const lightOut = byId("luminance-value", HTMLOutputElement);
  const luminance = () => Number((10 ** Number(light.value)).toPrecision(3));
  for (const [set, label] of /** @type {const} */ ([["natural", "Natural scenes"], ["charts", "Charts"]])) {
    const own = engine.scenes.filter((s) => s.set === set);
    if (own.length > 0) scene.append(make("optgroup", { label }, ...own.map((s) => make("option", { value: s.id }, s.name))));
  }
  const showLight = () => {
    lightOut.textContent = lightText(luminance());
    light.setAttribute("aria-valuetext", lightText(luminance()));
  };
  /** Shows the scene and the luminance of an address, and the picture as it was looked at, and says which scene is missing. @param {Partial<import("./share.js").Shared>} shared @returns {string} */
  function showConditions({ scene: id = "", luminance: shown, look }) {
    // A photograph has a number, which would be that of another one here.
    const isKnown = engine.scenes.some((s) => s.id === id && s.set !== "own");
    if (isKnown) scene.value = id;
    else if (!scene.value || id) scene.value = engine.scenes[0].id;
    if (shown !== undefined) light.value = String(Math.log10(shown));
    if (look) picture.lookAs(look);
    showLight();
    if (isKnown || !id) return "";
    return id.startsWith(PHOTOGRAPH)
      ? `The scene of this address is a photograph of the sender, which is not in the address. ${sceneName()} is shown.`
      : `This page has no scene ${shortened(id)}. ${sceneName()} is shown.`;
  }
  const sceneName = () => scene.selectedOptions[0]?.textContent ?? "";
  const isOwnScene = () => engine.scenes.some((s) => s.id === scene.value && s.set === "own");
  /** The names of the files of photographs, by scene. @type {Map<string, string>} */
  const photographs = new Map();
  /** The scene in names of files. */
  const sceneFile = () => (isOwnScene() ? sceneName() : scene.value);
  const work = { again: () => {} };
  const picture = setUpPicture(() => work.again());
  const missing = showConditions(first.shared ?? {});
  if (missing) tell(missing);

  /** @type {import("./engine.js").Curves | undefined} */
  let curves;
  /** @type {import("./scores.js").Known} */
  const own = {};
  /** @type {import("./scores.js").Known} */
  const pin = {};
  /** Colours of filters as seen, also of those that are new until their curve is known. @type {Record<string, string>} */
  const colors = {};
  /** Whether a result is to be told: after changes, not at the start. */
  let isChanged = false;
  /** Whether it is to be told what of the cameras is not simulated, which has changed. */
  let isLimited = false;
  /** Whether a change waits for the next frame. */
  let isWaiting = false;

  const scores = setUpScores(engine.catalogue);
  const mosaic = setUpMosaic(store, engine, () => colors);
  const filters = setUpFilters(store, engine, () => curves);
  const { openPreset } = setUpOpening(store, engine, { takeCurve: filters.take, takePhotograph, judgeBy, showConditions });
  const sensor = setUpSensor(store, engine, openPreset);
  const gathering = byId("gathering", HTMLElement);
  wait.textContent = "Learning the first picture…";

  const isPinned = () => store.pinned !== undefined && JSON.stringify(store.pinned) === JSON.stringify(store.camera);
  /** What the page says of a design beside the engine. @returns {import("./engine.js").Warning[]} */
  const ownWarnings = () => [refusedByCommands(store.camera)].filter(Boolean).map((message) => ({ key: "wavelengths_nm", message }));
  const showWarnings = () => scores.warn([...ownWarnings(), ...own.picture?.warnings ?? [], ...own.figures?.warnings ?? []], own.picture !== undefined && own.figures !== undefined);
  const showScores = () => scores.show(own, store.pinned && !isPinned() ? pin : undefined);
  let [drawnWhat, drawnMs] = ["", 0];
  /** The cameras of the curves and of the figures of the array, as text. */
  let [curvesOf, figuresOf] = ["", ""];
  const plot = byId("plot", HTMLElement);
  /** The name of a design that was changed, or that differs from the pinned one of the same name, says so. @param {Camera} camera */
  const nameOf = ({ name }) => (store.named.name !== store.camera.name || (store.pinned?.name === name && !isPinned()) ? `${name}, changed` : name);
  /** Marks what a loop computes as of the state before the last change, or no longer. @param {import("./work.js").Loop} loop @param {boolean} is */
  const mark = (loop, is) => {
    scores.mark(loop, is);
    showPinned();
  };
  const showPinned = () => {
    const { camera, pinned } = store;
    const text = isPinned() ? "Change something to see what it does." : `${nameOf(camera) === camera.name ? "Against" : `${nameOf(camera)}, against`} the pinned ${pinned?.name}`;
    byId("pinned", HTMLElement).textContent = scores.isEarlier("pictures") || scores.isEarlier("figures") ? "Dimmed values are out of date." : text;
  };
  /** The messages about designs that could not be computed, by loop. @type {Map<string, string>} */
  const failures = new Map();
  /** Who waits for picture and figures of the latest change; they hear whether these are there. @type {((isThere: boolean) => void)[]} */
  const waiting = [];
  /** Whether the latest change is still being computed. */
  let isPending = true;
  const whenSettled = () => (isPending ? new Promise((/** @type {(isThere: boolean) => void} */ resolve) => { waiting.push(resolve); }) : failures.size === 0);
  /** Answers who waits. @param {boolean} isThere */
  const settle = (isThere) => {
    isPending = isWaiting;
    for (const go of waiting.splice(0)) go(isThere);
  };
  const inEngine = (/** @type {Camera} */ camera) => simulated(engine, camera).camera;
  const wanted = () => ({ camera: inEngine(store.camera), pinned: store.pinned && inEngine(store.pinned), scene: scene.value, luminance: luminance(), family: familyOf() });
  const compute = setUpWork(engine, wanted, () => ({ pin: picture.needsPin(), map: picture.needsMap(), pinMap: picture.needsPinMap() }), {
    picture(drawn, { camera, scene: drawnScene, luminance: drawnLuminance }) {
      wait.hidden = true;
      wait.textContent = "";
      // Scores take longer than the picture, and a picture that is there is not drawn again.
      const what = JSON.stringify([camera, drawnScene, drawnLuminance]);
      const isSame = what === drawnWhat;
      if (!isSame) [drawnWhat, drawnMs] = [what, drawn.timings_ms.total - drawn.timings_ms.score];
      picture.showOwn(drawn, `${nameOf(camera)} · exposed for ${Number(drawn.exposure_ms.toPrecision(3))} ms · drawn in ${Math.round(drawnMs)} ms`, isSame);
      byId("display-gain", HTMLElement).textContent = String(drawn.gain);
      if (!drawn.scores) return;
      [own.picture, own.luminance] = [drawn, drawnLuminance];
      mark("pictures", false);
      showWarnings();
      showScores();
    },
    pinned(drawn, { pinned }) {
      pin.picture = drawn;
      picture.showPin(drawn, pinned?.name ?? "");
      showScores();
    },
    pinMap: picture.showPinMap,
    clipping: scores.showClipping,
    curves(known, { camera }) {
      curves = known;
      curvesOf = JSON.stringify(camera);
      plot.toggleAttribute("data-earlier", false);
      for (const { letter, color } of known.channels) colors[letter] = color;
      mosaic();
      filters.show();
    },
    figures(known, before, { camera }) {
      [own.figures, pin.figures, figuresOf] = [known, before, JSON.stringify(camera)];
      mark("figures", false);
      showWarnings();
      showScores();
    },
    overLight: scores.showOverLight,
    waits(design, isForPicture) {
      const text = design && `Computing the light for ${lensText(design)}…`;
      if (!isForPicture) return scores.waits(text ? "Computing statistics of the light…" : "");
      if (gathering.textContent !== (text ?? "")) gathering.textContent = text ?? "";
      gathering.hidden = !text;
    },
    done() {
      // A change that waits for the next frame is newer than what is done.
      if (isWaiting) return;
      const said = showScores();
      document.documentElement.dataset.settled = String(store.at);
      settle(true);
      if (isChanged) announce(`${said}. ${scores.warned()}${isLimited ? ` ${limitsText()}` : ""}`);
      isChanged = isLimited = false;
    },
    worked(loop) {
      const text = failures.get(loop);
      failures.delete(loop);
      const others = [...failures.values()];
      if (text === undefined || others.includes(text)) return;
      untell(text);
      if (others.length > 0) tell(others[0], "trouble");
    },
    failed(loop, error) {
      const now = wanted();
      const camera = JSON.stringify(now.camera);
      // At the start there is nothing earlier.
      let isBefore = loop === "pictures" && own.picture !== undefined;
      if (loop === "pictures") {
        gathering.hidden = true;
        if (drawnWhat !== JSON.stringify([now.camera, now.scene, now.luminance])) picture.markEarlier();
      } else {
        scores.showOverLight([], [], now.luminance);
        scores.waits("Not known for this design");
        plot.toggleAttribute("data-earlier", curvesOf !== "" && curvesOf !== camera);
        isBefore = figuresOf !== "" && figuresOf !== camera;
      }
      if (isBefore) mark(loop, true);
      const text = `${message(error)}.${isBefore ? " The picture and the dimmed values are out of date." : ""}`;
      failures.set(loop, text);
      settle(false);
      // Of two failures, that of the picture is said.
      if (loop === "pictures" || !failures.has("pictures")) tell(text, "trouble");
    },
  });
  let clippingOf = "";
  const soon = atFrame(() => {
    isWaiting = false;
    // What is known of another scene or of another pinned design does not hold; that of a design before a change does about.
    const of = JSON.stringify([scene.value, store.pinned]);
    if (clippingOf !== of) scores.showClipping(undefined, Infinity);
    clippingOf = of;
    compute();
  });
  work.again = () => {
    isWaiting = isPending = true;
    delete document.documentElement.dataset.settled;
    soon();
  };

  // ---- the bar ----

  const name = byId("name", HTMLInputElement);
  name.addEventListener("change", () => store.change(withValue(store.camera, ["name"], name.value.trim() || "design"), "the name"));
  const [undo, redo] = [byId("undo", HTMLButtonElement), byId("redo", HTMLButtonElement)];
  const back = () => { const what = store.undo(); if (what !== undefined) announce(`Undone: ${what}`); };
  const forth = () => { const what = store.redo(); if (what !== undefined) announce(`Redone: ${what}`); };
  undo.addEventListener("click", back);
  redo.addEventListener("click", forth);
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target === name) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "y" || event.shiftKey) forth();
    else back();
  });
  byId("pin", HTMLButtonElement).addEventListener("click", () => {
    store.pin(store.camera, { isChosen: true, as: store.named });
    announce(`${store.camera.name} is pinned. Scores show what changes from here do.`);
  });

  // What opens over the page closes with Escape, and menus also with a click elsewhere or on one of their buttons.
  const menus = /** @type {NodeListOf<HTMLDetailsElement>} */ (document.querySelectorAll("details"));
  document.addEventListener("click", ({ target }) => {
    for (const menu of menus) if (menu.matches(".menu") && !(target instanceof Node && menu.contains(target) && !(target instanceof HTMLButtonElement))) menu.open = false;
  });
  for (const menu of menus) {
    menu.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      menu.open = false;
      menu.querySelector("summary")?.focus();
    });
  }

  const rival = () => (isPinned() ? undefined : store.pinnedNamed);
  const shared = () => ({ camera: store.named, pinned: rival(), scene: isOwnScene() ? PHOTOGRAPH : scene.value, luminance: luminance(), look: picture.look() });
  byId("share", HTMLButtonElement).addEventListener("click", async () => {
    const photograph = isOwnScene() ? " The photograph is not in it." : "";
    history.replaceState(null, "", await fragmentOf(shared()));
    try {
      await navigator.clipboard.writeText(location.href);
      tell(location.hostname === "127.0.0.1"
        ? `Copied the address, which holds the whole design.${photograph} Its part from # on opens the design in any studio.`
        : `Copied the address, which holds the whole design.${photograph}`);
    } catch {
      tell(`The address of this page now holds the whole design; copy it from the browser.${photograph}`);
    }
  });

  const toml = async (/** @type {Camera} */ camera) => thicknessComments(camera.sensor.cfa.filters) + await engine.cameraToml(camera);
  byId("save-toml", HTMLButtonElement).addEventListener("click", async () => {
    try {
      const { named } = store;
      save(fileName(named.name, "toml"), new Blob([await toml(named)], { type: "application/toml" }));
    } catch (error) {
      tell(`${message(error)}.`, "trouble");
    }
  });
  byId("save-png", HTMLButtonElement).addEventListener("click", async () => {
    const png = await picture.png();
    if (png) save(fileName(`${store.named.name} ${sceneFile()} ${luminance()}`, "png"), png);
  });
  byId("save-csv", HTMLButtonElement).addEventListener("click", () => {
    if (curves) save(fileName(`${store.named.name} curves`, "csv"), new Blob([curvesCsv(curves)], { type: "text/csv" }));
  });

  /** Makes a scene of a photograph. @param {File} file */
  async function takePhotograph(file) {
    try {
      const name = shortened(file.name.replace(/\.[^.]*$/, "")) || "Photograph";
      const pixels = await readPhotograph(file);
      const { id } = await engine.addPhotograph(name, pixels);
      photographs.set(id, file.name);
      const group = scene.querySelector('optgroup[label="Your photographs"]') ?? make("optgroup", { label: "Your photographs" });
      group.append(make("option", { value: id }, name));
      scene.append(group);
      scene.value = id;
      work.again();
      tell(`The photograph “${name}” is now a scene of ${pixels.width} × ${pixels.height} pixels in daylight. Its spectra are estimated from its colours (Jakob and Hanika 2019). It stays in this browser.`);
    } catch (error) {
      tell(`${shortened(file.name)}: ${message(error)}.`, "trouble");
    }
  }

  // ---- the design ----

  const native = setUpNative(() => ({
    camera: store.named, pinned: rival(), scene: scene.value, luminance: luminance(), isOwn: isOwnScene(),
  }), (work) => store.on(["design", "pin"], work));
  setUpOwnFiles(native, engine, () => ({ camera: inEngine(store.named), scene: scene.value, sceneName: sceneFile(), luminance: luminance() }));
  setUpReport(engine, whenSettled, () => ({
    camera: store.named, pinned: rival(), simulated: inEngine, own: { ...own }, pin: { ...pin }, layers: picture.layers(), scores: scores.shown(), toml, shared: shared(),
    scene: sceneName(), sceneInCommands: engine.scenes.find((s) => s.id === scene.value)?.catalogue, photograph: photographs.get(scene.value), sceneFile: sceneFile(), luminance: luminance(), limits: limitsText("on the page of the studio"),
  }));
  setUpSweep(native, () => ({ camera: store.named, luminance: luminance() }));
  setUpImprove(store, engine, { luminance, simulated: inEngine, fail: (error) => tell(`${message(error)}.`, "trouble"), native });
  /** Judges filters as those of a family, if the page has it. @param {string | null | undefined} name */
  function judgeBy(name) {
    const family = byId("family", HTMLSelectElement);
    if ([...family.options].some((option) => option.value === name)) family.value = String(name);
  }
  if (!location.hash) judgeBy((await offered())?.family);
  const limits = byId("limits", HTMLDetailsElement);
  const limitsText = (where = "on this page") => {
    const { camera } = store;
    const pinned = isPinned() ? undefined : store.pinned;
    const [own, other] = [camera, pinned].map((c) => (c ? simulated(engine, c).left.join(", ") : ""));
    const theOther = pinned && (pinned.name === camera.name ? "the pinned design" : `the pinned ${pinned.name}`);
    const parts = own !== "" && own === other ? [`for ${camera.name} and ${theOther}: ${own}`] : [own && `for ${camera.name}: ${own}`, other && `for ${theOther}: ${other}`].filter(Boolean);
    return parts.length === 0 ? "" : `Not simulated ${where} ${parts.join("; ")}. Saved files, shared addresses and full computations use the camera as stated.`;
  };
  const showLimits = () => {
    const text = limitsText();
    const place = /** @type {HTMLElement} */ (limits.lastElementChild);
    if (place.textContent === text) return;
    place.textContent = text;
    limits.hidden = text === "";
    if (text !== "") isLimited = true;
    else limits.open = false;
  };
  const show = () => {
    if (document.activeElement !== name) name.value = store.camera.name;
    undo.setAttribute("aria-disabled", String(!store.canUndo));
    redo.setAttribute("aria-disabled", String(!store.canRedo));
    showLimits();
    showPinned();
  };
  store.on(["design", "pin"], () => {
    isChanged = true;
    show();
    work.again();
  });
  light.addEventListener("input", () => {
    showLight();
    work.again();
  });
  for (const select of [scene, byId("family", HTMLSelectElement)]) select.addEventListener("change", () => work.again());
  show();
  mosaic();
  sensor();
  filters.show();
  work.again();
}

start().catch((error) => {
  byId("wait", HTMLElement).textContent = `The simulator cannot start: ${message(error)}.`;
  byId("wait", HTMLElement).dataset.failed = "";
});
