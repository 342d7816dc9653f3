// @ts-check
// The whole design in the fragment of the address, which browsers send to no server: JSON, deflated, in base 64 for addresses.

import { RIVALS, VIEWS } from "./picture.js";
import { LUMINANCES } from "./work.js";

/** @typedef {import("./design.js").Camera} Camera */
/** What an address holds: the design, what is compared with it, and how the picture is looked at. @typedef {{ camera: Camera, pinned?: Camera, scene?: string, luminance?: number, look?: import("./picture.js").Look }} Shared */

/** The scene of an address whose picture is a photograph of the sender, which is not in the address. */
export const PHOTOGRAPH = "photograph";
/** The version of the form. */
const PREFIX = "#1.";
/** The largest design that is read, characters of JSON. */
const MOST = 2_000_000;
/** The range of the slider, cd/m². */
const [LEAST_LUMINANCE, MOST_LUMINANCE] = [LUMINANCES[0], LUMINANCES[LUMINANCES.length - 1]];

/** @param {unknown} value @returns {value is Record<string, unknown>} */
const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** @param {Uint8Array<ArrayBuffer>} bytes @param {"deflate-raw"} format @param {boolean} back */
async function through(bytes, format, back) {
  const stream = new Blob([bytes]).stream().pipeThrough(back ? new DecompressionStream(format) : new CompressionStream(format));
  const reader = stream.getReader();
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const parts = [];
  for (let length = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
    length += value.length;
    if (length > MOST) throw new Error("the address holds more than a design");
    parts.push(value);
  }
}

/** @param {Shared} shared @returns {Promise<string>} The fragment, with its `#`. */
export async function fragmentOf(shared) {
  const bytes = await through(new TextEncoder().encode(JSON.stringify(shared)), "deflate-raw", false);
  let text = "";
  for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
  return PREFIX + btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** What a fragment holds; `undefined` when it is empty. Fails when it holds something else. @param {string} fragment @returns {Promise<Shared | undefined>} */
export async function sharedIn(fragment) {
  if (fragment.length <= 1) return undefined;
  if (!fragment.startsWith(PREFIX)) throw new Error(/^#\d+\./.test(fragment) ? "the address was made by another version of the studio" : "the part of the address after # is no design of the studio");
  let shared;
  try {
    const text = atob(fragment.slice(PREFIX.length).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = await through(Uint8Array.from(text, (c) => c.charCodeAt(0)), "deflate-raw", true);
    shared = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw new Error("the address is cut off or changed");
  }
  const { camera, pinned, scene, luminance, look } = isObject(shared) ? shared : {};
  if (!isObject(camera)) throw new Error("the address holds no design");
  if (pinned !== undefined && !isObject(pinned)) throw new Error("pinned of the address is no design");
  if (scene !== undefined && typeof scene !== "string") throw new Error("scene of the address is no text; expected the name of a scene");
  if (luminance !== undefined && !(typeof luminance === "number" && luminance >= LEAST_LUMINANCE && luminance <= MOST_LUMINANCE)) throw new Error(`luminance of the address is no number from ${LEAST_LUMINANCE} to ${MOST_LUMINANCE} cd/m²`);
  const isLook = look === undefined || (isObject(look) && VIEWS.includes(/** @type {any} */ (look.view)) && RIVALS.includes(/** @type {any} */ (look.against)));
  if (!isLook) throw new Error(`look of the address has no view of ${VIEWS.join(", ")} against ${RIVALS.join(" or ")}`);
  return /** @type {Shared} */ ({ camera, pinned, scene, luminance, look });
}
