// What a design on the page comes from: the camera that was opened, with the mosaics of the catalogue; and the name of a design that is no longer that camera.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { cells, field, filterOf, openPreset, saved, settled, smalti, startFrom, studioAndSite, toml } from "./studio.mjs";

let own;
before(async () => { own = await studioAndSite(); });
after(() => own?.end());
const open = (...args) => own.open(...args);
// The design as the command reads it from the saved file.
async function read(page) {
  await writeFile(join(own.dir, "read.toml"), await toml(page));
  return JSON.parse(own.run("show", "read.toml", "--json", "--quiet")).description;
}
// The description of a camera of the command with all of its filters.
function inFull(catalogue, description) {
  const { pattern, filters } = description.sensor.cfa;
  const mosaic = catalogue.cfas.find(({ name, aliases }) => name === pattern || aliases?.includes(pattern));
  return { ...description, sensor: { ...description.sensor, cfa: { pattern: mosaic?.tile ?? pattern, filters: { ...mosaic?.filters, ...filters } } } };
}

test("every built-in camera has with every mosaic the filters that CAMERA@MOSAIC has", async () => {
  const { page, close } = await open();
  const { catalogue, found } = await page.evaluate(async () => {
    const [{ Engine }, { originOf, withMosaic }] = await Promise.all(["engine.js", "exchange.js"].map((file) => import(new URL(file, document.baseURI))));
    const engine = await Engine.start("engine/");
    const { catalogue } = engine;
    const all = catalogue.cfas.filter(({ tile, filters }) => [...tile.join("")].every((letter) => letter in filters));
    const found = await Promise.all(catalogue.cameras.flatMap((design) => all.map(async (mosaic) => {
      const origin = await originOf(engine, design);
      const { camera, missing = [] } = await withMosaic(engine, origin.camera, origin, mosaic.name);
      const isOwn = [mosaic.name, ...mosaic.aliases].includes(design.sensor.cfa.pattern);
      return { of: design.name, isOwn, hasBinning: Boolean(design.sensor.binning), mosaic: mosaic.name, camera, missing };
    })));
    return { catalogue, found };
  });
  await close();
  const refused = [];
  for (const { of, isOwn, hasBinning, mosaic, camera, missing } of found) {
    const binning = hasBinning ? ["--set", "sensor.binning=none"] : [];
    const { status, stdout, stderr } = spawnSync(smalti, ["show", `${of}@${mosaic}`, "--json", "--quiet", ...binning], { encoding: "utf8" });
    assert.equal(status !== 0, missing.length > 0, `${of}@${mosaic}: ${stderr}`);
    if (status !== 0) {
      assert.match(stderr, /for which the camera has no filter/);
      refused.push(`${of}@${mosaic}`);
      continue;
    }
    const expected = inFull(catalogue, JSON.parse(stdout).description);
    assert.deepEqual(camera.sensor.cfa.pattern, expected.sensor.cfa.pattern, `${of}@${mosaic}`);
    assert.deepEqual(camera.sensor.cfa.filters, expected.sensor.cfa.filters, `${of}@${mosaic}`);
    assert.equal(camera.name, isOwn ? of : expected.name);
  }
  assert.ok(found.length > 400 && refused.length > 20 && refused.includes("cmv12000@rgbw"), `${found.length}, ${refused.length}`);
});

test("a mosaic of the catalogue is the same on every path, and is that of CAMERA@MOSAIC", async () => {
  const { page, faults, close } = await open({}, own.exported.address);
  const expected = async (name, design) => {
    assert.equal(design.name, name);
    const { description } = JSON.parse(own.run("show", name, "--json", "--quiet"));
    const catalogue = await page.evaluate(async () => (await (await import(new URL("engine.js", document.baseURI))).Engine.start("engine/")).catalogue);
    assert.deepEqual(design, inFull(catalogue, description));
  };
  await startFrom(page, "multispectral-5x5");
  await page.getByRole("radio", { name: "Filter W" }).click();
  assert.equal(await page.locator("#filter .fields select").inputValue(), "band-23-of-25", "every curve has its name");
  await startFrom(page, "mono");
  await expected("bayer@mono", await read(page));
  await startFrom(page, "rgbw");
  await startFrom(page, "multispectral-5x5");
  await expected("bayer@multispectral-5x5", await read(page));
  await startFrom(page, "bayer");
  assert.equal(await page.getByLabel("Name of the design").inputValue(), "bayer", "its own mosaic is no other one");
  // The preset that was chosen last.
  await openPreset(page, "rgbw");
  await startFrom(page, "five-band");
  await expected("rgbw@five-band", await read(page));
  await page.keyboard.press("Control+z");
  await startFrom(page, "mono");
  await expected("rgbw@mono", await read(page));
  // A camera with curves of its own has none for some letters.
  await openPreset(page, "cmv12000");
  const before = await cells(page);
  await startFrom(page, "rgbw");
  await page.locator("#message[data-kind=trouble]", { hasText: "rgbw needs a filter for W, and cmv12000 has curves of its own, which the generic filters of the catalogue do not fit." }).waitFor();
  assert.deepEqual(await cells(page), before, "it stays as it is");
  await startFrom(page, "quad-bayer");
  await expected("cmv12000@quad-bayer", await read(page));
  // A shared design that has a mosaic of the catalogue is known to have it.
  await openPreset(page, "bayer");
  await startFrom(page, "multispectral-5x5");
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.length > 10);
  const other = await open({}, page.url());
  await startFrom(other.page, "mono");
  await expected("bayer@mono", await read(other.page));
  await settled(other.page);
  assert.deepEqual([...faults, ...other.faults], []);
  await other.close();
  await close();
});

test("filters that were changed by hand replace those of their kind in every mosaic", async () => {
  const { page, faults, close } = await open();
  assert.match(await page.locator("#grid-help").textContent(), /Start from takes the filters of camera@mosaic but keeps those that you changed\.$/);
  await page.getByLabel("Read noise").fill("2.5");
  await page.getByRole("radio", { name: "Filter R" }).click();
  await page.getByLabel("Shape of filter R").selectOption("gaussian");
  await field(page, "center_nm").fill("611");
  await field(page, "center_nm").press("Enter");
  const changed = filterOf(await toml(page), "R");
  assert.match(changed, /center_nm = 611/);
  for (const [mosaic, isKept] of [["xtrans", true], ["mono", undefined], ["multispectral-5x5", false], ["rgbw", true]]) {
    await startFrom(page, mosaic);
    const file = await toml(page);
    if (isKept !== undefined) assert.equal(filterOf(file, "R") === changed, isKept, mosaic);
    if (mosaic === "mono") assert.match(filterOf(file, "W"), /builtin = "white"/);
    assert.match(file, /read_noise/);
    assert.equal(await page.getByLabel("Read noise").inputValue(), "2.5", mosaic);
  }
  // Changed back, it is no change any more.
  await page.getByRole("radio", { name: "Filter R" }).click();
  await page.getByLabel("Shape of filter R").selectOption("builtin");
  await page.locator("#filter .fields select").selectOption("red");
  await startFrom(page, "mono");
  await startFrom(page, "bayer");
  assert.match(filterOf(await toml(page), "R"), /builtin = "red"/);
  // The history has each mosaic with what was changed then.
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("Control+z");
  assert.deepEqual(await cells(page), ["RG", "WB"], "rgbw");
  assert.equal(filterOf(await toml(page), "R"), changed);
  await startFrom(page, "quad-bayer");
  assert.equal(filterOf(await toml(page), "R"), changed);
  // An opened camera begins anew.
  await openPreset(page, "bayer");
  await startFrom(page, "xtrans");
  assert.match(filterOf(await toml(page), "R"), /builtin = "red"/);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("a camera that was changed is saved under a name of its own", async () => {
  const { page, faults, close } = await open({}, own.exported.address);
  const file = async () => {
    const { name, content } = await saved(page, "Save camera.toml");
    return [name, String(content).match(/^name = "(.*)"$/m)[1]];
  };
  assert.deepEqual(await file(), ["bayer.toml", "bayer"]);
  await page.getByLabel("Read noise").fill("9");
  await settled(page);
  assert.deepEqual(await file(), ["bayer-changed.toml", "bayer-changed"]);
  for (const [item, name] of [[/learned table/, "bayer-changed-10.l3"], [/raw capture/, "bayer-changed-brushes-10.dng"], ["Save picture as PNG", "bayer-changed-brushes-10.png"], ["Save curves as CSV", "bayer-changed-curves.csv"]]) {
    assert.equal((await saved(page, item)).name, name);
  }
  // Undone, it is the camera again; a mosaic of the catalogue gives it the name that the command does.
  await page.keyboard.press("Control+z");
  assert.deepEqual(await file(), ["bayer.toml", "bayer"]);
  await startFrom(page, "rgbw");
  assert.deepEqual(await file(), ["bayer-rgbw.toml", "bayer@rgbw"]);
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 1:" }).click();
  assert.deepEqual(await file(), ["bayer-rgbw-changed.toml", "bayer@rgbw-changed"]);
  // A shared address has that name too, and a design that is opened and changed keeps it.
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.length > 10);
  const other = await open({}, page.url());
  assert.equal(await other.page.getByLabel("Name of the design").inputValue(), "bayer@rgbw-changed");
  await other.page.getByLabel("Read noise").fill("9");
  assert.equal((await saved(other.page, "Save camera.toml")).name, "bayer-rgbw-changed.toml");
  await other.close();
  // A name that was given by hand stays, in other mosaics too.
  await page.getByLabel("Name of the design").fill("mine");
  await page.getByLabel("Name of the design").press("Enter");
  await startFrom(page, "xtrans");
  assert.deepEqual(await file(), ["mine.toml", "mine"]);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("the report and full computations have the names of the saved designs", async () => {
  const sent = [];
  const { page, faults, close } = await open({}, undefined, (p) => p.on("websocket", (socket) => socket.on("framesent", ({ payload }) => sent.push(JSON.parse(payload)))));
  const panel = page.locator("#native-panel");
  const job = async (button) => {
    await button();
    await panel.getByRole("button", { name: "Cancel" }).click();
    await panel.getByText("was cancelled.").waitFor({ timeout: 60_000 });
    return sent.findLast(({ start }) => start).start.job;
  };
  await page.getByLabel("Read noise").fill("9");
  const { report } = await job(() => panel.getByRole("button", { name: "Report", exact: true }).click());
  assert.deepEqual([report.design.name, report.rival.name], ["bayer-changed", "bayer"]);
  const { capture } = await job(() => panel.getByRole("button", { name: "Full-size picture" }).click());
  assert.equal(capture.design.name, "bayer-changed");
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  await page.getByLabel("Read noise").fill("8");
  const { report: later } = await job(() => panel.getByRole("button", { name: "Report", exact: true }).click());
  assert.deepEqual([later.design.name, later.rival.name], ["bayer-changed", "bayer-changed (pinned)"]);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});
