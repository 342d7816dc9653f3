// A browser without a network, and pages in it that record every fault.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const require = createRequire(import.meta.url);
export const axeSource = await readFile(require.resolve("axe-core/axe.min.js"), "utf8");
const executablePath = process.env.SMALTI_CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((p) => existsSync(p));

// `options` are those of Playwright's launch; `more` are further arguments of the browser.
export function launch(options = {}, more = []) {
  if (!executablePath) throw new Error("no Chromium: install Debian's chromium or set SMALTI_CHROMIUM");
  const args = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", ...more];
  return chromium.launch({ executablePath, args, ...options });
}

// Opens a file. `faults` collects errors, violations of the content security policy, and requests for anything but the file itself.
export async function open(browser, file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1500, height: 1000 }, offline: true, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const faults = [];
  page.on("console", (m) => { if (["error", "warning"].includes(m.type())) faults.push(`console: ${m.text()}`); });
  page.on("pageerror", (e) => faults.push(`error: ${e.stack}`));
  page.on("request", (r) => { if (!/^(data|blob):/.test(r.url()) && r.url() !== `file://${file}`) faults.push(`request: ${r.url()}`); });
  page.on("dialog", (d) => { faults.push(`dialog: ${d.message()}`); d.dismiss(); });
  await page.goto(`file://${file}`);
  return { page, faults, close: () => context.close() };
}

// Runs `doing` on a page once the element that `ready` locates exists, and fails on every fault.
export async function work(browser, file, options, ready, doing) {
  const { page, faults, close } = await open(browser, file, options);
  try {
    await ready(page).waitFor();
    await doing(page);
    assert.deepEqual(faults, []);
  } finally {
    await close();
  }
}

// The serious violations that axe-core finds.
export async function axe(page) {
  await page.evaluate(axeSource);
  const { violations } = await page.evaluate(() => window.axe.run());
  return violations
    .filter((v) => ["serious", "critical"].includes(v.impact))
    .map((v) => `${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map((n) => n.html.slice(0, 160)).join(" | ")}`);
}

// Texts with less than 4.5:1 among those whose contrast axe-core leaves open, because of a picture behind them or their length. Where the colour behind a text
// shows what lies below, black and white are assumed there. Elements that the page replaced meanwhile are looked at again.
export async function weakContrast(page) {
  await page.evaluate(axeSource);
  return page.evaluate(async () => {
    let nodes;
    do {
      const { incomplete } = await window.axe.run({ runOnly: ["color-contrast"], elementRef: true });
      nodes = incomplete.flatMap((rule) => rule.nodes);
    } while (nodes.some((node) => !node.element.isConnected));
    const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const rgba = (color) => {
      context.clearRect(0, 0, 1, 1);
      context.fillStyle = color;
      context.fillRect(0, 0, 1, 1);
      return [...context.getImageData(0, 0, 1, 1).data].map((v) => v / 255);
    };
    const over = ([r, g, b, a], below) => [r, g, b].map((v, i) => v * a + below[i] * (1 - a));
    const luminance = (color) => color.map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)).reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
    const contrast = (a, b) => {
      const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return (high + 0.05) / (low + 0.05);
    };
    const weak = [];
    for (const { element } of nodes) {
      let behind = element;
      while (rgba(getComputedStyle(behind).backgroundColor)[3] === 0 && behind.parentElement) behind = behind.parentElement;
      const { color, fill } = getComputedStyle(element);
      const [text, back] = [rgba(element instanceof SVGElement ? fill : color), rgba(getComputedStyle(behind).backgroundColor)];
      const least = Math.min(...[[0, 0, 0], [1, 1, 1]].map((below) => contrast(over(text, over(back, below)), over(back, below))));
      if (!(least >= 4.5)) weak.push(`${least.toFixed(2)}: ${element.outerHTML.slice(0, 160)}`);
    }
    return weak;
  });
}
