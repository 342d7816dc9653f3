// @ts-check
// The picture: alone, against another one, or as a map of differences; zoomed and moved.
import { announce, atFrame, byId } from "./dom.js";
import { OUT_OF_DATE } from "./scores.js";

/** @typedef {import("./engine.js").Picture} Picture */
/** The views of the picture, and what it is compared with. */
export const [VIEWS, RIVALS] = [/** @type {const} */ (["one", "split", "other", "map"]), /** @type {const} */ (["reference", "pin"])];
/** @typedef {typeof VIEWS[number]} View */
/** How the picture is looked at: in which view, and against what. @typedef {{ view: View, against: typeof RIVALS[number] }} Look */

/** The colours of a map of differences, dark to bright. */
const SCALE = [[0, 0, 4], [40, 11, 84], [101, 21, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];
/** The difference at the end of the scale. */
const MOST = 20;
const MOST_ZOOM = 32;

/** @param {number} share 0 to 1 @returns {number[]} */
function colorOf(share) {
  const x = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
  const i = Math.min(Math.floor(x), SCALE.length - 2);
  return SCALE[i].map((c, k) => Math.round(c + (SCALE[i + 1][k] - c) * (x - i)));
}

/** @param {Uint8ClampedArray} rgba @param {number} width @param {number} height */
function canvasOf(rgba, width, height) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const image = new ImageData(width, height);
  image.data.set(rgba);
  canvas.getContext("2d")?.putImageData(image, 0, 0);
  return canvas;
}

/** @param {Float32Array} difference @param {number} width @param {number} height */
function mapOf(difference, width, height) {
  const rgba = new Uint8ClampedArray(4 * width * height);
  difference.forEach((d, i) => rgba.set([...colorOf(d / MOST), 255], 4 * i));
  return canvasOf(rgba, width, height);
}

/**
 * Sets up the stage. `onView` is called when another picture may be needed.
 * @param {() => void} onView
 */
export function setUpPicture(onView) {
  const stage = byId("stage", HTMLDivElement);
  const canvas = byId("canvas", HTMLCanvasElement);
  const split = byId("split", HTMLDivElement);
  const [caption, captionOther] = [byId("caption", HTMLElement), byId("caption-other", HTMLElement)];
  const other = byId("other", HTMLSelectElement);
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  /** @type {{ own?: HTMLCanvasElement, reference?: HTMLCanvasElement, pin?: HTMLCanvasElement, map?: HTMLCanvasElement, pinMap?: HTMLCanvasElement }} */
  const layers = {};
  let names = { own: "", pin: "" };
  /** @type {View} */
  let view = "one";
  let line = 0.5;
  /** Device pixels for each pixel of the picture; 0 shows all of it. */
  let zoom = 0;
  /** The point of the picture in the middle of the stage, in shares of its size. */
  let middle = [0.5, 0.5];

  const scaleBar = /** @type {HTMLCanvasElement} */ (byId("scale-bar", HTMLCanvasElement));
  for (let x = 0; x < scaleBar.width; x += 1) {
    const bar = /** @type {CanvasRenderingContext2D} */ (scaleBar.getContext("2d"));
    bar.fillStyle = `rgb(${colorOf(x / (scaleBar.width - 1)).join(" ")})`;
    bar.fillRect(x, 0, 1, scaleBar.height);
  }

  const otherLayer = () => (other.value === "pin" ? layers.pin : layers.reference);
  const mapLayer = () => (other.value === "pin" ? layers.pinMap : layers.map);
  const fit = () => (layers.own ? Math.min(canvas.width / layers.own.width, canvas.height / layers.own.height) : 1);
  const factor = () => (zoom === 0 ? fit() : zoom);

  function showNow() {
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (!layers.own) return;
    const scale = factor();
    const { width, height } = layers.own;
    // The picture is never moved out of the stage.
    const bound = (/** @type {number} */ share, /** @type {number} */ size, /** @type {number} */ room) => {
      const half = room / scale / size / 2;
      return half >= 0.5 ? 0.5 : Math.min(Math.max(share, half), 1 - half);
    };
    middle = [bound(middle[0], width, canvas.width), bound(middle[1], height, canvas.height)];
    const [left, top] = [Math.round(canvas.width / 2 - middle[0] * width * scale), Math.round(canvas.height / 2 - middle[1] * height * scale)];
    context.imageSmoothingEnabled = scale < 1;
    const put = (/** @type {HTMLCanvasElement | undefined} */ layer) => { if (layer) context.drawImage(layer, left, top, Math.round(width * scale), Math.round(height * scale)); };
    if (view === "other") put(otherLayer());
    else if (view === "map") put(mapLayer());
    else put(layers.own);
    const x = Math.round(canvas.width * line);
    if (view === "split") {
      context.save();
      context.beginPath();
      context.rect(x, 0, canvas.width - x, canvas.height);
      context.clip();
      context.clearRect(x, 0, canvas.width, canvas.height);
      put(otherLayer());
      context.restore();
    }
    split.hidden = view !== "split";
    split.style.left = `${100 * line}%`;
    split.setAttribute("aria-valuenow", String(Math.round(100 * line)));
    split.setAttribute("aria-valuetext", `${Math.round(100 * line)} % of the width shows the design`);
    const button = document.querySelector('[data-view="other"]');
    if (button) button.textContent = other.value === "pin" ? "Pinned" : "Reference";
    const nameOther = other.value === "pin" ? `Pinned: ${names.pin}${layers.pin ? "" : ", being computed…"}` : "Reference";
    const nameMap = `ΔE2000 from ${other.value === "pin" ? `the pinned ${names.pin}` : "the reference"}${mapLayer() ? "" : ", being computed…"}`;
    caption.textContent = view === "other" ? nameOther : view === "map" ? nameMap : names.own;
    captionOther.textContent = nameOther;
    captionOther.hidden = view !== "split";
    byId("scale", HTMLDivElement).hidden = view !== "map";
  }
  const show = atFrame(showNow);

  new ResizeObserver(() => {
    const ratio = devicePixelRatio || 1;
    [canvas.width, canvas.height] = [Math.max(Math.round(stage.clientWidth * ratio), 1), Math.max(Math.round(stage.clientHeight * ratio), 1)];
    showNow();
  }).observe(stage);

  /** @param {View} to */
  function setView(to) {
    view = to;
    for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-view]"))) button.setAttribute("aria-pressed", String(button.dataset.view === view));
    show();
    onView();
  }
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-view]"))) {
    button.addEventListener("click", () => setView(/** @type {View} */ (button.dataset.view)));
  }
  other.addEventListener("change", () => {
    if (view === "one") setView("split");
    show();
    onView();
  });

  /** Zooms so that a point of the stage, in device pixels from its middle, stays. @param {number} by @param {[number, number]} [at] */
  function zoomBy(by, [dx, dy] = [0, 0]) {
    if (!layers.own) return;
    const before = factor();
    const after = Math.min(Math.max(before * by, fit()), MOST_ZOOM);
    middle = [middle[0] + dx / layers.own.width * (1 / before - 1 / after), middle[1] + dy / layers.own.height * (1 / before - 1 / after)];
    zoom = after <= fit() * 1.001 ? 0 : after;
    stage.toggleAttribute("data-zoomed", zoom !== 0);
    show();
  }
  byId("zoom-in", HTMLButtonElement).addEventListener("click", () => zoomBy(1.5));
  byId("zoom-out", HTMLButtonElement).addEventListener("click", () => zoomBy(1 / 1.5));
  byId("zoom-fit", HTMLButtonElement).addEventListener("click", () => zoomBy(0));
  stage.addEventListener("wheel", (event) => {
    // In a narrow window, the wheel scrolls the page.
    if (!event.ctrlKey && matchMedia("(max-width: 999.98px)").matches) return;
    event.preventDefault();
    const box = stage.getBoundingClientRect();
    const ratio = devicePixelRatio || 1;
    zoomBy(Math.exp(-event.deltaY / 400), [(event.clientX - box.left - box.width / 2) * ratio, (event.clientY - box.top - box.height / 2) * ratio]);
  }, { passive: false });

  /** @param {number} dx @param {number} dy Device pixels. */
  function moveBy(dx, dy) {
    if (!layers.own) return;
    middle = [middle[0] - dx / layers.own.width / factor(), middle[1] - dy / layers.own.height / factor()];
    show();
  }
  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || zoom === 0 || event.target !== canvas) return;
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    if (stage.hasPointerCapture(event.pointerId)) moveBy(event.movementX * (devicePixelRatio || 1), event.movementY * (devicePixelRatio || 1));
  });

  /** @param {number} to */
  function setLine(to) {
    line = Math.min(Math.max(to, 0.02), 0.98);
    show();
  }
  split.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    event.stopPropagation();
    split.focus();
    split.setPointerCapture(event.pointerId);
  });
  split.addEventListener("pointermove", (event) => {
    const box = stage.getBoundingClientRect();
    if (split.hasPointerCapture(event.pointerId)) setLine((event.clientX - box.left) / box.width);
  });
  split.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    setLine(line + by);
  });
  stage.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = 40 * (devicePixelRatio || 1);
    const work = /** @type {Record<string, () => void>} */ ({
      "+": () => zoomBy(1.5), "=": () => zoomBy(1.5), "-": () => zoomBy(1 / 1.5), 0: () => zoomBy(0),
      ArrowLeft: () => moveBy(step, 0), ArrowRight: () => moveBy(-step, 0), ArrowUp: () => moveBy(0, step), ArrowDown: () => moveBy(0, -step),
      1: () => setView("one"), 2: () => setView("split"), 3: () => setView("other"), 4: () => setView("map"),
      f: () => {
        setView(view === "other" ? "one" : "other");
        announce(view === "other" ? caption.textContent || "Other picture" : "Picture of the design");
      },
    })[event.key];
    if (!work) return;
    event.preventDefault();
    work();
  });

  return {
    /** How the picture is looked at. @returns {Look} */
    look: () => ({ view, against: other.value === "pin" ? "pin" : "reference" }),
    /** Sets the view, and what the picture is compared with. @param {Look} look */
    lookAs({ view: wanted, against }) {
      other.value = against;
      setView(wanted);
    },
    /** Whether the pinned picture is looked at. */
    needsPin: () => other.value === "pin" && (view === "split" || view === "other"),
    /** Whether the map of differences is looked at. */
    needsMap: () => view === "map" && other.value === "reference",
    /** Whether the map of differences from the pinned picture is looked at. */
    needsPinMap: () => view === "map" && other.value === "pin",
    /** @param {Picture} picture @param {string} name @param {boolean} isSame Whether the map of differences that is there is that of this picture. */
    showOwn(picture, name, isSame) {
      const { width, height } = picture;
      layers.own = canvasOf(picture.rgba, width, height);
      layers.reference = canvasOf(picture.reference, width, height);
      if (picture.difference) layers.map = mapOf(picture.difference, width, height);
      else if (!isSame) layers.map = undefined;
      names = { ...names, own: name };
      stage.setAttribute("aria-busy", "false");
      show();
    },
    /** @param {Picture | undefined} picture None while it is not known. @param {string} name */
    showPin(picture, name) {
      layers.pin = picture && canvasOf(picture.rgba, picture.width, picture.height);
      names = { ...names, pin: name };
      show();
    },
    /** @param {Float32Array | undefined} difference None while it is not known. @param {Picture} of The picture of the design. */
    showPinMap(difference, { width, height }) {
      layers.pinMap = difference && mapOf(difference, width, height);
      show();
    },
    /** Says that the picture is not of the latest change, which could not be computed. */
    markEarlier() {
      if (layers.own && !names.own.startsWith(OUT_OF_DATE)) names = { ...names, own: OUT_OF_DATE + names.own };
      show();
    },
    /** The pictures of the design, of the pinned one and of the reference, as far as they are known. */
    layers: () => ({ own: layers.own, pin: layers.pin, reference: layers.reference }),
    /** The picture of the design as PNG. @returns {Promise<Blob | null>} */
    png: () => new Promise((resolve) => { if (layers.own) layers.own.toBlob(resolve, "image/png"); else resolve(null); }),
  };
}
