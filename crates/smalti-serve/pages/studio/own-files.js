// @ts-check
// The table and the raw image of the picture that the page shows, without a server: the engine of the page makes them.
import { message, tell } from "./dom.js";
import { fileName, save } from "./files.js";

/**
 * Sets up the items of the menu that save files of the engine, unless a server makes larger ones.
 * @param {Promise<object | undefined>} native The server, if there is one.
 * @param {import("./engine.js").Engine} engine
 * @param {() => { camera: import("./design.js").Camera, scene: string, sceneName: string, luminance: number }} shown The design as it is drawn, under the name with which it is saved, and the name of the scene in names of files.
 */
export async function setUpOwnFiles(native, engine, shown) {
  if (await native) return;
  /** @type {Record<string, () => Promise<void>>} */
  const saves = {
    async table() {
      const { camera, luminance } = shown();
      save(fileName(`${camera.name} ${luminance}`, "l3"), await engine.table({ design: camera, luminance }));
    },
    async raw() {
      const { camera, scene, sceneName, luminance } = shown();
      save(fileName(`${camera.name} ${sceneName} ${luminance}`, "dng"), await engine.raw({ design: camera, scene, luminance }));
    },
  };
  for (const [kind, make] of Object.entries(saves)) {
    const item = document.querySelector(`#menu [data-native="${kind}"]`);
    if (!(item instanceof HTMLButtonElement)) continue;
    item.hidden = false;
    item.addEventListener("click", () => make().catch((error) => tell(`${message(error)}.`, "trouble")));
  }
}
