// The studio and the native library behind it: full computations, the search, the end of the server, and what the server refuses.
import assert from "node:assert/strict";
import { once } from "node:events";
import { readFile, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { cells, filterOf, lockCell, lockFilter, openPreset, pixels, saved, settled, studio, toml } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

test("heavy work goes to the native library, can be cancelled, and its files open in the command", async () => {
  const { page, faults, close } = await open();
  const panel = page.locator("#native-panel");
  const done = (title) => page.waitForFunction((text) => document.querySelector("#native [data-state]").textContent.startsWith(text), `${title} is done`, { timeout: 240_000 });
  // A table takes a scene after the other.
  await page.getByRole("button", { name: "Full-size picture" }).click();
  await page.waitForFunction(() => /training .*, \d+ of \d+/.test(document.querySelector("#native [data-state]").textContent), null, { timeout: 60_000 });
  assert.equal(await page.getByRole("button", { name: "Full-size picture" }).getAttribute("aria-disabled"), "true", "one job at a time");
  const begun = Date.now();
  const cancel = panel.getByRole("button", { name: "Cancel" });
  await cancel.evaluate((button) => button.addEventListener("click", () => {
    window.states = [];
    const state = document.querySelector("#native [data-state]");
    new MutationObserver(() => window.states.push(state.textContent)).observe(state, { childList: true });
  }, { once: true }));
  await cancel.click();
  await panel.getByText("The full-size picture was cancelled.").waitFor({ timeout: 60_000 });
  assert.ok(Date.now() - begun < 20_000, `${Date.now() - begun} ms`);
  assert.deepEqual(await page.evaluate(() => window.states), ["The full-size picture was cancelled."], "no progress after that");
  // The design, its raw capture and its table, which the command makes again to the same bytes.
  await page.getByLabel("Name of the design").fill("mine");
  await page.getByLabel("Name of the design").press("Enter");
  await page.getByLabel("Read noise").fill("3");
  await settled(page);
  await writeFile(join(own.dir, "mine.toml"), (await saved(page, "Save camera.toml")).content);
  const raw = await saved(page, "Save raw capture (DNG)");
  assert.equal(raw.name, "mine-brushes-10.dng");
  await writeFile(join(own.dir, raw.name), raw.content);
  own.run("simulate", "mine.toml", "--scene", "photo-brushes", "--luminance", "10", "--illuminant", "D65", "-o", "simulated", "-q");
  assert.ok(raw.content.equals(await readFile(join(own.dir, "simulated", "raw.dng"))), "the raw capture is that of smalti simulate");
  await page.getByText("File", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download", { timeout: 240_000 }), page.getByRole("button", { name: "Save learned table (.l3)" }).click()]);
  assert.equal(download.suggestedFilename(), "mine.l3");
  const table = await readFile(await download.path());
  await writeFile(join(own.dir, "mine.l3"), table);
  own.run("train", "mine.toml", "--illuminants", "D65", "-o", "again.l3", "-q");
  assert.ok(table.equals(await readFile(join(own.dir, "again.l3"))), "the table is that of smalti train");
  own.run("render", raw.name, "--pipeline", "mine.l3", "-o", "rendered.png", "-q");
  // The statistics are kept, so that the picture needs no further learning.
  await page.getByRole("button", { name: "Full-size picture" }).click();
  // It is told to be of the design with which it began.
  await page.getByLabel("Name of the design").fill("later");
  await page.getByLabel("Name of the design").press("Enter");
  await page.locator("#scene").selectOption("spices");
  await done("The full-size picture");
  await page.locator("#scene").selectOption("brushes");
  await page.getByLabel("Name of the design").fill("mine");
  await page.getByLabel("Name of the design").press("Enter");
  const picture = panel.getByRole("img", { name: "Full-size picture: mine, brushes, 10 cd/m²" });
  assert.deepEqual(await picture.evaluate((image) => image.decode().then(() => [image.naturalWidth, image.naturalHeight])), [640, 480]);
  assert.match(await panel.locator("figcaption").textContent(), /640 × 480 pixels, exposed for 100 ms\. CPSNR [\d.]+ dB, ΔE2000 [\d.]+, S-CIELAB [\d.]+\./);
  const [png] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "Save PNG" }).click()]);
  own.run("simulate", "mine.toml", "--scene", "photo-brushes", "--luminance", "10", "--illuminant", "D65", "--pipeline", "mine.l3", "-o", "learned", "-q");
  assert.ok((await readFile(await png.path())).equals(await readFile(join(own.dir, "learned", "rendered.png"))), "the picture is that of smalti simulate");
  // The report is a page that works alone.
  await page.getByText("File", { exact: true }).click();
  const [report] = await Promise.all([page.waitForEvent("download", { timeout: 240_000 }), page.getByRole("button", { name: "Save report with intervals (HTML)" }).click()]);
  assert.equal(report.suggestedFilename(), "mine-report.html");
  await panel.getByText("The report is done. The file mine-report.html was downloaded.").waitFor();
  // What was computed before a change of the design says so, until the change is undone.
  const old = panel.locator(".outdated:visible");
  assert.equal(await old.count(), 0, (await old.allTextContents()).join());
  await page.getByLabel("Read noise").fill("4");
  assert.deepEqual(await old.allTextContents(), ["Out of date: the design or the pinned design has changed since this report.", "Out of date: the design has changed since this picture."]);
  await page.keyboard.press("Control+z");
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  assert.deepEqual(await old.allTextContents(), ["Out of date: the design or the pinned design has changed since this report."]);
  const html = await readFile(await report.path(), "utf8");
  assert.match(html, /^<!doctype html>/i);
  assert.ok(html.includes("smalti compare again-1.toml again-2.toml --luminance 10 --scene photo-brushes"), "it states its command");
  assert.deepEqual(faults, []);
  await close();
});

test("the native library searches all mosaics, and keeps what is locked", async () => {
  const { page, faults, close } = await open();
  const found = (what) => page.locator(".improve .progress", { hasText: what }).waitFor({ timeout: 240_000 });
  await page.getByLabel("Filters are").selectOption("dichroic");
  await page.getByLabel("Keep the mosaic").check();
  await page.getByRole("button", { name: "Global search" }).click();
  await found(/^The mosaic was kept, and its filters were searched\. (Expected: [+−±][\d.]+ dB|None is better)/);
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  if (await page.getByRole("button", { name: "Discard" }).isVisible()) {
    await page.getByRole("button", { name: "Discard" }).click();
    assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true", "the search is one step");
  }
  // A cell and a filter, which stays in its cells.
  await page.getByLabel("Keep the mosaic").uncheck();
  await lockCell(page, 2, 2);
  await lockFilter(page, "R");
  const filter = filterOf(await toml(page), "R");
  await page.getByRole("button", { name: "Global search" }).click();
  await found(/^\d+ mosaics with their filters were searched\. (Expected: [+−±][\d.]+ dB|None is better)/);
  const [first, second] = await cells(page);
  assert.equal(`${first[0]}${second[1]}`, "RB");
  assert.equal(filterOf(await toml(page), "R"), filter);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("the native library receives the camera as stated", async () => {
  let connection;
  const sent = [];
  const { page, faults, close } = await open({}, undefined, (p) => p.on("websocket", (socket) => { connection = socket; socket.on("framesent", ({ payload }) => sent.push(JSON.parse(payload))); }));
  assert.ok(connection);
  await openPreset(page, "phone");
  await settled(page);
  const raw = await saved(page, "Save raw capture (DNG)");
  assert.match(raw.name, /^phone-.*\.dng$/);
  const { design } = sent.find(({ start }) => start?.job.capture).start.job.capture;
  const { exposure, sensor } = JSON.parse(own.run("show", "phone", "--json")).description;
  assert.equal(design.sensor.crosstalk_percent, sensor.crosstalk_percent);
  assert.equal(design.exposure.auto, exposure.auto);
  assert.deepEqual(faults, []);
  await close();
});

test("when the server ends, the page says so and goes on", async () => {
  const other = await own.serve();
  const { page, faults, close } = await open({}, other.address);
  await page.getByLabel("Read noise").fill("4");
  await page.getByRole("button", { name: "Full-size picture" }).click();
  await page.waitForFunction(() => /training/.test(document.querySelector("#native [data-state]").textContent), null, { timeout: 60_000 });
  await other.end();
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
  // The report of the picture comes from the page, and does not hand on the address of the server with its token.
  const report = await saved(page, "Save report of this picture (HTML)");
  assert.match(report.name, /^bayer-changed-.*-report\.html$/);
  const html = report.content.toString();
  assert.ok(html.includes("<h1>bayer-changed</h1>") && html.includes("append this text to the address of its page"), html.slice(0, 2000));
  assert.ok(!html.includes(new URL(other.address).host) && !html.includes(/[0-9a-f]{32}/.exec(other.address)[0]));
  assert.deepEqual(faults.filter((f) => !f.includes("WebSocket")), []);
  await close();
});

test("what does not come from the own page is refused", async () => {
  const origin = new URL(own.server.address).origin;
  const ask = async (path, options = {}, base = own.server.address) => {
    const response = await fetch(base + path, options);
    return [response.status, response.headers, await response.text()];
  };
  const [ok, headers] = await ask("");
  assert.equal(ok, 200);
  assert.match(headers.get("content-security-policy"), /default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; .*frame-ancestors 'none'/);
  assert.equal(headers.get("cross-origin-resource-policy"), "same-origin");
  const expected = [
    [403, await ask("", {}, own.server.address.replace(/[0-9a-f]{32}/, "0".repeat(32)))],
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
  const other = await (await own.browser.newContext()).newPage();
  await other.goto(`http://127.0.0.1:${foreign.address().port}/`);
  const reached = await other.evaluate((address) => fetch(`${address}start.toml`).then((r) => r.type, () => "refused"), own.server.address);
  assert.equal(reached, "refused");
  const connected = await other.evaluate((address) => new Promise((resolve) => {
    const socket = new WebSocket(`${address.replace("http", "ws")}native`);
    socket.onopen = () => resolve("connected");
    socket.onerror = () => resolve("refused");
  }), own.server.address);
  assert.equal(connected, "refused");
  foreign.close();
});
