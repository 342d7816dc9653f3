// Bilinear demosaicking of any mosaic, as smalti::isp::demosaic does it: where a channel is not sampled, it is interpolated in the
// Delaunay cell of its samples that encloses the pixel; of a cell with more than three corners on its circle, the mean over the fans
// of triangles from each. All in whole numbers, [row, column] from the pixel.

const orient = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
// Positive when p is inside the circle through a, b, c, which turn positively.
function inCircle(a, b, c, p) {
  const [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [a, b, c].map(([r, s]) => [r - p[0], s - p[1], (r - p[0]) ** 2 + (s - p[1]) ** 2]);
  return ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx);
}
// The Delaunay cell on the positive side of its edge a–b; null at the hull.
function cellLeftOf(near, a, b) {
  const left = near.filter((p) => orient(a, b, p) > 0);
  if (!left.length) return null;
  const third = left.reduce((best, p) => (inCircle(a, b, best, p) > 0 ? p : best));
  const rest = left.filter((p) => inCircle(a, b, third, p) === 0);
  return [a, ...[...rest, b].sort((p, q) => -orient(a, p, q))];
}
// The cell that holds the pixel; `near` is sorted by distance from it.
function enclosingCell(near) {
  if (near.length < 3) return null;
  const [start, ...others] = near;
  const distance = (p) => (p[0] - start[0]) ** 2 + (p[1] - start[1]) ** 2;
  const next = others.reduce((best, p) => (distance(p) < distance(best) ? p : best));
  const [a, b] = orient(start, next, [0, 0]) >= 0 ? [start, next] : [next, start];
  let cell = cellLeftOf(near, a, b) ?? cellLeftOf(near, b, a);
  for (let step = 0; cell && step < near.length; step += 1) {
    const at = cell.findIndex((p, i) => orient(p, cell[(i + 1) % cell.length], [0, 0]) < 0);
    if (at < 0) return cell;
    cell = cellLeftOf(near, cell[(at + 1) % cell.length], cell[at]);
  }
  return null;
}
// Whether no sample beyond `reach` can lie in the circle of a cell.
function circleWithin([a, b, c], reach) {
  const [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
  const [b2, c2, d] = [bx * bx + by * by, cx * cx + cy * cy, 2 * orient(a, b, c)];
  const [x, y] = [(cy * b2 - by * c2) / d, (bx * c2 - cx * b2) / d];
  return Math.max(Math.abs(x + a[0]), Math.abs(y + a[1])) + Math.hypot(x, y) < reach + 1 - 1e-6;
}
function fanMean(cell) {
  const n = cell.length;
  const sum = new Array(n).fill(0);
  for (let apex = 0; apex < n; apex += 1) {
    for (let k = 1; k < n - 1; k += 1) {
      const t = [apex, (apex + k) % n, (apex + k + 1) % n];
      const opposite = t.map((_, i) => orient(cell[t[(i + 1) % 3]], cell[t[(i + 2) % 3]], [0, 0]));
      if (opposite.some((v) => v < 0)) continue;
      const area = orient(cell[t[0]], cell[t[1]], cell[t[2]]);
      t.forEach((corner, i) => { sum[corner] += opposite[i] / area / n; });
      break;
    }
  }
  return cell.map(([row, col], i) => ({ row, col, weight: sum[i] })).filter((t) => t.weight > 0);
}
// What a channel at a pixel is made of: places and weights of its samples; null where none within 64 pixels enclose it.
function tapsOf(isSample) {
  if (isSample(0, 0)) return [{ row: 0, col: 0, weight: 1 }];
  for (let reach = 4; reach <= 64; reach *= 2) {
    const near = [];
    for (let r = -reach; r <= reach; r += 1) for (let c = -reach; c <= reach; c += 1) if (isSample(r, c)) near.push([r, c]);
    near.sort((p, q) => p[0] * p[0] + p[1] * p[1] - q[0] * q[0] - q[1] * q[1] || p[0] - q[0] || p[1] - q[1]);
    const cell = enclosingCell(near);
    if (cell && circleWithin(cell, reach)) return fanMean(cell);
  }
  return null;
}

// A mosaic from its rows of letters: its channels, and for each cell of the tile and channel its taps. Kept, since most designs of a
// study share a few.
const mosaics = new Map();
function mosaicOf(tile) {
  if (!mosaics.has(tile)) mosaics.set(tile, newMosaic(tile));
  return mosaics.get(tile);
}
function newMosaic(tile) {
  const rows = tile.split("/").map((row) => [...row].map((c) => c.charCodeAt(0) - 97));
  const [down, across] = [rows.length, rows[0].length];
  const modulo = (a, n) => ((a % n) + n) % n;
  const channelAt = (r, c) => rows[modulo(r, down)][modulo(c, across)];
  const channels = 1 + rows.flat().reduce((most, c) => Math.max(most, c), 0);
  const taps = (row, col) => Array.from({ length: channels }, (_, channel) => tapsOf((r, c) => channelAt(row + r, col + c) === channel));
  const cells = rows.map((line, r) => line.map((_, c) => taps(r, c)));
  let [reach, isWhole] = [0, true];
  for (const found of cells.flat(2)) {
    isWhole &&= found !== null;
    for (const { row, col } of found ?? []) reach = Math.max(reach, Math.abs(row), Math.abs(col));
  }
  return { down, across, channels, rows, cells, reach, isWhole };
}

// A plane for each channel from samples, rows × cols. At the border the weights of the samples that are there are scaled to sum to 1;
// where none is there, the mean of the nearest is taken.
function demosaicked(samples, rows, cols, mosaic) {
  const planes = Array.from({ length: mosaic.channels }, () => new Float32Array(rows * cols));
  const cellAt = (r, c) => mosaic.rows[r % mosaic.down][c % mosaic.across];
  const nearest = (row, col, channel) => {
    for (let ring = 1; ring < Math.max(rows, cols); ring += 1) {
      let [sum, n] = [0, 0];
      for (let r = Math.max(0, row - ring); r <= Math.min(rows - 1, row + ring); r += 1) {
        for (let c = Math.max(0, col - ring); c <= Math.min(cols - 1, col + ring); c += 1) {
          if (cellAt(r, c) === channel) {
            sum += samples[r * cols + c];
            n += 1;
          }
        }
      }
      if (n) return sum / n;
    }
    return 0;
  };
  for (let row = 0; row < rows; row += 1) {
    const inRows = row >= mosaic.reach && row + mosaic.reach < rows;
    const line = mosaic.cells[row % mosaic.down];
    for (let col = 0; col < cols; col += 1) {
      const inside = inRows && col >= mosaic.reach && col + mosaic.reach < cols;
      const at = row * cols + col;
      const cell = line[col % mosaic.across];
      for (let channel = 0; channel < mosaic.channels; channel += 1) {
        let [sum, total, missing] = [0, 0, false];
        for (const t of cell[channel]) {
          if (!inside && (row + t.row < 0 || row + t.row >= rows || col + t.col < 0 || col + t.col >= cols)) {
            missing = true;
            continue;
          }
          sum += t.weight * samples[at + t.row * cols + t.col];
          total += t.weight;
        }
        planes[channel][at] = !missing ? sum : total > 0 ? sum / total : nearest(row, col, channel);
      }
    }
  }
  return planes;
}
