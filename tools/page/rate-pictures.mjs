// Makes the pictures of the rating page in the documentation for tools/make_pictures.py: `SMALTI FOLDER EXPERIMENT`. They show a pair and the display
// check. The answers of these sessions go to EXPERIMENT.
import { pictures, rest } from "./pictures.mjs";

await pictures(["rate", "serve", ...rest], [
  ["rate", "wide", "light", "pair"], ["rate-dark", "wide", "dark", "display"], ["rate-phone", "phone", "light", "pair"], ["rate-phone-dark", "phone", "dark", "display"],
], async (page, screen, isPhone) => {
  await page.getByLabel("I have read this and agree to take part.").check();
  await page.getByRole("button", { name: "Continue" }).click();
  await page.getByRole("heading", { name: "Check your display" }).waitFor();
  if (screen !== "pair") return;
  await page.getByRole("button", { name: "Continue" }).click();
  await page.locator("#pause").waitFor();
  await page.locator("#go-on").click();
  await page.locator("figure[data-side=reference] img:not([data-waits])").waitFor();
  if (isPhone) await page.getByRole("button", { name: "B", exact: true }).click();
});
