// What the studio opens, saves and shares: addresses, camera files, photographs, cameras that it does not simulate in full, and the exported folder.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { crc32, deflateRawSync, deflateSync } from "node:zlib";
import { cells, openPreset, pixels, saved, score, settled, site, startFrom, studio, toml } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

test("a shared address opens the same design, and the saved camera file is that of the command", async () => {
  const { page, faults, close } = await open();
  await startFrom(page, "rgbw");
  await page.getByLabel("Name of the design").fill("night <b>");
  await page.getByLabel("Name of the design").press("Enter");
  await page.getByLabel("Read noise").fill("2.5");
  await page.getByLabel("Luminance", { exact: true }).press("Home");
  await settled(page);
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.length > 10);
  const address = page.url();
  assert.match(address, /#1\.[\w-]+$/);
  const picture = await pixels(page);
  const file = await saved(page, "Save camera.toml");
  assert.equal(file.name, "night-b.toml");
  await writeFile(join(own.dir, "night.toml"), file.content);
  const shown = JSON.parse(own.run("show", "night.toml", "--json"));
  assert.equal(shown.name ?? shown.description.name, "night <b>");
  assert.deepEqual(shown.description.sensor.cfa.pattern, await cells(page));
  const { read_noise_mv, read_noise_e, conversion_gain_uv_per_e } = shown.description.sensor.pixel;
  assert.ok(Math.abs((read_noise_e ?? read_noise_mv * 1000 / conversion_gain_uv_per_e) - 2.5) < 1e-9);
  const csv = await saved(page, "Save curves as CSV");
  assert.match(csv.content.toString(), /^wavelength_nm,transmittance_R,.*quantum_efficiency_R,.*lens_transmittance,light_relative\n/);
  const png = await saved(page, "Save picture as PNG");
  assert.deepEqual([...png.content.subarray(1, 4)], [..."PNG"].map((c) => c.charCodeAt(0)));
  assert.deepEqual(faults, []);
  await close();
  const other = await open({}, address);
  assert.equal(await other.page.getByLabel("Name of the design").inputValue(), "night <b>");
  assert.equal(await pixels(other.page), picture);
  assert.equal(await other.page.locator("#luminance-value").textContent(), "0.1 cd/m²");
  // The camera file opens too, as a step that can be undone; what is no camera is refused with the reason.
  await other.page.locator("#file").setInputFiles({ name: "mine.toml", mimeType: "text/plain", buffer: Buffer.from(file.content.toString().replace('name = "night <b>"', 'name = "mine"')) });
  await other.page.waitForFunction(() => document.getElementById("name").value === "mine");
  await other.page.locator("#file").setInputFiles({ name: "bad.toml", mimeType: "text/plain", buffer: Buffer.from("[sensor]\nrows = \"many\"\n") });
  await other.page.locator("#message[data-kind=trouble]", { hasText: "rows" }).waitFor();
  // The results of a comparison: the first camera, with the second one pinned.
  const { description: rival } = JSON.parse(own.run("show", "bayer", "--json"));
  const results = (cameras) => ({ name: "results.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify({ cameras })) });
  await other.page.locator("#file").setInputFiles(results([{ ...shown.description, name: "first" }, { ...rival, name: "second" }]));
  await other.page.waitForFunction(() => document.getElementById("name").value === "first");
  await other.page.locator("#pinned", { hasText: "Against the pinned second" }).waitFor();
  assert.equal(await other.page.locator("#note").textContent(), "first is open, and second is pinned for comparison.");
  // What was chosen as pinned stays when another camera is opened.
  await openPreset(other.page, "phone");
  assert.equal(await other.page.locator("#note").textContent(), "phone is open and compared with the pinned second.");
  await other.page.locator("#pinned", { hasText: "Against the pinned second" }).waitFor();
  await other.page.locator("#file").setInputFiles(results([]));
  await other.page.locator("#message[data-kind=trouble]", { hasText: "it holds no camera" }).waitFor();
  await other.page.locator("#file").setInputFiles({ name: "red.csv", mimeType: "text/csv", buffer: Buffer.from("nm,percent\n400,0\n600,10\n610,90\n700,80\n") });
  await other.page.locator("#message", { hasText: "read as percent" }).waitFor();
  assert.deepEqual(other.faults, []);
  await other.close();
  const broken = await open({}, `${address.slice(0, -20)}`);
  await broken.page.locator("#message[data-kind=trouble]", { hasText: "the address is cut off or changed" }).waitFor();
  await broken.close();
});

test("an address that is pasted into the open page opens its design, which can be undone", async () => {
  const { page, close } = await open();
  await startFrom(page, "rgbw");
  await page.locator("#scene").selectOption("spices");
  await page.getByLabel("Luminance", { exact: true }).press("Home");
  await page.getByLabel("Against").selectOption("pin");
  await page.getByRole("button", { name: "Difference" }).click();
  await settled(page);
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.length > 10);
  const [address, mosaic] = [page.url(), await cells(page)];
  await close();
  const other = await open();
  assert.notDeepEqual(await cells(other.page), mosaic);
  await other.page.goto(address);
  await other.page.locator("#message", { hasText: "of the address is open" }).waitFor();
  await settled(other.page);
  assert.deepEqual(await cells(other.page), mosaic);
  assert.equal(await other.page.locator("#scene").inputValue(), "spices");
  assert.equal(await other.page.locator("#luminance-value").textContent(), "0.1 cd/m²");
  // The picture is looked at as it was, also when the page opens with the address.
  const looks = async (page) => [await page.locator("#other").inputValue(), await page.locator("[data-view][aria-pressed=true]").textContent()];
  assert.deepEqual(await looks(other.page), ["pin", "Difference"]);
  const third = await open({}, address);
  assert.deepEqual(await looks(third.page), ["pin", "Difference"]);
  await third.page.locator("#caption", { hasText: /^ΔE2000 from the pinned bayer$/ }).waitFor();
  assert.deepEqual(third.faults, []);
  await third.close();
  await other.page.keyboard.press("Control+z");
  assert.deepEqual(await cells(other.page), ["RG", "GB"]);
  await other.page.evaluate(() => { location.hash = "#1.broken"; });
  await other.page.locator("#message[data-kind=trouble]", { hasText: "The design in the address cannot be opened" }).waitFor();
  // What an address holds beside its design is checked too, with the page as without it.
  for (const [changed, expected] of [
    [{ pinned: "" }, "pinned of the address is no design"], [{ scene: { toString: 1 } }, "scene of the address is no text"], [{ luminance: { valueOf: 1 } }, "luminance of the address is no number from 0.1 to 1000 cd/m²"],
    [{ luminance: -3 }, "luminance of the address is no number"], [{ look: { view: "map" } }, "look of the address has no view of one, split, other, map against reference or pin"],
  ]) {
    const hash = `#1.${deflateRawSync(JSON.stringify({ camera: {}, ...changed })).toString("base64url")}`;
    await other.page.evaluate((to) => { location.hash = to; }, hash);
    await other.page.locator("#message[data-kind=trouble]", { hasText: expected }).waitFor();
  }
  const hostile = `#1.${deflateRawSync(JSON.stringify({ camera: {}, luminance: {} })).toString("base64url")}`;
  const fourth = await open({}, `${own.server.address}${hostile}`);
  await fourth.page.locator("#message[data-kind=trouble]", { hasText: "luminance of the address is no number" }).waitFor();
  assert.deepEqual(await cells(fourth.page), ["RG", "GB"]);
  await fourth.close();
  // A design that was pinned stays pinned when an address without one is opened, and when a preset is.
  await openPreset(other.page, "bayer");
  assert.equal(await other.page.locator("#note").textContent(), "bayer is open and compared with the pinned bayer.");
  await other.page.getByRole("button", { name: "Pin", exact: true }).click();
  await openPreset(other.page, "phone");
  assert.equal(await other.page.locator("#note").textContent(), "phone is open and compared with the pinned bayer.");
  assert.deepEqual(other.faults, []);
  await other.close();
});

test("a camera stays as stated when the page does not simulate all of it, and the page says so without moving", async () => {
  const { page, faults, close } = await open();
  const note = page.locator("#limits");
  assert.ok(await note.isHidden());
  const stage = await page.locator("main").boundingBox();
  await openPreset(page, "phone");
  assert.equal(await page.locator("#note").textContent(), "phone is open and pinned: later changes are compared with it.");
  for (const [camera, ...left] of [
    ["phone", "crosstalk", "exposure by a percentile of the illuminance"], ["phone-quad-binned", "binning"], ["rgbx", "its wavelengths of 400 to 830 nm"],
  ]) {
    await openPreset(page, camera);
    await settled(page);
    const said = await note.textContent();
    assert.ok(await note.isVisible());
    for (const words of [`for ${camera}: `, ...left]) assert.ok(said.includes(words), `${camera}: ${said}`);
    await writeFile(join(own.dir, "stated.toml"), await toml(page));
    const [found, expected] = ["stated.toml", camera].map((name) => JSON.parse(own.run("show", name, "--json")).description);
    // The mosaic is written out in letters.
    for (const description of [found, expected]) delete description.sensor.cfa;
    assert.deepEqual(found, expected);
  }
  // A curve in samples that ends within its wavelengths: the page draws it, and says that commands refuse it.
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("samples");
  await page.locator("#warnings li", { hasText: "Commands and full computations refuse this design: they simulate it at 400 to 830 nm, and the filter G is in samples at fewer wavelengths." }).waitFor({ state: "attached" });
  await settled(page);
  await writeFile(join(own.dir, "short.toml"), await toml(page));
  assert.throws(() => own.run("evaluate", "short.toml", "--quiet"), /status 1|Command failed/);
  assert.equal(await page.locator("#pinned").textContent(), "rgbx, changed, against the pinned rgbx");
  await page.keyboard.press("Control+z");
  // It opens over the page, and closes with Escape.
  await note.getByText("Simulated in part").click();
  await note.locator("p", { hasText: "Not simulated on this page for rgbx: " }).waitFor();
  assert.deepEqual(await page.locator("main").boundingBox(), stage, "nothing moves");
  await page.keyboard.press("Escape");
  await note.locator("p", { hasText: "Not simulated on this page for rgbx: " }).waitFor({ state: "hidden" });
  // Also for a pinned camera alone.
  await openPreset(page, "bayer");
  assert.ok(await note.isHidden());
  await page.keyboard.press("Control+z");
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  await page.keyboard.press("Control+Shift+z");
  assert.match(await note.textContent(), /for the pinned rgbx: /);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

// A PNG file of one colour with a line of another one.
function png(width, height) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, sum]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2], 8);
  const line = (row) => Buffer.concat([Buffer.from([0]), Buffer.alloc(3 * width, Buffer.from(row % 16 === 0 ? [240, 240, 240] : [180, 90, 60]))]);
  const rows = height > 4096 ? Buffer.alloc(16) : Buffer.concat(Array.from({ length: height }, (_, row) => line(row)));
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", header), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

test("a photograph becomes a scene and stays in the browser; what is none is refused", async () => {
  const { page, faults, close } = await open();
  const sent = [];
  page.on("request", (r) => { if (r.method() !== "GET" || r.postData() !== null) sent.push(r.url()); });
  const begun = await pixels(page);
  await page.locator("#photo").setInputFiles({ name: "the wall's.png", mimeType: "image/png", buffer: png(2000, 900) });
  await page.locator("#message", { hasText: /The photograph “the wall's” is now a scene of 942 × 424 pixels in daylight. Its spectra are estimated .* It stays in this browser/ }).waitFor();
  await settled(page);
  // The note stays until the next action, and its text for screen readers.
  const message = page.locator("#message");
  assert.equal(await message.getAttribute("data-kind"), "note");
  await page.getByRole("button", { name: "Zoom in" }).click();
  assert.equal(await message.getAttribute("data-kind"), null);
  assert.notEqual(await message.evaluate((e) => getComputedStyle(e).clipPath), "none", "out of view");
  assert.match(await page.locator("#note").textContent(), /is now a scene/);
  await page.getByRole("button", { name: "Fit" }).click();
  assert.notEqual(await pixels(page), begun);
  assert.equal(await page.locator("#scene option:checked").textContent(), "the wall's");
  assert.equal((await saved(page, "Save picture as PNG")).name, "bayer-the-wall-s-10.png");
  // The page makes the report of a photograph itself, and states what the command needs beside the camera file.
  const report = (await saved(page, "Save report of this picture (HTML)")).content.toString();
  assert.match(report, /<p class="hint">the wall's at 10 cd\/m² in daylight/);
  assert.match(report, /<code>smalti compare bayer\.toml --luminance 10 --exposure own --scene '\.\/the wall'\\''s\.png'<\/code>/);
  assert.equal(await page.evaluate(async () => (await import(new URL("files.js", document.baseURI))).fileName("bayer ../Café 東京 \u202e<b> 10", "dng")), "bayer-cafe-東京-b-10.dng");
  assert.ok(await score(page, "CPSNR") > 15);
  // Dropped, behind another lens too.
  await page.getByLabel("f-number").fill("2.8");
  await page.getByLabel("f-number").press("Enter");
  await settled(page);
  await page.evaluate(async (bytes) => {
    const data = new DataTransfer();
    data.items.add(new File([new Uint8Array(bytes)], "small.png", { type: "image/png" }));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
  }, [...png(64, 48)]);
  await page.locator("#message", { hasText: "“small” is now a scene of 64 × 48 pixels" }).waitFor();
  await settled(page);
  assert.equal(await page.locator("#scene optgroup[label='Your photographs'] option").count(), 2);
  // An address does not hold the photograph, and says so where it is sent and where it is opened.
  await page.getByRole("button", { name: "Share" }).click();
  await page.locator("#message", { hasText: "The photograph is not in it." }).waitFor();
  const other = await open({}, page.url());
  await other.page.locator("#message", { hasText: "The scene of this address is a photograph of the sender, which is not in the address. Paint brushes is shown." }).waitFor();
  assert.equal(await other.page.locator("#scene").inputValue(), "brushes");
  await other.close();
  const refused = async (name, mimeType, buffer, text) => {
    await page.locator("#photo").setInputFiles({ name, mimeType, buffer });
    await page.locator("#message[data-kind=trouble]", { hasText: text }).waitFor();
  };
  await refused("huge.png", "image/png", png(60_000, 60_000), "huge.png: it has 60000 × 60000 pixels; expected at most 120 megapixels");
  await refused("cut.png", "image/png", png(300, 200).subarray(0, 60), "cut.png: the file is damaged");
  await refused("tiny.png", "image/png", png(20, 400), "expected at least 32 pixels along each side");
  await refused("moving.gif", "image/gif", Buffer.from("GIF89a"), "moving.gif: it is neither a PNG nor a JPEG file");
  await refused("false.jpg", "image/jpeg", Buffer.from("no picture at all"), "false.jpg: it is neither a PNG nor a JPEG file");
  assert.deepEqual(sent, []);
  assert.deepEqual(faults, []);
  await close();
});

test("the exported folder works from any web server, and nothing moves while it or the served page starts", async () => {
  const other = await site(join(own.dir, "site"), "/deep/");
  const { page, faults, close } = await open({}, other.address);
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  // It offers nothing that needs the server, and says which commands do it.
  assert.ok(await page.locator("#native-panel").isHidden());
  assert.ok(await page.getByRole("button", { name: "Global search" }).isHidden());
  await page.getByText("File", { exact: true }).click();
  // The engine makes the table and the raw image of the picture.
  assert.equal(await page.getByRole("button", { name: "Save report with intervals (HTML)" }).count(), 0);
  assert.equal(await page.getByRole("button", { name: /Save learned table|Save raw capture/ }).count(), 2);
  await page.getByText("smalti train", { exact: true }).waitFor();
  assert.equal(await page.locator(".about p").innerText(), "Scores of the picture: one scene, one noise realisation (seed 1), no interval. Scores at full size (more pixels, more training scenes) and in the curves (expected over the training scenes) differ. smalti compare states intervals.");
  await page.getByText("File", { exact: true }).click();
  assert.deepEqual(faults, []);
  await close();
  for (const [width, height] of [[1440, 900], [390, 844], [360, 740]]) {
    for (const address of [own.server.address, other.address]) {
      const { page: fresh, close: end } = await open({ viewport: { width, height } }, address);
      const shift = await fresh.evaluate(() => new Promise((resolve) => {
        let sum = 0;
        new PerformanceObserver((list) => { for (const entry of list.getEntries()) sum += entry.value; }).observe({ type: "layout-shift", buffered: true });
        setTimeout(() => resolve(sum), 300);
      }));
      assert.ok(shift < 0.02, `layout shift ${shift} at ${width} × ${height}, ${address === other.address ? "exported" : "served"}`);
      await end();
    }
  }
  other.end();
  // A browser runs no module from a file; the page then says what it needs.
  const file = await (await own.browser.newContext()).newPage();
  await file.goto(pathToFileURL(join(own.dir, "site", "index.html")).href);
  await file.waitForFunction(() => getComputedStyle(document.querySelector("#wait .needs-server")).opacity === "1");
  assert.match(await file.locator("#wait").innerText(), /web server: run python3 -m http\.server/);
  await file.context().close();
});
