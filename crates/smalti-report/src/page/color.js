// Colours that people with any colour vision tell apart, and the colours of filters: those of color.rs.

const OKABE_ITO = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0], [110, 110, 110], [190, 175, 30]];
function css([r, g, b]) {
  return `rgb(${r} ${g} ${b})`;
}
// One colour for a number of colours, in all figures.
function colorOfCount(colors) {
  return category(colors + OKABE_ITO.length - 3);
}
function category(place) {
  const color = OKABE_ITO[place % OKABE_ITO.length];
  // Dark colours are lifted off a dark page.
  return isDark() ? color.map((v) => Math.round(v + (255 - v) * 0.22)) : color;
}

// The CIE 1931 colour-matching functions after the fit of Wyman et al. 2013.
function matching(wavelength) {
  const nm = Math.min(655, Math.max(415, wavelength));
  const fade = Math.exp(-Math.max((nm - wavelength) / 9, (wavelength - nm) / 15, 0));
  const lobe = (center, left, right) => {
    const t = (nm - center) * (nm < center ? left : right);
    return fade * Math.exp(-0.5 * t * t);
  };
  return [
    0.362 * lobe(442, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323) - 0.065 * lobe(501.1, 0.049, 0.0382),
    0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
    1.217 * lobe(437, 0.0845, 0.0278) + 0.681 * lobe(459, 0.0385, 0.0725),
  ];
}
// White is added to what the display cannot show, the brightest channel becomes `peak`.
function display([x, y, z], peak) {
  let linear = [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.204 * y + 1.057 * z];
  const missing = Math.min(0, ...linear);
  linear = linear.map((v) => v - missing);
  const top = Math.max(0, ...linear);
  return linear.map((v) => encoded(top > 0 ? (v / top) * peak : 0));
}
// Linear light, 0 to 1, as a byte of sRGB (IEC 61966-2-1).
function encoded(linear) {
  const v = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}
// About the colour of a filter under equal-energy light: hue as seen, brightness such that it stands out.
function colorOfFilter(nm, transmittance) {
  const xyz = [0, 0, 0];
  nm.forEach((wavelength, i) => {
    const t = transmittance[i];
    if (t > 0) matching(wavelength).forEach((m, c) => { xyz[c] += m * t; });
  });
  const full = display(xyz, 0.75).map((v) => v + (128 - v) * 0.1);
  const [r, g, b] = full;
  const dark = Math.min(1, 145 / Math.max(1, 0.299 * r + 0.587 * g + 0.114 * b));
  return full.map((v) => Math.round(v * dark));
}
function colorOfWavelength(nm) {
  return display(matching(nm), Math.min(1, Math.max(0.12, Math.min((nm - 375) / 45, (730 - nm) / 60))));
}
