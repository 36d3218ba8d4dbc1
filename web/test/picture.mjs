// The picture of docs/how-to/watch-a-render.md: two integrators side by side, after some seconds.
// usage: node test/picture.mjs URL OUTPUT.jpg SECONDS     (run where node_modules is)
import { chromium } from "playwright-core";

const [url, output, seconds] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.METROLUX_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu"],
});
const page = await browser.newPage({ viewport: { width: 1200, height: 720 } });
await page.goto(url);
await page.waitForSelector("html[data-pictures]");
await page.selectOption("#compare", "path");
await page.mouse.move(640, 380);
await page.waitForTimeout(1000 * Number(seconds));
await page.screenshot({ path: output, type: "jpeg", quality: 88 });
await browser.close();
