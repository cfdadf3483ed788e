// Pictures of the page: node pictures.mjs BROWSER ADDRESS FOLDER
import { join } from "node:path";
import { DESKTOP, PHONE, address, launch, open, rest, slide } from "./browser.mjs";

const [folder] = rest;
const browser = await launch();
const shots = {
  "web-desktop.png": { ...DESKTOP },
  "web-dark.png": { ...DESKTOP, colorScheme: "dark" },
  "web-phone.png": { ...PHONE },
  "web-design.png": { ...DESKTOP },
};
for (const [name, options] of Object.entries(shots)) {
  const { page, context } = await open(browser, options);
  if (name.includes("dark")) {
    await page.selectOption("#scene", "doppler");
    await slide(page, "second_db", -6);
    await page.selectOption("#tones-most", "4");
  }
  if (name.includes("design")) {
    await page.keyboard.press("5");
    await page.waitForSelector("#design-table tbody tr");
  }
  // The waterfall and the histories fill.
  await page.waitForTimeout(name.includes("design") ? 500 : 11_000);
  await page.screenshot({ path: join(folder, name) });
  console.log(name);
  await context.close();
}
await browser.close();
