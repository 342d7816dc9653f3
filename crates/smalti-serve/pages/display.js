// @ts-check
// What the page learns about the display: its size, its gamma, and whether the browser resamples pictures.

/** The width of a bank card, mm (ISO/IEC 7810, ID-1), and the ratio of its height to its width. */
const CARD_MM = 85.6;
const CARD_ASPECT = 53.98 / 85.6;
/** The largest long side of the outline, CSS pixels, and the least width of a place in which it lies. */
const [LONGEST, LYING] = [640, 540];
/** Side of the grey square, CSS pixels. */
const SQUARE = 80;

/** @template {Element} T @param {string} id @param {new (...args: any[]) => T} kind @returns {T} */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

/** The warning for a device pixel ratio at which pictures are not shown pixel for pixel; empty at 1. @param {number} ratio */
export function ratioWarning(ratio) {
  if (Math.abs(ratio - 1) < 1e-3) return "";
  const shown = ratio.toFixed(2).replace(/\.?0+$/, "");
  if (Math.abs(ratio - Math.round(ratio)) < 1e-3) {
    return `Your browser shows each pixel of a picture as ${shown} × ${shown} pixels of the display. Pictures stay sharp but appear enlarged. If you can, change the browser’s zoom until this message disappears.`;
  }
  return `Your browser resamples pictures: it shows each pixel of a picture as ${shown} × ${shown} pixels of the display. This can hide detail or add artefacts. Set the browser’s zoom to 100 % and the display’s scaling to a whole number, until this message disappears.`;
}

/** The level of grey, 0 to 255, that has the luminance of alternating black and white lines on a display of this gamma. @param {number} gamma */
export function greyOf(gamma) {
  return Math.round(255 * 0.5 ** (1 / gamma));
}

/**
 * Gives a canvas as many pixels as the device pixels that it covers, whenever their number changes, and then draws it. Only then is no line
 * resampled: rounding the size in CSS pixels times the ratio of pixels can be one off where the browser aligns the canvas with device pixels.
 * @param {HTMLCanvasElement} canvas @param {() => void} draw
 */
function fitToDevice(canvas, draw) {
  const observer = new ResizeObserver(([entry]) => {
    const box = entry?.devicePixelContentBoxSize?.[0];
    const { width, height } = canvas.getBoundingClientRect();
    // An emulated screen, as that of developer tools, is stated in CSS pixels.
    const exact = (/** @type {number | undefined} */ stated, /** @type {number} */ about) =>
      (stated !== undefined && Math.abs(stated - about) <= 1 ? stated : Math.round(about));
    canvas.width = exact(box?.inlineSize, width * devicePixelRatio);
    canvas.height = exact(box?.blockSize, height * devicePixelRatio);
    draw();
  });
  try {
    observer.observe(canvas, { box: "device-pixel-content-box" });
  } catch {
    // A browser that cannot tell device pixels.
    observer.observe(canvas);
  }
}

function drawLines(/** @type {HTMLCanvasElement} */ canvas, /** @type {number} */ gamma) {
  const ratio = devicePixelRatio || 1;
  const context = canvas.getContext("2d");
  if (!context) return;
  context.fillStyle = "#000";
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = "#fff";
  for (let row = 0; row < canvas.height; row += 2) context.fillRect(0, row, canvas.width, 1);
  const grey = greyOf(gamma);
  context.fillStyle = `rgb(${grey} ${grey} ${grey})`;
  const side = Math.round(SQUARE * ratio);
  context.fillRect(Math.round((canvas.width - side) / 2), Math.round((canvas.height - side) / 2), side, side);
}

/** Sets up the checks, which are shown, and returns a function that reads them. @returns {() => import("./server.js").Display} */
export function setUpDisplay() {
  const size = element("size", HTMLInputElement);
  const gamma = element("gamma", HTMLInputElement);
  const [sizeMatches, gammaMatches] = [element("size-matches", HTMLInputElement), element("gamma-matches", HTMLInputElement)];
  const card = element("card", SVGSVGElement);
  const place = element("card-place", HTMLDivElement);
  const lines = element("lines", HTMLCanvasElement);
  const ratio = element("ratio", HTMLParagraphElement);
  const update = () => {
    // They are not shown any more.
    if (place.clientWidth === 0) return;
    // The outline stands upright where a card that lies would not fit.
    const room = place.clientWidth;
    const isLying = room >= LYING;
    const longest = Math.min(LONGEST, Math.floor(isLying ? room : room / CARD_ASPECT));
    size.max = String(longest);
    place.style.height = `${Math.ceil(isLying ? longest * CARD_ASPECT : longest)}px`;
    const long = Number(size.value);
    const short = Math.round(long * CARD_ASPECT);
    const [width, height] = isLying ? [long, short] : [short, long];
    card.setAttribute("width", String(width));
    card.setAttribute("height", String(height));
    const rect = card.querySelector("rect");
    rect?.setAttribute("width", String(width - 2));
    rect?.setAttribute("height", String(height - 2));
    element("size-value", HTMLOutputElement).value = `${long} px`;
    element("gamma-value", HTMLOutputElement).value = Number(gamma.value).toFixed(2);
    drawLines(lines, Number(gamma.value));
    const warning = ratioWarning(devicePixelRatio || 1);
    ratio.textContent = warning;
    ratio.hidden = warning === "";
  };
  // Where a slider begins is no measurement: its value counts once the observer has moved it or says that it is right.
  for (const [input, matches] of /** @type {const} */ ([[size, sizeMatches], [gamma, gammaMatches]])) {
    input.addEventListener("input", () => {
      matches.checked = true;
      update();
    });
  }
  addEventListener("resize", update);
  new ResizeObserver(update).observe(place);
  update();
  fitToDevice(lines, update);
  return () => ({
    device_pixel_ratio: devicePixelRatio || 1,
    screen_px: [Math.max(1, Math.round(screen.width)), Math.max(1, Math.round(screen.height))],
    ...(sizeMatches.checked ? { px_per_mm: Number(size.value) / CARD_MM } : {}),
    ...(gammaMatches.checked ? { gamma: Number(gamma.value) } : {}),
  });
}
