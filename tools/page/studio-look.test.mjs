// How the studio looks: accessibility, narrow screens, and what it shows when something fails.
import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { axe, weakContrast } from "./browser.mjs";
import { cells, openPreset, pixels, settled, startFrom, studio } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

for (const colorScheme of ["light", "dark"]) {
  test(`it is accessible and fits from 360 px to 4K in ${colorScheme}`, async () => {
    const { page, faults, close } = await open({ colorScheme });
    // A mosaic with a clear filter, and a difference from what is pinned.
    await startFrom(page, "rgbw");
    await openPreset(page, "phone");
    await settled(page);
    await page.keyboard.press("Control+z");
    await page.getByText("Definitions", { exact: true }).press("Enter");
    await page.getByText("Peak signal-to-noise ratio of the picture against the reference. Higher is better.").waitFor();
    await settled(page);
    for (const [width, height] of [[360, 800], [390, 844], [1440, 900], [3840, 2160]]) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(100);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${width}`);
      assert.deepEqual(await axe(page), [], `${width}`);
      // The colours of narrow and wide windows are the same.
      if (width === 1440) assert.deepEqual(await weakContrast(page), []);
      if (process.env.SMALTI_PICTURES) await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `studio-${width}-${colorScheme}.png`), fullPage: width < 1000 });
    }
    // axe.run is evaluated in the page, whose policy admits no other script.
    assert.deepEqual(faults.filter((f) => !f.includes("Content Security Policy")), []);
    await close();
  });
}

test("on a phone the picture stays at the top while the rest scrolls, unless the window is low", async () => {
  const { page, faults, close } = await open({ viewport: { width: 390, height: 844 } });
  const stage = page.locator("#stage");
  const scrolled = async (to) => {
    await page.locator(to).evaluate((e) => e.scrollIntoView());
    const { y, height } = await stage.boundingBox();
    const isSeen = await page.evaluate((at) => document.elementFromPoint(innerWidth / 2, at)?.id === "canvas", Math.max(y + height / 2, 1));
    const below = (await page.locator(to).boundingBox()).y - y - height;
    return { y, isSeen, below };
  };
  for (const [width, height] of [[390, 844], [360, 740]]) {
    await page.setViewportSize({ width, height });
    for (const to of ["#scores-title", "#mosaic-title", "#filters-title", "#improve-title"]) {
      const { y, isSeen, below } = await scrolled(to);
      assert.equal(y, 0, `${width}, ${to}`);
      assert.ok(isSeen && below >= 0, `${width}, ${to}: ${isSeen}, ${below}`);
    }
    const [card, cols] = [await page.locator(".card.mosaic").boundingBox(), await page.locator("#cols").boundingBox()];
    assert.ok(cols.x + cols.width <= card.x + card.width - 10, `${width}: the field for columns is in its card`);
    assert.ok((await page.locator("#symmetry").boundingBox()).width > 120, `${width}: symmetry is read in full`);
  }
  await page.setViewportSize({ width: 740, height: 360 });
  assert.ok((await scrolled("#mosaic-title")).y < 0);
  assert.deepEqual(faults, []);
  await close();
});

test("nothing moves when a shape with more fields is chosen and when lists are opened", async () => {
  const { page, faults, close } = await open();
  const boxes = () => Promise.all(["#stage", ".card.filters", ".scores"].map((s) => page.locator(s).boundingBox()));
  await startFrom(page, "rgbw");
  await page.getByLabel("Infrared cut").selectOption("none");
  await page.locator("#warnings[data-some]").waitFor();
  await settled(page);
  const begun = await boxes();
  await page.getByText("Definitions", { exact: true }).click();
  await page.getByText("Mean CIEDE2000 over the pixels of the picture").waitFor();
  assert.deepEqual(await boxes(), begun, "definitions");
  await page.keyboard.press("Escape");
  await page.locator("#warnings summary").click();
  assert.deepEqual(await boxes(), begun, "warnings");
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#warnings").getAttribute("open"), null);
  for (const shape of ["dye", "gaussian", "flat", "samples"]) {
    await page.getByLabel(/^Shape of filter/).selectOption(shape);
    await settled(page);
    assert.deepEqual((await boxes())[1], begun[1], shape);
  }
  assert.deepEqual(faults, []);
  await close();
});

test("that there are no warnings is said once the picture and the figures are known", async () => {
  const { page, faults, close } = await open({}, undefined, (p) => p.addInitScript(() => {
    window.early = [];
    new MutationObserver(() => {
      const said = document.querySelector("#warnings summary")?.textContent;
      const values = [...document.querySelectorAll(".tile .value")].map((e) => e.textContent);
      if (said && (values.length === 0 || values.includes("–"))) window.early.push(said);
    }).observe(document, { childList: true, subtree: true, characterData: true });
  }));
  assert.equal(await page.locator("#warnings summary").textContent(), "No warnings");
  assert.deepEqual(await page.evaluate(() => window.early), []);
  assert.deepEqual(faults, []);
  await close();
});

test("no letter of a filter lies on another one, and no curve crosses it", async () => {
  const { page, faults, close } = await open();
  for (const mosaic of ["rgbw", "rgbcmy", "bayer"]) {
    await startFrom(page, mosaic);
    if (mosaic === "bayer") await page.getByRole("button", { name: "Add a filter" }).click();
    await settled(page);
    for (const [width, height] of [[1440, 900], [360, 740], [3840, 2160]]) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(100);
      const found = await page.evaluate(() => {
        const letters = [...document.querySelectorAll("#plot .letter")].map((e) => ({ text: e.textContent, box: e.getBBox() }));
        const curves = [...document.querySelectorAll("#plot .curve")].map((path) => Array.from({ length: 2001 }, (_, i) => path.getPointAtLength(path.getTotalLength() * i / 2000)));
        const all = [];
        // Within the letter itself: its box has the height of a line.
        const inside = ({ x, y, width: w, height: h }, p) => p.x > x && p.x < x + w && p.y > y + h / 4 && p.y < y + 3 * h / 4;
        letters.forEach(({ text, box }, i) => {
          for (const { text: other, box: b } of letters.slice(i + 1)) if (Math.abs(box.x - b.x) < box.width && Math.abs(box.y - b.y) < box.height * 0.7) all.push(`${text} on ${other}`);
          if (curves.some((points) => points.some((p) => inside(box, p)))) all.push(`a curve through ${text}`);
        });
        return { all, count: letters.length };
      });
      assert.deepEqual(found.all, [], `${mosaic}, ${width}`);
      assert.ok(found.count >= 4, `${mosaic}: ${found.count} letters`);
    }
    await page.setViewportSize({ width: 1440, height: 900 });
  }
  assert.deepEqual(faults, []);
  await close();
});

test("the cells of the largest tile can be hit on a narrow screen, where a finger scrolls and a tap paints", async () => {
  const { page, faults, close } = await open({ viewport: { width: 360, height: 800 }, hasTouch: true, isMobile: true });
  for (const side of ["Rows", "Columns"]) {
    await page.getByLabel(side).fill("16");
    await page.getByLabel(side).press("Enter");
  }
  const cell = page.getByRole("gridcell", { name: "Row 2, column 3:" });
  const { width, height } = await cell.boundingBox();
  assert.ok(width >= 24 && height >= 24, `${width} × ${height}`);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  await page.getByRole("radio", { name: "Filter B" }).tap();
  await cell.tap();
  assert.equal((await cells(page))[1].slice(0, 4), "GBBB");
  // Out of sight, with the keyboard.
  await page.keyboard.press("End");
  assert.ok(await page.locator("#grid").evaluate((grid) => grid.scrollLeft > 0));
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("a worker that fails is replaced, the picture follows, and the page says so once", async () => {
  const { page, faults, close } = await open();
  const begun = await pixels(page);
  // The next answer of each worker is a trap of the module.
  for (const worker of page.workers()) {
    await worker.evaluate(() => {
      const { decode } = TextDecoder.prototype;
      TextDecoder.prototype.decode = () => {
        TextDecoder.prototype.decode = decode;
        throw new WebAssembly.RuntimeError("unreachable");
      };
    });
  }
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 2" }).click();
  await page.locator("#message[data-kind=trouble]", { hasText: "The simulator of this page failed, for example for lack of memory, and was started again." }).waitFor();
  await settled(page);
  assert.notEqual(await pixels(page), begun);
  await page.getByRole("button", { name: "Dismiss the message" }).click();
  await page.keyboard.press("Control+z");
  await settled(page);
  assert.equal(await pixels(page), begun);
  assert.equal(await page.locator("#message").getAttribute("data-kind"), null, "once");
  assert.deepEqual(faults, []);
  await close();
});

test("a picture does not remove the message about the figures", async () => {
  const { page, close } = await open({}, undefined, (p) => p.route("**/statistics.bin", (route) => route.fulfill({ status: 404 })), (p) => p.locator("#message[data-kind=trouble]", { hasText: "statistics.bin is missing" }).waitFor());
  await page.locator("#wait").waitFor({ state: "hidden" });
  const begun = await pixels(page);
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 2" }).click();
  await page.waitForFunction(() => document.querySelector(".delta[data-kind=better], .delta[data-kind=worse]"), null, { timeout: 60_000 });
  assert.notEqual(await pixels(page), begun);
  assert.match(await page.locator("#message[data-kind=trouble]").textContent(), /statistics\.bin is missing/);
  await close();
});

test("the page says why it has no first picture, and shows the figures that need none", async () => {
  const failed = (p) => p.route("**/training.bin", (route) => route.fulfill({ status: 500, body: "the lens has no image" }));
  const { page, close } = await open({}, undefined, failed, (p) => p.locator("#message[data-kind=trouble]", { hasText: "the lens has no image" }).waitFor());
  await page.waitForFunction(() => [...document.querySelectorAll(".tile")].some((tile) => tile.textContent.includes("Vora") && /\d/.test(tile.querySelector(".value").textContent)));
  await close();
});

test("a pinned picture of other conditions is not shown", async () => {
  const { page, faults, close } = await open();
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 2" }).click();
  await page.getByLabel("Against").selectOption("pin");
  await page.locator('[data-view="other"]').click();
  await settled(page);
  assert.equal(await page.locator("#caption").textContent(), "Pinned: bayer");
  // What it says from the choice of another scene on.
  await page.evaluate(() => {
    const caption = document.getElementById("caption");
    const observer = new MutationObserver(() => window.captions.push(caption.textContent));
    document.getElementById("scene").addEventListener("change", () => {
      window.captions = [];
      observer.observe(caption, { childList: true });
    }, { capture: true });
  });
  const begun = await pixels(page);
  await page.locator("#scene").selectOption("spices");
  await settled(page);
  assert.notEqual(await pixels(page), begun);
  assert.deepEqual([...new Set(await page.evaluate(() => window.captions))], ["Pinned: bayer, being computed…", "Pinned: bayer"]);
  assert.deepEqual(faults, []);
  await close();
});
