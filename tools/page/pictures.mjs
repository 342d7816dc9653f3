// What the pictures of a page in the documentation share: `SMALTI FOLDER …` make them with a server of the command, in light and dark colours, on a wide window and on a phone.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";

const [smalti, folder, ...more] = process.argv.slice(2).map((p) => resolve(p));
// The other arguments.
export const rest = more;
const WIDE = { viewport: { width: 1440, height: 900 } };
const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };

// Makes each picture `[name, device, colours, what]` of the page that `smalti args` serves, after `prepare(page, what, isPhone)`.
export async function pictures(args, all, prepare) {
  const server = spawn(smalti, [...args, "--json", "--quiet"], { stdio: ["ignore", "pipe", "inherit"] });
  const [line] = await once(server.stdout, "data");
  const { address } = JSON.parse(line);
  const browser = await launch();
  const faults = [];
  try {
    for (const [name, device, colorScheme, what] of all) {
      const isPhone = device === "phone";
      const page = await (await browser.newContext({ ...isPhone ? PHONE : WIDE, colorScheme })).newPage();
      page.on("console", (m) => { if (m.type() === "error") faults.push(m.text()); });
      page.on("pageerror", (e) => faults.push(e.stack));
      await page.goto(address);
      await prepare(page, what, isPhone);
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
}
