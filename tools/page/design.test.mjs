// The page of a design in a real browser, as study.test.mjs for studies.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { axe, launch, work } from "./browser.mjs";

const smalti = resolve(process.env.SMALTI ?? join(import.meta.dirname, "../../target/debug/smalti"));
// Seconds of search: one mosaic, small patches, few wavelengths, noise that leaves two exposures to learn from.
const design = `name = '</script><script>alert(1)</script><img src=x onerror="alert(2)">'
camera = "bayer"
colors = [3]
luminances_cd_m2 = [5, 80]
rivals = false
[set]
"sensor.pixel.read_noise_mv" = 100
wavelengths_nm = [400, 50, 700]
[filters.pigments]
[mosaics]
given = [["bc", "ab"]]
[search]
starts = 3
steps = 10
[light]
side = 3
max_components = 4
step_px = 8
`;
let dir;
let browser;
let plain;
let proved;

before(async () => {
  dir = await mkdtemp(join(tmpdir(), "smalti-design-"));
  const run = (...args) => execFileSync(smalti, [...args, "--training-set", "catalog", "--quiet"], { cwd: dir, stdio: ["ignore", "ignore", "inherit"], env: { ...process.env, SMALTI_CACHE_DIR: join(dir, "cache") } });
  await writeFile(join(dir, "host.toml"), design);
  run("design", "host.toml", "--no-pipeline", "-o", "plain");
  const scenes = ["--proof-scene", "dead-leaves?rows=64&cols=64&largest=40", "--proof-scene", "macbeth?patch=8"];
  run("design", "host.toml", "--no-pipeline", "-o", "proved", "--prove", "--proof-patch", "3", "--patch", "3", "--seeds", "2", ...scenes);
  plain = join(dir, "plain/design.html");
  proved = join(dir, "proved/design.html");
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await rm(dir, { recursive: true, force: true });
});

const withPage = (options, doing, path = proved) => work(browser, path, options, (page) => page.locator(".drawing svg").first(), doing);
const sections = (page) => page.locator("main > section").evaluateAll((all) => all.map((s) => s.id));

test("hostile names are shown and do nothing", () => withPage({}, async (page) => {
  assert.match(await page.title(), /^<\/script><script>alert/);
  assert.equal(await page.locator("h1 img, h1 script, h3 img, td img").count(), 0);
}));

test("an unproved page states expectations and the command of the proof", () => withPage({}, async (page) => {
  assert.deepEqual(await sections(page), ["result", "arrays", "limits", "sensitivity", "search"]);
  assert.match(await page.locator("#result .headline").textContent(), /^Expected against the camera’s own array: [+−]\d/);
  assert.match(await page.locator("#result pre").textContent(), /^smalti design plain --prove$/);
  // The array that was found and the camera's own, each with a tile and with the curves that all filters share.
  assert.equal(await page.locator("#arrays .camera").count(), 2);
  for (const name of ["quantum efficiency", "lens and infrared cut"]) assert.equal(await page.locator("#arrays .camera").first().locator("svg text").getByText(name, { exact: true }).count(), 1, name);
}, plain));

test("a proved page has the statement, all rivals, pictures and other conditions", () => withPage({}, async (page) => {
  assert.deepEqual(await sections(page), ["result", "arrays", "proof", "pictures", "robustness", "limits", "sensitivity", "search"]);
  const results = JSON.parse(await readFile(join(dir, "proved/proof/results.json"), "utf8"));
  assert.match(await page.locator("#result .headline").textContent(), / (beats|does not beat) its one rival /);
  assert.deepEqual(await page.locator("#proof .verdict h3").allTextContents(), ["5 cd/m²", "80 cd/m²"]);
  await page.locator("#proof summary").click();
  const cells = await page.locator("#proof tbody tr").first().locator("td").allTextContents();
  const lead = results.proofs[0].rivals[0].leads[0][0];
  const [value, low, high] = [lead.by.value, lead.simultaneous.low, lead.simultaneous.high].map((v) => v.toFixed(2).replace("-", "−"));
  assert.ok(cells[0].startsWith(`${value} [${low}, ${high}]`), cells[0]);
  assert.equal(await page.locator("#robustness tbody tr").count(), results.robustness.rows.length);
  assert.equal(await page.locator("#pictures .telling").count(), 2);
  for (const width of await page.locator("#pictures .crop").evaluateAll((all) => all.map((i) => i.naturalWidth))) assert.ok(width > 8);
  assert.equal(await page.locator("#pictures a").getAttribute("href"), "proof/comparison/report.html");
}));

test("shares of the error fill their bars", () => withPage({}, async (page) => {
  const figures = page.locator("#limits .drawing svg");
  assert.equal(await figures.count(), 2);
  for (let i = 0; i < 2; i += 1) {
    const text = await figures.nth(i).locator("desc").textContent();
    const shares = [...text.matchAll(/all patches: \w+ (\d+) %/g)].map((m) => Number(m[1]));
    assert.equal(shares.length, 6, text);
    for (const light of [shares.slice(0, 3), shares.slice(3)]) assert.ok(Math.abs(light.reduce((a, b) => a + b) - 100) <= 1, text);
  }
}));

for (const colorScheme of ["light", "dark"]) {
  for (const width of [360, 1500, 3840]) {
    test(`the page is accessible and never wider than ${width} px in ${colorScheme}`, () => withPage({ colorScheme, viewport: { width, height: 900 } }, async (page) => {
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
      assert.deepEqual(await axe(page), []);
    }));
  }
}
