// @ts-check
// A pair of pictures beside the reference, or one after the other where the window is too narrow for three. An answer counts once both were shown.
import { element } from "./display.js";

/** Milliseconds for which both pictures have been shown before an answer counts. */
const LEAST_MS = 250;
/** CSS pixels beside three pictures. */
const BESIDE = 110;
const SIDES = /** @type {const} */ (["left", "reference", "right"]);
/** The sides that are compared. */
const COMPARED = /** @type {const} */ (["left", "right"]);

/** @typedef {(choice: import("./server.js").Side, responseMs: number) => void} Chosen */

export class PairView {
  /** @param {Chosen} chosen @param {number} rows @param {number} cols The largest pictures of the experiment. */
  constructor(chosen, rows, cols) {
    this.chosen = chosen;
    this.cols = cols;
    this.section = element("pair", HTMLElement);
    this.section.style.setProperty("--rows", String(rows));
    this.section.style.setProperty("--cols", String(cols));
    this.buttons = { left: element("left", HTMLButtonElement), right: element("right", HTMLButtonElement) };
    this.hint = element("look", HTMLParagraphElement);
    this.isOpen = false;
    /** When the pair was opened, and when the last of its pictures was shown. */
    this.since = 0;
    this.completeSince = 0;
    /** The sides shown since the pair was opened. @type {Set<string>} */
    this.seen = new Set();
    /** @type {string[]} */
    this.urls = [];
    this.buttons.left.addEventListener("click", () => this.choose("left"));
    this.buttons.right.addEventListener("click", () => this.choose("right"));
    for (const button of this.section.querySelectorAll("button[data-view]")) {
      button.addEventListener("click", () => this.show(button.getAttribute("data-view") ?? "reference"));
    }
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("resize", () => this.arrange());
    this.arrange();
    this.show("reference");
  }

  arrange() {
    const isNarrow = document.documentElement.clientWidth < 3 * this.cols + BESIDE;
    this.section.classList.toggle("one-by-one", isNarrow);
    this.note();
  }

  isOneByOne() { return this.section.classList.contains("one-by-one"); }

  isComplete() { return COMPARED.every((side) => this.seen.has(side)); }

  /** Notes which pictures are shown now, and admits answers once both have been. */
  note() {
    if (!this.isOpen) return;
    const wasComplete = this.isComplete();
    for (const side of SIDES) {
      if (!this.isOneByOne() || this.figure(side).parentElement?.hasAttribute("data-shown")) this.seen.add(side);
    }
    if (!this.isComplete()) return;
    if (!wasComplete) this.completeSince = performance.now();
    this.enable(true);
  }

  /** @param {string} side */
  figure(side) {
    const found = this.section.querySelector(`figure[data-side="${side}"] img`);
    if (!(found instanceof HTMLImageElement)) throw new Error(`the page has no picture ${side}`);
    return found;
  }

  /** Shows one picture where they are shown one after the other. @param {string} side */
  show(side) {
    for (const other of SIDES) {
      this.figure(other).parentElement?.toggleAttribute("data-shown", other === side);
      this.section.querySelector(`button[data-view="${other}"]`)?.setAttribute("aria-pressed", String(other === side));
    }
    this.note();
  }

  /** Buttons that wait keep the focus. @param {boolean} isEnabled */
  enable(isEnabled) {
    for (const button of Object.values(this.buttons)) button.setAttribute("aria-disabled", String(!isEnabled));
    this.hint.toggleAttribute("data-done", isEnabled);
  }

  /** Empties the places of the pictures. They keep their size, so that nothing moves. */
  clear() {
    this.isOpen = false;
    this.enable(false);
    for (const side of SIDES) this.figure(side).toggleAttribute("data-waits", true);
  }

  /**
   * Shows a pair once all its pictures are decoded.
   * @param {Record<"left" | "reference" | "right", Blob>} pictures @param {{ rows: number, cols: number }} size
   */
  async open(pictures, size) {
    const before = this.urls;
    this.urls = [];
    await Promise.all(SIDES.map(async (side) => {
      const image = this.figure(side);
      const url = URL.createObjectURL(pictures[side]);
      this.urls.push(url);
      image.width = size.cols;
      image.height = size.rows;
      image.src = url;
      await image.decode();
    }));
    before.forEach((url) => URL.revokeObjectURL(url));
    for (const side of SIDES) this.figure(side).toggleAttribute("data-waits", false);
    this.seen.clear();
    this.isOpen = true;
    this.since = performance.now();
    this.show("reference");
  }

  /** @param {import("./server.js").Side} side */
  choose(side) {
    const now = performance.now();
    if (!this.isOpen || !this.isComplete() || now - this.completeSince < LEAST_MS) return;
    this.isOpen = false;
    this.chosen(side, now - this.since);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (this.section.hidden || event.altKey || event.ctrlKey || event.metaKey || event.repeat) return;
    const sides = /** @type {const} */ ({ ArrowLeft: "left", ArrowRight: "right" });
    const side = sides[/** @type {keyof typeof sides} */ (event.key)];
    if (!side) return;
    event.preventDefault();
    this.choose(side);
  }
}
