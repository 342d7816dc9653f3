// The design in the studio: mosaic, filters, sensor, lens and history, in a real browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { cells, curve, field, filterOf, openPreset, pixels, saved, score, settled, studio, toml } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

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
  assert.ok(await page.locator(".delta[data-kind=better], .delta[data-kind=worse]").count() > 0);
  await page.waitForFunction(() => /CPSNR [\d.]+ dB/.test(document.getElementById("told").textContent));
  // Only a change beyond the doubt of the page is called better or worse.
  for (const [label, relevant, doubt] of [["CPSNR", 0.1, 0.9], ["ΔE2000", 0.05, 0.6], ["S-CIELAB", 0.05, 1.8]]) {
    const tile = page.locator(".tile", { has: page.getByText(label, { exact: true }) }).locator(".delta");
    const [shown, kind] = [await tile.locator("[aria-hidden]").textContent(), await tile.getAttribute("data-kind")];
    const by = Math.abs(Number.parseFloat(shown.replace(/^[+−±]/, "")));
    const expected = by < relevant ? /^[+−±][\d.]+$/ : by < doubt ? new RegExp(`^[+−][\\d.]+ ± ${doubt}$`) : /^[+−][\d.]+ (better|worse)$/;
    assert.match(shown, expected, label);
    assert.equal(kind === "same", by < doubt, `${label}: ${shown}`);
  }
  // That of the noise is relative.
  const noise = page.locator(".tile", { has: page.getByText("Noise", { exact: true }) }).locator(".delta");
  const [shown, kind] = [await noise.locator("[aria-hidden]").textContent(), await noise.getAttribute("data-kind")];
  const now = await score(page, "Noise");
  const by = Number(shown.replace("−", "-").match(/^[+−±-]?[\d.]+/)[0].replace("±", ""));
  assert.equal(kind === "same", Math.abs(by) < 0.35 * Math.max(now, now - by), `${shown}, ${now}`);
  // That of the resolution is larger in dim light. The smallest relevant change is 5 %.
  await page.getByLabel("Luminance", { exact: true }).fill("0");
  await settled(page);
  const tile = page.locator(".tile", { has: page.getByText("MTF50 4:1", { exact: true }) }).locator(".delta [aria-hidden]");
  const [resolution, change] = [await score(page, "MTF50 4:1"), await tile.textContent()];
  const amount = Number(change.match(/[\d.]+/)[0]);
  if (amount > 0.06 * resolution && amount < 0.1) assert.match(change, /^[+−][\d.]+ ± 0\.1$/, String(resolution));
  else assert.match(change, amount >= 0.1 ? /better|worse/ : /^[+−±][\d.]+/, String(resolution));
  await page.getByLabel("Luminance", { exact: true }).fill("1");
  await settled(page);
  assert.doesNotMatch(await page.locator("#told").textContent(), / [,;]/);
  // A design that differs from the pinned one of the same name says so.
  assert.equal(await page.locator("#pinned").textContent(), "bayer, changed, against the pinned bayer");
  assert.match(await page.locator("#caption").textContent(), /^bayer, changed · /);
  assert.equal(await page.locator("#wait").textContent(), "", "nothing is said of the start any more");
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

test("the map of differences is that from what the page compares with", async () => {
  const { page, faults, close } = await open();
  await page.getByLabel("Read noise").fill("30");
  await page.getByLabel("Read noise").press("Enter");
  await page.getByRole("button", { name: "Difference" }).click();
  await page.locator("#caption", { hasText: /^ΔE2000 from the reference$/ }).waitFor();
  await settled(page);
  const fromReference = await pixels(page);
  await page.getByLabel("Against").selectOption("pin");
  await page.locator("#caption", { hasText: /^ΔE2000 from the pinned bayer$/ }).waitFor();
  await settled(page);
  assert.notEqual(await pixels(page), fromReference);
  // From itself it is zero everywhere: the darkest colour of the scale.
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  await settled(page);
  const most = await page.locator("#canvas").evaluate((canvas) => Math.max(...canvas.getContext("2d").getImageData(canvas.width / 2 - 20, canvas.height / 2 - 20, 40, 40).data.filter((_, i) => i % 4 === 0)));
  assert.equal(most, 0);
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

test("a curve is drawn freely, in one step of the history", async () => {
  const { page, faults, close } = await open();
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByRole("button", { name: "Draw", exact: true }).click();
  const plot = page.locator("#plot svg");
  await plot.scrollIntoViewIfNeeded();
  const box = await plot.boundingBox();
  // As the page draws its axes.
  const at = (nm, value) => [box.x + 34 + (nm - 380) / 400 * (box.width - 44), box.y + box.height - 30 - value * (box.height - 40)];
  await page.mouse.move(...at(480, 0.2));
  await page.mouse.down();
  await page.mouse.move(...at(620, 0.2), { steps: 10 });
  await page.mouse.up();
  assert.equal(await page.getByLabel("Shape of filter G").inputValue(), "samples");
  await settled(page);
  const [names, ...rows] = (await saved(page, "Save curves as CSV")).content.toString().trim().split("\n").map((line) => line.split(","));
  const column = names.indexOf("transmittance_G");
  for (const row of rows.filter(([nm]) => nm >= 490 && nm <= 610)) assert.ok(Math.abs(row[column] - 0.2) < 0.02, row.join());
  // Its point moves with the keyboard and states its height.
  const point = page.getByRole("slider", { name: "G: Point of the curve" });
  const height = Number(await point.getAttribute("aria-valuenow"));
  await point.press("ArrowUp");
  assert.equal(Number(await point.getAttribute("aria-valuenow")), height + 1);
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true");
  assert.equal(await page.getByLabel("Shape of filter G").inputValue(), "builtin");
  assert.deepEqual(faults, []);
  await close();
});

test("the handle of a dye moves its band and its absorbance", async () => {
  const { page, faults, close } = await open();
  await page.getByRole("radio", { name: "Filter G" }).click();
  await page.getByLabel("Shape of filter G").selectOption("dye");
  await settled(page);
  const numbers = async () => [Number(await field(page, "center_nm 0").inputValue()), Number(await page.getByLabel("Peak absorbance 1").inputValue())];
  const [center, absorbance] = await numbers();
  const handle = page.getByRole("slider", { name: "G: Absorption band 1, centre and absorbance" });
  await handle.scrollIntoViewIfNeeded();
  const box = await handle.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y + 12, { steps: 6 });
  await page.mouse.up();
  const [dragged, deeper] = await numbers();
  assert.ok(dragged > center + 10 && dragged < center + 70, `${center} to ${dragged}`);
  assert.ok(deeper > absorbance, `${absorbance} to ${deeper}`);
  await handle.press("ArrowUp");
  assert.ok((await numbers())[1] < deeper);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

// What Beer and Lambert say of a layer that is `thickness` times as thick.
const thicker = (transmittance, thickness, clear) => clear * (transmittance / clear) ** thickness;

test("the thickness of a measured pigment is a number and a handle, and the file says it", async () => {
  const { page, faults, close } = await open();
  await page.getByRole("radio", { name: "Filter R" }).click();
  await page.locator("#filter .fields select").selectOption("pigment/R");
  await settled(page);
  const own = await curve(page, "R");
  const most = Math.max(...own.map(([, t]) => t));
  const steps = async () => page.locator("#undo").getAttribute("aria-disabled");
  const field_ = field(page, "thickness");
  assert.equal(await field_.inputValue(), "1");
  const handle = page.getByRole("slider", { name: "R: Relative thickness" });
  await handle.waitFor();
  await field_.fill("2");
  await field_.press("Enter");
  await settled(page);
  assert.ok(await field_.evaluate((input) => document.activeElement === input), "the focus stays");
  const twice = await curve(page, "R");
  // A clear filter transmits the same share at all wavelengths: 95 %, or the most of the filter, which may be infrared.
  const brightest = own.findIndex(([, t]) => t === most);
  const clear = most ** 2 / twice[brightest][1];
  assert.ok(clear > Math.max(0.95, most) - 1e-4 && clear <= 1, String(clear));
  for (const [i, [nm, t]] of twice.entries()) assert.ok(Math.abs(t - thicker(own[i][1], 2, clear)) < 2e-5, `${nm} nm: ${own[i][1]} to ${t}`);
  assert.ok(twice.some(([, t], i) => own[i][1] - t > 0.1));
  // It is still the built-in pigment, which the saved file says of its curve.
  assert.equal(await page.getByLabel("Shape of filter R").inputValue(), "builtin");
  assert.equal(await page.locator("#filter .fields select").inputValue(), "pigment/R");
  const file = await toml(page);
  assert.match(file, /^# sensor\.cfa\.filters\.R: pigment\/R at 2 times its thickness \(Beer–Lambert law\), in samples\.$/m);
  assert.match(filterOf(file, "R"), /samples/);
  // The handle moves it down; the keys up again.
  const box = await handle.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x, y + 8, { steps: 4 });
  await page.mouse.up();
  const dragged = Number(await field_.inputValue());
  assert.ok(dragged > 2.1 && dragged <= 4, String(dragged));
  assert.equal(await handle.getAttribute("aria-valuetext"), `${dragged} times as thick`);
  await handle.press("Shift+ArrowUp");
  assert.ok(Number(await field_.inputValue()) < dragged);
  for (let i = 0; i < 2; i += 1) await page.keyboard.press("Control+z");
  assert.equal(await field_.inputValue(), "2");
  await page.keyboard.press("Control+z");
  assert.equal(await field_.inputValue(), "1");
  assert.doesNotMatch(await toml(page), /thickness|samples/);
  assert.equal(await steps(), "false");
  // A drawn curve has a thickness as well, from where it was drawn.
  await page.getByLabel("Shape of filter R").selectOption("samples");
  await settled(page);
  await field(page, "thickness").fill("0.5");
  await settled(page);
  const half = await curve(page, "R");
  for (const [i, [nm, t]] of half.entries()) assert.ok(Math.abs(t - thicker(own[i][1], 0.5, Math.max(0.95, most))) < 3e-4, `${nm} nm: ${own[i][1]} to ${t}`);
  assert.match(await toml(page), /filters\.R: a drawn curve at 0\.5 times its thickness/);
  assert.deepEqual(faults, []);
  await close();
});

test("a number out of range is refused in words, and its field shows the design again", async () => {
  const { page, close } = await open();
  for (const [label, wrong, range] of [["#read-noise", "-5", "Read noise: expected 0 to 1000000 e⁻."], ["#filter [data-parameter=thickness]", "9", "Relative thickness: expected 0.25 to 4 ×."], ["#f-number", "0.01", "f-number: expected "]]) {
    const input = page.locator(label);
    const before = await input.inputValue();
    await input.fill(wrong);
    await input.press("Enter");
    await page.locator("#message[data-kind=trouble]", { hasText: range }).waitFor();
    await input.blur();
    assert.equal(await input.inputValue(), before, label);
  }
  await close();
});

test("the curves over luminance say from where on the design clips", async () => {
  const { page, faults, close } = await open();
  const note = page.locator("#clipping");
  const found = async (what) => { await page.locator("#clipping", { hasText: what }).waitFor({ timeout: 60_000 }); return note.textContent(); };
  await page.getByLabel("Full well").fill("1000");
  await settled(page);
  const [, limit] = (await found(/: above [\d.]+ cd\/m² \(dotted; the pinned design: above 7/)).match(/^Expected figures do not include clipping: above ([\d.]+) cd\/m² \(dotted; the pinned design: above 7\d\d cd\/m²\), more than 1 % of the samples clip\.$/);
  // The pictures agree: at the luminance of the slider below it at most 1 % of the samples are saturated, and more at the next one.
  const slider = page.getByLabel("Luminance", { exact: true });
  const at = async (decades) => {
    await slider.fill(String(decades));
    await settled(page);
    return score(page, "Saturated");
  };
  const decades = Math.log10(Number(limit));
  const step = Math.floor(decades * 20);
  assert.ok(await at(step / 20) <= 1);
  assert.ok(await at((step + 1) / 20) > 1);
  // The curve is solid up to there and dotted beyond.
  const [solid, dotted] = await page.locator("#light-curve path.own").evaluateAll((all) => [all.find((p) => !p.matches(".clips")), all.find((p) => p.matches(".clips"))].map((p) => p.getBBox()).map(({ x, width }) => ({ x, width })));
  assert.ok(Math.abs(solid.x + solid.width - dotted.x) < 0.2, JSON.stringify([solid, dotted, limit]));
  const [left, right] = [solid.x, dotted.x + dotted.width];
  assert.ok(Math.abs((dotted.x - left) / (right - left) - (decades + 1) / 4) < 0.01, `${left}, ${dotted.x}, ${right}: ${limit} cd/m²`);
  assert.match(await page.locator("#light-curve svg").getAttribute("aria-label"), /above [\d.]+ cd\/m² \(dotted; the pinned design/);
  const place = await note.boundingBox();
  // With the largest full well nothing clips.
  await page.getByLabel("Full well").fill("1000000");
  await page.getByLabel("Conversion gain").fill("1");
  await settled(page);
  await found(/: more than 1 % of the samples of the pinned design clip above 7\d\d cd\/m² \(dotted\)\.$/);
  assert.equal(await page.locator("#light-curve path.own.clips").count(), 0);
  assert.deepEqual(await note.boundingBox(), place, "nothing moves");
  // The pinned design never clips.
  await page.getByRole("button", { name: "Pin", exact: true }).click();
  await page.getByLabel("Full well").fill("10000");
  await settled(page);
  await found(/: above [\d.]+ cd\/m² \(dotted; the pinned design: at none\), more than 1 % of the samples clip\.$/);
  assert.deepEqual(faults, []);
  await close();
});

test("symmetry paints the images of a cell; filters are added and removed", async () => {
  const { page, faults, close } = await open();
  for (const side of ["Rows", "Columns"]) {
    await page.getByLabel(side).fill("4");
    await page.getByLabel(side).press("Enter");
  }
  assert.deepEqual(await cells(page), ["RGRG", "GBGB", "RGRG", "GBGB"]);
  await page.getByRole("radio", { name: "Filter B" }).click();
  assert.match(await page.locator("#grid-help").textContent(), /^A stroke paints one cell\./);
  await page.getByLabel("Symmetry").selectOption("both");
  assert.match(await page.locator("#grid-help").textContent(), /^Symmetry is on \(both axes\): a stroke paints up to four cells\./);
  await page.evaluate(() => {
    window.told = [];
    const place = document.getElementById("told");
    new MutationObserver(() => window.told.push(place.textContent)).observe(place, { childList: true });
  });
  await page.getByRole("gridcell", { name: "Row 1, column 1:" }).click();
  assert.deepEqual(await cells(page), ["BGRB", "GBGB", "RGRG", "BBGB"]);
  await page.waitForFunction(() => window.told.includes("Row 1, column 1: B, and 2 more cells by symmetry"));
  await page.getByLabel("Symmetry").selectOption("diagonal");
  await page.getByRole("gridcell", { name: "Row 1, column 3:" }).click();
  assert.deepEqual(await cells(page), ["BGBB", "GBGB", "BGRG", "BBGB"]);
  await page.getByLabel("Symmetry").selectOption("none");
  await page.getByRole("button", { name: "Add a filter" }).click();
  assert.equal(await page.locator("#palette [aria-checked=true]").textContent(), "W");
  // Its curve is drawn before a cell is painted with it, and its handle lies on the curve.
  await page.waitForFunction(() => document.querySelectorAll("#plot .curve").length === 4);
  assert.deepEqual((await page.locator("#plot .letter").allTextContents()).sort(), ["B", "G", "R", "W"]);
  const apart = await page.evaluate(() => {
    const curve = [...document.querySelectorAll("#plot .curve")].at(-1);
    const [, x, y] = document.querySelector("#plot .handle").getAttribute("transform").match(/translate\((\S+) (\S+)\)/).map(Number);
    const points = Array.from({ length: 1001 }, (_, i) => curve.getPointAtLength(curve.getTotalLength() * i / 1000));
    return Math.min(...points.map((p) => Math.hypot(p.x - x, p.y - y)));
  });
  assert.ok(apart < 3, `${apart} px from the handle to the curve`);
  await page.getByRole("gridcell", { name: "Row 1, column 2:" }).click();
  assert.equal((await cells(page))[0], "BWBB");
  await settled(page);
  await page.getByRole("button", { name: "Remove filter W" }).click();
  assert.equal((await cells(page))[0], "BRBB", "the next filter takes its cells");
  assert.equal(await page.locator("#palette [role=radio]").count(), 3);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});

test("the infrared cut and automatic exposure change the picture and the camera file", async () => {
  const { page, faults, close } = await open();
  const begun = await pixels(page);
  await page.getByLabel("Infrared cut").selectOption("none");
  await settled(page);
  const open700 = await pixels(page);
  assert.notEqual(open700, begun);
  assert.doesNotMatch(await toml(page), /ir_cut/);
  await page.getByLabel("Automatic exposure").check();
  await settled(page);
  assert.ok(await page.locator("#time").isDisabled());
  assert.match(await toml(page), /auto = "specular"/);
  assert.doesNotMatch(await page.locator("#caption").textContent(), /exposed for 100 ms/);
  assert.notEqual(await pixels(page), open700);
  await page.getByLabel("Automatic exposure").uncheck();
  await settled(page);
  assert.match(await page.locator("#caption").textContent(), /exposed for 100 ms/);
  assert.equal(await pixels(page), open700);
  assert.deepEqual(faults, []);
  await close();
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
  await page.locator("#light-curve svg .own:not(.clips)").waitFor({ timeout: 60_000 });
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
  // In the range, but no scene can be imaged on such pixels; the message goes with its cause.
  await page.getByLabel("Pixel pitch").fill("1000");
  await page.getByLabel("Pixel pitch").press("Enter");
  await page.locator("#message[data-kind=trouble]").filter({ hasNotText: "expected 0.001" }).waitFor();
  // All that is of the state before says so: picture, scores and warnings.
  const opacity = (name) => page.locator(".tile", { has: page.getByText(name, { exact: true }) }).locator("dd").evaluate((e) => Number(getComputedStyle(e).opacity));
  await page.locator("#caption", { hasText: /^Out of date: bayer, changed · / }).waitFor();
  assert.equal(await page.locator("#pinned").textContent(), "Dimmed values are out of date.");
  assert.match(await page.locator("#warnings summary").textContent(), /^Out of date: /);
  assert.match(await page.locator("#trouble").textContent(), /The picture and the dimmed values are out of date\.$/);
  for (const name of ["CPSNR", "Noise", "Saturated"]) {
    assert.ok(await opacity(name) < 0.6, name);
    assert.match(await page.locator(".tile", { has: page.getByText(name, { exact: true }) }).innerText(), /out of date/);
  }
  assert.equal(await page.locator("#light-curve svg path").count(), 0, "no curves of another design");
  await page.keyboard.press("Control+z");
  await settled(page);
  for (const place of ["#caption", "#pinned", "#warnings summary"]) assert.doesNotMatch(await page.locator(place).textContent(), /out of date/i);
  assert.equal(await opacity("CPSNR"), 1);
  assert.equal(await page.locator("#message").getAttribute("data-kind"), null);
  for (const id of ["fill-factor", "read-noise", "full-well", "gain", "time"]) assert.ok(await page.locator(`#${id}`).isEditable(), id);
  // The field shows the value of the design again; a preset has a lens and pixels of its own.
  await page.getByLabel("Preset").focus();
  assert.equal(await page.getByLabel("Pixel pitch").inputValue(), "2.2");
  await openPreset(page, "phone");
  await settled(page);
  const phone = JSON.parse(own.run("show", "phone", "--json")).description;
  assert.equal(Number(await page.getByLabel("Pixel pitch").inputValue()), phone.sensor.pixel.pitch_um);
  assert.equal(Number(await stop.inputValue()), phone.optics.f_number);
  assert.deepEqual(faults, []);
  await close();
});

test("without kept light it shows a picture first and gathers the rest", async () => {
  const other = await own.serve("--no-cache");
  const { page, faults, close } = await open({}, other.address);
  await page.locator("#light-curve svg .own:not(.clips)").waitFor();
  assert.deepEqual(faults, []);
  await close();
  await other.end();
});
