// @ts-check
// What the page shows: the design, every step that led to it, what it is compared with, and what an improvement may not change.
import { named } from "./exchange.js";

/** @typedef {import("./design.js").Camera} Camera */
/** @typedef {import("./exchange.js").Origin} Origin */

export class Store extends EventTarget {
  /** @param {Origin} origin */
  constructor(origin) {
    super();
    const { camera } = origin;
    /** @type {{ camera: Camera, what: string, origin: Origin }[]} */
    this.steps = [{ camera, what: "", origin }];
    this.at = 0;
    /** Whether the design comes from the history: fields show it even while they have the focus. */
    this.jumps = false;
    /** The key of a change that goes on, such as a drag. @type {string | undefined} */
    this.ongoing = undefined;
    /** @type {Camera | undefined} */
    this.pinned = undefined;
    /** The pinned design under the name with which it is saved. @type {Camera | undefined} */
    this.pinnedNamed = undefined;
    /** Whether the pinned design was chosen as such: it stays when another camera is opened. */
    this.isPinChosen = false;
    /** @type {Set<string>} Letters of filters. */
    this.lockedFilters = new Set();
    /** @type {Set<string>} Cells as `row,col`. */
    this.lockedCells = new Set();
    this.selected = Object.keys(camera.sensor.cfa.filters)[0];
  }

  get camera() { return this.steps[this.at].camera; }
  get origin() { return this.steps[this.at].origin; }
  /** The design under the name with which it is saved. */
  get named() { return named(this.camera, this.origin); }
  get canUndo() { return this.at > 0; }
  get canRedo() { return this.at + 1 < this.steps.length; }

  /**
   * A new design. Changes with the same `key` in succession, such as those of one drag, are one step. `what` says in words what changed. `origin` is that of the
   * design, if it is another one.
   * @param {Camera} camera @param {string} what @param {string} [key] @param {Origin} [origin]
   */
  change(camera, what, key, origin = this.origin) {
    if (key !== undefined && key === this.ongoing && this.at > 0) this.steps[this.at] = { camera, what, origin };
    else {
      this.steps.splice(this.at + 1, Infinity, { camera, what, origin });
      this.at += 1;
    }
    this.ongoing = key;
    this.settle();
  }

  /** Ends a change that goes on. */
  end() { this.ongoing = undefined; }

  /** @returns {string | undefined} What was undone. */
  undo() {
    if (!this.canUndo) return undefined;
    const { what } = this.steps[this.at];
    this.jump(this.at - 1);
    return what;
  }

  /** @returns {string | undefined} What was done again. */
  redo() {
    if (!this.canRedo) return undefined;
    this.jump(this.at + 1);
    return this.steps[this.at].what;
  }

  /** @param {number} to */
  jump(to) {
    this.at = to;
    this.ongoing = undefined;
    this.jumps = true;
    this.settle();
    this.jumps = false;
  }

  /** @param {Camera} camera @param {{ isChosen: boolean, as?: Camera }} how Whether somebody chose it; `as` is the same under the name with which it is saved. */
  pin(camera, { isChosen, as = camera }) {
    [this.pinned, this.pinnedNamed, this.isPinChosen] = [camera, as, isChosen];
    this.tell("pin");
  }

  /** @param {string} letter */
  select(letter) {
    this.selected = letter;
    this.tell("view");
  }

  /** @param {Set<string>} set @param {string} item */
  toggleLock(set, item) {
    if (!set.delete(item)) set.add(item);
    this.tell("view");
  }

  /** What depends on filters and cells that may be gone. */
  settle() {
    const { filters, pattern } = this.camera.sensor.cfa;
    if (!(this.selected in filters)) [this.selected] = Object.keys(filters);
    for (const letter of this.lockedFilters) if (!(letter in filters)) this.lockedFilters.delete(letter);
    for (const cell of this.lockedCells) {
      const [row, col] = cell.split(",").map(Number);
      if (row >= pattern.length || col >= pattern[0].length) this.lockedCells.delete(cell);
    }
    this.tell("design");
  }

  /** @param {"design" | "pin" | "view"} type */
  tell(type) { this.dispatchEvent(new Event(type)); }

  /** @param {("design" | "pin" | "view")[]} types @param {() => void} work */
  on(types, work) { for (const type of types) this.addEventListener(type, work); }
}
