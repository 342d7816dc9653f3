// Makes the pictures of pages in the documentation for tools/make_pictures.py: `FILE PICTURE [light|dark] [WHAT]`. WHAT is `whole` (all designs of
// a study without a selection), `design` (the best design of five colours alone), or the name of a map.
import { resolve } from "node:path";
import { launch, open } from "./browser.mjs";

const [file, picture] = process.argv.slice(2, 4).map((p) => resolve(p));
const [colorScheme = "light", what] = process.argv.slice(4);
const browser = await launch();
const { page, faults } = await open(browser, file, { viewport: { width: 1500, height: 1130 }, colorScheme });
const plot = page.locator(".scatter [role=application]");
const at = (box, x, y) => [box.x + x * box.width, box.y + y * box.height];
if (what === "design") {
  await page.setViewportSize({ width: 760, height: 1130 });
  await page.locator("#best tbody tr", { has: page.locator("td", { hasText: /^5$/ }) }).first().getByRole("button").dispatchEvent("click");
  await page.locator(".pictures canvas[data-drawn]").nth(1).waitFor();
  // The command at the end of the page names a folder of this machine.
  await page.locator("section.design h4").last().evaluate((heading) => {
    heading.nextElementSibling.remove();
    heading.remove();
  });
} else if (await plot.count() > 0) {
  // The page of a study, with a selection of designs.
  if (what !== "whole") {
    const box = await plot.boundingBox();
    await page.mouse.move(...at(box, 0.36, 0.62));
    await page.mouse.down();
    await page.mouse.move(...at(box, 0.72, 0.87), { steps: 5 });
    await page.mouse.up();
    await page.mouse.move(5, 5);
  }
} else if (what) {
  // A table at the highest luminance, with the values under the cursor.
  await page.getByLabel("Scene").selectOption("natural-table");
  await page.getByLabel("Luminance").press("End");
  await page.getByLabel("Show").selectOption(what);
  await page.mouse.move(...at(await page.locator(".frame").last().boundingBox(), 0.4, 0.5));
  await page.waitForTimeout(300);
}
const part = what && what !== "whole" && page.locator(what === "design" ? "section.design" : "section#pictures");
await (part || page).screenshot({ path: picture });
await browser.close();
if (faults.length > 0) throw new Error(faults.join("\n"));
