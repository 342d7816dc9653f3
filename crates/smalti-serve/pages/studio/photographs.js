// @ts-check
// Photographs of the visitor. They stay in this browser.

/** The largest file, bytes. */
const MOST_BYTES = 64 << 20;
/** The most pixels of a file, which the browser decodes as a whole. */
const MOST_PIXELS = 120e6;
/** The most pixels of a scene, and along a side. */
const [SCENE_PIXELS, SCENE_SIDE] = [400_000, 1024];
/** The fewest pixels along a side of a scene. */
const LEAST_SIDE = 32;

/**
 * The size that the header of a PNG or JPEG file states; `undefined` when it is neither.
 * @param {DataView} view @returns {[width: number, height: number] | undefined}
 */
export function sizeOf(view) {
  const has = (/** @type {number} */ bytes) => view.byteLength >= bytes;
  if (has(24) && view.getUint32(0) === 0x89504e47) return [view.getUint32(16), view.getUint32(20)];
  if (!has(4) || view.getUint16(0) !== 0xffd8) return undefined;
  for (let at = 2; has(at + 9) && view.getUint8(at) === 0xff; ) {
    const marker = view.getUint8(at + 1);
    // The frame header is that of any coding except tables (DHT, JPG, DAC).
    if (marker >= 0xc0 && marker <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(marker)) return [view.getUint16(at + 7), view.getUint16(at + 5)];
    // Fill bytes and markers without a length.
    if (marker === 0xff) at += 1;
    else at += marker >= 0xd0 && marker <= 0xd8 ? 2 : 2 + view.getUint16(at + 2);
  }
  return undefined;
}

/** The size of a scene of a photograph, at most that of the photograph. @param {number} width @param {number} height @returns {[number, number]} */
export function sceneSize(width, height) {
  const scale = Math.min(1, SCENE_SIDE / width, SCENE_SIDE / height, Math.sqrt(SCENE_PIXELS / width / height));
  return [Math.floor(width * scale + 1e-9), Math.floor(height * scale + 1e-9)];
}

/**
 * The pixels of a photograph, sRGB, reduced to the size of a scene. Transparent parts become white.
 * @param {File} file @returns {Promise<ImageData>}
 */
export async function readPhotograph(file) {
  const megabytes = (/** @type {number} */ bytes) => `${(bytes / 2 ** 20).toFixed(0)} MB`;
  if (file.size > MOST_BYTES) throw new Error(`the file has ${megabytes(file.size)}; expected at most ${megabytes(MOST_BYTES)}`);
  const stated = sizeOf(new DataView(await file.arrayBuffer()));
  if (!stated) throw new Error("it is neither a PNG nor a JPEG file, or it is damaged");
  const said = `${stated[0]} × ${stated[1]} pixels`;
  if (stated[0] * stated[1] > MOST_PIXELS) throw new Error(`it has ${said}; expected at most ${MOST_PIXELS / 1e6} megapixels`);
  const bitmap = await createImageBitmap(file).catch(() => { throw new Error("the file is damaged: this browser cannot decode it"); });
  const [width, height] = sceneSize(bitmap.width, bitmap.height);
  if (Math.min(width, height) < LEAST_SIDE) {
    bitmap.close();
    throw new Error(`it has ${said}; expected at least ${LEAST_SIDE} pixels along each side, also after a reduction to ${SCENE_SIDE} pixels along the other`);
  }
  const canvas = new OffscreenCanvas(width, height);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true }));
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, width, height);
  bitmap.close();
  return context.getImageData(0, 0, width, height);
}
