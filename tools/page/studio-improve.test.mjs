// The improvement in the studio: what it finds, keeps and discards, in a real browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { cells, curve, filterOf, lockCell, lockFilter, settled, studio, toml } from "./studio.mjs";

let own;
before(async () => { own = await studio(); });
after(() => own?.end());
const open = (...args) => own.open(...args);

// Begins an improvement and stops it once it is better: within the page, where it cannot end meanwhile.
const improveOnce = (page) => page.evaluate(() => new Promise((resolve) => {
  const [state, button] = [document.querySelector(".improve .progress"), document.querySelector("[data-improve]")];
  new MutationObserver((_, observer) => {
    if (!state.textContent.includes("Expected:") || button.textContent !== "Stop and keep") return;
    observer.disconnect();
    button.click();
    resolve();
  }).observe(state, { childList: true, subtree: true, characterData: true });
  button.click();
}));

test("a filter of pigments that the improvement found states them", async () => {
  const { page, faults, close } = await open();
  await page.getByLabel("Filters are").selectOption("pigments");
  await lockFilter(page, "B");
  await improveOnce(page);
  await page.locator(".improve .progress", { hasText: /kept\.|better\.$/ }).waitFor();
  await settled(page);
  await page.getByRole("radio", { name: "Filter R" }).click();
  const layers = page.locator("#filter .fields p");
  await page.waitForFunction(() => document.querySelector("#filter .fields p")?.textContent !== "");
  assert.match(await layers.textContent(), /^Pigments: (\d\.\d\d × pigment\/[RGBCMY]( \+ )?)+\. A thickness of 1 is that of the built-in filter\.$/);
  // Its curve is that of the layers: those of the pigments alone, each as thick as stated.
  const stated = [...(await layers.textContent()).matchAll(/([\d.]+) × (\S+?)(?=\.? )/g)].map(([, d, name]) => [Number(d), name]);
  const made = await curve(page, "R");
  const product = made.map(() => 0.95);
  for (const [thickness, name] of stated) {
    await page.getByLabel("Shape of filter R").selectOption("builtin");
    await page.locator("#filter .fields select").selectOption(name);
    await settled(page);
    const pigment = await curve(page, "R");
    const most = Math.max(...pigment.map(([, t]) => t));
    pigment.forEach(([, t], i) => { product[i] *= Math.max(t / most, Math.exp(-7)) ** thickness; });
  }
  // Half of the last digit of each thickness, times an absorbance of 7, and the 0.005 within which a curve counts as one of pigments.
  for (const [i, [nm, t]] of made.entries()) assert.ok(Math.abs(t - product[i]) < 0.02, `${nm} nm: ${t} and ${product[i]}`);
  // Another curve is of no pigments.
  await page.getByLabel("Shape of filter R").selectOption("box");
  await page.getByLabel("Shape of filter R").selectOption("samples");
  await settled(page);
  assert.equal(await layers.textContent(), "");
  assert.deepEqual(faults, []);
  await close();
});

test("an improvement goes on until it is stopped, keeps what is locked, and can be discarded", async () => {
  const { page, faults, close } = await open();
  const expected = async () => Number(((await page.locator(".improve .progress").textContent()).match(/Expected: ([+−][\d.]+) dB/)?.[1] ?? "0").replace("−", "-"));
  await page.getByLabel("Keep the mosaic").check();
  await improveOnce(page);
  await page.getByRole("button", { name: "Improve" }).waitFor();
  assert.ok(await expected() > 0, await page.locator(".improve .progress").textContent());
  assert.deepEqual(await cells(page), ["RG", "GB"]);
  await page.getByRole("button", { name: "Discard" }).click();
  assert.equal(await page.locator("#undo").getAttribute("aria-disabled"), "true", "the improvement is one step");
  assert.equal(await page.locator("#redo").getAttribute("aria-disabled"), "false");
  // A locked cell, and a locked filter, which stays in its cells, while the mosaic may change.
  await page.getByLabel("Keep the mosaic").uncheck();
  await lockCell(page, 2, 2);
  await lockFilter(page, "R");
  const before = await toml(page);
  const [red, green] = ["R", "G"].map((letter) => filterOf(before, letter));
  await improveOnce(page);
  await page.getByRole("button", { name: "Improve" }).waitFor();
  const [first, second] = await cells(page);
  assert.equal(`${first[0]}${second[1]}`, "RB");
  assert.equal(filterOf(await toml(page), "R"), red);
  assert.notEqual(filterOf(await toml(page), "G"), green);
  await settled(page);
  assert.deepEqual(faults, []);
  await close();
});
