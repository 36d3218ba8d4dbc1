// Opens the page of a running `metrolux view` in headless Chromium, operates it as a user does and writes what it saw.
// usage: node test/live.mjs URL RESULT.json [SCREENSHOT.png]     (run where node_modules is)
// The rendering has to end by --passes, so that the picture can be compared with a file.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { chromium } from "playwright-core";

const [url, result_file, screenshot] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.METROLUX_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu"],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
const problems = [];
page.on("pageerror", (error) => problems.push(`error: ${error.message}`));
page.on("console", (message) => message.type() === "error" && problems.push(`console: ${message.text()}`));
page.on("request", (request) => {
  if (!request.url().startsWith(new URL(url).origin) && !/^(data|blob):/.test(request.url()))
    problems.push(`request: ${request.url()}`);
});

const start = Date.now();
await page.goto(url);
await page.waitForSelector("html[data-pictures]");
const seconds_to_picture = (Date.now() - start) / 1000;

const state = () => page.evaluate(async () => (await fetch("state")).json());
const phase = (name) => page.waitForSelector(`body[data-phase=${name}]`, { timeout: 60000 });
const passes = async () => Number(await page.textContent('#sides dd[data-name="passes"]'));
const until = async (what, condition) => {
  for (let i = 0; i < 600; ++i) {
    if (await condition()) return;
    await page.waitForTimeout(50);
  }
  assert.fail(`waited in vain for ${what}`);
};
const snapshot = () => page.evaluate(() => document.getElementById("canvas").toDataURL());
const box = await page.locator("#stage").boundingBox();
const middle = [box.x + box.width / 2, box.y + box.height / 2];
async function drag(dx, dy, button = "left") {
  await page.mouse.move(...middle);
  await page.mouse.down({ button });
  await page.mouse.move(middle[0] + dx, middle[1] + dy, { steps: 6 });
  await page.mouse.up({ button });
}

// It ends by itself; what it then shows is the file's picture, to the last digit.
await phase("done");
const { resolution, sides } = await state();
await until("the last picture", async () => (await page.evaluate(() => Number(document.documentElement.dataset.pictures))) > 0);
const pixels = [];
for (const [x, y] of [[0, 0], [resolution[0] >> 1, resolution[1] >> 1], [resolution[0] - 1, resolution[1] - 1], [3, 7]]) {
  const zoom = Math.min(box.width / resolution[0], box.height / resolution[1]) * 0.97;
  const at = [middle[0] + (x + 0.5 - resolution[0] / 2) * zoom, middle[1] + (y + 0.5 - resolution[1] / 2) * zoom];
  await page.mouse.move(at[0] + 1, at[1]);
  await page.mouse.move(...at);
  await page.waitForSelector(`#readout[data-x="${x}"][data-y="${y}"][data-passes="${sides[0].passes}"]`);
  pixels.push({ x, y, values: JSON.parse(await page.getAttribute("#readout", "data-values")) });
}

// Display: exposure, curve, layers.
const plain = await snapshot();
await page.keyboard.press("BracketRight");
await until("another exposure", async () => (await snapshot()) !== plain);
assert.equal(await page.textContent("#exposure-value"), "+0.5");
await page.keyboard.press("BracketLeft");
await until("the exposure of before", async () => (await snapshot()) === plain);
await page.selectOption("#curve", "filmic");
await until("another curve", async () => (await snapshot()) !== plain);
await page.selectOption("#curve", "srgb");
for (const layer of ["error", "variance", "albedo", "normal", "depth"]) {
  await page.selectOption("#layer", layer);
  await until(`the layer ${layer}`, async () => (await snapshot()) !== plain);
  assert.equal(await page.locator("#scale").isVisible(), layer === "error");
}
await page.selectOption("#layer", "color");
await until("the image", async () => (await snapshot()) === plain);

// Zoom and pan.
await page.locator("#stage").focus();
await page.mouse.move(...middle);
const zoom = await page.textContent("#zoom-value");
await page.mouse.wheel(0, -480);
await until("zoom", async () => (await page.textContent("#zoom-value")) !== zoom);
const zoomed = await snapshot();
await drag(60, 40);
await until("pan", async () => (await snapshot()) !== zoomed);
await page.keyboard.press("f");
await until("fit", async () => (await snapshot()) === plain);

// The camera: the next picture is there in less than a second, and of another view.
const before = await state();
await page.click("#hand-camera");
await page.evaluate(() => {
  window.turned = 0;
  const old = document.documentElement.dataset.pictures;
  new MutationObserver(() => {
    if (!window.turned && document.documentElement.dataset.pictures !== old) window.turned = performance.now();
  }).observe(document.documentElement, { attributes: true });
});
await page.mouse.move(...middle);
await page.mouse.down();
const began = await page.evaluate(() => performance.now());
await page.mouse.move(middle[0] + 90, middle[1] + 30);
await page.mouse.up();
await until("a picture of the new camera", () => page.evaluate(() => window.turned));
const seconds_to_turn = ((await page.evaluate(() => window.turned)) - began) / 1000;
const after = await state();
assert.notDeepEqual(after.camera, before.camera);
assert.ok(after.sides[0].generation > before.sides[0].generation);
await page.mouse.move(...middle);
await page.mouse.wheel(0, -200);
await until("dolly", async () => (await state()).camera.join() !== after.camera.join());
const dollied = await state();
await drag(40, 0, "right");
await until("pan of the camera", async () => (await state()).camera.join() !== dollied.camera.join());
await page.click("#reset-camera");
await until("the camera of the scene", async () => (await state()).camera.join() === before.camera.join());

// Another integrator, which has no limit that is near: pause, go on, stop.
await page.selectOption("#integrator", "bdpt");
await until("another integrator", async () => (await state()).sides[0].integrator === "bdpt");
await page.click("#hand-crop");
await drag(box.width / 8, box.height / 8);
await until("a crop", async () => (await state()).window[2] < resolution[0]);
await page.click("#full");
await until("the full image", async () => (await state()).window[2] === resolution[0]);
await page.click("#hand-look");

// Two side by side.
await page.selectOption("#compare", "path");
await until("another side", async () => (await state()).sides.length === 2);
await until("both labels", async () => (await page.locator("#labels span").count()) === 2);
assert.equal(await page.locator("#share").isVisible(), true);
await until("a picture on the right", async () => (await state()).sides[1].passes > 1);
if (screenshot) await page.screenshot({ path: screenshot.replace(/\.png$/, "-two.png") });
await page.selectOption("#compare", "");
await until("one side", async () => (await state()).sides.length === 1);

// Pause, go on, stop.
await page.keyboard.press("r");
await until("passes again", async () => (await state()).phase === "rendering" && (await passes()) > 0);
await page.click("#pause");
await phase("paused");
const held = (await state()).sides[0].passes;
await page.waitForTimeout(400);
assert.equal((await state()).sides[0].passes, held, "a pause is one");
await page.click("#stop");
await phase("stopped");
assert.equal(await page.isDisabled("#stop"), true);
await page.click("#pause");
await until("it goes on", async () => (await state()).sides[0].passes > held);

// Saving tells what was written.
await page.click("#save");
await page.waitForSelector("#message:not([hidden])");
await until("the message", async () => (await page.textContent("#message")).includes("wrote"));
const message = await page.textContent("#message");

if (screenshot) await page.screenshot({ path: screenshot });
await browser.close();
assert.deepEqual(problems, []);
await writeFile(result_file, JSON.stringify({ pixels, seconds_to_picture, seconds_to_turn, message }, null, 2));
