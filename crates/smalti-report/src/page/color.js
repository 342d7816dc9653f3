// Colours that people with any colour vision distinguish.

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
