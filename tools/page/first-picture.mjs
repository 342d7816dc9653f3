// Measures the time from the command `smalti studio bayer` to its first picture in a running browser: `node first-picture.mjs [SMALTI [STARTS]]`. The defaults are the release and six
// starts of each kind: with an empty cache, and with the light that an earlier start kept.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";
import { settled, stated, text } from "./studio.mjs";

const [smalti = join(import.meta.dirname, "../../target/release/smalti"), starts = "6"] = process.argv.slice(2);
const folder = await mkdtemp(join(tmpdir(), "smalti-studio-"));
const browser = await launch();
const statistics = (page) => page.evaluate(async () => (await (await fetch("engine/manifest.json")).json()).statistics);

// The time of one start, ms, in which the light must be `kept` or not. `then` works with the page afterwards.
async function start(cache, kept, then = async () => {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  const begun = performance.now();
  const server = spawn(resolve(smalti), ["studio", "bayer", "--json", "--quiet"], { stdio: ["ignore", "pipe", "inherit"], env: { ...process.env, SMALTI_CACHE_DIR: cache } });
  try {
    const [line] = await Promise.race([once(server.stdout, "data"), once(server, "exit").then(([code]) => { throw new Error(`the command ended with ${code}`); })]);
    await page.goto(JSON.parse(line).address, { waitUntil: "commit" });
    await page.waitForFunction(() => document.querySelector("#wait")?.hidden);
    const time = performance.now() - begun;
    await settled(page);
    if (Boolean(await statistics(page)) !== kept) throw new Error(kept ? "the light was not kept" : "the light was there before");
    await then(page);
    return time;
  } finally {
    server.kill("SIGKILL");
    await context.close();
  }
}

try {
  // The browser runs before the first start.
  await (await browser.newPage()).goto("about:blank");
  const caches = Array.from({ length: Number(starts) }, (_, i) => join(folder, String(i)));
  const first = [];
  // The rest of the light is gathered and kept a quarter of a minute after a start.
  for (const cache of caches) first.push(await start(cache, false, (page) => page.waitForTimeout(cache === caches.at(-1) ? 40_000 : 0)));
  console.log(`empty cache: ${text(stated(first))}`);
  const later = [];
  for (const _ of caches) later.push(await start(caches.at(-1), true));
  console.log(`light of an earlier start: ${text(stated(later))}`);
} finally {
  await browser.close();
  await rm(folder, { recursive: true });
}
