// Makes a page of many designs from a page of few by replacing its data. The content security policy allows this, since data are no script.
// `marked` is the number of designs at the end that have marks.
export function withDesigns(html, count, marked = 0) {
  const found = html.match(/(<script type="application\/json" id="sweep">)(.*?)(<\/script>)/s);
  const data = JSON.parse(found[2]);
  let state = 1;
  const random = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
  const packed = (f) => ({ n: count, f32: Buffer.from(Float32Array.from({ length: count }, (_, i) => f(i)).buffer).toString("base64") });
  const constant = (value) => ({ n: count, table: Buffer.from(Float32Array.of(value).buffer).toString("base64") });
  const ranges = { delta_e_76: [0.6, 25], delta_e_2000: [0.5, 12], mtf50_cy_per_mm: [45, 120], mtf50_cy_per_px: [0.1, 0.3], luminance_noise_percent: [1, 6] };
  const filters = 3 * count;
  const each = (f) => ({ n: filters, f32: Buffer.from(Float32Array.from({ length: filters }, (_, i) => f(i)).buffer).toString("base64") });
  Object.assign(data, {
    rows: count,
    number: [0, count],
    section: constant(0),
    front: constant(0),
    colors: constant(3),
    columns: data.columns.filter((c) => ranges[c.name]).map((c) => ({ ...c, values: packed(() => ranges[c.name][0] + (ranges[c.name][1] - ranges[c.name][0]) * random() * random()) })),
    words: data.words.map((w) => ({ ...w, values: { words: [w.name === "tile" ? "bc/ab" : w.values.words[0]], codes: constant(0) } })),
    // Every filter is another one; those beyond the blocks of the page have no curve.
    filters: {
      ...data.filters, used: each((i) => i), center: each((i) => 450 + 70 * (i % 3)), fwhm: each(() => 60 + 40 * random()),
      peak: { n: filters, table: constant(1).table }, color: { n: filters, table: constant(0x808080).table },
    },
    marks: marked > 0 ? [{ study: "few", name: "", rows: { n: marked, f32: Buffer.from(Float32Array.from({ length: marked }, (_, i) => count - marked + i).buffer).toString("base64") } }] : [],
    pictures: [],
  });
  const json = JSON.stringify(data).replaceAll("<", "\\u003c");
  return html.slice(0, found.index) + found[1] + json + found[3] + html.slice(found.index + found[0].length);
}
