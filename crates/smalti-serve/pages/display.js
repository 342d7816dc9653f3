// @ts-check
// What the page finds out about the display: size, grey, and whether the browser scales pictures.

/** The width of a bank card, mm (ISO/IEC 7810, ID-1), and its height by its width. */
const CARD_MM = 85.6;
const CARD_ASPECT = 53.98 / 85.6;
/** Side of the grey square, CSS pixels. */
const SQUARE = 80;

/** @template {Element} T @param {string} id @param {new (...args: any[]) => T} kind @returns {T} */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

/** Words for a ratio of pixels at which pictures are not shown pixel by pixel; empty at 1. @param {number} ratio */
export function ratioWarning(ratio) {
  if (Math.abs(ratio - 1) < 1e-3) return "";
  const shown = ratio.toFixed(2).replace(/\.?0+$/, "");
  if (Math.abs(ratio - Math.round(ratio)) < 1e-3) {
    return `Your browser shows ${shown} × ${shown} pixels of the display for each pixel of a picture. Pictures stay sharp, but are seen larger than their pixels; if you can, set the zoom of the browser so that this ratio is 1.`;
  }
  return `Your browser scales pictures: ${shown} pixels of the display for each of theirs. This hides or invents detail. Set the zoom of the browser to 100 %, and the scaling of the display to a whole number, until this warning goes.`;
}

/** The level of grey, 0 to 255, that is as bright as lines of black and white on a display with an exponent. @param {number} gamma */
export function greyOf(gamma) {
  return Math.round(255 * 0.5 ** (1 / gamma));
}

function drawLines(/** @type {HTMLCanvasElement} */ canvas, /** @type {number} */ gamma) {
  const ratio = devicePixelRatio || 1;
  const [width, height] = [240, 160];
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
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

/** Sets up the checks, and returns a function that reads them. @returns {() => import("./server.js").Display} */
export function setUpDisplay() {
  const size = element("size", HTMLInputElement);
  const gamma = element("gamma", HTMLInputElement);
  const [sizeSkip, gammaSkip] = [element("size-skip", HTMLInputElement), element("gamma-skip", HTMLInputElement)];
  const card = element("card", SVGSVGElement);
  const lines = element("lines", HTMLCanvasElement);
  const ratio = element("ratio", HTMLParagraphElement);
  const update = () => {
    const width = Number(size.value);
    const height = Math.round(width * CARD_ASPECT);
    // The space for the outline stays as it is, so that nothing on the page moves.
    card.setAttribute("width", String(width));
    card.setAttribute("height", String(height));
    const rect = card.querySelector("rect");
    rect?.setAttribute("width", String(width - 2));
    rect?.setAttribute("height", String(height - 2));
    element("size-value", HTMLOutputElement).value = `${width} px`;
    element("gamma-value", HTMLOutputElement).value = Number(gamma.value).toFixed(2);
    size.disabled = sizeSkip.checked;
    gamma.disabled = gammaSkip.checked;
    drawLines(lines, Number(gamma.value));
    const warning = ratioWarning(devicePixelRatio || 1);
    ratio.textContent = warning;
    ratio.hidden = warning === "";
  };
  for (const input of [size, gamma, sizeSkip, gammaSkip]) input.addEventListener("input", update);
  addEventListener("resize", update);
  update();
  return () => ({
    device_pixel_ratio: devicePixelRatio || 1,
    screen_px: [Math.max(1, Math.round(screen.width)), Math.max(1, Math.round(screen.height))],
    ...(sizeSkip.checked ? {} : { px_per_mm: Number(size.value) / CARD_MM }),
    ...(gammaSkip.checked ? {} : { gamma: Number(gamma.value) }),
  });
}
