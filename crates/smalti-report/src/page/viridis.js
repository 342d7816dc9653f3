// Viridis, the colours of values: that of color.rs.

const VIRIDIS = [
  0x440154, 0x481769, 0x472a7a, 0x433d84, 0x3d4e8a, 0x355e8d, 0x2e6d8e, 0x297b8e, 0x23898e, 0x1f978b,
  0x21a585, 0x2eb37c, 0x46c06f, 0x65cb5e, 0x89d548, 0xb0dd2f, 0xd8e219, 0xfde725,
];
const channelsOf = (word) => [word >> 16, (word >> 8) & 255, word & 255];
// Viridis at a place along its entries.
function between(place) {
  const i = Math.min(VIRIDIS.length - 2, Math.floor(place));
  const [a, b] = [channelsOf(VIRIDIS[i]), channelsOf(VIRIDIS[i + 1])];
  return a.map((v, c) => Math.round(v + (b[c] - v) * (place - i)));
}
function viridis(t) {
  // The palest yellow is lost on white, the darkest violet on black.
  const [low, high] = isDark() ? [0.16, 1] : [0, 0.93];
  return between((low + (high - low) * Math.min(1, Math.max(0, t))) * (VIRIDIS.length - 1));
}
