// @ts-check
// The whole design in the fragment of the address, which browsers send to no server: JSON, deflated, in base 64 for addresses.

/** @typedef {import("./design.js").Camera} Camera */
/** What an address holds: the design, what is compared with it, and how the picture is looked at. @typedef {{ camera: Camera, pinned?: Camera, scene?: string, luminance?: number, look?: import("./picture.js").Look }} Shared */

/** The scene of an address whose picture is a photograph of the sender, which is not in the address. */
export const PHOTOGRAPH = "photograph";
/** The version of the form. */
const PREFIX = "#1.";
/** The largest design that is read, characters of JSON. */
const MOST = 2_000_000;

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
  if (!fragment.startsWith(PREFIX)) throw new Error("the address was made by another version of the studio");
  let shared;
  try {
    const text = atob(fragment.slice(PREFIX.length).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = await through(Uint8Array.from(text, (c) => c.charCodeAt(0)), "deflate-raw", true);
    shared = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw new Error("the address is cut off or changed");
  }
  if (typeof shared?.camera !== "object" || shared.camera === null) throw new Error("the address holds no design");
  return shared;
}
