// The page of a rating experiment in a real browser, against the server of the command: observers at the same time, a server that is killed, other origins.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { createServer } from "node:http";
import { once } from "node:events";
import { mkdtemp, readFile, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { axe, launch } from "./browser.mjs";

const smalti = resolve(process.env.SMALTI ?? join(import.meta.dirname, "../../target/debug/smalti"));
const TRAINING = 2;
const PAIRS = TRAINING + 6 + 2 + 2;
let dir;
let browser;
let server;

const env = () => ({ ...process.env, SMALTI_CACHE_DIR: join(dir, "cache") });
const run = (...args) => execFileSync(smalti, [...args, "--quiet"], { cwd: dir, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"], env: env() });

async function serve() {
  const child = spawn(smalti, ["rate", "serve", "trial", "--json", "--quiet"], { cwd: dir, stdio: ["ignore", "pipe", "inherit"], env: env() });
  const [line] = await once(child.stdout, "data");
  return { child, address: JSON.parse(line).address };
}
async function kill({ child }) {
  const ended = once(child, "exit");
  child.kill("SIGKILL");
  await ended;
}

before(async () => {
  dir = await mkdtemp(join(tmpdir(), "smalti-rate-"));
  const cameras = ["bayer", "rgbw", "--processing", "bilinear", "--luminance", "1,80"];
  const scenes = ["--scene", "macbeth?patch=24", "--scene", "dead-leaves?rows=192&cols=256&largest=60"];
  const trials = ["--side", "128", "--ratings", "6", "--repeats", "2", "--traps", "2", "--training", String(TRAINING), "--break-every", "4"];
  run("rate", "init", ...cameras, ...scenes, ...trials, "-o", "trial");
  browser = await launch();
  server = await serve();
});
after(async () => {
  await browser?.close();
  if (server) await kill(server);
  await rm(dir, { recursive: true, force: true });
});

// A browser of its own, as another person has. Faults are errors, violations of the policy and requests elsewhere; while the server is away, requests fail.
async function open(options = {}, allowed = /never/) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  const faults = [];
  page.on("console", (m) => { if (["error", "warning"].includes(m.type()) && !allowed.test(m.text())) faults.push(`console: ${m.text()}`); });
  page.on("pageerror", (e) => faults.push(`error: ${e.stack}`));
  page.on("request", (r) => { if (!/^(data|blob):/.test(r.url()) && !r.url().startsWith(server.address)) faults.push(`request: ${r.url()}`); });
  await page.goto(server.address);
  return { page, faults, close: () => context.close() };
}
const heading = (page) => page.locator("h1:visible").textContent();
async function join_(page) {
  await page.getByLabel("I have read this and agree to take part.").check();
  await page.getByRole("button", { name: "Continue" }).click();
  await page.getByRole("heading", { name: "Check your display" }).waitFor();
  await page.getByRole("button", { name: "Continue" }).click();
  await page.locator("#pause").waitFor();
}
// Judges pairs until none is left, or a number of them; screens in between are continued. Returns the headings of these screens.
async function judge(page, most = Infinity, choose = async (p) => p.keyboard.press("ArrowLeft")) {
  const screens = [];
  for (let judged = 0; ;) {
    await page.locator("#pause:visible, #done:visible, #left:not([aria-disabled=true])").first().waitFor();
    if (await page.locator("#done").isVisible()) return screens;
    if (await page.locator("#pause").isVisible()) {
      screens.push(await heading(page));
      await page.locator("#go-on").click();
      continue;
    }
    if (judged === most) return screens;
    const count = await page.locator("#count").textContent();
    await page.waitForTimeout(270);
    await choose(page);
    judged += 1;
    await page.waitForFunction((before) => document.getElementById("pair").hidden || document.getElementById("count").textContent !== before || document.getElementById("left").ariaDisabled === "true", count);
  }
}
async function answers() {
  const folder = join(dir, "trial/answers");
  const files = (await readdir(folder)).filter((f) => f.endsWith(".jsonl")).sort();
  return Promise.all(files.map(async (f) => (await readFile(join(folder, f), "utf8")).trim().split("\n").map((l) => JSON.parse(l))));
}

test("three observers judge at the same time, the server is killed in between, and nobody loses an answer", async () => {
  const all = await Promise.all([0, 1, 2].map(() => open({}, /Failed to load resource|ERR_CONNECTION/)));
  // One after the other, so that their numbers are known.
  for (const { page } of all) await join_(page);
  await Promise.all(all.map(({ page }, i) => judge(page, TRAINING + i)));
  const before = await answers();
  assert.deepEqual(before.map((lines) => lines.filter((l) => l.kind === "answer").length), [2, 3, 4]);
  await kill(server);
  // An answer while the server is away waits for it.
  await all[0].page.keyboard.press("ArrowRight");
  await all[0].page.getByText("The server does not answer.").waitFor();
  const { address } = server;
  server = await serve();
  assert.equal(server.address, address);
  const screens = await Promise.all(all.map(({ page }, i) => judge(page, Infinity, async (p) => (i === 1 ? p.getByRole("button", { name: "B is closer" }).click() : p.keyboard.press("ArrowLeft")))));
  assert.ok(screens.every((s) => s.includes("Take a break")), JSON.stringify(screens));
  const lines = await answers();
  assert.equal(lines.length, 3);
  for (const [i, observer] of lines.entries()) {
    assert.equal(observer.filter((l) => l.kind === "answer").length, PAIRS);
    assert.deepEqual(observer.slice(0, before[i].length), before[i], "earlier lines stay");
    const roles = observer.filter((l) => l.kind === "shown").map((l) => l.trial.role);
    assert.deepEqual(["training", "rating", "repeat", "trap"].map((r) => roles.filter((x) => x === r).length), [TRAINING, 6, 2, 2]);
  }
  assert.equal(lines[0].filter((l) => l.kind === "answer")[2].choice, "right");
  for (const { page, faults, close } of all) {
    assert.equal(await heading(page), "Thank you");
    assert.deepEqual(faults, []);
    await close();
  }
});

test("an observer who reloads the page goes on, and another one begins anew", async () => {
  const { page, faults, close } = await open();
  await join_(page);
  await judge(page, 3);
  await page.reload();
  await page.locator("#pause").waitFor();
  assert.equal(await heading(page), "Welcome back");
  await judge(page);
  await page.getByRole("button", { name: "Begin as another observer" }).click();
  await page.getByRole("heading", { name: "Which picture is closer to the reference?" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Continue" }).isDisabled(), "nobody takes part without consent");
  // The reload may interrupt requests of the page before it.
  assert.deepEqual(faults.filter((f) => !f.includes("net::ERR_ABORTED")), []);
  await close();
});

test("nobody learns of the answers of others, and wrong requests are refused", async () => {
  const { page, close } = await open();
  await join_(page);
  await judge(page, 1);
  const origin = new URL(server.address).origin;
  const secret = await page.evaluate(() => Object.entries(localStorage).find(([k]) => k.startsWith("smalti-observer"))[1]);
  const ask = async (path, options = {}, base = server.address) => {
    const response = await fetch(base + path, { ...options, headers: { Authorization: `Bearer ${secret}`, Origin: origin, ...options.headers } });
    return [response.status, await response.text(), response.headers];
  };
  const post = (path, body, headers = {}) => ask(path, { method: "POST", body, headers: { "Content-Type": "application/json", ...headers } });
  // The state has numbers alone: neither conditions nor roles nor anything of others.
  const [ok, state, headers] = await ask("api/pair");
  assert.equal(ok, 200);
  assert.deepEqual(Object.keys(JSON.parse(state)).sort(), ["cols", "done", "number", "pairs", "rows", "training"]);
  assert.match(headers.get("content-security-policy"), /default-src 'none'.*frame-ancestors 'none'/);
  assert.equal(headers.get("cross-origin-resource-policy"), "same-origin");
  const { number } = JSON.parse(state);
  const answer = JSON.stringify({ number, choice: "left", response_ms: 500 });
  const expected = [
    [401, await ask("api/pair", { headers: { Authorization: "Bearer 00000000000000000000000000000000" } })],
    [401, await ask("api/pair", { headers: { Authorization: "" } })],
    [401, await post("api/answer", answer, { Authorization: "Bearer x" })],
    [403, await ask("", {}, server.address.replace(/[0-9a-f]{32}/, "0".repeat(32)))],
    [403, await ask("", {}, `${origin}/`)],
    [403, await post("api/answer", answer, { Origin: "http://evil.example" })],
    [403, await post("api/answer", answer, { Origin: "null" })],
    [403, await ask("api/pair", { headers: { "Sec-Fetch-Site": "cross-site" } })],
    [409, await post("api/answer", JSON.stringify({ number: number + 1, choice: "left", response_ms: 1 }))],
    [409, await ask(`api/picture/${number - 1}/left`)],
    [404, await ask(`api/picture/${number}/..%2f..%2fexperiment.json`)],
    [404, await ask("%2e%2e%2f%2e%2e%2fetc/passwd")],
    [404, await ask("answers/observer-0001.jsonl")],
    [404, await ask("api/picture/x/left")],
    [413, await post("api/answer", "x".repeat(5000))],
    [400, await post("api/answer", "{")],
    [400, await post("api/answer", JSON.stringify({ number, choice: "both", response_ms: 1 }))],
    [400, await post("api/answer", JSON.stringify({ number, choice: "left", response_ms: 1, role: "trap" }))],
    [400, await post("api/answer", answer, { "Content-Type": "text/plain" })],
    [400, await post("api/observers", JSON.stringify({ consent: false, display: { device_pixel_ratio: 1, screen_px: [1, 1] } }))],
    [400, await post("api/observers", JSON.stringify({ consent: true, display: { device_pixel_ratio: 1e9, screen_px: [1, 1] } }))],
    [405, await ask("api/answer")],
  ];
  for (const [i, [status, [got, text]]] of expected.entries()) assert.equal(got, status, `request ${i}: ${text}`);
  assert.equal(JSON.parse((await ask("api/pair"))[1]).number, number, "nothing was recorded");
  // A page of another origin cannot reach the server, with the address known.
  const foreign = createServer((_, response) => { response.setHeader("Content-Type", "text/html"); response.end("<!doctype html><title>other</title>"); });
  foreign.listen(0, "127.0.0.1");
  await once(foreign, "listening");
  const other = await (await browser.newContext()).newPage();
  await other.goto(`http://127.0.0.1:${foreign.address().port}/`);
  const reached = await other.evaluate(async ([address, body]) => {
    const tries = [fetch(`${address}api/experiment`), fetch(`${address}api/answer`, { method: "POST", mode: "no-cors", body })];
    return (await Promise.allSettled(tries)).map((t) => (t.status === "fulfilled" ? t.value.type : "refused"));
  }, [server.address, answer]);
  assert.equal(reached[0], "refused");
  assert.equal(JSON.parse((await ask("api/pair"))[1]).number, number);
  foreign.close();
  await close();
});

test("pictures are shown pixel by pixel, and a browser that scales them warns", async () => {
  const shown = async (options) => {
    const { page, faults, close } = await open(options);
    await page.getByLabel("I have read").check();
    await page.getByRole("button", { name: "Continue" }).click();
    const warning = await page.locator("#ratio").isVisible() ? await page.locator("#ratio").textContent() : "";
    await page.getByRole("button", { name: "Continue" }).click();
    await judge(page, 0);
    const sizes = await page.locator("#pictures img:visible").evaluateAll((all) => all.map((i) => {
      const box = i.getBoundingClientRect();
      return [box.width / i.naturalWidth, box.height / i.naturalHeight];
    }));
    assert.deepEqual(faults, []);
    await close();
    return { warning, sizes };
  };
  const plain = await shown({});
  assert.equal(plain.warning, "");
  assert.deepEqual(plain.sizes, [[1, 1], [1, 1], [1, 1]]);
  assert.match((await shown({ deviceScaleFactor: 1.5 })).warning, /scales pictures: 1\.5 pixels/);
  assert.match((await shown({ deviceScaleFactor: 2 })).warning, /2 × 2 pixels/);
});

test("where three pictures do not fit, they are shown one after the other in one place", async () => {
  const { page, faults, close } = await open({ viewport: { width: 390, height: 844 } });
  await join_(page);
  await judge(page, 0);
  const box = async () => page.locator("#pictures").boundingBox();
  const alt = async () => page.locator("#pictures img:visible").evaluateAll((all) => all.map((i) => i.alt));
  const place = await box();
  assert.deepEqual(await alt(), ["Reference"]);
  await page.getByRole("button", { name: "A", exact: true }).press("Enter");
  assert.deepEqual(await alt(), ["Picture A"]);
  await page.getByRole("button", { name: "B", exact: true }).click();
  assert.deepEqual(await alt(), ["Picture B"]);
  assert.deepEqual(await box(), place, "nothing moves");
  assert.deepEqual(faults, []);
  await close();
});

test("nothing on the page moves from pair to pair", async () => {
  const { page, close } = await open();
  await join_(page);
  await judge(page, 0);
  const places = async () => Promise.all(["#pictures", "#left", "#right", "#progress"].map((s) => page.locator(s).boundingBox()));
  const first = await places();
  await judge(page, 1);
  assert.deepEqual(await places(), first);
  await close();
});

for (const colorScheme of ["light", "dark"]) {
  for (const [width, height] of [[360, 800], [390, 844], [1440, 900], [3840, 2160]]) {
    test(`every screen is accessible and never wider than ${width} px in ${colorScheme}`, async () => {
      const { page, faults, close } = await open({ colorScheme, viewport: { width, height } });
      const check = async (name) => {
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), name);
        assert.deepEqual(await axe(page), [], name);
        if (process.env.SMALTI_PICTURES) await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `rate-${name}-${width}-${colorScheme}.png`) });
      };
      await check("welcome");
      await page.getByLabel("I have read").check();
      await page.getByRole("button", { name: "Continue" }).click();
      await check("display");
      await page.getByRole("button", { name: "Continue" }).click();
      await page.locator("#pause").waitFor();
      assert.equal(await page.evaluate(() => document.activeElement.id), "pause-title");
      await check("pause");
      await judge(page, 0);
      await check("pair");
      // axe.run is evaluated in the page, whose policy admits no other script.
      assert.deepEqual(faults.filter((f) => !f.includes("Content Security Policy")), []);
      await close();
    });
  }
}

test("the answers are analysed", async () => {
  const text = run("rate", "analyse", "trial", "--keep-all", "--json");
  const results = JSON.parse(text);
  assert.equal(results.result.kind, "scale");
  assert.deepEqual(results.observers.slice(0, 3).map((o) => [o.answered, o.pairs]), [[PAIRS, PAIRS], [PAIRS, PAIRS], [PAIRS, PAIRS]]);
  const page = await (await browser.newContext({ offline: true })).newPage();
  await page.goto(`file://${join(dir, "trial/analysis/report.html")}`);
  assert.deepEqual(await page.locator("main > section").evaluateAll((all) => all.map((s) => s.id)), ["scale", "scenes", "agreement", "observers", "again"]);
  assert.equal(await page.locator("#scale tbody tr").count(), 4);
  assert.equal(await page.locator("#agreement tbody tr").count(), 7);
  assert.deepEqual(await axe(page), []);
  if (process.env.SMALTI_PICTURES) {
    for (const colorScheme of ["light", "dark"]) {
      for (const [width, height] of [[390, 844], [1440, 900]]) {
        await page.emulateMedia({ colorScheme });
        await page.setViewportSize({ width, height });
        await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `analysis-${width}-${colorScheme}.png`), fullPage: true });
      }
    }
  }
});
