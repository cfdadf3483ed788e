// A browser without a window.
import { chromium } from "playwright-core";

const [executablePath, address, ...rest] = process.argv.slice(2);
export { address, rest };

export const DESKTOP = { viewport: { width: 1440, height: 920 }, deviceScaleFactor: 1 };
export const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };

const QUIET = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream",
];

// A browser that hangs is ended.
setTimeout(() => { console.error("no end in four minutes"); process.exit(1); }, 240_000).unref();

export const launch = () => chromium.launch({ executablePath, args: QUIET });

/** Opens the page; `errors` gathers what its console complains of. */
export async function open(browser, options = DESKTOP, prepare = async () => {}) {
  const context = await browser.newContext({ acceptDownloads: true, ...options });
  // A machine with other work draws few frames a second.
  context.setDefaultTimeout(60_000);
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(String(error.stack ?? error)));
  await prepare(page);
  await page.goto(address);
  await page.waitForSelector("#figures .value");
  return { page, errors, context };
}

/** A slider or field to a value, as a person leaves it. */
export const slide = (page, name, value) => page.locator(`#${name}`).evaluate((input, to) => {
  input.value = to;
  input.dispatchEvent(new Event("input", { bubbles: true }));
  input.dispatchEvent(new Event("change", { bubbles: true }));
}, String(value));
