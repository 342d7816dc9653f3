// The pictures of pages in the documentation:
//   smalti sweep table2 -o out && smalti report out && node tools/page/screenshot.mjs out/report/report.html docs/images/report-sweep.png
//   smalti compare bayer rgbw && node tools/page/screenshot.mjs out/report.html docs/images/report-compare.png
import { resolve } from "node:path";
import { launch, open } from "./browser.mjs";

const [file, picture] = process.argv.slice(2).map((p) => resolve(p));
const browser = await launch();
const { page, faults } = await open(browser, file, { viewport: { width: 1500, height: 1130 }, colorScheme: "light" });
const plot = page.getByRole("application");
// Of a study, with designs selected.
if (await plot.count() > 0) {
  const box = await plot.boundingBox();
  const at = (x, y) => [box.x + x * box.width, box.y + y * box.height];
  await page.mouse.move(...at(0.36, 0.62));
  await page.mouse.down();
  await page.mouse.move(...at(0.72, 0.87), { steps: 5 });
  await page.mouse.up();
  await page.mouse.move(5, 5);
}
await page.screenshot({ path: picture });
await browser.close();
if (faults.length > 0) throw new Error(faults.join("\n"));
