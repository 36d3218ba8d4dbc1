// Opens a study's page in headless Chromium, operates it as a user does and writes what it saw.
// usage: node test/page.mjs INDEX.html RESULT.json [SCREENSHOT.png]     (run where node_modules is)
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [page_file, result_file, screenshot] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.METROLUX_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu"],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 1000 } });
const problems = [];
page.on("pageerror", (error) => problems.push(`error: ${error.message}`));
page.on("console", (message) => message.type() === "error" && problems.push(`console: ${message.text()}`));
page.on("request", (request) => {
  if (!/^(file|data|blob):/.test(request.url())) problems.push(`request: ${request.url()}`);
});

await page.goto(pathToFileURL(page_file).href);
await page.waitForSelector("html[data-ready=true]", { timeout: 60000 });
const study = JSON.parse(await page.textContent("#study"));
const labels = study.entrants.filter((e) => e.runs.length > 0).map((e) => e.label);
const stage = await page.locator("#stage").boundingBox();
const { width, height } = study.scene.window;

const tag = (side) => page.textContent(`#tag-${side}`);
// Color of the stage at a share of its size, as shown.
const shown = (x, y) =>
  page.evaluate(
    ([u, v]) => {
      const canvas = document.getElementById("canvas");
      return [...canvas.getContext("2d").getImageData(u * canvas.width, v * canvas.height, 1, 1).data];
    },
    [x, y],
  );
const snapshot = () => page.evaluate(() => document.getElementById("canvas").toDataURL());
// The numbers of an image below the pointer when it is at the middle of a pixel; the view fits the stage.
async function valueAt(name, x, y) {
  const scale = Math.min(stage.width / width, stage.height / height);
  const left = stage.x + (stage.width - width * scale) / 2;
  const top = stage.y + (stage.height - height * scale) / 2;
  await page.mouse.move(left + (x + 0.5) * scale, top + (y + 0.5) * scale);
  assert.equal(await page.textContent("#readout .place"), `x ${x}  y ${y}`);
  const row = page.locator(`#readout .pixel[data-name="${name}"]`);
  return Promise.all(["r", "g", "b"].map((channel) => row.locator(`.${channel}`).textContent()));
}

// Flip: digits choose the left image, Shift and a digit the right one.
await page.locator("#stage").focus();
assert.equal(await tag("left"), labels[0]);
assert.equal(await tag("right"), "reference");
const first = await snapshot();
await page.keyboard.press("Digit2");
assert.equal(await tag("left"), labels[1]);
assert.notEqual(await snapshot(), first, "another image looks different");
await page.keyboard.press("Shift+Digit1");
assert.equal(await tag("right"), labels[0]);
await page.keyboard.press("Digit1");
await page.keyboard.press("Shift+Digit0");
assert.equal(await snapshot(), first, "and back");

// Values under the pointer.
const pixels = [];
for (const [digit, image] of [[0, "reference"], [1, labels[0]], [2, labels[1]]]) {
  await page.keyboard.press(`Digit${digit}`);
  for (const [x, y] of [[0, 0], [width >> 1, height >> 1], [width - 1, height - 1]])
    pixels.push({ image, x, y, rgb: await valueAt(image, x, y) });
}

// Wipe: a drag moves the dividing line, W takes it away.
await page.keyboard.press("Digit1");
const beyond = await shown(0.45, 0.5);
await page.mouse.move(stage.x + 0.5 * stage.width, stage.y + 0.5 * stage.height);
await page.mouse.down();
await page.mouse.move(stage.x + 0.2 * stage.width, stage.y + 0.5 * stage.height, { steps: 4 });
await page.mouse.up();
const divider = await page.locator("#divider").boundingBox();
assert.ok(Math.abs(divider.x - stage.x - 0.2 * stage.width) < 2, "the line is where it was dragged to");
const right = await shown(0.45, 0.5);
await page.keyboard.press("Digit0");
await page.keyboard.press("KeyW");
assert.deepEqual(await shown(0.45, 0.5), right, "right of the line is the reference");
await page.keyboard.press("Digit1");
assert.deepEqual(await shown(0.45, 0.5), beyond, "without wipe the left image is everywhere");
await page.keyboard.press("KeyW");
assert.equal(await page.locator("#divider").isVisible(), true);

// Zoom at the pointer keeps what is below it, and shows pixels as squares.
await page.mouse.move(stage.x + 0.75 * stage.width, stage.y + 0.4 * stage.height);
const place = await page.textContent("#readout .place");
for (let i = 0; i < 4; ++i) await page.mouse.wheel(0, -240);
await page.waitForFunction((before) => document.getElementById("zoom").textContent !== before, first && "1\u00d7");
await page.mouse.move(stage.x + 0.75 * stage.width + 1, stage.y + 0.4 * stage.height);
assert.equal(await page.textContent("#readout .place"), place);
const colors = await page.evaluate(() => {
  const canvas = document.getElementById("canvas");
  const row = canvas.getContext("2d").getImageData(0.6 * canvas.width, 0.5 * canvas.height, 200, 1).data;
  return new Set(Array.from({ length: 200 }, (_, i) => row.slice(4 * i, 4 * i + 3).join())).size;
});
assert.ok(colors <= 4, `200 screen pixels show ${colors} colors: nearest neighbor`);
await page.keyboard.press("KeyF");

// Exposure and false color change what is shown; the scale is there for the errors only.
const normal = await snapshot();
await page.keyboard.press("BracketRight");
assert.equal(await page.textContent("#exposure-value"), "+0.5");
assert.notEqual(await snapshot(), normal);
await page.keyboard.press("BracketLeft");
assert.equal(await snapshot(), normal);
assert.equal(await page.locator("#scale").isVisible(), false);
await page.keyboard.press("KeyE");
assert.equal(await page.locator("#scale").isVisible(), true);
assert.deepEqual((await shown(0.9, 0.5)).slice(0, 3), [0, 0, 0], "the reference has no error");
await page.keyboard.press("KeyE");

// Curves and table.
assert.ok((await page.locator("#chart canvas").count()) > 0);
const curve = () => page.evaluate(() => document.querySelector("#chart canvas").toDataURL());
const relMse = await curve();
await page.click('#metric button[data-key="bias"]');
assert.notEqual(await curve(), relMse);
await page.click('#metric button[data-key="rel_mse"]');
assert.equal(await page.locator("#table tbody tr").count(), study.entrants.length);
for (const [column, metric] of ["rel_mse", "trimmed_rel_mse", "mse", "smape", "bias"].entries()) {
  const winner = page.locator(`#table tbody tr:has(td:nth-child(${column + 2})[data-best]) th`);
  assert.equal(await winner.textContent(), study.winners[metric].entrant);
}

if (screenshot) {
  await page.screenshot({ path: screenshot, fullPage: true });
  await page.emulateMedia({ colorScheme: "dark" });
  await page.screenshot({ path: screenshot.replace(/\.png$/, "-dark.png"), fullPage: true });
}
await browser.close();
assert.deepEqual(problems, []);
await writeFile(result_file, JSON.stringify({ pixels }, null, 2));
