// The pages of compare and evaluate in a real browser, as study.test.mjs for studies.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { axe, launch, open, work } from "./browser.mjs";

const smalti = resolve(process.env.SMALTI ?? join(import.meta.dirname, "../../target/debug/smalti"));
// Noise that leaves two exposures to learn from, few wavelengths.
const quick = ["--set", "sensor.pixel.read_noise_mv=100", "--set", "wavelengths_nm=[400,50,700]", "--seed", "3"];
let dir;
let browser;
let compared;
let evaluated;

before(async () => {
  dir = await mkdtemp(join(tmpdir(), "smalti-compare-"));
  const run = (...args) => execFileSync(smalti, [...args, "--no-cache", "--quiet"], { cwd: dir, stdio: ["ignore", "ignore", "inherit"] });
  await writeFile(join(dir, "host.toml"), "name = '</script><script>alert(1)</script><img src=x onerror=\"alert(2)\">'\n");
  const scene = "dead-leaves?rows=96&cols=128&largest=60";
  run("compare", "host.toml", "--processing", "l3,bilinear", "--patch", "3", "--luminance", "5,80", "--scene", scene, "--scene", "macbeth?patch=8", "-o", "out", ...quick);
  run("evaluate", "host.toml", "rgbw", "--luminance", "75", "-o", "scores", ...quick);
  compared = join(dir, "out/report.html");
  evaluated = join(dir, "scores/report.html");
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await rm(dir, { recursive: true, force: true });
});

const withPage = (options, doing, path = compared) => work(browser, path, options, (page) => page.locator(".stage img").first(), async (page) => {
  await page.locator("#viewer").evaluate((viewer) => viewer.scrollIntoView({ behavior: "instant" }));
  await doing(page);
});
const stage = (page) => page.getByRole("application");
const placed = (page) => page.locator(".stage img").evaluateAll((all) => all.map((i) => getComputedStyle(i).transform));
const sources = (page) => page.locator(".stage img").evaluateAll((all) => all.map((i) => i.src));
const lightOf = (page) => page.getByRole("slider", { name: "Luminance" });
async function setLight(page, place) {
  await lightOf(page).focus();
  await page.keyboard.press("Home");
  for (let i = 0; i < place; i += 1) await page.keyboard.press("ArrowRight");
}
const whole = "matrix(1, 0, 0, 1, 0, 0)";
// All are placed alike; this is how.
async function placeOf(page) {
  const all = await placed(page);
  assert.equal(new Set(all).size, 1, `${all}`);
  return all[0];
}

test("hostile names are shown and do nothing", () => withPage({}, async (page) => {
  assert.match(await page.title(), /^<\/script><script>alert/);
  assert.equal(await page.locator("h1 img, h1 script, figcaption img, option img").count(), 0);
  const policy = await page.locator("meta[http-equiv]").getAttribute("content");
  assert.match(policy, /^default-src 'none'; script-src 'sha256-[^ ]+'; style-src 'sha256-[^ ]+'; img-src data:;/);
}));

test("pictures are enlarged and moved together, by wheel, mouse, keys and buttons", () => withPage({}, async (page) => {
  assert.equal(await page.locator(".stage img").count(), 3);
  for (const size of await page.locator(".stage img").evaluateAll((all) => all.map((i) => [i.naturalWidth, i.complete]))) {
    assert.ok(size[0] > 30 && size[1]);
  }
  assert.equal(await placeOf(page), whole);
  const box = await page.locator(".frame").nth(1).boundingBox();
  // Events have whole pixels, and frames need not begin at one.
  const [x, y] = [Math.round(box.x + box.width * 0.25), Math.round(box.y + box.height * 0.5)];
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -700);
  await page.waitForFunction(() => document.querySelector(".stage").classList.contains("near"));
  const near = await placeOf(page);
  assert.equal(await page.locator(".stage img.crisp").count(), 3);
  // What is under the mouse stays there.
  const [scale, , , , shift] = near.match(/-?[\d.e+]+/g).map(Number);
  assert.ok(Math.abs((x - box.x - shift) / scale - (x - box.x)) < 0.5, near);

  await page.mouse.down();
  await page.mouse.move(x - 60, y, { steps: 3 });
  await page.mouse.up();
  const moved = await placeOf(page);
  assert.ok(Math.abs(Number(moved.match(/-?[\d.e+]+/g)[4]) - (shift - 60)) < 1, `${near} ${moved}`);

  await stage(page).focus();
  await page.keyboard.press("0");
  assert.equal(await placeOf(page), whole);
  await page.keyboard.press("+");
  const once = await placeOf(page);
  assert.notEqual(once, whole);
  await page.keyboard.press("ArrowRight");
  assert.notEqual(await placeOf(page), once);
  await page.keyboard.press("-");
  assert.equal(await placeOf(page), whole);
  await page.getByRole("button", { name: "Larger" }).click();
  assert.match(await page.locator(".zooms output").textContent(), /^2× around row \d+, column \d+$/);
  await page.getByRole("button", { name: "Whole picture" }).click();
  assert.equal(await placeOf(page), whole);
  // The whole cannot become smaller: the page scrolls.
  const top = await page.evaluate(() => scrollY);
  await page.mouse.wheel(0, 300);
  await page.waitForFunction((y) => scrollY > y + 100, top);
  assert.equal(await placeOf(page), whole);
}));

test("the page opens with the verdict, its figure and its differences", () => withPage({}, async (page) => {
  assert.equal(await page.locator("main section").first().getAttribute("id"), "verdict");
  const verdict = page.locator("#verdict");
  const results = JSON.parse(await readFile(join(dir, "out/results.json"), "utf8"));
  assert.match(await verdict.locator(".headline").textContent(), /^At 5(.* and 80)? cd\/m² /);
  assert.deepEqual(await verdict.locator(".verdict h3").allTextContents(), ["5 cd/m²", "80 cd/m²"]);
  for (const [i, light] of results.verdict.lights.entries()) {
    const words = await verdict.locator(".verdict").nth(i).locator("dd").first().textContent();
    const by = light.metrics[0].leads.find((_, k) => k !== light.metrics[0].best).by;
    const [value, low, high] = [by.value, by.interval.low, by.interval.high].map((v) => v.toFixed(2).replace("-", "−"));
    assert.ok(words.includes(`${value} dB [${low}, ${high}]`), words);
    // The difference from the first is that of the means of both, and lies in its interval.
    for (const [k, metric] of light.metrics.entries()) {
      const of = (contender) => results.results[2 * contender + i][metric.metric];
      const { value, interval } = metric.from_first[1];
      assert.ok(Math.abs(value - (of(1) - of(0))) < 1e-9 && interval.low <= value && value <= interval.high, `${k}: ${value}`);
      assert.deepEqual(metric.from_first[0], { value: 0, interval: null });
    }
  }
  // Names stand at the lines, and every difference has a bar: a white one below a coloured one, with two caps each.
  const figure = verdict.locator(".drawing > svg").first();
  assert.match(await figure.getAttribute("role"), /img/);
  for (const name of results.contenders) assert.ok((await figure.locator("text").allTextContents()).some((t) => t.length > 3 && name.startsWith(t.replace("…", ""))), name);
  assert.equal(await figure.locator("g line").count(), 2 * 6);
  await verdict.locator("summary").click();
  assert.equal(await verdict.locator("details tbody tr").count(), 2);
}));

test("each scene has the crop in which the cameras differ most", () => withPage({}, async (page) => {
  const crops = page.locator(".telling");
  assert.equal(await crops.count(), 2);
  for (let scene = 0; scene < 2; scene += 1) {
    const crop = crops.nth(scene);
    assert.equal(await crop.locator("img.crop").count(), 3);
    assert.equal(await crop.locator("img.overview").count(), 1);
    const [top, bottom, left, right] = (await crop.locator(".where .help").textContent())
      .match(/^Rows (\d+) to (\d+), columns (\d+) to (\d+) of \d+ × \d+ pixels, counted from 0\.$/).slice(1).map(Number);
    const [wide, high] = await crop.locator("img.crop").first().evaluate((i) => [i.naturalWidth, i.naturalHeight]);
    assert.deepEqual([wide, high], [right - left + 1, bottom - top + 1]);
    // By the maps in the page, JPEG of 256 steps, no other window of either light differs more.
    const means = await page.locator(".gallery .shots").evaluateAll((all, [name, wide, high]) => all.filter((g) => g.dataset.scene === name).map((group) => {
      const scale = JSON.parse(group.dataset.tops)[1] / 255;
      const maps = Array.from(group.querySelectorAll('img.map[data-map="1"]'), (map) => {
        const context = Object.assign(document.createElement("canvas"), { width: map.naturalWidth, height: map.naturalHeight }).getContext("2d");
        context.drawImage(map, 0, 0);
        return context.getImageData(0, 0, map.naturalWidth, map.naturalHeight);
      });
      const { width, height } = maps[0];
      const value = (i) => scale * Math.abs(maps[0].data[4 * i] - maps[1].data[4 * i]);
      const found = {};
      for (let row = 0; row + high <= height; row += 1) {
        for (let col = 0; col + wide <= width; col += 1) {
          let sum = 0;
          for (let r = 0; r < high; r += 4) for (let c = 0; c < wide; c += 4) sum += value((row + r) * width + col + c);
          found[`${row},${col}`] = sum / (Math.ceil(high / 4) * Math.ceil(wide / 4));
        }
      }
      return { light: group.dataset.light, found };
    }), [await crop.getAttribute("data-scene"), wide, high]);
    const light = await crop.getAttribute("data-light");
    const mine = means.find((m) => m.light === light).found[`${top},${left}`];
    const best = Math.max(...means.flatMap((m) => Object.values(m.found)));
    assert.ok(mine > 0.93 * best, `${mine} of ${best}`);
  }
  // A button shows it in the viewer.
  await page.getByRole("button", { name: "Show in the viewer (macbeth)" }).click();
  assert.equal(await page.getByRole("combobox", { name: "Scene" }).evaluate((s) => s.selectedOptions[0].text), "macbeth");
  assert.equal(await lightOf(page).getAttribute("aria-valuetext"), `${await crops.nth(1).getAttribute("data-light")} cd/m²`);
}));

test("a slider changes the light of all pictures, by keys and for screen readers", () => withPage({}, async (page) => {
  const slider = lightOf(page);
  const lights = () => page.locator(".stage img").evaluateAll((all) => all.map((i) => i.alt.match(/at ([\d.]+) cd/)[1]));
  await slider.focus();
  await page.keyboard.press("Home");
  assert.deepEqual([await slider.getAttribute("aria-valuetext"), await lights()], ["5 cd/m²", ["5", "5", "5"]]);
  await page.keyboard.press("ArrowRight");
  assert.deepEqual([await slider.getAttribute("aria-valuetext"), await lights()], ["80 cd/m²", ["80", "80", "80"]]);
  assert.equal(await page.locator(".light output").textContent(), "80 cd/m²");
  assert.deepEqual(await page.locator(".light-names span").allTextContents(), ["5", "80"]);
  // What was enlarged stays so.
  await stage(page).focus();
  await page.keyboard.press("+");
  const near = await placeOf(page);
  await slider.focus();
  await page.keyboard.press("ArrowLeft");
  assert.equal(await placeOf(page), near);
  assert.deepEqual(await lights(), ["5", "5", "5"]);
}));

for (const [width, scrolls] of [[360, true], [1280, false], [3840, false]]) {
  test(`candidates stay beside the reference at ${width} pixels`, () => withPage({ viewport: { width, height: 900 } }, async (page) => {
    const lefts = () => page.locator(".stage figure").evaluateAll((all) => all.map((f) => Math.round(f.getBoundingClientRect().left)));
    const before = await lefts();
    const top = await page.locator(".stage figure").evaluateAll((all) => new Set(all.map((f) => Math.round(f.getBoundingClientRect().top))).size);
    assert.equal(top, 1, "all in one row");
    const next = page.getByRole("button", { name: "Next camera" });
    assert.equal(await next.isVisible(), scrolls);
    if (!scrolls) return;
    const ends = async () => (await page.locator(".stage figure").last().boundingBox()).x + (await page.locator(".stage figure").last().boundingBox()).width;
    assert.ok(await ends() > width);
    await stage(page).focus();
    await page.keyboard.press("Shift+ArrowRight");
    await page.waitForFunction(() => document.querySelector(".stage").scrollLeft > 0);
    await page.keyboard.press("Shift+ArrowRight");
    await page.waitForFunction(() => document.querySelector("[aria-label='Next camera']").disabled);
    const after = await lefts();
    assert.equal(after[0], before[0], "the reference stays");
    assert.ok(after[2] < before[2] && await ends() <= width, `${before} ${after}`);
    // Another light keeps the place.
    await setLight(page, 1);
    assert.deepEqual(await lefts(), after);
  }));
}

test("the ColorChecker shows reference and rendering, and where they lie in a*b*", () => withPage({}, async (page) => {
  const results = JSON.parse(await readFile(join(dir, "scores/results.json"), "utf8"));
  const svgs = page.locator("#colours .drawing > svg");
  assert.equal(await svgs.count(), 4, "two cameras, two drawings each");
  for (const [i, camera] of results.cameras.entries()) {
    const patches = await svgs.nth(i).locator("g > title").allTextContents();
    assert.deepEqual(patches.map((t) => t.match(/: ([\d.]+)$/)[1]), camera.delta_e_2000.per_patch.map((d) => d.toFixed(1)));
    assert.match(patches[0], /^1 dark skin/);
    // White: CIELAB is that of the display's white, above; the difference from it below.
    const white = await svgs.nth(i).locator("g").nth(18).locator("rect").first().getAttribute("fill");
    assert.equal(white, "#ffffff");
    const { reference_lab: reference, rendered_lab: rendered } = camera.patch_colors;
    // Arrows begin and end at the places of CIELAB, in the same scale along both axes.
    const arrows = await svgs.nth(2 + i).locator("path[stroke='#262626']").evaluateAll((all) => all.map((p) => p.getAttribute("d").match(/-?[\d.]+/g).map(Number)));
    assert.equal(arrows.length, 24);
    const slope = (px, lab) => {
      const [a, b] = [15, 12];
      return (px(arrows[a]) - px(arrows[b])) / (lab(a) - lab(b));
    };
    const [across, up] = [slope((p) => p[0], (k) => reference[k][1]), slope((p) => p[1], (k) => reference[k][2])];
    assert.ok(Math.abs(across / -up - 1) < 0.03, `${across} ${up}`);
    for (const [k, [x0, y0, x1, y1]] of arrows.entries()) {
      assert.ok(Math.abs(x1 - x0 - across * (rendered[k][1] - reference[k][1])) < 0.1, `patch ${k}`);
      assert.ok(Math.abs(y1 - y0 - up * (rendered[k][2] - reference[k][2])) < 0.1, `patch ${k}`);
    }
  }
}, evaluated));

test("the slider between two pictures moves by keyboard and mouse", () => withPage({}, async (page) => {
  await page.getByLabel("View").selectOption("Before and after");
  assert.equal(await page.locator(".stage img").count(), 2);
  const slider = page.getByRole("slider", { name: /left picture/ });
  const cut = () => page.locator(".over").evaluate((e) => e.style.clipPath);
  assert.match(await cut(), /50%/);
  await slider.focus();
  for (let i = 0; i < 10; i += 1) await page.keyboard.press("ArrowRight");
  assert.match(await cut(), /60%/);
  await page.keyboard.press("Home");
  assert.match(await cut(), /inset\(0(px)? 0(px)? 0(px)? 0%\)/);
  const box = await page.locator(".frame").boundingBox();
  await page.mouse.move(box.x + box.width * 0.1, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.7, box.y + box.height / 2, { steps: 3 });
  await page.mouse.up();
  assert.match(await cut(), /70%/);
  const [left, right] = await sources(page);
  await page.getByRole("combobox", { name: "Left" }).selectOption("reference");
  const [other, same] = await sources(page);
  assert.ok(other !== left && same === right);
  await stage(page).focus();
  await page.keyboard.press("+");
  assert.notEqual(await placeOf(page), whole);
}));

test("choosers switch scene, light and maps", () => withPage({}, async (page) => {
  const seen = new Set([(await sources(page)).join()]);
  const next = async (label, option) => {
    await page.getByRole("combobox", { name: label, exact: true }).selectOption({ index: option });
    const now = (await sources(page)).join();
    assert.ok(!seen.has(now), `${label} shows what was there`);
    seen.add(now);
  };
  await setLight(page, 1);
  assert.ok(!seen.has((await sources(page)).join()));
  seen.add((await sources(page)).join());
  await next("Scene", 1);
  for (const [option, name, unit] of [[1, "ΔE2000 difference", "ΔE00"], [2, "S-CIELAB difference", "ΔE*ab"]]) {
    await next("Show", option);
    const { top } = await topOf(page, 1, 1, option - 1);
    assert.equal(await page.locator(".legend").textContent(), `0${top} ${unit} and more`);
    assert.equal(await page.locator(`.stage img[alt^='${name}']`).count(), 2);
    assert.ok((await page.locator(".about-map").textContent()).length > 20);
    // Without a map, the reference is shown, and that is said.
    assert.match(await page.locator(".stage figcaption").first().textContent(), new RegExp(`no ${name}: the picture`));
  }
  await setLight(page, 0);
  await page.getByRole("combobox", { name: "Show" }).selectOption("Pictures");
  assert.equal(await page.locator(".legend").textContent() + await page.locator(".about-map").textContent(), "");
}));

// The end of the scale of a kind of map, and the mean of each map of it as far as the scale goes.
function topOf(page, scene, light, kind) {
  return page.locator(".gallery .shots").nth(2 * scene + light).evaluate((group, i) => {
    const top = JSON.parse(group.dataset.tops)[i];
    const means = Array.from(group.querySelectorAll(`img.map[data-map="${i}"]`), (map) => {
      const context = Object.assign(document.createElement("canvas"), { width: map.naturalWidth, height: map.naturalHeight }).getContext("2d");
      context.drawImage(map, 0, 0);
      const { data } = context.getImageData(0, 0, map.naturalWidth, map.naturalHeight);
      return (top * data.filter((_, k) => k % 4 === 0).reduce((sum, v) => sum + v, 0)) / 255 / (data.length / 4);
    });
    return { top, means };
  }, kind);
}
// What the values under the pointer say: row, column, and for each kind of map one of each camera.
async function told(page) {
  const lines = await page.locator(".values p").allTextContents();
  if (lines.length === 0) return null;
  const [, row, col] = lines[0].match(/^Row (\d+), column (\d+) \(counted from 0\)$/);
  const kinds = lines.slice(1).map((l) => {
    const [, name, all] = l.match(/^(.+), about: (.+)$/);
    return { name, values: all.split(" · ").map((v) => Number(v.match(/([\d.]+)( or more)?$/)[1])) };
  });
  return { row: Number(row), col: Number(col), kinds };
}

test("maps have the means that the scores tell", () => withPage({}, async (page) => {
  const figures = await page.locator(".shots").first().locator("figcaption").allTextContents();
  const scores = figures.slice(1).map((t) => t.match(/ΔE2000 ([\d.]+), S-CIELAB ([\d.]+)$/).slice(1).map(Number));
  assert.equal(scores.length, 2);
  for (const kind of [0, 1]) {
    const { means } = await topOf(page, 0, 0, kind);
    // One value in twenty may be beyond the scale.
    means.forEach((mean, i) => assert.ok(mean < 1.03 * scores[i][kind] + 0.02 && mean > 0.8 * scores[i][kind], `${means} ${scores}`));
  }
}));

test("both maps' values stand under the pointer, those of the colours shown", () => withPage({}, async (page) => {
  const box = await page.locator(".frame").last().boundingBox();
  const at = [box.x + box.width * 0.3, box.y + box.height * 0.4];
  const seen = [];
  for (const [option, name] of [[1, "ΔE2000 difference (ΔE00)"], [2, "S-CIELAB difference (ΔE*ab)"]]) {
    await page.mouse.move(1, 1);
    await page.getByLabel("Show").selectOption({ index: option });
    await page.mouse.move(...at);
    const found = await told(page);
    assert.deepEqual(found.kinds.map((k) => k.name), ["ΔE2000 difference (ΔE00)", "S-CIELAB difference (ΔE*ab)"]);
    assert.ok((await page.locator(".values .chosen").textContent()).startsWith(name));
    const size = await page.locator(".gallery img.shot").first().evaluate((i) => [i.naturalWidth, i.naturalHeight]);
    assert.ok(Math.abs(found.col - 0.3 * size[0]) <= 2 && Math.abs(found.row - 0.4 * size[1]) <= 2, `${found.row} ${found.col} of ${size}`);
    const { top } = await topOf(page, 0, 0, option - 1);
    // Judged by where the colour that is seen lies along the seven colours of the legend.
    const expected = await page.evaluate(([col, row]) => {
      const stops = ["440154", "433d84", "2e6d8e", "23898e", "46c06f", "89d548", "fde725"].map((c) => [0, 2, 4].map((i) => parseInt(c.slice(i, i + 2), 16)));
      return Array.from(document.querySelectorAll(".stage img[src^='data:image/png']"), (map) => {
        const context = Object.assign(document.createElement("canvas"), { width: map.naturalWidth, height: map.naturalHeight }).getContext("2d");
        context.drawImage(map, 0, 0);
        const pixel = context.getImageData(col, row, 1, 1).data;
        let best = { far: Infinity };
        for (let i = 0; i <= 600; i += 1) {
          const [k, t] = [Math.min(5, Math.floor(i / 100)), i / 100 - Math.min(5, Math.floor(i / 100))];
          const far = stops[k].reduce((sum, v, c) => sum + (v + (stops[k + 1][c] - v) * t - pixel[c]) ** 2, 0);
          if (far < best.far) best = { far, share: i / 600 };
        }
        return best.share;
      });
    }, [found.col, found.row]);
    assert.equal(expected.length, 2);
    found.kinds[option - 1].values.forEach((value, i) => {
      assert.ok(Math.abs(value / top - expected[i]) < 0.06, `${value} of ${top}, the map's colour says ${expected[i] * top}`);
    });
    seen.push(found);
  }
  assert.deepEqual(seen[0], seen[1], "what is told does not depend on what is shown");
  await page.mouse.move(box.x + box.width * 0.7, box.y + box.height * 0.6);
  assert.notDeepEqual((await told(page)).kinds, seen[0].kinds);
  await page.mouse.move(1, 1);
  assert.equal(await told(page), null);
  await stage(page).focus();
  await page.keyboard.press("+");
  assert.equal((await told(page)).kinds.length, 2);
}));

// As where the page had no room for it, or an earlier version made none.
test("a map that is missing is said to be, and the other is there", async () => {
  const path = join(dir, "out/without.html");
  const html = await readFile(compared, "utf8");
  const without = html.replace(/<img [^>]*data-map="0">/g, "");
  assert.ok(without.length < html.length);
  await writeFile(path, without);
  await work(browser, path, {}, (page) => page.locator(".stage img").first(), async (page) => {
    await page.getByLabel("Show").selectOption("ΔE2000 difference");
    assert.match(await page.locator(".stage figcaption").last().textContent(), /no ΔE2000 difference: the picture/);
    assert.equal(await page.locator(".legend").textContent(), "");
    await page.locator(".frame").last().hover();
    assert.deepEqual((await told(page)).kinds.map((k) => k.name), ["S-CIELAB difference (ΔE*ab)"]);
  });
});

test("maps that are pictures have no values", () => withPage({}, async (page) => {
  await page.getByLabel("Scene").selectOption("zone plate");
  await page.getByLabel("Show").selectOption("Aliasing");
  assert.equal(await page.locator(".stage img[alt^='Aliasing']").count(), 2);
  await page.locator(".frame").last().hover();
  assert.equal(await page.locator(".values").count(), 0);
  assert.match(await page.locator(".about-map").textContent(), /Grey means no difference/);
}, evaluated));

test("classes and kernels follow position, texture and level", () => withPage({}, async (page) => {
  const box = page.locator(".kernels").first();
  const about = box.locator(".about-class");
  const before = await about.textContent();
  assert.match(before, /^[\d,]+ patches in training\. Kernels: (learned|fallback: .+)\.$/);
  assert.equal(await box.locator(".drawings svg").count(), 3);
  const label = () => box.locator(".drawings svg").first().getAttribute("aria-label");
  const kernel = await label();
  await box.getByRole("slider").focus();
  await page.keyboard.press("ArrowLeft");
  assert.notEqual(await about.textContent(), before);
  assert.notEqual(await label(), kernel);
  await box.getByLabel("Position").selectOption({ index: 2 });
  assert.match(await box.locator(".counts caption").textContent(), /row 1, column 0: G$/);
  // Fallbacks are there, and marked by a letter.
  const borrowed = box.locator("td.borrowed").first();
  assert.match(await borrowed.textContent(), /[ITSNL]$/);
  await borrowed.click();
  assert.match(await about.textContent(), /fallback: /);
  assert.equal(await box.locator("td.here").count(), 1);
  await box.locator("summary").click();
  assert.equal(await box.locator("details tbody tr").count(), 10, "nine weights and an offset");
  // Where channels clip there are other kernels.
  const clipped = box.getByLabel("Clipped channels");
  assert.equal(await clipped.locator("option").first().textContent(), "none");
  const unclipped = await label();
  await clipped.selectOption({ index: 1 });
  assert.notEqual(await label(), unclipped);
  assert.match(await box.locator(".counts .help").textContent(), /levels with training data/);
  assert.match(await about.textContent(), /patches in training/);
}));

test("the best are marked by more than colour, and tables sort", () => withPage({}, async (page) => {
  const table = page.locator("#scores table").first();
  assert.ok((await table.locator(".best").allTextContents()).every((t) => / ?★ best$/.test(t)));
  await table.getByRole("button", { name: "CPSNR, dB" }).click();
  const cells = (await table.locator("tbody td:nth-child(4)").allTextContents()).map(parseFloat);
  assert.deepEqual(cells, [...cells].sort((a, b) => a - b));
}));

for (const [name, path] of [["compare", () => compared], ["evaluate", () => evaluated]]) {
  test(`nothing of ${name} is left unsaid`, () => withPage({}, async (page) => {
    assert.doesNotMatch(await page.locator("body").innerText(), /\b(null|undefined|NaN)\b/);
  }, path()));

  for (const colorScheme of ["light", "dark"]) {
    test(`${name}: axe finds no serious fault, ${colorScheme}`, () => withPage({ colorScheme }, async (page) => {
      assert.deepEqual(await axe(page), []);
      await page.getByLabel("Show").selectOption({ index: 1 });
      await page.locator(".frame").last().hover();
      assert.deepEqual(await axe(page), []);
      await page.getByLabel("View").selectOption("Before and after");
      for (const details of await page.locator("details").all()) await details.evaluate((d) => { d.open = true; });
      assert.deepEqual(await axe(page), []);
    }, path()));
  }
  test(`${name}: a phone needs no horizontal scrolling`, () => withPage({ viewport: { width: 390, height: 844 }, hasTouch: true }, async (page) => {
    await page.getByLabel("Show").selectOption({ index: 1 });
    await page.locator(".frame").last().hover();
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    const wide = await page.evaluate(() => [...document.querySelectorAll("main *")]
      .filter((e) => e.getBoundingClientRect().right > 391 && !e.closest(".scrolls, .stage, .across, pre, svg, .hidden-text"))
      .map((e) => e.outerHTML.slice(0, 120)));
    assert.deepEqual(wide, []);
  }, path()));
}

test("without scripts, and on paper, all pictures stand", async () => {
  const { page, close } = await open(browser, compared, { javaScriptEnabled: false });
  assert.equal(await page.locator(".gallery img.shot:visible").count(), 12);
  assert.equal(await page.locator("#scores table:visible").count(), 2);
  await close();
  await withPage({}, async (printed) => {
    assert.equal(await printed.locator(".gallery img.shot:visible").count(), 0);
    await printed.emulateMedia({ media: "print" });
    assert.equal(await printed.locator(".gallery img.shot:visible").count(), 12);
    assert.equal(await printed.locator(".stage:visible").count(), 0);
  });
});
