// The page of a rating experiment in a real browser, against the server of the command: observers at the same time, a server that is killed, other origins.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { createServer } from "node:http";
import { once } from "node:events";
import { mkdtemp, readFile, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { axe, axeSource, launch } from "./browser.mjs";

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

const SECRET = "0123456789abcdef0123456789abcdef";
// A browser of its own, as another person has. Faults are errors, violations of the policy and requests elsewhere; while the server is away, requests fail.
async function open(options = {}, allowed = /never/, own = browser) {
  const context = await own.newContext({ viewport: { width: 1440, height: 900 }, ...options });
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
    await page.locator("#pause:visible, #done:visible, #left:not([aria-disabled=true]), #look:not([data-done]):visible").first().waitFor();
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
  await all[0].page.getByText("The server is not available").waitFor();
  const { address } = server;
  server = await serve();
  assert.equal(server.address, address);
  const screens = await Promise.all(all.map(({ page }, i) => judge(page, Infinity, async (p) => (i === 1 ? p.getByRole("button", { name: "B is closer" }).click() : p.keyboard.press("ArrowLeft")))));
  // After four of ten pairs; after eight, only two are left.
  assert.ok(screens.every((s) => s.filter((heading) => heading === "Take a break").length === 1), JSON.stringify(screens));
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
  // Somebody else may sit here now; nothing of the answers so far is lost.
  await page.getByRole("button", { name: "I am another observer" }).click();
  await page.getByRole("heading", { name: "Who is taking part?" }).waitFor();
  await page.getByRole("button", { name: `(3 of ${PAIRS} pairs judged)` }).click();
  await page.locator("#pause").waitFor();
  await judge(page);
  await page.getByRole("button", { name: "Begin as another observer" }).click();
  await page.getByRole("heading", { name: "Which picture is closer to the reference?" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Continue" }).isDisabled(), "nobody takes part without consent");
  // The reload may interrupt requests of the page before it.
  assert.deepEqual(faults.filter((f) => !f.includes("net::ERR_ABORTED")), []);
  await close();
});

test("windows of one browser are different observers, unless one chooses to continue as another who has left", async () => {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const window_ = async (opened = context.newPage()) => {
    const page = await opened;
    if (page.url() === "about:blank") await page.goto(server.address);
    await page.locator("h1:visible").waitFor();
    return page;
  };
  const observer = async (page) => Number((await page.locator("#place").textContent()).match(/Observer (\d+)/)[1]);
  const first = await window_();
  await join_(first);
  await judge(first, 3);
  // A second window while the first is open: another observer, without being asked.
  const second = await window_();
  assert.equal(await heading(second), "Which picture is closer to the reference?");
  await join_(second);
  await judge(second, 1);
  const [one, two] = [await observer(first), await observer(second)];
  assert.equal(two, one + 1);
  await judge(first, 1);
  const given = (await answers()).filter((l) => [one, two].includes(l[0].number)).map((l) => l.filter((x) => x.kind === "answer").length);
  assert.deepEqual(given, [4, 1]);
  // A duplicated window has the memory of the first one, whose observer it must not become.
  const opening = context.waitForEvent("page");
  await first.evaluate(() => { window.open(location.href); });
  const duplicate = await opening;
  await duplicate.getByRole("heading", { name: "Which picture is closer to the reference?" }).waitFor();
  await duplicate.close();
  // The first window is closed: a new one may continue there, but not as the observer of the second window.
  await first.close();
  const third = await window_();
  assert.equal(await heading(third), "Who is taking part?");
  assert.deepEqual(await third.locator("#earlier button").allTextContents(), [`Continue as observer ${one} (4 of ${PAIRS} pairs judged)`]);
  assert.deepEqual(await axe(third), []);
  // Buttons beside each other are equally high and on one line.
  const [anew, earlier] = await Promise.all(["#anew", "#earlier button"].map((s) => third.locator(s).boundingBox()));
  assert.deepEqual([earlier.y, earlier.height], [anew.y, anew.height]);
  await third.locator("#earlier button").click();
  await third.locator("#pause").waitFor();
  assert.equal(await heading(third), "Welcome back");
  await judge(third, 1);
  assert.equal(await observer(third), one);
  // Whoever begins anew there is another observer, and the one before can still continue.
  await third.close();
  const fourth = await window_();
  await fourth.getByRole("button", { name: "Begin as a new observer" }).click();
  await join_(fourth);
  await judge(fourth, 0);
  assert.equal(await observer(fourth), two + 1);
  await context.close();
});

test("a server that fails, such as on a full disk, and replies that are lost cost neither an answer nor an observer", async () => {
  const { page, close } = await open({}, /Failed to load resource|ERR_FAILED/);
  const before = (await answers()).length;
  // The first request to take part is served, and its reply lost; the second one fails on the server.
  let joins = 0;
  await page.route("**/api/observers", async (route) => {
    joins += 1;
    if (joins === 1) {
      await route.fetch();
      await route.abort();
    } else if (joins === 2) await route.fulfill({ status: 500, body: "the server cannot store or read this" });
    else await route.continue();
  });
  await join_(page);
  assert.equal(joins, 3);
  assert.equal((await answers()).length, before + 1, "one observer");
  let answered = 0;
  await page.route("**/api/answer", async (route) => {
    answered += 1;
    if (answered === 1) await route.fulfill({ status: 500, body: "the server cannot store or read this" });
    else if (answered === 2) {
      await route.fetch();
      await route.abort();
    } else await route.continue();
  });
  await judge(page, 0);
  await page.waitForTimeout(270);
  await page.keyboard.press("ArrowRight");
  await page.getByText("The server is not available").waitFor();
  await page.waitForFunction(() => document.getElementById("count").textContent.startsWith("2 of"));
  assert.equal(await page.locator("#trouble").textContent(), "");
  assert.equal(answered, 3);
  assert.deepEqual((await answers()).at(-1).filter((l) => l.kind === "answer").map((l) => l.choice), ["right"]);
  await close();
});

test("nobody learns of the answers of others, and wrong requests are refused", async () => {
  const { page, close } = await open();
  await join_(page);
  await judge(page, 1);
  const origin = new URL(server.address).origin;
  const secret = await page.evaluate(() => Object.entries(sessionStorage).find(([k]) => k.startsWith("smalti-observer"))[1]);
  const ask = async (path, options = {}, base = server.address) => {
    const response = await fetch(base + path, { ...options, headers: { Authorization: `Bearer ${secret}`, Origin: origin, ...options.headers } });
    return [response.status, await response.text(), response.headers];
  };
  const post = (path, body, headers = {}) => ask(path, { method: "POST", body, headers: { "Content-Type": "application/json", ...headers } });
  // The state has numbers alone: neither conditions nor roles nor anything of others.
  const [ok, state, headers] = await ask("api/pair");
  assert.equal(ok, 200);
  assert.deepEqual(Object.keys(JSON.parse(state)).sort(), ["cols", "done", "number", "observer", "pairs", "rows", "training"]);
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
    [400, await post("api/observers", JSON.stringify({ consent: false, secret: SECRET, display: { device_pixel_ratio: 1, screen_px: [1, 1] } }))],
    [400, await post("api/observers", JSON.stringify({ consent: true, secret: "guess", display: { device_pixel_ratio: 1, screen_px: [1, 1] } }))],
    [400, await post("api/observers", JSON.stringify({ consent: true, secret: SECRET, display: { device_pixel_ratio: 1e9, screen_px: [1, 1] } }))],
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
  assert.match((await shown({ deviceScaleFactor: 1.5 })).warning, /resamples pictures: .* as 1\.5 × 1\.5 pixels/);
  assert.match((await shown({ deviceScaleFactor: 2 })).warning, /2 × 2 pixels/);
});

// Rows of the screen in device pixels, from the middle column of the canvas: from left of the square, where all rows are lines.
async function linesOf(page) {
  const shot = (await page.screenshot()).toString("base64");
  return page.evaluate(async (data) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = document.getElementById("lines");
    const box = canvas.getBoundingClientRect();
    const copy = new OffscreenCanvas(image.width, image.height).getContext("2d");
    copy.drawImage(image, 0, 0);
    const x = Math.round((box.left + box.width / 8) * devicePixelRatio);
    const [top, bottom] = [box.top, box.bottom].map((y) => Math.round(y * devicePixelRatio));
    const { data: pixels } = copy.getImageData(x, top + 2, 1, bottom - top - 4);
    return { levels: Array.from({ length: bottom - top - 4 }, (_, i) => pixels[4 * i]), css: [box.width, box.height], scroll: document.documentElement.scrollWidth - innerWidth };
  }, shot);
}

for (const [ratio, width, height] of [[1, 1440, 900], [1.25, 1440, 900], [1.5, 1440, 900], [1.75, 1433, 911], [2, 1440, 900], [3, 390, 1400], [2.625, 412, 1400]]) {
  test(`the lines of the gamma check are one device pixel each at a ratio of ${ratio}`, async () => {
    // A screen of this ratio, which the browser does not emulate by scaling what it has drawn.
    const own = await launch({}, [`--force-device-scale-factor=${ratio}`, `--window-size=${width},${height}`]);
    const { page, faults } = await open({ viewport: null }, /never/, own);
    assert.equal(await page.evaluate(() => devicePixelRatio), ratio);
    await page.getByLabel("I have read").check();
    await page.getByRole("button", { name: "Continue" }).click();
    await page.locator("#lines").scrollIntoViewIfNeeded();
    await page.waitForFunction(() => document.getElementById("lines").width > 200);
    const { levels, css, scroll } = await linesOf(page);
    assert.deepEqual(css.map((v) => Math.round(1000 * v) / 1000), [240, 160]);
    assert.ok(scroll <= 0, `wider by ${scroll} px`);
    assert.ok(levels.length > 150 * ratio);
    const first = levels[0];
    assert.ok(first === 0 || first === 255, `level ${first}`);
    for (const [i, level] of levels.entries()) assert.equal(level, i % 2 === 0 ? first : 255 - first, `row ${i}`);
    assert.deepEqual(faults, []);
    await own.close();
  });
}

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

test("where pictures are shown one after the other, an answer counts once both were shown", async () => {
  const { page, faults, close } = await open({ viewport: { width: 390, height: 844 } });
  await join_(page);
  await page.locator("#go-on").click();
  const count = page.locator("#count");
  const press = async () => {
    await page.waitForTimeout(300);
    await page.keyboard.press("ArrowLeft");
    await page.locator("#left").dispatchEvent("click");
    await page.waitForTimeout(100);
  };
  for (const pair of [1, 2]) {
    await page.waitForFunction((p) => document.querySelector("figure[data-side=reference] img").complete && document.getElementById("count").textContent.startsWith(`${p} of`), pair);
    await page.locator("figure[data-side=reference] img:not([data-waits])").waitFor();
    await press();
    assert.match(await count.textContent(), new RegExp(`^${pair} of`), "the reference alone was shown");
    await page.getByRole("button", { name: "A", exact: true }).click();
    await press();
    assert.match(await count.textContent(), new RegExp(`^${pair} of`), "A alone was shown");
    assert.equal(await page.locator("#left").getAttribute("aria-disabled"), "true");
    assert.ok(await page.getByText("Look at A and at B before you answer.").isVisible());
    await page.getByRole("button", { name: "B", exact: true }).click();
    assert.equal(await page.locator("#left").getAttribute("aria-disabled"), "false");
    assert.ok(!(await page.getByText("Look at A and at B before you answer.").isVisible()));
    await page.waitForTimeout(300);
    await page.keyboard.press("ArrowLeft");
    if (pair === 1) await page.waitForFunction(() => document.getElementById("count").textContent.startsWith("2 of"));
  }
  // In a window that is wide enough again all pictures are shown, and an answer counts at once.
  await page.locator("#go-on").click();
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.locator("#left:not([aria-disabled=true])").waitFor();
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

// What axe-core leaves to people: texts below WCAG AA against what lies behind them, and controls whose border has less than 3:1.
async function faint(page) {
  await page.evaluate(axeSource);
  return page.evaluate(async () => {
    const { incomplete } = await window.axe.run({ runOnly: ["color-contrast"] });
    const channels = (color) => (color.match(/[\d.]+/g) ?? []).map(Number);
    const isClear = (color) => channels(color).length === 4 && channels(color)[3] === 0;
    const luminance = (color) => {
      const [r, g, b] = channels(color).map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ratio = (a, b) => {
      const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return (high + 0.05) / (low + 0.05);
    };
    const behind = (element) => {
      for (let e = element.parentElement; e; e = e.parentElement) {
        const { backgroundColor } = getComputedStyle(e);
        if (!isClear(backgroundColor)) return backgroundColor;
      }
      return "rgb(255, 255, 255)";
    };
    // Undecided are signs such as arrows, whose ratio is computed here, and whatever lies on a picture or a gradient, of which there is none.
    const undecided = incomplete.flatMap((v) => v.nodes).flatMap((n) => {
      const element = document.querySelector(n.target[0]);
      const { color, backgroundColor } = getComputedStyle(element);
      const isSign = n.any.some((a) => a.data?.messageKey === "nonBmp");
      const found = ratio(color, isClear(backgroundColor) ? behind(element) : backgroundColor);
      return isSign && found >= 4.5 ? [] : [`text ${n.html.slice(0, 120)}: ${found.toFixed(2)}, ${n.any.map((a) => a.message).join("; ")}`];
    });
    const controls = [...document.querySelectorAll("button")].filter((b) => b.checkVisibility() && !b.disabled && b.ariaDisabled !== "true");
    const edges = controls.flatMap((b) => {
      const { borderTopColor, backgroundColor } = getComputedStyle(b);
      // A control is seen by its border or by its own colour.
      const best = Math.max(...[borderTopColor, backgroundColor].filter((c) => !isClear(c)).map((c) => ratio(c, behind(b))));
      return best < 3 ? [`border of ${b.textContent}: ${best.toFixed(2)}`] : [];
    });
    return [...undecided, ...edges];
  });
}

for (const colorScheme of ["light", "dark"]) {
  for (const [width, height, ratio] of [[360, 800, 1], [390, 844, 1], [390, 844, 3], [1440, 900, 1], [1440, 900, 1.5], [1440, 900, 2], [3840, 2160, 1]]) {
    test(`every screen is accessible and never wider than ${width} px in ${colorScheme} at a ratio of ${ratio}`, async () => {
      const { page, faults, close } = await open({ colorScheme, viewport: { width, height }, deviceScaleFactor: ratio });
      const check = async (name) => {
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), name);
        const [left, right] = await page.locator("section:visible").evaluate((s) => [s.getBoundingClientRect().left, document.documentElement.clientWidth - s.getBoundingClientRect().right]);
        assert.ok(Math.abs(left - right) <= 1, `${name} is not in the middle: ${left} px on the left, ${right} px on the right`);
        assert.deepEqual(await axe(page), [], name);
        assert.deepEqual(await faint(page), [], name);
        if (process.env.SMALTI_PICTURES) await page.screenshot({ path: join(process.env.SMALTI_PICTURES, `rate-${name}-${width}-${ratio}-${colorScheme}.png`), fullPage: true });
      };
      await check("welcome");
      await page.getByLabel("I have read").check();
      await page.getByRole("button", { name: "Continue" }).click();
      // The outline of a card lies within its place, however large it is, and stands upright where it would not fit.
      const display = page.locator("#size");
      const most = Number(await display.getAttribute("max"));
      const place = await page.locator("#card-place").boundingBox();
      assert.ok(most >= 320 / 0.64, `${most}`);
      for (const size of [120, most, 324]) {
        await display.fill(String(size));
        const card = await page.locator("#card").boundingBox();
        assert.equal(Math.max(card.width, card.height), size);
        assert.equal(card.height > card.width, width < 600);
        assert.ok(card.x >= place.x && card.x + card.width <= place.x + place.width + 0.5 && card.y + card.height <= place.y + place.height + 0.5, `${size} px`);
        assert.deepEqual(await page.locator("#card-place").boundingBox(), place, "nothing moves");
      }
      await check("display");
      await page.getByRole("button", { name: "Continue" }).click();
      await page.locator("#pause").waitFor();
      assert.equal(await page.evaluate(() => document.activeElement.id), "pause-title");
      await check("pause");
      await judge(page, 0);
      await page.locator("figure[data-side=reference] img:not([data-waits])").waitFor();
      await check("pair");
      // axe.run is evaluated in the page, whose policy admits no other script.
      assert.deepEqual(faults.filter((f) => !f.includes("Content Security Policy")), []);
      await close();
    });
  }
}

test("a value of the display that the observer neither moved nor confirmed is not recorded", async () => {
  const recorded = async (adjust) => {
    const { page, close } = await open();
    await page.getByLabel("I have read").check();
    await page.getByRole("button", { name: "Continue" }).click();
    await adjust(page);
    await page.getByRole("button", { name: "Continue" }).click();
    await page.locator("#pause").waitFor();
    await close();
    const { device_pixel_ratio, screen_px, ...found } = (await answers()).at(-1)[0].display;
    assert.deepEqual([device_pixel_ratio, screen_px], [1, [1440, 900]]);
    return found;
  };
  const [size, gamma] = ["The outline is as large as my card", "The square is as bright as the lines"];
  assert.deepEqual(await recorded(async () => {}), {});
  assert.deepEqual(await recorded(async (page) => {
    await page.locator("#gamma").press("ArrowRight");
    assert.ok(await page.getByLabel(gamma).isChecked() && !(await page.getByLabel(size).isChecked()));
  }), { gamma: 2.22 });
  // Where the slider begins may be right, and who moved it may be in doubt.
  assert.deepEqual(await recorded(async (page) => {
    await page.getByLabel(size).check();
    await page.locator("#gamma").press("ArrowRight");
    await page.getByLabel(gamma).uncheck();
  }), { px_per_mm: 324 / 85.6 });
});

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
  // The display gamma is that of the observers who stated it.
  const headings = await page.locator("#observers thead th").allTextContents();
  const gammas = await page.locator("#observers tbody tr").evaluateAll((rows, column) => rows.map((r) => r.children[column].textContent), headings.indexOf("display gamma"));
  const stated = (await answers()).map((lines) => lines[0].display.gamma?.toFixed(2) ?? "–");
  assert.deepEqual(gammas, stated);
  assert.ok(stated.includes("–") && stated.includes("2.22"), stated.join());
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
