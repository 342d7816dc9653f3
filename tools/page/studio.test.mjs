// The studio in a real browser, against the server of the command and as an exported folder behind another one.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { createServer } from "node:http";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { crc32, deflateSync } from "node:zlib";
import { axe, launch } from "./browser.mjs";

const smalti = resolve(process.env.SMALTI ?? join(import.meta.dirname, "../../target/debug/smalti"));
let dir;
let browser;
let server;

const env = () => ({ ...process.env, SMALTI_CACHE_DIR: join(dir, "cache") });
const run = (...args) => execFileSync(smalti, args, { cwd: dir, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"], env: env() });

before(async () => {
  dir = await mkdtemp(join(tmpdir(), "smalti-studio-"));
  browser = await launch();
  const child = spawn(smalti, ["studio", "bayer", "--json", "--quiet"], { cwd: dir, stdio: ["ignore", "pipe", "inherit"], env: env() });
  const [line] = await once(child.stdout, "data");
  server = { child, address: JSON.parse(line).address };
});
after(async () => {
  await browser?.close();
  if (server) {
    const ended = once(server.child, "exit");
    server.child.kill("SIGKILL");
    await ended;
  }
  await rm(dir, { recursive: true, force: true });
});

// A browser of its own. Faults are errors, violations of the policy and requests elsewhere; the tests themselves read the canvas.
async function open(options = {}, address = server.address) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const faults = [];
  page.on("console", (m) => { if (["error", "warning"].includes(m.type()) && !m.text().includes("willReadFrequently")) faults.push(`console: ${m.text()}`); });
  page.on("pageerror", (e) => faults.push(`error: ${e.stack}`));
  page.on("request", (r) => { if (!/^(data|blob):/.test(r.url()) && !r.url().startsWith(address.split("#")[0])) faults.push(`request: ${r.url()}`); });
  await page.goto(address);
  await settled(page);
  return { page, faults, close: () => context.close() };
}
// The picture of the latest change is drawn and scored.
const settled = (page) => page.waitForFunction(() => document.documentElement.dataset.settled !== undefined, null, { timeout: 60_000 });
const cells = (page) => page.locator("#grid [role=row]").evaluateAll((rows) => rows.map((r) => [...r.children].map((c) => c.textContent).join("")));
const pixels = (page) => page.locator("#canvas").evaluate((canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let hash = 0;
  for (let i = 0; i < data.length; i += 1) hash = (hash * 31 + data[i]) | 0;
  return hash;
});
const score = async (page, name) => Number((await page.locator(".tile", { has: page.getByText(name, { exact: true }) }).locator(".value").textContent()).replace("−", "-"));
const field = (page, key) => page.locator(`[data-parameter="${key}"]`);
async function saved(page, name) {
  await page.getByText("File", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
  return { name: download.suggestedFilename(), content: await readFile(await download.path()) };
}

test("a cell is painted, a filter dragged, both undone; scores say what the change did", async () => {
  const { page, faults, close } = await open();
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  const begun = await pixels(page);
  const cpsnr = await score(page, "CPSNR");
  assert.ok(cpsnr > 15 && cpsnr < 60, String(cpsnr));
  assert.equal(await page.locator(".delta[data-kind=better], .delta[data-kind=worse]").count(), 0, "nothing has changed yet");
  // A cell.
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 2" }).click();
  assert.deepEqual(await cells(page), ["RB", "GB"]);
  await settled(page);
  assert.notEqual(await pixels(page), begun, "another picture");
  assert.ok(await page.locator(".delta[data-kind=better], .delta[data-kind=worse]").count() > 2);
  await page.waitForFunction(() => /CPSNR .* dB, .* (better|worse) than pinned/.test(document.getElementById("told").textContent));
  // A filter: another shape, then its centre.
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("gaussian");
  await settled(page);
  const center = Number(await field(page, "center_nm").inputValue());
  const handle = await page.getByRole("slider", { name: "G: Centre and peak" }).boundingBox();
  await page.mouse.move(handle.x + handle.width / 2, handle.y + handle.height / 2);
  await page.mouse.down();
  await page.mouse.move(handle.x + handle.width / 2 + 30, handle.y + handle.height / 2 + 20, { steps: 6 });
  await page.mouse.up();
  const dragged = Number(await field(page, "center_nm").inputValue());
  assert.ok(dragged > center + 15 && dragged < center + 70, `${center} to ${dragged}`);
  await settled(page);
  // The drag is one step of the history, the shape another, the cell the first.
  for (let i = 0; i < 3; i += 1) await page.keyboard.press("Control+z");
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true");
  await settled(page);
  assert.equal(await pixels(page), begun, "the same picture again");
  for (let i = 0; i < 3; i += 1) await page.keyboard.press("Control+Shift+z");
  assert.equal(Number(await field(page, "center_nm").inputValue()), dragged);
  // Pinned, it is what later changes are compared with.
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  await settled(page);
  assert.equal(await page.locator(".delta[data-kind=better], .delta[data-kind=worse]").count(), 0);
  await page.getByLabel("Against").selectOption("pin");
  assert.equal(await page.getByRole("button", { name: "Split" }).getAttribute("aria-pressed"), "true");
  const line = page.getByRole("slider", { name: "Line between the two pictures" });
  await line.press("ArrowRight");
  await page.waitForFunction(() => document.getElementById("split").getAttribute("aria-valuenow") === "52");
  assert.deepEqual(faults, []);
  await close();
});

test("an improvement goes on until it is stopped, keeps what is locked, and can be discarded", async () => {
  const { page, faults, close } = await open();
  const expected = async () => Number(((await page.locator(".improve .progress").textContent()).match(/Expected: ([+−][\d.]+) dB/)?.[1] ?? "0").replace("−", "-"));
  await page.getByLabel("Keep the mosaic").check();
  await page.getByRole("button", { name: "Improve" }).click();
  await page.locator(".improve .progress", { hasText: "Expected:" }).waitFor({ timeout: 60_000 });
  await page.getByRole("button", { name: "Stop and keep" }).click();
  await page.getByRole("button", { name: "Improve" }).waitFor();
  assert.ok(await expected() > 0, await page.locator(".improve .progress").textContent());
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  await page.getByRole("button", { name: "Discard" }).click();
  assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true", "the improvement is one step");
  assert.equal(await page.locator("#redo").getAttribute("aria-disabled"), "false");
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("heavy work goes to the native library, can be cancelled, and its files open in the command", async () => {
  const { page, faults, close } = await open();
  const panel = page.locator("#native-panel");
  const done = (title) => page.waitForFunction((text) => document.querySelector("#native [data-state]").textContent.startsWith(text), `${title} is done`, { timeout: 240_000 });
  // A table takes a scene after the other.
  await page.getByRole("button", { name: "Full-size picture" }).click();
  await page.waitForFunction(() => /training .*, \d+ of \d+/.test(document.querySelector("#native [data-state]").textContent), null, { timeout: 60_000 });
  assert.equal(await page.getByRole("button", { name: "Full-size picture" }).getAttribute("aria-disabled"), "true", "one job at a time");
  const begun = Date.now();
  await panel.getByRole("button", { name: "Cancel" }).click();
  await panel.getByText("The full-size picture was cancelled.").waitFor({ timeout: 60_000 });
  assert.ok(Date.now() - begun < 20_000, `${Date.now() - begun} ms`);
  // The design, its raw capture and its table, which the command makes again to the same bytes.
  await page.getByLabel("Name of the design").fill("mine");
  await page.getByLabel("Name of the design").press("Enter");
  await page.getByLabel("Read noise").fill("3");
  await settled(page);
  await writeFile(join(dir, "mine.toml"), (await saved(page, "Save camera.toml")).content);
  const raw = await saved(page, "Save raw capture (DNG)");
  assert.equal(raw.name, "mine-brushes-10.dng");
  await writeFile(join(dir, raw.name), raw.content);
  run("simulate", "mine.toml", "--scene", "photo-brushes", "--luminance", "10", "--illuminant", "D65", "-o", "simulated", "-q");
  assert.ok(raw.content.equals(await readFile(join(dir, "simulated", "raw.dng"))), "the raw capture is that of smalti simulate");
  await page.getByText("File", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download", { timeout: 240_000 }), page.getByRole("button", { name: "Save learned table (.l3)" }).click()]);
  assert.equal(download.suggestedFilename(), "mine.l3");
  const table = await readFile(await download.path());
  await writeFile(join(dir, "mine.l3"), table);
  run("train", "mine.toml", "--illuminants", "D65", "-o", "again.l3", "-q");
  assert.ok(table.equals(await readFile(join(dir, "again.l3"))), "the table is that of smalti train");
  run("render", raw.name, "--pipeline", "mine.l3", "-o", "rendered.png", "-q");
  // The statistics are kept, so that the picture needs no further learning.
  await page.getByRole("button", { name: "Full-size picture" }).click();
  await done("The full-size picture");
  const picture = panel.getByRole("img", { name: "Full-size picture: mine, brushes, 10 cd/m²" });
  assert.deepEqual(await picture.evaluate((image) => image.decode().then(() => [image.naturalWidth, image.naturalHeight])), [640, 480]);
  assert.match(await panel.locator("figcaption").textContent(), /640 × 480 pixels, exposed for 100 ms\. CPSNR [\d.]+ dB, ΔE2000 [\d.]+, S-CIELAB [\d.]+\./);
  const [png] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "Save PNG" }).click()]);
  run("simulate", "mine.toml", "--scene", "photo-brushes", "--luminance", "10", "--illuminant", "D65", "--pipeline", "mine.l3", "-o", "learned", "-q");
  assert.ok((await readFile(await png.path())).equals(await readFile(join(dir, "learned", "rendered.png"))), "the picture is that of smalti simulate");
  // The report is a page that works alone.
  await page.getByText("File", { exact: true }).click();
  const [report] = await Promise.all([page.waitForEvent("download", { timeout: 240_000 }), page.getByRole("button", { name: "Save report (HTML)" }).click()]);
  assert.equal(report.suggestedFilename(), "mine-report.html");
  const html = await readFile(await report.path(), "utf8");
  assert.match(html, /^<!doctype html>/i);
  assert.ok(html.includes("smalti compare again-1.toml again-2.toml --luminance 10 --scene photo-brushes"), "it states its command");
  assert.deepEqual(faults, []);
  await close();
});

test("the native library searches all mosaics, and keeps what is locked", async () => {
  const { page, faults, close } = await open();
  await page.getByLabel("Keep the mosaic").check();
  await page.getByLabel("Filters are").selectOption("dichroic");
  await page.getByRole("button", { name: "Search widely" }).click();
  await page.locator(".improve .progress", { hasText: /^(One mosaic was|\d+ mosaics were) searched\. (Expected: [+−][\d.]+ dB|None is better)/ }).waitFor({ timeout: 240_000 });
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  if (await page.getByRole("button", { name: "Discard" }).isVisible()) {
    await page.getByRole("button", { name: "Discard" }).click();
    assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true", "the search is one step");
  }
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("when the server ends, the page says so and goes on", async () => {
  const own = spawn(smalti, ["studio", "bayer", "--json", "--quiet"], { cwd: dir, stdio: ["ignore", "pipe", "inherit"], env: env() });
  const [line] = await once(own.stdout, "data");
  const { page, faults, close } = await open({}, JSON.parse(line).address);
  await page.getByLabel("Read noise").fill("4");
  await page.getByRole("button", { name: "Full-size picture" }).click();
  await page.waitForFunction(() => /training/.test(document.querySelector("#native [data-state]").textContent), null, { timeout: 60_000 });
  const ended = once(own, "exit");
  own.kill("SIGKILL");
  await ended;
  await page.locator("#message[data-kind=trouble]", { hasText: "The server has ended. The page goes on with its own engine" }).waitFor();
  assert.equal(await page.getByRole("button", { name: "Full-size picture" }).getAttribute("aria-disabled"), "true");
  assert.ok(await page.locator("#native-panel").getByRole("button", { name: "Cancel" }).isHidden());
  const begun = await pixels(page);
  await page.getByRole("radio", { name: "Filter B" }).click();
  await page.getByRole("gridcell", { name: "Row 1, column 2" }).click();
  await settled(page);
  assert.notEqual(await pixels(page), begun, "it still draws");
  const file = await saved(page, "Save camera.toml");
  assert.match(file.content.toString(), /"RB"/);
  assert.deepEqual(faults.filter((f) => !f.includes("WebSocket")), []);
  await close();
});

test("a shared address opens the same design, and the saved camera file is that of the command", async () => {
  const { page, faults, close } = await open();
  await page.getByLabel("Start from").selectOption("rgbw");
  await page.getByLabel("Name of the design").fill("night <b>");
  await page.getByLabel("Name of the design").press("Enter");
  await page.getByLabel("Read noise").fill("2.5");
  await page.getByLabel("Light", { exact: true }).press("Home");
  await settled(page);
  await page.getByRole("button", { name: "Share" }).click();
  await page.waitForFunction(() => location.hash.length > 10);
  const address = page.url();
  assert.match(address, /#1\.[\w-]+$/);
  const picture = await pixels(page);
  const file = await saved(page, "Save camera.toml");
  assert.equal(file.name, "night-b.toml");
  await writeFile(join(dir, "night.toml"), file.content);
  const shown = JSON.parse(run("show", "night.toml", "--json"));
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
  const { description: rival } = JSON.parse(run("show", "bayer", "--json"));
  const results = (cameras) => ({ name: "results.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify({ cameras })) });
  await other.page.locator("#file").setInputFiles(results([{ ...shown.description, name: "first" }, { ...rival, name: "second" }]));
  await other.page.waitForFunction(() => document.getElementById("name").value === "first");
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

test("pitch and f-number change the picture; the light is gathered once, and the picture stays meanwhile", async () => {
  const { page, faults, close } = await open();
  const begun = await pixels(page);
  const noise = await score(page, "Noise");
  const stop = page.getByLabel("f-number");
  await stop.fill("2");
  await stop.press("Enter");
  await page.locator("#gathering", { hasText: "Computing the light for f/2, 2.2 µm…" }).waitFor();
  assert.equal(await pixels(page), begun, "the picture stays");
  await settled(page);
  assert.ok(await page.locator("#gathering").isHidden());
  const wide = await pixels(page);
  assert.notEqual(wide, begun);
  // Four times the light: half the noise, where it is that of photons.
  assert.ok(await score(page, "Noise") < 0.75 * noise, `${noise}`);
  await page.locator("#light-curve svg .own").waitFor({ timeout: 60_000 });
  await page.keyboard.press("Control+z");
  await settled(page);
  assert.equal(await pixels(page), begun);
  await page.keyboard.press("Control+Shift+z");
  await settled(page);
  assert.equal(await pixels(page), wide);
  // Beyond the range of the key.
  await page.getByLabel("Pixel pitch").fill("0");
  await page.getByLabel("Pixel pitch").press("Enter");
  await page.locator("#message[data-kind=trouble]", { hasText: "Pixel pitch: expected 0.001 to 1000 µm" }).waitFor();
  for (const id of ["fill-factor", "read-noise", "full-well", "gain", "time"]) assert.ok(await page.locator(`#${id}`).isEditable(), id);
  // The field shows the value of the design again; a preset has a lens and pixels of its own.
  await page.getByLabel("Preset").focus();
  assert.equal(await page.getByLabel("Pixel pitch").inputValue(), "2.2");
  await page.getByLabel("Preset").selectOption({ label: "phone" });
  await settled(page);
  const phone = JSON.parse(run("show", "phone", "--json")).description;
  assert.equal(Number(await page.getByLabel("Pixel pitch").inputValue()), phone.sensor.pixel.pitch_um);
  assert.equal(Number(await stop.inputValue()), phone.optics.f_number);
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
  await page.locator("#photo").setInputFiles({ name: "wall.png", mimeType: "image/png", buffer: png(2000, 900) });
  await page.locator("#message", { hasText: /wall is a scene of 942 × 424 pixels now, in daylight. Its spectra are estimated .* It stays in this browser/ }).waitFor();
  await settled(page);
  assert.notEqual(await pixels(page), begun);
  assert.equal(await page.locator("#scene option:checked").textContent(), "wall");
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
  await page.locator("#message", { hasText: "small is a scene of 64 × 48 pixels" }).waitFor();
  await settled(page);
  assert.equal(await page.locator("#scene optgroup[label='Your photographs'] option").count(), 2);
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

test("picture, scores and their differences follow a change in half a second", async () => {
  const { page, faults, close } = await open();
  await page.getByLabel("Start from").selectOption("rgbw");
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("gaussian");
  await settled(page);
  // The best of some runs counts, since the machine may do something else as well.
  let best;
  for (let run = 0; run < 3 && !(best?.p95 <= 500); run += 1) {
    const times = await page.evaluate(async () => {
      const field = document.querySelector('[data-parameter="center_nm"]');
      const root = document.documentElement;
      const all = [];
      for (let i = 0; i < 21; i += 1) {
        const begun = performance.now();
        field.value = String(520 + i);
        field.dispatchEvent(new Event("input", { bubbles: true }));
        await new Promise((resolve) => {
          const watch = new MutationObserver(() => { if (root.dataset.settled !== undefined) { watch.disconnect(); resolve(); } });
          watch.observe(root, { attributes: true, attributeFilter: ["data-settled"] });
        });
        all.push(performance.now() - begun);
      }
      return all.slice(1).sort((a, b) => a - b);
    });
    const found = { median: times[9], p95: times[18] };
    console.log(`# whole page after a change of a filter: ${found.median.toFixed(0)} ms in the median, ${found.p95.toFixed(0)} ms in 95 %`);
    if (!best || found.p95 < best.p95) best = found;
  }
  assert.ok(best.median <= 500 && best.p95 <= 500, JSON.stringify(best));
  assert.deepEqual(faults, []);
  await close();
});

test("the keyboard does it all", async () => {
  const { page, faults, close } = await open();
  await page.getByRole("gridcell", { name: "Row 1, column 1" }).focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("r");
  await page.keyboard.press("Shift+ArrowDown");
  assert.deepEqual(await cells(page), ["RR", "GR"]);
  await page.keyboard.press("3");
  assert.equal((await cells(page))[1][1], await page.locator("#palette [role=radio]").nth(2).textContent());
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  await page.getByRole("radio", { name: "Filter" }).first().focus();
  await page.keyboard.press("ArrowRight");
  const selected = await page.locator("#palette [aria-checked=true]").textContent();
  await page.getByLabel(`Shape of filter ${selected}`).selectOption("gaussian");
  const handle = page.getByRole("slider", { name: `${selected}: Centre and peak` });
  const before = Number(await handle.getAttribute("aria-valuenow"));
  await handle.focus();
  await page.keyboard.press("Shift+ArrowRight");
  assert.ok(Math.abs(Number(await handle.getAttribute("aria-valuenow")) - before - 10) <= 1);
  await page.getByLabel("Rows").fill("4");
  await page.getByLabel("Rows").press("Enter");
  assert.equal((await cells(page)).length, 4);
  await page.locator("#stage").focus();
  await page.keyboard.press("4");
  await page.locator("#scale").waitFor();
  await page.keyboard.press("f");
  await page.locator("#caption", { hasText: /^Reference$/ }).waitFor();
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

for (const colorScheme of ["light", "dark"]) {
  test(`it is accessible and fits from 360 px to 4K in ${colorScheme}`, async () => {
    const { page, faults, close } = await open({ colorScheme });
    // A mosaic with a clear filter, and a difference from what is pinned.
    await page.getByLabel("Start from").selectOption("rgbw");
    await settled(page);
    for (const [width, height] of [[360, 800], [390, 844], [1440, 900], [3840, 2160]]) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(100);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${width}`);
      assert.deepEqual(await axe(page), [], `${width}`);
      if (process.env.SMALTI_PICTURES) await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `studio-${width}-${colorScheme}.png`), fullPage: width < 1000 });
    }
    // axe.run is evaluated in the page, whose policy admits no other script.
    assert.deepEqual(faults.filter((f) => !f.includes("Content Security Policy")), []);
    await close();
  });
}

test("the exported folder works from any web server, and nothing moves while it starts", async () => {
  run("studio", "bayer", "--export", "site", "--quiet");
  const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json" };
  const other = createServer(async (request, response) => {
    const path = new URL(request.url, "http://x").pathname.replace(/^\/deep\//, "/").replace(/\/$/, "/index.html");
    try {
      response.setHeader("Content-Type", types[extname(path)] ?? "application/octet-stream");
      response.end(await readFile(join(dir, "site", path)));
    } catch {
      response.writeHead(404).end();
    }
  });
  other.listen(0, "127.0.0.1");
  await once(other, "listening");
  const { page, faults, close } = await open({}, `http://127.0.0.1:${other.address().port}/deep/`);
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  // It offers nothing that needs the server, and says which commands do it. The engine makes the table and the raw image of the picture.
  assert.ok(await page.locator("#native-panel").isHidden());
  assert.ok(await page.getByRole("button", { name: "Search widely" }).isHidden());
  await page.getByText("File", { exact: true }).click();
  assert.equal(await page.getByRole("button", { name: /Save report/ }).count(), 0);
  assert.equal(await page.getByRole("button", { name: /Save learned table|Save raw capture/ }).count(), 2);
  await page.getByText("smalti train", { exact: true }).waitFor();
  await page.getByText("File", { exact: true }).click();
  const shift = await page.evaluate(() => new Promise((resolve) => {
    let sum = 0;
    new PerformanceObserver((list) => { for (const entry of list.getEntries()) sum += entry.value; }).observe({ type: "layout-shift", buffered: true });
    setTimeout(() => resolve(sum), 300);
  }));
  assert.ok(shift < 0.1, `layout shift ${shift}`);
  assert.deepEqual(faults, []);
  await close();
  other.close();
});

test("what does not come from the own page is refused", async () => {
  const origin = new URL(server.address).origin;
  const ask = async (path, options = {}, base = server.address) => {
    const response = await fetch(base + path, options);
    return [response.status, response.headers, await response.text()];
  };
  const [ok, headers] = await ask("");
  assert.equal(ok, 200);
  assert.match(headers.get("content-security-policy"), /default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; .*frame-ancestors 'none'/);
  assert.equal(headers.get("cross-origin-resource-policy"), "same-origin");
  const expected = [
    [403, await ask("", {}, server.address.replace(/[0-9a-f]{32}/, "0".repeat(32)))],
    [403, await ask("main.js", {}, `${origin}/`)],
    [403, await ask("", { headers: { Origin: "http://evil.example" } })],
    [403, await ask("engine/manifest.json", { headers: { "Sec-Fetch-Site": "cross-site" } })],
    [403, await ask("", { method: "POST", body: "x" })],
    [405, await ask("", { method: "POST", body: "x", headers: { Origin: origin } })],
    [405, await ask("start.toml", { method: "PUT", body: "x".repeat(100_000), headers: { Origin: origin } })],
    [404, await ask("engine/..%2f..%2fstart.toml")],
    [404, await ask("%2e%2e%2f%2e%2e%2fetc/passwd")],
    [404, await ask("engine/")],
    [404, await ask("%00")],
    [400, await ask("native", { headers: { Origin: origin } })],
  ];
  for (const [i, [status, [got, , text]]] of expected.entries()) assert.equal(got, status, `request ${i}: ${text}`);
  // A page of another origin cannot read the design, with the address known.
  const foreign = createServer((_, response) => { response.setHeader("Content-Type", "text/html"); response.end("<!doctype html><title>other</title>"); });
  foreign.listen(0, "127.0.0.1");
  await once(foreign, "listening");
  const other = await (await browser.newContext()).newPage();
  await other.goto(`http://127.0.0.1:${foreign.address().port}/`);
  const reached = await other.evaluate((address) => fetch(`${address}start.toml`).then((r) => r.type, () => "refused"), server.address);
  assert.equal(reached, "refused");
  const connected = await other.evaluate((address) => new Promise((resolve) => {
    const socket = new WebSocket(`${address.replace("http", "ws")}native`);
    socket.onopen = () => resolve("connected");
    socket.onerror = () => resolve("refused");
  }), server.address);
  assert.equal(connected, "refused");
  foreign.close();
});
