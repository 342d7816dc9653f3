// Makes the pictures of the studio in the documentation for tools/make_pictures.py: `SMALTI FOLDER`. Each shows what RGBW changes against the
// pinned Bayer mosaic, in light and dark colours, on a wide window and on a phone.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";

const [smalti, folder] = process.argv.slice(2, 4).map((p) => resolve(p));
const server = spawn(smalti, ["studio", "bayer", "--json", "--quiet"], { stdio: ["ignore", "pipe", "inherit"] });
const [line] = await once(server.stdout, "data");
const { address } = JSON.parse(line);
const browser = await launch();
const WIDE = { viewport: { width: 1440, height: 900 } };
const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };
const faults = [];
try {
  for (const [name, options, colorScheme, view] of [
    ["studio", WIDE, "light", "one"], ["studio-dark", WIDE, "dark", "split"], ["studio-phone", PHONE, "light", "split"], ["studio-phone-dark", PHONE, "dark", "map"],
  ]) {
    const page = await (await browser.newContext({ ...options, colorScheme })).newPage();
    page.on("console", (m) => { if (m.type() === "error") faults.push(m.text()); });
    page.on("pageerror", (e) => faults.push(e.stack));
    await page.goto(address);
    const settled = () => page.waitForFunction(() => document.documentElement.dataset.settled !== undefined, null, { timeout: 60_000 });
    await settled();
    await page.getByLabel("Start from").selectOption("rgbw");
    await page.getByLabel("Name of the design").fill("rgbw");
    await page.getByLabel("Name of the design").press("Enter");
    if (view === "split") await page.getByLabel("Against").selectOption("pin");
    if (view === "map") await page.getByRole("button", { name: "Difference" }).click();
    // The curves of both designs, which follow the picture.
    await page.locator("#light-curve svg .pinned").waitFor({ timeout: 60_000 });
    await settled();
    await page.evaluate(() => {
      if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
      for (const element of [document.scrollingElement, ...document.querySelectorAll(".left, .right")]) element?.scrollTo(0, 0);
    });
    await page.waitForTimeout(200);
    await page.screenshot({ path: join(folder, `${name}.png`) });
    await page.context().close();
  }
} finally {
  await browser.close();
  server.kill("SIGKILL");
}
if (faults.length > 0) throw new Error(faults.join("\n"));
