// Makes the pictures of the rating page in the documentation for tools/make_pictures.py: `SMALTI FOLDER EXPERIMENT`. They show a pair and the display
// check, in light and dark colours, on a wide window and on a telephone. The answers of these sessions go to EXPERIMENT.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";

const [smalti, folder, experiment] = process.argv.slice(2, 5).map((p) => resolve(p));
const server = spawn(smalti, ["rate", "serve", experiment, "--json", "--quiet"], { stdio: ["ignore", "pipe", "inherit"] });
const [line] = await once(server.stdout, "data");
const { address } = JSON.parse(line);
const browser = await launch();
const WIDE = { viewport: { width: 1440, height: 900 } };
const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };
const faults = [];
try {
  for (const [name, options, colorScheme, screen] of [
    ["rate", WIDE, "light", "pair"], ["rate-dark", WIDE, "dark", "display"], ["rate-phone", PHONE, "light", "pair"], ["rate-phone-dark", PHONE, "dark", "display"],
  ]) {
    const page = await (await browser.newContext({ ...options, colorScheme })).newPage();
    page.on("console", (m) => { if (m.type() === "error") faults.push(m.text()); });
    page.on("pageerror", (e) => faults.push(e.stack));
    await page.goto(address);
    await page.getByLabel("I have read this and agree to take part.").check();
    await page.getByRole("button", { name: "Continue" }).click();
    await page.getByRole("heading", { name: "Check your display" }).waitFor();
    if (screen === "pair") {
      await page.getByRole("button", { name: "Continue" }).click();
      await page.locator("#pause").waitFor();
      await page.locator("#go-on").click();
      await page.locator("figure[data-side=reference] img:not([data-waits])").waitFor();
      if (options === PHONE) await page.getByRole("button", { name: "B", exact: true }).click();
    }
    await page.evaluate(() => {
      if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
      scrollTo(0, 0);
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
