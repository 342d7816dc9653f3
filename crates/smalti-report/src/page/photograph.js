// Pictures of designs, drawn here as the simulator makes them: the light on the pixels is a sum of few pictures with a spectrum each, so a
// filter makes of each of them one number. Then the read-out, demosaicking, the design's colour matrix, the display.

// Random numbers of a seed (sfc32): uniform, normal (Box and Muller), Poisson of a mean.
function randomOf(seed) {
  let [a, b, c, d] = [0x9e3779b9, 0x243f6a88, 0xb7e15162, seed | 0];
  const uniform = () => {
    const t = (((a + b) | 0) + d) | 0;
    d = (d + 1) | 0;
    a = b ^ (b >>> 9);
    b = (c + (c << 3)) | 0;
    c = ((c << 21) | (c >>> 11)) + t | 0;
    return ((t >>> 0) + 0.5) / 4294967296;
  };
  for (let i = 0; i < 15; i += 1) uniform();
  let spare = null;
  const normal = () => {
    if (spare !== null) {
      const kept = spare;
      spare = null;
      return kept;
    }
    const [size, angle] = [Math.sqrt(-2 * Math.log(uniform())), 2 * Math.PI * uniform()];
    spare = size * Math.sin(angle);
    return size * Math.cos(angle);
  };
  const poisson = (mean) => {
    if (mean > 40) return Math.max(0, Math.round(mean + Math.sqrt(mean) * normal()));
    const end = Math.exp(-mean);
    let n = 0;
    for (let p = uniform(); p > end; p *= uniform()) n += 1;
    return n;
  };
  return { uniform, normal, poisson };
}

// What a filter makes of a spectrum of the stage, per nm of step.
function through(filter, spectrum, from = 0) {
  return filter.reduce((sum, t, i) => sum + Math.max(0, t) * spectrum[from + i], 0);
}

// Photoelectrons per second of a channel at every pixel.
function ratesOf(planes, weights) {
  const out = new Float32Array(planes[0].length);
  planes.forEach((plane, k) => { for (let i = 0; i < out.length; i += 1) out[i] += weights[k] * plane[i]; });
  return out;
}
// The channel of the mosaic at every pixel; without a mosaic a plane for each channel. A border of pixels around goes on with the
// pattern, in the light of the outermost.
function seen(rates, rows, cols, mosaic, border) {
  const [height, width] = [rows + 2 * border, cols + 2 * border];
  const within = (v, n) => Math.min(n - 1, Math.max(0, v));
  const modulo = (v, n) => ((v % n) + n) % n;
  return (mosaic ? [rates] : rates.map((one) => [one])).map((channels) => {
    const out = new Float32Array(height * width);
    for (let r = -border, i = 0; r < rows + border; r += 1) {
      const line = mosaic && mosaic.rows[modulo(r, mosaic.down)];
      for (let c = -border; c < cols + border; c += 1, i += 1) {
        const channel = mosaic ? line[modulo(c, mosaic.across)] : 0;
        out[i] = channels[channel][within(r, rows) * cols + within(c, cols)];
      }
    }
    return out;
  });
}
// What pixels give to their neighbours, from a plane with a border of one.
function spread(wide, rows, cols, kernel) {
  const out = new Float32Array(rows * cols);
  for (let r = 0, at = 0; r < rows; r += 1) {
    for (let c = 0; c < cols; c += 1, at += 1) {
      let sum = 0;
      for (let i = 0; i < 3; i += 1) for (let j = 0; j < 3; j += 1) sum += kernel[i][j] * wide[(r + 2 - i) * (cols + 2) + c + 2 - j];
      out[at] = sum;
    }
  }
  return out;
}

// Samples from photoelectrons per second: 0 at black level, 1 at saturation. In the order of smalti::sensor. `pattern` is what belongs
// to the device, `random` to the capture; without noise there are none.
function readOut(rates, rows, cols, time, readout, pattern, random) {
  const out = new Float32Array(rates.length);
  const columns = Array.from({ length: cols }, () => (random ? readout.column_noise_v * pattern.normal() : 0));
  const defects = readout.dead + readout.hot;
  for (let r = 0, i = 0; r < rows; r += 1) {
    const line = random ? readout.row_noise_v * random.normal() : 0;
    for (let c = 0; c < cols; c += 1, i += 1) {
      let electrons = rates[i] * time;
      let [response, offset] = [1, 0];
      if (random) {
        const defect = defects > 0 ? pattern.uniform() : 1;
        electrons = defect < readout.dead ? 0 : electrons + time * (defect < defects ? readout.hot_e_per_s : readout.dark_e_per_s);
        electrons = random.poisson(electrons);
        if (readout.prnu) response = Math.max(0, 1 + readout.prnu * pattern.normal());
        if (readout.dsnu_v) offset += readout.dsnu_v * pattern.normal();
        offset += readout.read_noise_v * random.normal() + line + columns[c];
      }
      let volts = Math.min(electrons, readout.full_well_e) * readout.gain_v_per_e * response + offset;
      volts = Math.min((volts + readout.analog_offset_v) * readout.analog_gain, readout.swing_v);
      if (readout.step_v) {
        const [low, high] = readout.range_v;
        volts = low + readout.step_v * Math.round((Math.min(high, Math.max(low, volts)) - low) / readout.step_v);
      }
      out[i] = (volts - readout.black_v) / (readout.white_v - readout.black_v);
    }
  }
  return out;
}

// The exposure time, s, of each picture: the stated one, or that of the rule.
function timeOf(metered, filters, rates, { readout, light }, step) {
  if (readout.time_s !== null) return readout.time_s / (readout.in_turn ? filters.length : 1);
  const mean = (of) => of.reduce((sum, v) => sum + v, 0) / of.length;
  const rate = metered ? light * step * Math.max(...filters.map((f) => through(f, metered))) : mean(rates.map(mean));
  return readout.metered_v / ((rate + readout.dark_e_per_s) * readout.gain_v_per_e);
}

// What it takes to draw a design; or why there is none of it, and whether another page may have it.
function studioOf(designs, row) {
  const drawn = designs.data.sections[designs.section[row]].drawn;
  if (drawn.none) return { none: drawn.none, isElsewhere: drawn.is_elsewhere };
  const stage = designs.stages[drawn.stage];
  if (!(designs.matrices.scale[row] > 0)) return { none: "it has no colour matrix", isElsewhere: false };
  const [first, step, count] = stage.nm;
  const nm = Array.from({ length: count }, (_, i) => first + i * step);
  const filters = [];
  for (let at = designs.start[row]; at < designs.start[row + 1]; at += 1) filters.push(curveOf(designs, at, nm));
  if (filters.some((f) => !f)) return { none: "the spectra of its filters are not in it", isElsewhere: true };
  const isMosaic = !drawn.readout.all_channels;
  const tile = isMosaic && designs.tile ? designs.tile.words[designs.tile.codes[row]] : null;
  if (isMosaic && !tile) return { none: "its mosaic is not in it", isElsewhere: true };
  if (tile && tile.length * filters.length > MOST_TAPS) return { none: "its mosaic is too large to be drawn here", isElsewhere: true };
  return { studio: { designs, row, drawn, stage, filters, tile } };
}
// Cells times channels of a mosaic: the taps of these are found in a second.
const MOST_TAPS = 60000;

// The picture of a scene, RGBA.
async function photograph({ designs, row, drawn, stage, filters, tile }, which, isNoisy) {
  const scene = stage.scenes[which];
  const planes = await scene.planes();
  const { rows, cols } = scene;
  const { readout } = drawn;
  const [, step, count] = stage.nm;
  const mosaic = tile && mosaicOf(tile);
  if (mosaic && !mosaic.isWhole) throw new Error("the samples of a channel are too far apart");
  const weights = filters.map((f) => planes.map((_, k) => drawn.light * step * scene.step * through(f, scene.spectra, k * count)));
  const border = readout.crosstalk ? 1 : 0;
  let rates = seen(weights.map((w) => ratesOf(planes, w)), rows, cols, mosaic, border);
  if (border) rates = rates.map((wide) => spread(wide, rows, cols, readout.crosstalk));
  const time = timeOf(drawn.metered[which] && unpack(drawn.metered[which]), filters, rates, drawn, step);
  const random = isNoisy ? randomOf(1 + designs.number[row]) : null;
  // Captures in turn are of one device, with one pattern; those behind a prism of one each.
  let pattern;
  const samples = rates.map((one) => {
    if (!pattern || readout.in_turn) pattern = randomOf(0);
    return readOut(one, rows, cols, time, readout, pattern, random);
  });
  return displayed(mosaic ? demosaicked(samples[0], rows, cols, mosaic) : samples, designs, row, stage);
}

// As bright as a viewer expects: all but the brightest few pixels are within the range of the display.
function displayed(channels, designs, row, stage) {
  const { scale, codes } = designs.matrices;
  const matrix = channels.map((_, k) => [0, 1, 2].map((i) => codes[3 * (designs.start[row] + k) + i] * scale[row]));
  const size = channels[0].length;
  const luminance = new Float32Array(size);
  channels.forEach((plane, k) => { for (let i = 0; i < size; i += 1) luminance[i] += matrix[k][1] * plane[i]; });
  const bright = luminance.slice().sort()[Math.floor((size - 1) * (1 - stage.bright_share))];
  const gain = bright > 0 ? 1 / bright : 1;
  const rgba = new Uint8ClampedArray(4 * size).fill(255);
  stage.rgb_from_xyz.forEach((line, color) => {
    const weights = matrix.map((xyz) => gain * (line[0] * xyz[0] + line[1] * xyz[1] + line[2] * xyz[2]));
    for (let i = 0; i < size; i += 1) {
      let v = 0;
      for (let k = 0; k < weights.length; k += 1) v += weights[k] * channels[k][i];
      rgba[4 * i + color] = encoded(v);
    }
  });
  return rgba;
}
