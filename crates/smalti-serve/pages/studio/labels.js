// @ts-check
// Places for the letters of curves, where they neither lie on each other nor, if that can be, on a line.

/** A point of the plot. @typedef {[x: number, y: number]} Point */
/** @typedef {{ left: number, right: number, top: number, bottom: number }} Box */
/** A curve by the letter that it gets. @typedef {{ letter: string, points: Point[] }} Curve */

/** Half of the width and of the height of a letter with its halo, and how far its middle is from its curve, in text of usual size. */
const [HALF_WIDTH, HALF_HEIGHT, AWAY] = [7, 8, 12];
/** What counts against a place: a letter or a handle there, a curve through it, another line through it, a height far below the peak, and a pixel between it and the peak. */
const [TAKEN, CROSSED, LINED, LOW, FAR] = [1e6, 1000, 150, 2000, 1];
/** From a point of the curve: above, below, and beside it. @type {Point[]} */
const SIDES = [[0, -1], [0, 1], [-1, 0], [1, 0]];

/** @param {Point} at @param {number} scale @returns {Box} */
const around = ([x, y], scale) => ({ left: x - HALF_WIDTH * scale, right: x + HALF_WIDTH * scale, top: y - HALF_HEIGHT * scale, bottom: y + HALF_HEIGHT * scale });
/** @param {Box} a @param {Box} b */
const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;

/** Whether a line from point to point goes through a box. @param {Point[]} points @param {Box} box */
function crosses(points, { left, right, top, bottom }) {
  return points.some(([x1, y1], i) => {
    if (i === 0) return false;
    const [x0, y0] = points[i - 1];
    const [from, to] = [Math.max(left, Math.min(x0, x1)), Math.min(right, Math.max(x0, x1))];
    if (from > to) return false;
    const y = (/** @type {number} */ x) => (x1 === x0 ? y0 : y0 + (y1 - y0) * (x - x0) / (x1 - x0));
    const ends = x1 === x0 ? [y0, y1] : [y(from), y(to)];
    return Math.min(...ends) < bottom && Math.max(...ends) > top;
  });
}

/**
 * The middle of the letter of each curve: near its peak, beside the curve. Curves that come first choose first.
 * @param {Curve[]} curves @param {Point[][]} lines Other lines. @param {Box[]} taken Boxes in which no letter stands. @param {Box} room Where letters stand.
 * @param {number} scale The size of text, relative to the usual one. @returns {Map<string, Point>}
 */
export function placeLabels(curves, lines, taken, room, scale) {
  /** @type {Map<string, Point>} */
  const places = new Map();
  const boxes = [...taken];
  for (const { letter, points } of curves) {
    const highest = Math.min(...points.map(([, y]) => y));
    const peak = points.find(([, y]) => y === highest) ?? points[0];
    let best = { cost: Infinity, at: peak };
    for (const [x, y] of points) {
      for (const [i, [right, down]] of SIDES.entries()) {
        const at = /** @type {Point} */ ([x + right * AWAY * scale, y + down * AWAY * scale]);
        const box = around(at, scale);
        if (box.left < room.left || box.right > room.right || box.top < room.top || box.bottom > room.bottom) continue;
        const isLow = y > (highest + room.bottom) / 2;
        // Of places that are as good, the first side is the best.
        let cost = FAR * Math.hypot(x - peak[0], y - peak[1]) + (isLow ? LOW : 0) + 4 * i;
        if (cost >= best.cost) continue;
        cost += TAKEN * boxes.filter((other) => overlap(box, other)).length;
        if (cost >= best.cost) continue;
        cost += CROSSED * curves.filter((curve) => crosses(curve.points, box)).length + LINED * lines.filter((line) => crosses(line, box)).length;
        if (cost < best.cost) best = { cost, at };
      }
    }
    places.set(letter, best.at);
    boxes.push(around(best.at, scale));
  }
  return places;
}
