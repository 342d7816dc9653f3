// Makes the pictures of the studio in the documentation for tools/make_pictures.py: `SMALTI FOLDER`. Each shows what RGBW changes against the
// pinned Bayer mosaic.
import { pictures } from "./pictures.mjs";
import { settled, startFrom } from "./studio.mjs";

await pictures(["studio", "bayer"], [
  ["studio", "wide", "light", "one"], ["studio-dark", "wide", "dark", "split"], ["studio-phone", "phone", "light", "split"], ["studio-phone-dark", "phone", "dark", "map"],
], async (page, view) => {
  await settled(page);
  await startFrom(page, "rgbw");
  await page.getByLabel("Name of the design").fill("rgbw");
  await page.getByLabel("Name of the design").press("Enter");
  if (view === "split") await page.getByLabel("Against").selectOption("pin");
  if (view === "map") await page.getByRole("button", { name: "Difference" }).click();
  // The curves of both designs, which follow the picture.
  await page.locator("#light-curve svg .pinned:not(.clips)").waitFor({ timeout: 60_000 });
  await settled(page);
});
