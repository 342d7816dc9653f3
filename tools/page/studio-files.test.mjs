// The files of the studio without a server, results that it opens, and the sweep.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { axe, open } from "./browser.mjs";
import { cells, saved, settled, startFrom, studioAndSite, toml } from "./studio.mjs";

let own;
before(async () => { own = await studioAndSite(); });
after(() => own?.end());

const picture = async (page, name) => {
  if (!process.env.SMALTI_PICTURES) return;
  for (const [width, height] of [[1440, 900], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(200);
    await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `${name}-${width}.png`), fullPage: true });
  }
};

test("without a server the page saves the table and the raw image of its picture, which make it again", async () => {
  const { page, faults, close } = await own.open({}, own.exported.address);
  const kept = async (name, file) => {
    const download = await saved(page, name);
    await writeFile(join(own.dir, file), download.content);
    return download.name;
  };
  await page.getByText("File", { exact: true }).click();
  await page.getByText("The table is that of the picture shown").waitFor();
  await picture(page, "files-menu");
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.getByText("File", { exact: true }).click();
  assert.match(await kept(/learned table/, "own.l3"), /^bayer-10\.l3$/);
  assert.match(await kept(/raw capture/, "own.dng"), /^bayer-.*-10\.dng$/);
  await kept(/picture as PNG/, "shown.png");
  const gain = await page.locator("#display-gain").textContent();
  own.run("render", "own.dng", "--pipeline", "own.l3", "--gain", gain, "-o", "own.png");
  const [shown, rendered] = await Promise.all(["shown.png", "own.png"].map((file) => readFile(join(own.dir, file), "base64")));
  const { size, differing } = await page.evaluate(async (files) => {
    const [a, b] = await Promise.all(files.map(async (file) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(file), (c) => c.charCodeAt(0))]), { colorSpaceConversion: "none" });
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return context.getImageData(0, 0, bitmap.width, bitmap.height);
    }));
    const differing = a.data.filter((value, i) => value !== b.data[i]).length;
    return { size: [a.width, a.height, b.width, b.height], differing };
  }, [shown, rendered]);
  assert.deepEqual(size.slice(0, 2), size.slice(2));
  assert.ok(size.every((side) => side >= 64 && side <= 1024), String(size));
  assert.equal(differing, 0, "bytes of the picture that the command renders differ from those of the page");
  assert.deepEqual(faults, []);
  await close();
});

// A name that would be markup in a page that does not escape it.
const HOSTILE = "<img src=x onerror=alert(1)></title><script>alert(2)</script>'&amp;";

test("without a server the page saves a report that stands alone and has the figures that it shows", async () => {
  const { page, faults, close } = await own.open({}, own.exported.address);
  const tiles = (of) => of.locator(".tile").evaluateAll((all) => all.map((tile) => ["dt", ".unit", ".value", ".delta > [aria-hidden]"].map((part) => tile.querySelector(part)?.textContent ?? "")));
  const begun = await tiles(page);
  await startFrom(page, "rgbw");
  await page.getByLabel("Infrared cut").selectOption("none");
  await page.locator("#name").fill(HOSTILE);
  await page.locator("#name").press("Enter");
  await settled(page);
  await page.waitForFunction(() => /of the samples/.test(document.querySelector("#clipping").textContent));
  const shown = await tiles(page);
  const [warnings, clipping] = [await page.locator("#warnings li").allTextContents(), await page.locator("#clipping").textContent()];
  const [camera, png, report] = [await toml(page), (await saved(page, "Save picture as PNG")).content, await saved(page, "Save report of this picture (HTML)")];
  assert.match(report.name, /^img-src-x-onerror-alert-1-title-script-alert-2-script-amp-brushes-10-report\.html$/);
  const file = join(own.dir, "report.html");
  await writeFile(file, report.content);
  for (const [width, height, colorScheme] of [[1440, 900, "light"], [1440, 900, "dark"], [390, 844, "light"], [390, 844, "dark"]]) {
    const look = await open(own.browser, file, { viewport: { width, height }, colorScheme });
    assert.deepEqual(await axe(look.page), [], `${width}, ${colorScheme}`);
    assert.ok(await look.page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${width}`);
    if (process.env.SMALTI_PICTURES) await look.page.screenshot({ path: join(process.env.SMALTI_PICTURES, `report-${width}-${colorScheme}.png`), fullPage: true });
    // axe.run is evaluated in the page, whose policy admits no script.
    assert.deepEqual(look.faults.filter((f) => !f.includes("Content Security Policy")), []);
    await look.close();
  }
  const read = await open(own.browser, file, { javaScriptEnabled: false });
  const section = (title) => read.page.locator("section", { has: read.page.getByRole("heading", { name: title, level: 2 }) });
  assert.equal(await read.page.locator("h1").textContent(), HOSTILE);
  assert.equal(await read.page.title(), `${HOSTILE}: report of the Smalti studio`);
  assert.equal(await read.page.locator("script, iframe, object, link:not([rel=icon]), [onerror], img:not([src^='data:image/png;base64,'])").count(), 0);
  // Scores: of the design, of the pinned one as the page began, and their differences with the doubt that the page states.
  const rows = await read.page.locator("table.scored tbody tr").evaluateAll((all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
  assert.deepEqual(rows.map((row) => row.slice(0, 4)), shown.map(([label, unit, value, delta], i) => [unit ? `${label} ${unit}` : label, value, begun[i][2], delta.replace(/ ± .*/, "")]));
  assert.equal(rows.length, 12);
  assert.deepEqual(rows.map((row) => row[4]).slice(0, 5), ["± 0.9", "± 0.6", "± 1.3", "± 1.8", "± 0.03"]);
  const [, noise, noiseBefore, , noiseDoubt] = rows[5];
  assert.ok(Math.abs(Number(noiseDoubt.replace("± ", "")) - 0.35 * Math.max(noise, noiseBefore)) < 0.01, JSON.stringify(rows[5]));
  assert.deepEqual(rows.slice(6).map((row) => row[4]), Array(6).fill("–"));
  assert.ok((await section("Scores").textContent()).includes("It is 0.9 dB (CPSNR), 0.6 (ΔE2000), 1.3 (ΔE2000, 95 %), 1.8 (S-CIELAB), 0.03 cy/px (MTF50 4:1; 0.1 below 10 cd/m²) and 35 % of the larger value (Noise)."));
  assert.deepEqual(await section("Scores").locator("ul li").allTextContents(), warnings);
  assert.ok(warnings.length > 0);
  assert.ok((await section("Over luminance").textContent()).includes(clipping));
  assert.equal(await section("Over luminance").locator("figure svg").count(), 4);
  // Both mosaics and their curves, and the conditions that differ.
  assert.deepEqual(await read.page.locator(".tile-drawing").evaluateAll((all) => all.map((svg) => svg.textContent)), ["RGWB", "RGGB"]);
  assert.equal(await read.page.locator(".design .curve").count(), 2 * (4 + 3));
  assert.deepEqual(await section("Sensor, lens and exposure").locator("strong").allTextContents(), ["ir-cut"]);
  assert.match(await read.page.locator("header").textContent(), /Paint brushes at 10 cd\/m² in daylight \(D65\) · noise seed 1 · Smalti \d+\.\d+\.\d+/);
  const commands = await section("How the figures were made").locator("pre").allTextContents();
  assert.match(commands[0], /^smalti compare \S+\.toml bayer\.toml --luminance 10 --exposure own --scene photo-brushes$/);
  // The pictures: the first one is that of the page, byte for byte.
  const images = await read.page.locator("img").evaluateAll((all) => all.map((img) => ({ src: img.src, width: img.naturalWidth, alt: img.alt })));
  assert.deepEqual(images.map(({ width }) => width > 64), [true, true, true]);
  assert.ok(images[2].alt.includes("standard observer"));
  assert.equal(images[0].src, `data:image/png;base64,${png.toString("base64")}`);
  // The camera file is that which the page saves, and the address opens both designs.
  const link = read.page.locator("a[download]").first();
  await read.page.locator("summary").first().click();
  assert.equal(decodeURIComponent((await link.getAttribute("href")).replace("data:application/toml;charset=utf-8,", "")), camera);
  await writeFile(join(own.dir, "of-report.toml"), camera);
  assert.equal(JSON.parse(own.run("show", "of-report.toml", "--json", "--quiet")).description.name, HOSTILE);
  const address = await read.page.getByRole("link", { name: "Open this design in the studio" }).getAttribute("href");
  assert.ok(address.startsWith(`${own.exported.address}#`));
  const again = await own.open({}, address);
  assert.deepEqual(await cells(again.page), ["RG", "WB"]);
  assert.deepEqual(await tiles(again.page), shown);
  assert.equal(await again.page.locator("#pinned").textContent(), await page.locator("#pinned").textContent());
  assert.deepEqual([...faults, ...read.faults, ...again.faults], []);
  await Promise.all([close(), read.close(), again.close()]);
});

test("results of a search and the report of a sweep open as designs", async () => {
  const { page, faults, close } = await own.open({}, own.exported.address);
  const flat = (value) => Array(31).fill(value);
  const search = {
    name: "found", family: { dichroic: { edge_nm: 20 } }, wavelengths_nm: flat(0).map((_, i) => 400 + 10 * i),
    searched: [{ tile: "ab/ca", transmittances: [flat(0.2), flat(0.5), flat(0.9)] }],
  };
  const take = (name, content) => page.locator("#file").setInputFiles({ name, mimeType: "application/json", buffer: Buffer.from(JSON.stringify(content)) });
  await take("results.json", search);
  await page.waitForFunction(() => document.querySelector("#name").value === "found");
  assert.deepEqual(await cells(page), ["AB", "CA"]);
  // Its filters are judged as those of the family of the search.
  assert.equal(await page.locator("#family").inputValue(), "dichroic");
  await page.getByText("found is open with the sensor and the lens of this page").waitFor();
  const filters = [[455, 25], [540, 35], [600, 30]].map(([center, sigma]) => `{ gaussian = { center_nm = ${center}, sigma_nm = ${sigma} } }`);
  await writeFile(join(own.dir, "few.toml"), `camera = "table1"\ncolors = [3]\nmosaics = { given = [["bc", "ab"]] }\nmetrics = ["vora_value"]\n[[filters.list]]\nfilters = [${filters.join(", ")}]\n`);
  own.run("sweep", "few.toml", "-o", "few", "-q");
  own.run("report", "few", "-q");
  await page.locator("#file").setInputFiles(join(own.dir, "few/report/report.json"));
  await page.waitForFunction(() => document.querySelector("#name").value === "few, trial 0");
  assert.deepEqual(await cells(page), ["BC", "AB"]);
  await settled(page);
  // A name that would turn the text around it is shown without that, as `smalti studio` does with the folder.
  const report = JSON.parse(await readFile(join(own.dir, "few/report/report.json")));
  report.studies[0].name = "a\u202eb";
  await take("report.json", report);
  await page.waitForFunction(() => document.querySelector("#name").value === "a\ufffdb, trial 0");
  await take("other.json", { studies: [] });
  await page.getByText("it holds no camera").waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("a file of another kind is named, with what can be done with it, and never printed", async () => {
  const { page, faults, close } = await own.open({}, own.exported.address);
  const trouble = page.locator("#message[data-kind=trouble] #trouble");
  const bytes = (text) => Buffer.from(text, "latin1");
  for (const [name, content, said] of [
    ["own.l3", await readFile(join(own.dir, "own.l3")), "own.l3 is a learned table (.l3), which has a pipeline and no design. Use it with `smalti render raw.dng --pipeline FILE`."],
    ["own.dng", await readFile(join(own.dir, "own.dng")), "own.dng is a TIFF file or a raw image (DNG)."],
    ["camera.toml", await readFile(join(own.dir, "own.l3")), "camera.toml is a learned table"],
    ["part.parquet", bytes("PAR1\x15\x04\0\0"), "is a table of a sweep (Parquet). `smalti report STUDY` writes report.json"],
    ["scene.exr", bytes("\x76\x2f\x31\x01\x02\0\0\0"), "is an OpenEXR image"],
    ["a.gif", bytes("GIF89a\x01\0"), "Convert it to PNG or JPEG."],
    ["a.bin", bytes("\x01\x02\x03\0\xff"), "is a file of an unknown kind. The page opens camera.toml, results.json, report.json, curves as CSV, PNG and JPEG."],
    ["page.html", bytes("<!doctype html><p>"), "is a page or another file in HTML or XML"],
    ["script.js", bytes("var x=1;".repeat(900)), "script.js is no camera file: line 1, column"],
    [`${"long".repeat(40)}\u202e.toml`, bytes(`name = 1 # ${"x".repeat(900)}\n`), "… is no camera file: line 1"],
  ]) {
    await page.locator("#file").setInputFiles({ name, mimeType: "", buffer: content });
    await trouble.filter({ hasText: said }).waitFor();
    const text = await trouble.textContent();
    assert.ok(text.length < 450 && !/[\p{Cc}\u202e]/u.test(text), text);
    const [box, stage, dismiss] = await Promise.all(["#message", "#stage", "#dismiss"].map((s) => page.locator(s).boundingBox()));
    assert.ok(box.y >= stage.y && dismiss.x + dismiss.width <= stage.x + stage.width && dismiss.y + dismiss.height <= box.y + box.height, name);
    await page.getByRole("button", { name: "Dismiss the message" }).click();
  }
  // A file that is dragged over the page is seen to be taken.
  const drag = (type) => page.evaluate((event) => {
    const data = new DataTransfer();
    data.items.add(new File(["x"], "a.bin"));
    document.dispatchEvent(new DragEvent(event, { dataTransfer: data, cancelable: true }));
  }, type);
  for (const end of ["dragleave", "drop"]) {
    await drag("dragover");
    assert.match(await page.evaluate(() => getComputedStyle(document.body, "::after").content), /Drop the file to open it/);
    await drag(end);
    assert.equal(await page.evaluate(() => getComputedStyle(document.body, "::after").content), "none");
  }
  assert.deepEqual(faults, []);
  await close();
});

test("a sweep over light and tolerances is shown as a table and saved as CSV", async () => {
  const { page, faults, close } = await own.open();
  const panel = page.locator("#native-panel");
  await panel.getByLabel("Sweep on").selectOption("charts");
  await panel.getByLabel("Luminance").selectOption("here");
  await panel.getByRole("button", { name: "Light and tolerances" }).click();
  const table = panel.locator(".sweep table");
  await table.waitFor({ timeout: 240_000 });
  assert.equal(await table.locator("tbody").count(), 1);
  assert.deepEqual(await table.locator("th[scope=row]").allTextContents(), ["as designed", "−5 nm", "+5 nm", "thickness −5 %", "thickness +5 %"]);
  const cell = table.locator("tbody tr").nth(1).locator("td").first();
  const cpsnr = Number(await cell.evaluate((td) => td.firstChild.textContent));
  assert.ok(cpsnr > 20 && cpsnr < 60, String(cpsnr));
  // Every figure has its interval, also those as designed.
  assert.equal(await table.locator("td").count(), 15);
  assert.equal(await table.locator("td small").count(), 15);
  const [low, high] = (await cell.locator("small").textContent()).split(" to ").map(Number);
  assert.ok(low < cpsnr && cpsnr < high, `${low} to ${high}`);
  const [download] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "Save CSV" }).click()]);
  assert.equal(download.suggestedFilename(), "bayer-sweep.csv");
  const csv = String(await readFile(await download.path())).trim().split("\n");
  assert.equal(csv.length, 6);
  assert.ok(Math.abs(Number(csv[1].split(",")[3]) - cpsnr) < 0.006, csv[1]);
  assert.ok(!(await table.innerText()).includes("−0.00 "), "zero has no sign");
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  assert.equal(await panel.locator(".outdated:visible").count(), 0);
  await page.getByLabel("Read noise").fill("9");
  await panel.getByText("Out of date: the design has changed since this sweep.").waitFor();
  await picture(page, "sweep");
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  assert.deepEqual(await axe(page), []);
  assert.deepEqual(faults.filter((f) => !f.includes("Content Security Policy")), []);
  await close();
});
