// @ts-check
// Cells of a mosaic in their colours.
import { draw } from "./dom.js";

/** The colour of a filter whose colour is not known. */
export const UNKNOWN = "#888888";

/** The ink that reads on a colour: of black and white, that with more contrast, which is at least 4.58:1. @param {string} color `#rrggbb` */
export function inkOn(color) {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.179 ? "#000000" : "#ffffff";
}

/** The side of a cell, and the space between two, in units of the drawing. */
const [SIDE, GAP] = [20, 2];

/** A tile as a drawing. @param {string[]} pattern Its letters, row by row. @param {Record<string, string>} colors Of the filters, by letter. @returns {SVGSVGElement} */
export function drawnTile(pattern, colors) {
  const [height, width] = [pattern.length, pattern[0].length].map((n) => n * (SIDE + GAP) - GAP);
  const cells = pattern.flatMap((line, row) => [...line].flatMap((letter, col) => {
    const [x, y] = [col, row].map((n) => n * (SIDE + GAP));
    const color = colors[letter] ?? UNKNOWN;
    return [
      draw("rect", { x, y, width: SIDE, height: SIDE, rx: 2, fill: color }),
      draw("text", { x: x + SIDE / 2, y: y + SIDE / 2, "text-anchor": "middle", "dominant-baseline": "central", color: inkOn(color) }, letter),
    ];
  }));
  return draw("svg", { class: "tile-drawing", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Mosaic, row by row: ${pattern.join(", ")}` }, ...cells);
}
