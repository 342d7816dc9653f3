// @ts-check
// The mosaic: cells that are painted with the pointer or the keyboard, the palette, size, symmetry and templates.
import { announce, byId, make, message, tell, untell } from "./dom.js";
import { MAX_SIDE, addFilter, images, letterAt, letters, paint, removeFilter, resize, share, size } from "./design.js";
import { withMosaic } from "./exchange.js";
import { counted } from "./numbers.js";
import { UNKNOWN, inkOn } from "./tile-drawing.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./engine.js").Engine} Engine */

/** Tiles with a longer side take the whole width of the panel. */
const LARGE_SIDE = 6;
const ARROWS = /** @type {Record<string, [number, number]>} */ ({ ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] });

/**
 * Sets up the editor. `colors` has the colour of each filter as seen.
 * @param {Store} store @param {Engine} engine @param {() => Record<string, string>} colors
 * @returns {() => void} Shows the design, after a change of colours too.
 */
export function setUpMosaic(store, engine, colors) {
  const grid = byId("grid", HTMLDivElement);
  const palette = byId("palette", HTMLDivElement);
  const [rowsField, colsField] = [byId("rows", HTMLInputElement), byId("cols", HTMLInputElement)];
  const symmetry = byId("symmetry", HTMLSelectElement);
  const lockCells = byId("lock-cells", HTMLInputElement);
  const template = byId("template", HTMLSelectElement);
  /** The cell with the focus. */
  let [atRow, atCol] = [0, 0];
  let stroke = 0;

  const cellAt = (/** @type {number} */ row, /** @type {number} */ col) => /** @type {HTMLElement} */ (grid.children[row].children[col]);
  const mirrored = (/** @type {number} */ row, /** @type {number} */ col) =>
    images(...size(store.camera), row, col, /** @type {import("./design.js").Symmetry} */ (symmetry.value));

  /** @param {number} row @param {number} col @param {string} letter @param {string} key */
  function paintAt(row, col, letter, key) {
    const cells = mirrored(row, col).filter(([r, c]) => letterAt(store.camera, r, c) !== letter);
    if (cells.length > 0) store.change(paint(store.camera, cells, letter), "painting", key);
    const others = cells.filter(([r, c]) => r !== row || c !== col).length;
    announce(`Row ${row + 1}, column ${col + 1}: ${letter}${others > 0 ? `, and ${others} more ${others === 1 ? "cell" : "cells"} by symmetry` : ""}`);
  }

  // Symmetry stays on, so it is said beside the tile what a stroke does.
  const strokeNote = byId("stroke-note", HTMLElement);
  const showStroke = () => {
    const { text } = symmetry.selectedOptions[0];
    strokeNote.textContent = symmetry.value === "none" ? "A stroke paints one cell." : `Symmetry is on (${text.toLowerCase()}): a stroke paints ${symmetry.value === "both" ? "up to four cells" : "up to two cells"}.`;
  };
  symmetry.addEventListener("change", () => {
    showStroke();
    announce(strokeNote.textContent ?? "");
  });
  showStroke();

  /** @param {number} row @param {number} col */
  function lockAt(row, col) {
    store.toggleLock(store.lockedCells, `${row},${col}`);
    announce(`Row ${row + 1}, column ${col + 1} ${store.lockedCells.has(`${row},${col}`) ? "locked" : "free"}`);
  }

  /** @param {number} row @param {number} col */
  function focus(row, col) {
    const [rows, cols] = size(store.camera);
    [atRow, atCol] = [(row + rows) % rows, (col + cols) % cols];
    for (const cell of grid.querySelectorAll('[tabindex="0"]')) cell.setAttribute("tabindex", "-1");
    const cell = cellAt(atRow, atCol);
    cell.tabIndex = 0;
    cell.focus();
  }

  /** The letter that a key stands for: its own, or that of the filter with its number. @param {string} key */
  function letterOf(key) {
    const all = letters(store.camera);
    if (/^[1-9]$/.test(key)) return all[Number(key) - 1];
    return all.find((l) => l === key) ?? all.find((l) => l === key.toUpperCase()) ?? all.find((l) => l === key.toLowerCase());
  }

  grid.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = ARROWS[event.key];
    if (arrow) {
      const letter = letterAt(store.camera, atRow, atCol);
      focus(atRow + arrow[0], atCol + arrow[1]);
      if (event.shiftKey) paintAt(atRow, atCol, letter, `stroke ${stroke}`);
    } else if (event.key === "Home" || event.key === "End") {
      focus(atRow, event.key === "Home" ? 0 : size(store.camera)[1] - 1);
    } else if (event.key === " " || event.key === "Enter") {
      if (lockCells.checked) lockAt(atRow, atCol);
      else paintAt(atRow, atCol, store.selected, `stroke ${++stroke}`);
    } else {
      const letter = letterOf(event.key);
      if (letter === undefined) return;
      store.select(letter);
      paintAt(atRow, atCol, letter, `stroke ${++stroke}`);
    }
    event.preventDefault();
  });

  /** @param {PointerEvent} event @returns {[number, number] | undefined} */
  function under(event) {
    const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest("[data-cell]");
    if (!(cell instanceof HTMLElement) || !grid.contains(cell)) return undefined;
    const [row, col] = (cell.dataset.cell ?? "").split(",").map(Number);
    return [row, col];
  }
  /** Whether the finger that is down scrolls a large tile in its box, so that only a tap paints. */
  let isScrolling = false;
  grid.addEventListener("click", (event) => {
    const at = under(/** @type {PointerEvent} */ (event));
    if (!isScrolling || !at) return;
    focus(...at);
    if (lockCells.checked) lockAt(...at);
    else paintAt(...at, store.selected, `stroke ${++stroke}`);
  });
  grid.addEventListener("pointerdown", (event) => {
    const at = under(event);
    isScrolling = event.pointerType === "touch" && getComputedStyle(grid).touchAction !== "none";
    if (!at || event.button !== 0 || isScrolling) return;
    event.preventDefault();
    focus(...at);
    if (lockCells.checked) return lockAt(...at);
    stroke += 1;
    grid.setPointerCapture(event.pointerId);
    paintAt(...at, store.selected, `stroke ${stroke}`);
  });
  grid.addEventListener("pointermove", (event) => {
    if (!grid.hasPointerCapture(event.pointerId)) return;
    const at = under(event);
    if (at) paintAt(...at, store.selected, `stroke ${stroke}`);
  });
  grid.addEventListener("lostpointercapture", () => store.end());

  for (const field of [rowsField, colsField]) {
    field.addEventListener("change", () => {
      const side = (/** @type {HTMLInputElement} */ f) => Math.min(Math.max(Math.round(Number(f.value)) || 1, 1), MAX_SIDE);
      const [rows, cols] = [side(rowsField), side(colsField)];
      store.change(resize(store.camera, rows, cols), "the size");
      [rowsField.value, colsField.value] = [String(rows), String(cols)];
      announce(`${counted(rows, "row")}, ${counted(cols, "column")}`);
    });
  }

  // Mosaics of mixtures have letters without a filter, which this editor does not paint.
  const plain = engine.catalogue.cfas.filter(({ tile, filters }) => Math.max(tile.length, tile[0].length) <= MAX_SIDE && [...tile.join("")].every((l) => l in filters));
  template.append(...plain.map(({ name, tile }) => make("option", { value: name }, `${name} (${tile.length} × ${tile[0].length})`)));
  /** Why the last mosaic was refused. */
  let refusal = "";
  /** Gives a mosaic of the catalogue to the design, as it is when the engine has answered. @param {Engine["catalogue"]["cfas"][number]} chosen */
  async function startFrom(chosen) {
    const { name, tile } = chosen;
    const { at, camera, origin } = store;
    const found = await withMosaic(engine, camera, origin, name);
    if (store.at !== at || store.camera !== camera) return startFrom(chosen);
    if ("missing" in found) {
      const { missing } = found;
      const filters = missing.length === 1 ? `a filter for ${missing[0]}` : `filters for ${missing.join(", ")}`;
      refusal = `${name} needs ${filters}, and ${origin.base.name} has curves of its own, which the generic filters of the catalogue do not fit. Add filters with these letters, or start from another camera preset.`;
      return tell(refusal, "trouble");
    }
    untell(refusal);
    store.change(found.camera, `the mosaic ${name}`, undefined, found.origin);
    announce(`${name}: ${counted(tile.length, "row")}, ${counted(tile[0].length, "column")}, ${counted(letters(store.camera).length, "filter")}`);
  }
  template.addEventListener("change", async () => {
    const chosen = plain.find(({ name }) => name === template.value);
    try {
      if (chosen) await startFrom(chosen);
    } catch (error) {
      tell(`${message(error)}.`, "trouble");
    }
    // It has the name of the mosaic until the design has it.
    if (template.value === chosen?.name) template.value = "";
  });

  const add = make("button", { type: "button", class: "swatch add", "aria-label": "Add a filter", title: "Add a filter", click: () => {
    const added = addFilter(store.camera, { gaussian: { center_nm: 500, sigma_nm: 30, peak: 0.9 } });
    if (!added) return;
    store.change(added[0], `the filter ${added[1]}`);
    store.select(added[1]);
    announce(`Filter ${added[1]} added. Paint cells with it.`);
  } }, "+");
  const remove = make("button", { type: "button", class: "swatch add", click: () => {
    const all = letters(store.camera);
    const gone = store.selected;
    const instead = all[(all.indexOf(gone) + 1) % all.length];
    if (all.length < 2) return;
    store.change(removeFilter(store.camera, gone, instead), `the filter ${gone}`);
    announce(`Filter ${gone} removed. ${instead} takes its cells.`);
  } }, "−");

  palette.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const all = letters(store.camera);
    store.select(all[(all.indexOf(store.selected) + step + all.length) % all.length]);
    /** @type {HTMLElement | null} */ (palette.querySelector('[aria-checked="true"]'))?.focus();
  });

  function showPalette() {
    const all = letters(store.camera);
    const seen = colors();
    const hadFocus = document.activeElement instanceof HTMLElement && palette.contains(document.activeElement) ? document.activeElement.dataset.letter : undefined;
    palette.replaceChildren(...all.map((letter) => {
      const [cells, of] = share(store.camera, letter);
      const swatch = make("button", {
        type: "button", class: "swatch", role: "radio", "data-letter": letter, "aria-checked": String(letter === store.selected), tabindex: letter === store.selected ? 0 : -1,
        "aria-label": `Filter ${letter}, ${cells} of ${of} cells`, title: `${letter}: ${cells} of ${of} cells`, click: () => store.select(letter),
      }, letter);
      const color = seen[letter] ?? UNKNOWN;
      swatch.style.background = color;
      swatch.style.color = inkOn(color);
      return swatch;
    }));
    remove.setAttribute("aria-disabled", String(all.length < 2));
    remove.setAttribute("aria-label", `Remove filter ${store.selected}`);
    remove.title = `Remove filter ${store.selected}`;
    if (hadFocus) /** @type {HTMLElement | null} */ (palette.querySelector(`[data-letter="${CSS.escape(hadFocus)}"]`))?.focus();
  }
  byId("palette-more", HTMLDivElement).append(add, remove);

  function show() {
    const [rows, cols] = size(store.camera);
    const seen = colors();
    if (grid.children.length !== rows || grid.children[0].children.length !== cols) {
      const hadFocus = grid.contains(document.activeElement);
      [atRow, atCol] = [Math.min(atRow, rows - 1), Math.min(atCol, cols - 1)];
      const cell = (/** @type {number} */ row, /** @type {number} */ col) => make("div", { role: "gridcell", "data-cell": `${row},${col}`, tabindex: row === atRow && col === atCol ? 0 : -1 });
      grid.replaceChildren(...Array.from({ length: rows }, (_, row) => make("div", { role: "row" }, ...Array.from({ length: cols }, (_, col) => cell(row, col)))));
      grid.style.setProperty("--cols", String(cols));
      grid.style.setProperty("--side", String(Math.max(rows, cols)));
      grid.parentElement?.toggleAttribute("data-large", Math.max(rows, cols) > LARGE_SIDE);
      grid.setAttribute("aria-rowcount", String(rows));
      grid.setAttribute("aria-colcount", String(cols));
      if (hadFocus) cellAt(atRow, atCol).focus();
    }
    for (let row = 0; row < rows; row += 1) {
      for (let col = 0; col < cols; col += 1) {
        const cell = cellAt(row, col);
        const letter = letterAt(store.camera, row, col);
        const color = seen[letter] ?? UNKNOWN;
        const isLocked = store.lockedCells.has(`${row},${col}`);
        cell.textContent = letter;
        cell.style.background = color;
        cell.style.color = inkOn(color);
        cell.toggleAttribute("data-locked", isLocked);
        cell.setAttribute("aria-label", `Row ${row + 1}, column ${col + 1}: ${letter}${isLocked ? ", locked" : ""}`);
      }
    }
    // A number that is being typed stays.
    if (store.jumps || document.activeElement !== rowsField) rowsField.value = String(rows);
    if (store.jumps || document.activeElement !== colsField) colsField.value = String(cols);
    showPalette();
  }
  store.on(["design", "view"], show);
  return show;
}
