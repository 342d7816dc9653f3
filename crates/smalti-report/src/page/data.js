// Columns as Rust packs them (columns.rs), and the trials made of them.

function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i += 1) bytes[i] = letters.charCodeAt(i);
  return bytes;
}
function floatsOf(text) {
  return new Float32Array(bytesOf(text).buffer);
}
function unpack(column) {
  if (column.f32 !== undefined) return floatsOf(column.f32);
  const table = floatsOf(column.table);
  const values = new Float32Array(column.n);
  if (column.u8 === undefined && column.u16 === undefined) return column.n > 0 ? values.fill(table[0]) : values;
  const codes = column.u8 !== undefined ? bytesOf(column.u8) : new Uint16Array(bytesOf(column.u16).buffer);
  for (let i = 0; i < values.length; i += 1) values[i] = table[codes[i]];
  return values;
}
function unrun(runs, count) {
  const values = new Float64Array(count);
  let at = 0;
  for (let i = 0; i + 1 < runs.length; i += 2) {
    for (let k = 0; k < runs[i + 1]; k += 1) values[at++] = runs[i] + k;
  }
  return values;
}

async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
// Pictures of whole numbers, as whole_pictures of columns.rs packs them, one after the other.
async function unpackPictures({ rows, cols, count, deflated }) {
  const bytes = await inflated(deflated);
  const size = rows * cols;
  const pictures = new Int32Array(count * size);
  for (let k = 0; k < count; k += 1) {
    const picture = pictures.subarray(k * size, (k + 1) * size);
    for (let i = 0, row = 0; row < rows; row += 1) {
      for (let col = 0; col < cols; col += 1, i += 1) {
        const at = k * size + i;
        const high = count * size + 2 * at;
        const code = bytes[at] | (bytes[high] << 8) | (bytes[high + 1] << 16);
        const left = col ? picture[i - 1] : 0;
        const above = row ? picture[i - cols] : 0;
        let expected = row ? above : left;
        if (row && col) expected = Math.max(Math.min(left, above), Math.min(Math.max(left, above), left + above - picture[i - cols - 1]));
        picture[i] = expected + ((code >> 1) ^ -(code & 1));
      }
    }
  }
  return pictures;
}

// Curves of filters, as filters.rs packs them; none in a browser that cannot inflate.
async function unpackCurves({ blocks }) {
  return Promise.all(blocks.map(unpackPictures)).catch(() => []);
}
// A colour that is one number, as [r, g, b].
function rgbOf(number) {
  return [number >> 16, (number >> 8) & 255, number & 255];
}

// A column of numbers whose values are made when they are first asked for.
function lazyColumn(about, values) {
  let made;
  return {
    better: "", unit: "", doc: "", ...about,
    get values() {
      made ??= values();
      return made;
    },
  };
}

function readTrials(data, curves) {
  const count = data.rows;
  const colors = unpack(data.colors);
  const start = new Uint32Array(count + 1);
  for (let i = 0; i < count; i += 1) start[i + 1] = start[i] + colors[i];
  const used = unpack(data.filters.used);
  const ofUsed = (column) => {
    const values = unpack(column);
    return Float32Array.from(used, (filter) => values[filter]);
  };
  const trials = {
    data, count, colors, start,
    number: unrun(data.number, count),
    section: unpack(data.section),
    front: unpack(data.front),
    marks: data.marks.map((m) => ({ ...m, rows: unpack(m.rows) })),
    center: ofUsed(data.filters.center),
    fwhm: ofUsed(data.filters.fwhm),
    peak: ofUsed(data.filters.peak),
    used, filterColors: unpack(data.filters.color),
    curves: { ...data.filters.curves, blocks: curves },
    scale: { ...data.filters.scale, colors: unpack(data.filters.scale.color) },
    words: data.words.map((w) => ({ ...w, words: w.values.words, codes: unpack(w.values.codes) })),
    pictures: new Map(data.pictures.map((p) => [p.row, p])),
    opticalSetups: data.optical_setups,
  };
  trials.tile = trials.words.find((w) => w.name === "tile");
  trials.reliability = trials.words.find((w) => w.name === "mtf50_reliability");
  if (data.sections.length > 1) {
    // The study is named where there are several.
    const several = data.studies.length > 1;
    const names = data.sections.map((s) => (several ? s.name : s.condition));
    const label = !several ? "Condition" : data.sections.some((s) => s.condition) ? "Study and condition" : "Study";
    trials.condition = { name: "section", label, doc: "", words: names, codes: trials.section };
    trials.words.unshift(trials.condition);
  }
  trials.columns = [
    lazyColumn({ name: "colors", label: "Number of colours" }, () => colors),
    ...data.columns.map((c) => lazyColumn(c, () => unpack(c.values))),
    ...ofFilters(trials),
  ];
  return trials;
}

// Parameters: what the filters of each design have in common, and those of each filter.
function ofFilters(trials) {
  const { count, colors, start, center, fwhm } = trials;
  const each = (f) => () => {
    const out = new Float32Array(count);
    for (let i = 0; i < count; i += 1) out[i] = f(start[i], start[i + 1]);
    return out;
  };
  const most = colors.reduce((a, b) => Math.max(a, b), 0);
  const fold = (values, f, from) => (a, b) => {
    let out = from;
    for (let k = a; k < b; k += 1) out = f(out, values[k]);
    return out;
  };
  const columns = [
    lazyColumn({ name: "least_spacing_nm", label: "Least spacing of centres", unit: "nm", parameter: true }, each((a, b) => {
      let least = Infinity;
      for (let k = a + 1; k < b; k += 1) least = Math.min(least, center[k] - center[k - 1]);
      return least === Infinity ? NaN : least;
    })),
    lazyColumn({ name: "mean_fwhm_nm", label: "Mean width (FWHM)", unit: "nm", parameter: true },
      each((a, b) => fold(fwhm, (s, v) => s + v, 0)(a, b) / (b - a))),
    lazyColumn({ name: "least_fwhm_nm", label: "Narrowest filter (FWHM)", unit: "nm", parameter: true }, each(fold(fwhm, Math.min, Infinity))),
    lazyColumn({ name: "largest_fwhm_nm", label: "Widest filter (FWHM)", unit: "nm", parameter: true }, each(fold(fwhm, Math.max, -Infinity))),
  ];
  for (let k = 0; k < most; k += 1) {
    const at = (values) => each((a, b) => (a + k < b ? values[a + k] : NaN));
    columns.push(lazyColumn({ name: `center_${letter(k)}_nm`, label: `Centre of filter ${letter(k)}`, unit: "nm", parameter: true }, at(center)));
    columns.push(lazyColumn({ name: `fwhm_${letter(k)}_nm`, label: `Width of filter ${letter(k)}`, unit: "nm", parameter: true }, at(fwhm)));
  }
  return columns;
}
function letter(index) {
  return String.fromCharCode(65 + (index % 26));
}

function withUnit(column) {
  return column.unit ? `${column.label}, ${column.unit}` : column.label;
}
// A value with as many digits as a reader compares.
function shown(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e6) return String(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2);
  return value.toFixed(size < 1 ? 3 : size < 20 ? 2 : 1);
}
// Values between which a share of them lies: [low, high], of those that are numbers.
function quantiles(values, keep, shares) {
  let some = [];
  const step = Math.max(1, Math.floor(values.length / 20000));
  for (let i = 0; i < values.length; i += step) if ((!keep || keep[i]) && Number.isFinite(values[i])) some.push(values[i]);
  some = Float32Array.from(some).sort();
  return shares.map((s) => (some.length ? some[Math.round(s * (some.length - 1))] : NaN));
}
function extent(values, keep) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; i += 1) {
    if ((!keep || keep[i]) && Number.isFinite(values[i])) {
      if (values[i] < low) low = values[i];
      if (values[i] > high) high = values[i];
    }
  }
  return [low, high];
}
