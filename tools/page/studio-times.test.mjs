// How fast the page of the studio follows.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { settled, startFrom, stated, studio, text, within } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

test("a new picture is on the canvas a tenth of a second after a movement of the pointer that drags a filter", async () => {
  // Each picture is a layer of its own that is drawn onto the canvas.
  const { page, faults, close } = await open({}, undefined, (p) => p.addInitScript(() => {
    const draw = CanvasRenderingContext2D.prototype.drawImage;
    let last;
    let moved;
    let waiting;
    let follow = () => {};
    CanvasRenderingContext2D.prototype.drawImage = function (layer, ...rest) {
      if (layer instanceof HTMLCanvasElement && layer !== last) {
        last = layer;
        follow(performance.now() - moved);
      }
      return draw.call(this, layer, ...rest);
    };
    addEventListener("pointermove", (event) => {
      moved = event.timeStamp;
      if (waiting) [follow, waiting] = [waiting, undefined];
    }, { capture: true });
    // The time from the next movement to the next picture.
    window.followed = () => new Promise((resolve, reject) => {
      follow = () => {};
      waiting = resolve;
      setTimeout(() => reject(new Error("no picture follows a movement of the pointer")), 10_000);
    });
  }));
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("gaussian");
  // A photograph of 256 × 256 pixels, and the scene with which the page begins, 288 × 384 pixels.
  const [begun, png] = await page.evaluate(async () => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 256, height: 256 });
    const context = canvas.getContext("2d");
    for (let y = 0; y < 256; y += 1) for (let x = 0; x < 256; x += 1) {
      context.fillStyle = `rgb(${x} ${y} ${(7 * x + 13 * y) % 256})`;
      context.fillRect(x, y, 1, 1);
    }
    const bytes = await (await new Promise((resolve) => canvas.toBlob(resolve, "image/png"))).arrayBuffer();
    return [document.getElementById("scene").value, [...new Uint8Array(bytes)]];
  });
  await page.locator("#photo").setInputFiles({ name: "square.png", mimeType: "image/png", buffer: Buffer.from(png) });
  await page.locator("#message", { hasText: "is now a scene of 256 × 256 pixels" }).waitFor();
  await settled(page);
  const handle = page.getByRole("slider", { name: "G: Centre and peak" });
  await handle.scrollIntoViewIfNeeded();
  const box = await handle.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const drag = async (size) => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    const times = [];
    for (let i = 1; i <= 65; i += 1) {
      // The picture is awaited from before the movement, in one request: a hand moves on at once, and a pause would begin the scores.
      const [time] = await Promise.all([page.evaluate(() => window.followed()), page.mouse.move(x + (i < 33 ? i : 65 - i), y + 10 + i % 3)]);
      times.push(time);
    }
    await page.mouse.up();
    // The first ones learn the mosaic.
    const found = stated(times.slice(5));
    console.log(`# from a movement of the pointer to the new picture of ${size} pixels on the canvas: ${text(found)}`);
    assert.ok(within(found, 100), text(found));
    await page.keyboard.press("Control+z");
    await settled(page);
  };
  await drag("256 × 256");
  await page.locator("#scene").selectOption(begun);
  await settled(page);
  await drag("288 × 384");
  assert.deepEqual(faults, []);
  await close();
});

test("picture, scores and their differences follow a change in half a second", async () => {
  const { page, faults, close } = await open();
  await startFrom(page, "rgbw");
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("gaussian");
  await settled(page);
  const times = await page.evaluate(async () => {
    const field = document.querySelector('[data-parameter="center_nm"]');
    const root = document.documentElement;
    const all = [];
    for (let i = 0; i < 61; i += 1) {
      const begun = performance.now();
      field.value = String(500 + i);
      field.dispatchEvent(new Event("input", { bubbles: true }));
      await new Promise((resolve) => {
        const watch = new MutationObserver(() => { if (root.dataset.settled !== undefined) { watch.disconnect(); resolve(); } });
        watch.observe(root, { attributes: true, attributeFilter: ["data-settled"] });
      });
      all.push(performance.now() - begun);
    }
    return all.slice(1);
  });
  const found = stated(times);
  console.log(`# whole page after a change of a filter: ${text(found)}`);
  assert.ok(within(found, 500), text(found));
  assert.deepEqual(faults, []);
  await close();
});
