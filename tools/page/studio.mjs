// What the tests of the studio share: the server of the command, pages of it in a browser, and what they show.
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { cp, mkdtemp, readFile, rm } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { launch } from "./browser.mjs";

export const smalti = resolve(process.env.SMALTI ?? join(import.meta.dirname, "../../target/debug/smalti"));

// Starts a browser and the server of `smalti studio bayer`, whose light is complete: the folder `site` is exported first, and leaves it in the cache.
// SMALTI_STUDIO_CACHE names a cache that has it already.
export async function studio() {
  const dir = await mkdtemp(join(tmpdir(), "smalti-studio-"));
  const env = { ...process.env, SMALTI_CACHE_DIR: join(dir, "cache") };
  const run = (...args) => execFileSync(smalti, args, { cwd: dir, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"], env });
  const serve = async (...args) => {
    const child = spawn(smalti, ["studio", "bayer", "--json", "--quiet", ...args], { cwd: dir, stdio: ["ignore", "pipe", "inherit"], env });
    const [line] = await once(child.stdout, "data");
    const end = async () => {
      const ended = once(child, "exit");
      child.kill("SIGKILL");
      await ended;
    };
    return { address: JSON.parse(line).address, end };
  };
  if (process.env.SMALTI_STUDIO_CACHE) await cp(process.env.SMALTI_STUDIO_CACHE, env.SMALTI_CACHE_DIR, { recursive: true });
  run("studio", "bayer", "--export", "site", "--quiet");
  const [browser, server] = await Promise.all([launch(), serve()]);
  // `before` prepares it, and it is returned once `ready`. A page in a context of its own. Faults are errors, violations of the policy and requests elsewhere; the tests themselves read the canvas.
  const open = async (options = {}, address = server.address, before = () => {}, ready = settled) => {
    const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
    const page = await context.newPage();
    const faults = [];
    page.on("console", (m) => { if (["error", "warning"].includes(m.type()) && !m.text().includes("willReadFrequently")) faults.push(`console: ${m.text()}`); });
    page.on("pageerror", (e) => faults.push(`error: ${e.stack}`));
    page.on("request", (r) => { if (!/^(data|blob):/.test(r.url()) && !r.url().startsWith(address.split("#")[0])) faults.push(`request: ${r.url()}`); });
    await before(page);
    await page.goto(address);
    await ready(page);
    return { page, faults, close: () => context.close() };
  };
  const end = async () => {
    await browser.close();
    await server.end();
    await rm(dir, { recursive: true, force: true });
  };
  return { dir, browser, server, run, serve, open, end };
}

// The same with its exported folder on a web server.
export async function studioAndSite() {
  const own = await studio();
  const exported = await site(join(own.dir, "site"));
  const end = async () => {
    exported.end();
    await own.end();
  };
  return { ...own, exported, end };
}

// A web server of a folder below a path, such as that of an exported studio.
export async function site(folder, path = "/") {
  const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json" };
  const server = createServer(async (request, response) => {
    const wanted = new URL(request.url, "http://x").pathname.replace(path, "/").replace(/\/$/, "/index.html");
    try {
      response.setHeader("Content-Type", types[extname(wanted)] ?? "application/octet-stream");
      response.end(await readFile(join(folder, wanted)));
    } catch {
      response.writeHead(404).end();
    }
  });
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  return { address: `http://127.0.0.1:${server.address().port}${path}`, end: () => server.close() };
}

// Picture, scores and figures are those of the latest change.
export const settled = (page) => page.waitForFunction(() => document.documentElement.dataset.settled !== undefined, null, { timeout: 90_000 });
export const cells = (page) => page.locator("#grid [role=row]").evaluateAll((rows) => rows.map((r) => [...r.children].map((c) => c.textContent).join("")));
export const pixels = (page) => page.locator("#canvas").evaluate((canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let hash = 0;
  for (let i = 0; i < data.length; i += 1) hash = (hash * 31 + data[i]) | 0;
  return hash;
});
// Opens a built-in camera. The list has its name until it is open, or until it is refused.
export async function openPreset(page, camera) {
  await page.getByLabel("Preset").selectOption({ label: camera });
  await page.waitForFunction(() => document.getElementById("preset").value === "");
}
// Gives a mosaic to the design. The list has its name until the design has it, or until it is refused.
export async function startFrom(page, mosaic) {
  await page.getByLabel("Start from").selectOption(mosaic);
  await page.waitForFunction(() => document.getElementById("template").value === "");
}
export const score = async (page, name) => Number((await page.locator(".tile", { has: page.getByText(name, { exact: true }) }).locator(".value").textContent()).replace("−", "-"));
export const field = (page, key) => page.locator(`[data-parameter="${key}"]`);
export async function saved(page, name) {
  await page.getByText("File", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
  return { name: download.suggestedFilename(), content: await readFile(await download.path()) };
}
// The design in the tile and filters as the page saves it.
export const toml = async (page) => (await saved(page, "Save camera.toml")).content.toString();
// The part of a camera file that describes a filter.
export const filterOf = (file, letter) => file.split(/^\[/m).filter((part) => part.startsWith(`sensor.cfa.filters.${letter}`)).join("");
export async function lockCell(page, row, col) {
  await page.getByLabel("Lock cells with the brush").check();
  await page.getByRole("gridcell", { name: `Row ${row}, column ${col}:` }).click();
  await page.getByRole("gridcell", { name: `Row ${row}, column ${col}: ${(await cells(page))[row - 1][col - 1]}, locked` }).waitFor();
  await page.getByLabel("Lock cells with the brush").uncheck();
}
export async function lockFilter(page, letter) {
  await page.getByRole("radio", { name: `Filter ${letter}` }).click();
  await page.getByLabel("Lock", { exact: true }).check();
}
// Times: median, 95 % and the largest.
export const stated = (times) => {
  const sorted = [...times].sort((a, b) => a - b);
  const at = (share) => sorted[Math.min(sorted.length - 1, Math.ceil(share * sorted.length) - 1)];
  return { median: at(0.5), p95: at(0.95), most: sorted.at(-1), count: sorted.length };
};
export const text = ({ median, p95, most, count }) => `${median.toFixed(1)} ms in the median, ${p95.toFixed(1)} ms in 95 %, at most ${most.toFixed(1)} ms (${count} times)`;
// All times count. A machine that does something else as well delays some of them: 95 % may take twice as long as the median may.
export const within = (found, limit) => found.median <= limit && found.p95 <= 2 * limit;
// Transmittances of a filter by wavelength, as the page saves them.
export async function curve(page, letter) {
  const [names, ...rows] = (await saved(page, "Save curves as CSV")).content.toString().trim().split("\n").map((line) => line.split(","));
  return rows.map((row) => [Number(row[0]), Number(row[names.indexOf(`transmittance_${letter}`)])]);
}
