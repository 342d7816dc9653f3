// The engine of the studio in a browser: what it answers, how fast, and what it refuses.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createServer } from "node:http";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { launch } from "./browser.mjs";
import { stated, text, within } from "./studio.mjs";

const here = import.meta.dirname;
const pages = join(here, "../../crates/smalti-serve/pages/studio");
const module = process.env.SMALTI_STUDIO_MODULE ?? join(here, "../../crates/smalti-serve/vendor/studio.wasm.deflate");
const maker = resolve(process.env.SMALTI_STUDIO_ASSETS ?? join(here, "../../target/debug/examples/studio_assets"));
const TYPES = { ".js": "text/javascript", ".html": "text/html", ".json": "application/json" };
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'";

let dir;
let server;
let browser;
let page;
const faults = [];

before(async () => {
  dir = await mkdtemp(join(tmpdir(), "smalti-engine-"));
  execFileSync(maker, [dir], { encoding: "utf8" });
  const file = (url) => {
    const name = basename(new URL(url, "http://a").pathname);
    if (name === "studio.wasm.deflate") return module;
    return join([".js"].includes(extname(name)) ? pages : dir, name);
  };
  server = createServer(async (request, response) => {
    try {
      const name = request.url === "/" ? null : file(request.url);
      const body = name ? await readFile(name) : "<!doctype html><title>engine</title>";
      const type = TYPES[name ? extname(name) : ".html"] ?? "application/octet-stream";
      response.writeHead(200, { "content-type": type, "content-security-policy": POLICY }).end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => { server.listen(0, "127.0.0.1", done); });
  browser = await launch();
  page = await browser.newPage();
  page.on("pageerror", (e) => faults.push(String(e)));
  page.on("console", (m) => { if (m.type() === "error") faults.push(m.text()); });
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
});
after(async () => {
  await browser?.close();
  server?.close();
  await rm(dir, { recursive: true, force: true });
});

// Begins with a loaded engine `engine`, its camera `camera`, and `blue`: the camera with another blue filter.
const begun = () => page.evaluate(async () => {
  const start = performance.now();
  const { Engine } = await import("/engine.js");
  const engine = await Engine.start("/assets/");
  const [{ camera }] = engine.setups;
  const picture = await engine.draw({ design: camera, scene: engine.scenes[0].id, luminance: 10, crop: { row: 0, col: 0, rows: 192, cols: 256 } });
  window.engine = engine;
  window.camera = camera;
  window.with_filter = (letter, filter) => ({
    ...camera,
    sensor: { ...camera.sensor, cfa: { pattern: ["GR", "BG"], filters: { R: { builtin: "pigment/R" }, G: { builtin: "pigment/G" }, B: { builtin: "pigment/B" }, [letter]: filter } } },
  });
  return { ms: performance.now() - start, scenes: engine.scenes, width: picture.width, height: picture.height, bytes: picture.rgba.length };
});

test("the first picture is there within two seconds", async () => {
  const first = await begun();
  console.log(`# from the import of the engine to the first picture: ${first.ms.toFixed(0)} ms`);
  assert.ok(first.scenes.length >= 4, JSON.stringify(first.scenes));
  assert.deepEqual(new Set(first.scenes.map((s) => s.set)), new Set(["charts", "natural"]));
  assert.equal(first.bytes, 4 * first.width * first.height);
  assert.ok(first.ms <= 2000, `${first.ms}`);
});

test("a changed filter gives a new learned picture of 256 × 256 pixels in a twentieth of a second", async () => {
  // The page draws the whole scene, 288 × 384 pixels, which takes longer.
  const times = await page.evaluate(async () => {
    const all = [];
    const [scene] = engine.scenes;
    for (let i = 0; i < 125; i += 1) {
      const design = with_filter("R", { gaussian: { center_nm: 560 + i, sigma_nm: 35, peak: 0.9 } });
      const start = performance.now();
      const picture = await engine.draw({ design, scene: scene.id, luminance: 10, crop: { row: 0, col: 16, rows: 256, cols: 256 } });
      all.push([performance.now() - start, picture.timings_ms.learn, picture.timings_ms.draw]);
    }
    // The first one learns the mosaic and gathers the light.
    return all.slice(5);
  });
  const found = stated(times.map(([ms]) => ms));
  const part = (i) => stated(times.map((t) => t[i])).median.toFixed(1);
  console.log(`# picture after a change of a filter: ${text(found)}; learning ${part(1)} ms, capture and rendering ${part(2)} ms`);
  assert.ok(within(found, 50), text(found));
});

test("the whole view takes half a second, whatever changes", async () => {
  const changes = {
    filter: `(i) => [with_filter("G", { gaussian: { center_nm: 520 + i, sigma_nm: 35, peak: 0.9 } }), 10]`,
    luminance: `(i) => [with_filter("G", { builtin: "pigment/G" }), 3 * 1.1 ** i]`,
    "read noise": `(i) => { const d = structuredClone(with_filter("G", { builtin: "pigment/G" })); d.sensor.pixel.read_noise_mv = 0.5 + i / 20; return [d, 10]; }`,
    cell: `(i) => { const d = structuredClone(with_filter("G", { builtin: "pigment/G" })); const n = i + 21; d.sensor.cfa.pattern = Array.from({ length: 4 }, (_, r) => Array.from({ length: 4 }, (_, c) => "RGBG"[(r * r * n + c * (n >> 1) + ((n >> (r + c)) & 1)) % 4]).join("")).map((line, r) => ["R", "G", "B", "G"][r] + line.slice(1)); return [d, 10]; }`,
    "the size of the tile": `(i) => { const d = structuredClone(with_filter("G", { builtin: "pigment/G" })); const [rows, cols] = [2 + i % 5, 2 + ((i / 5) | 0)]; d.sensor.cfa.pattern = Array.from({ length: rows }, (_, r) => Array.from({ length: cols }, (_, c) => "RGBG"[(2 * r + c) % 4]).join("")); return [d, 10]; }`,
  };
  const failed = [];
  for (const [what, change] of Object.entries(changes)) {
    const times = await page.evaluate(`(async () => {
      const change = ${change};
      const all = [];
      const scene = engine.scenes[0];
      for (let i = 0; i < 20; i += 1) {
        const [design, luminance] = change(i);
        const start = performance.now();
        const [picture] = await Promise.all([
          engine.draw({ design, scene: scene.id, luminance, measure: true }),
          engine.scores(design, luminance),
          engine.curves(design),
        ]);
        all.push([performance.now() - start, picture.timings_ms.learn, picture.timings_ms.draw, picture.timings_ms.score]);
      }
      return all.slice(2);
    })()`);
    const found = stated(times.map(([ms]) => ms));
    const part = (i) => stated(times.map((t) => t[i])).median.toFixed(0);
    console.log(`# whole view after a change of ${what}: ${text(found)}; learning ${part(1)}, drawing ${part(2)}, scores of the picture ${part(3)} ms`);
    if (!within(found, 500)) failed.push(`${what}: ${text(found)}`);
  }
  assert.deepEqual(failed, []);
});

test("the light behind another lens is gathered once, and designs of both lenses are drawn in turn", async () => {
  const found = await page.evaluate(async () => {
    const scene = engine.scenes[0].id;
    const other = structuredClone(with_filter("G", { builtin: "pigment/G" }));
    other.optics.f_number = 2.8;
    other.sensor.pixel.pitch_um = 1.4;
    const waits = !engine.hasLight(other, ["training", { scene }]);
    const start = performance.now();
    await engine.light(other, ["training", { scene }]);
    const gathered = performance.now() - start;
    const draw = async (design) => [...(await engine.draw({ design, scene, luminance: 10 })).rgba];
    const [a, b, c] = [await draw(camera), await draw(other), await draw(camera)];
    const same = (x, y) => x.length === y.length && x.every((v, i) => v === y[i]);
    const again = engine.hasLight(other, ["training", { scene }]);
    const array = await engine.scores(other, []);
    const expected = await engine.scores(other, [10]);
    return { waits, gathered, same: same(a, c), differs: !same(a, b), again, array: array.expected.length, expected: expected.expected[0].cpsnr_db };
  });
  console.log(`# light behind another lens: ${found.gathered.toFixed(0)} ms to the first picture`);
  assert.ok(found.waits && found.same && found.differs && found.again, JSON.stringify(found));
  assert.equal(found.array, 0);
  assert.ok(found.expected > 10, String(found.expected));
});

test("pictures have the bytes of the native library, and scores its numbers", async () => {
  const luminance = 4;
  const [scene, designs] = await page.evaluate(() => {
    const other = structuredClone(with_filter("G", { gaussian: { center_nm: 545, sigma_nm: 30, peak: 0.9 } }));
    other.sensor.cfa.pattern = ["GRGB", "BGRG", "RGBG", "GBGR"];
    return [engine.scenes[1].id, [camera, other]];
  });
  const requests = designs.flatMap((design) => [
    { draw: { design, scene, luminance_cd_m2: luminance, seed: 7, thorough: true } },
    { measure: { design, scene, luminance_cd_m2: luminance, seed: 7, thorough: true } },
    { scores: { design, luminances_cd_m2: [luminance, 80] } },
  ]);
  const out = await mkdtemp(join(dir, "native-"));
  await writeFile(join(out, "requests.json"), JSON.stringify(requests));
  execFileSync(join(dirname(maker), "studio_answers"), [dir, join(out, "requests.json"), out]);
  const answers = await Promise.all(requests.map(async (_, i) => {
    const bytes = await readFile(join(out, String(i)));
    const length = bytes.readUInt32LE(0);
    return { said: JSON.parse(bytes.subarray(4, 4 + length)), bytes: bytes.subarray(4 + length) };
  }));
  // The largest difference between two numbers at the same place, relative to the larger of both and 1.
  const apart = (a, b, at = "") => {
    if (typeof a === "number" && typeof b === "number") return Math.abs(a - b) / Math.max(1, Math.abs(a), Math.abs(b));
    if (typeof a !== "object" || a === null) { assert.equal(a, b, at); return 0; }
    assert.deepEqual(Object.keys(a).sort(), Object.keys(b).sort(), at);
    return Math.max(0, ...Object.keys(a).map((key) => apart(a[key], b[key], `${at}.${key}`)));
  };
  let most = 0;
  for (const [i, design] of designs.entries()) {
    const found = await page.evaluate(async ({ design, scene, luminance }) => {
      const picture = await engine.draw({ design, scene, luminance, measure: true, seed: 7 });
      const scores = await engine.scores(design, [luminance, 80]);
      return { rgba: [...picture.rgba], scores: picture.scores, difference: [...picture.difference], figures: scores };
    }, { design, scene, luminance });
    const [draw, measure, scores] = answers.slice(3 * i, 3 * i + 3);
    assert.equal(Buffer.compare(Buffer.from(found.rgba), draw.bytes), 0, "the same bytes");
    most = Math.max(most, apart(found.scores, measure.said), apart(found.figures, scores.said));
    const native = new Float32Array(measure.bytes.buffer.slice(measure.bytes.byteOffset, measure.bytes.byteOffset + measure.bytes.length));
    assert.equal(native.length, found.difference.length);
    most = native.reduce((sum, v, k) => Math.max(sum, Math.abs(v - found.difference[k])), most);
  }
  console.log(`# largest difference of a score from the native library: ${most.toExponential(1)}`);
  assert.ok(most <= 1e-6, String(most));
});

test("of many calls the latest counts", async () => {
  const found = await page.evaluate(async () => {
    const draw = (i) => engine.draw({ design: with_filter("R", { gaussian: { center_nm: 600 + i, sigma_nm: 30 } }), scene: engine.scenes[0].id, luminance: 10 });
    const all = await Promise.all(Array.from({ length: 30 }, (_, i) => draw(i)));
    // Figures for another part of the page do not take the place of those that are shown.
    const figures = await Promise.all([engine.scores(camera, [10]), engine.scores(camera, [10], { asker: "other" }), engine.scores(camera, [20]), engine.scores(camera, [30], { asker: "other" })]);
    return [all, figures].map((results) => results.map((result) => result !== null));
  });
  const [pictures, figures] = found;
  assert.equal(pictures.at(-1), true);
  assert.ok(pictures.filter(Boolean).length <= 2, JSON.stringify(pictures));
  // The first one is at work when the others come.
  assert.deepEqual(figures, [true, false, true, true]);
});

test("figures, curves and an improvement", async () => {
  const found = await page.evaluate(async () => {
    const scores = await engine.scores(camera, [1, 10, 80]);
    const curves = await engine.curves(camera);
    const design = with_filter("R", { gaussian: { center_nm: 560, sigma_nm: 35, peak: 0.9 } });
    const steps = [];
    const abort = new AbortController();
    const last = await engine.improve(design, { filters: ["B"], mosaic: true }, [10], (step) => { steps.push(step.cost); if (steps.length === 6) abort.abort(); }, abort.signal);
    const toml = await engine.cameraToml(last.design);
    const again = await engine.parse(toml);
    return { scores, curves, steps, last, toml, same: JSON.stringify(again.sensor.cfa) === JSON.stringify(last.design.sensor.cfa) };
  });
  const { scores, curves, steps, last } = found;
  assert.equal(scores.expected.length, 3);
  assert.ok(scores.expected[0].cpsnr_db < scores.expected[2].cpsnr_db);
  assert.ok(scores.array.vora_value > 0.5 && scores.array.photon_efficiency > 0.1, JSON.stringify(scores.array));
  assert.equal(curves.wavelengths_nm.length, 31);
  assert.match(curves.channels[0].color, /^#[0-9a-f]{6}$/);
  assert.equal(steps.length, 6);
  assert.ok(steps.every((cost, i) => i === 0 || cost <= steps[i - 1]) && steps.at(-1) < last.own_cost, JSON.stringify(steps));
  assert.deepEqual(last.design.sensor.cfa.filters.B, { builtin: "pigment/B" });
  assert.match(found.toml, /\[sensor\.cfa\]/);
  assert.ok(found.same);
});

test("what is wrong is said, and the engine goes on", async () => {
  const refused = (call) => page.evaluate(`(async () => { try { await (${call}); return null; } catch (error) { return error.message; } })()`);
  const scene = "engine.scenes[0].id";
  const changed = (change) => `(() => { const d = structuredClone(with_filter("R", { builtin: "pigment/R" })); ${change}; return d; })()`;
  const draw = (design) => `engine.draw({ design: ${design}, scene: ${scene}, luminance: 10 })`;
  assert.match(await refused(draw(changed("d.sensor.pixel.pich_um = 2"))), /pich_um.*pitch_um/s);
  assert.match(await refused(draw(changed("d.wavelengths_nm = [400, 5, 700]"))), /wavelengths_nm.*gathered with/s);
  assert.match(await refused(draw(changed("d.optics.f_number = 0.1"))), /optics\.f_number.*0\.5 to 1000/s);
  assert.match(await refused(draw(changed("d.optics.f_number = 'wide'"))), /f_number/);
  assert.match(await refused(draw(changed("d.sensor.cfa.pattern = ['RX', 'GB']"))), /X/);
  assert.match(await refused(draw(changed("d.sensor.crosstalk_percent = 5"))), /light/);
  assert.match(await refused(`engine.draw({ design: camera, scene: "none", luminance: 10 })`), /there is no scene 'none'/);
  assert.match(await refused(`engine.draw({ design: camera, scene: ${scene}, luminance: -1 })`), /luminance_cd_m2.*-1/s);
  assert.match(await refused(`engine.draw({ design: camera, scene: ${scene}, luminance: 10, crop: { row: 0, col: 0, rows: 9999, cols: 1 } })`), /crop/);
  assert.match(await refused(`engine.improve(camera, { filters: ["Q"] }, [10], () => {})`), /no filter "Q"/);
  assert.match(await refused("engine.parse('[sensor]\\nrowz = 4')"), /camera\.toml:2.*rowz/s);
  assert.match(await refused("engine.parse('x'.repeat(2 ** 21))"), /at most/);
  assert.equal(await refused(draw("camera")), null);
  assert.deepEqual(faults, []);
});

test("a worker whose module traps, or whose script fails, is replaced, and requests are answered", async () => {
  await page.evaluate(async () => {
    window.ends = [];
    const { Engine } = await import("/engine.js");
    window.engine = await Engine.start("/assets/", (message) => window.ends.push(message));
    // A photograph, which another worker needs as well, and another lens.
    const photograph = new ImageData(48, 32);
    photograph.data.fill(200);
    window.own = await engine.addPhotograph("wall", photograph);
    window.other = structuredClone(camera);
    other.optics.f_number = 2.8;
    window.answers = async () => {
      const pictures = [];
      for (const [design, scene] of [[camera, engine.scenes[0].id], [other, engine.scenes[0].id], [other, own.id]]) {
        pictures.push([...(await engine.draw({ design, scene, luminance: 10 })).rgba].reduce((sum, v) => (sum * 31 + v) | 0, 0));
      }
      return JSON.stringify([pictures, (await engine.scores(camera, [10])).expected.map((e) => e.cpsnr_db), (await engine.curves(camera)).mosaic]);
    };
    window.first = await answers();
  });
  const fail = (how) => Promise.all(page.workers().map((worker) => worker.evaluate(how)));
  const trap = () => fail(() => {
    const { decode } = TextDecoder.prototype;
    TextDecoder.prototype.decode = () => {
      TextDecoder.prototype.decode = decode;
      throw new WebAssembly.RuntimeError("unreachable");
    };
  });
  await trap();
  assert.ok(await page.evaluate(async () => await answers() === first));
  // The workers of the pictures and of the figures ended, each told once.
  assert.deepEqual(await page.evaluate(() => window.ends.splice(0)), Array(2).fill("the simulator failed: unreachable"));
  await fail(() => { setTimeout(() => { throw new Error("broken"); }); });
  await page.waitForFunction(() => window.ends.length >= 2);
  assert.ok(await page.evaluate(async () => await answers() === first));
  // Light that has to be gathered anew, by a worker that traps as well.
  await trap();
  const again = await page.evaluate(async () => {
    const third = structuredClone(camera);
    third.optics.f_number = 5.6;
    return (await engine.draw({ design: third, scene: own.id, luminance: 10 })).width;
  });
  assert.equal(again, 48);
});
