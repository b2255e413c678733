// Opens report pages in a browser from file:// and uses them: node page_test.js PLAYWRIGHT_FOLDER PICTURE_FOLDER PAGE...
"use strict";
const assert = require("node:assert");
const path = require("node:path");
const { chromium } = require(path.resolve(process.argv[2]));
const pictures = path.resolve(process.argv[3]);
const pages = process.argv.slice(4).map((page) => path.resolve(page));
const flags = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];

/** What the canvas shows. */
const picture = (page) => page.evaluate(() => document.getElementById("scene").toDataURL());
const text = (page, selector) => page.locator(selector).first().textContent();

async function sortAndFilter(page) {
  const rows = () => page.locator("#table tbody tr");
  const all = await rows().count();
  assert(all > 0, "the table has rows");
  const digits = async () => (await page.locator("#table tbody tr td:nth-child(6)").allTextContents()).filter((s) => s !== "-").map(Number);
  await page.click("#table thead th:nth-child(6) button");
  const up = await digits();
  assert.deepStrictEqual(up, [...up].sort((a, b) => a - b), "sorted upwards");
  await page.click("#table thead th:nth-child(6) button");
  const down = await digits();
  assert.deepStrictEqual(down, [...down].sort((a, b) => b - a), "sorted downwards");
  assert.strictEqual(await page.getAttribute("#table thead th:nth-child(6)", "aria-sort"), "descending");
  await page.fill("#filter", "F_x");
  const some = await rows().count();
  assert(some > 0 && some < all, "the filter leaves some rows");
  await page.fill("#filter", "");
  await page.check("#only-red");
  const red = await rows().count();
  assert(red === 0 || await page.locator("#sentence.differ").count() === 1, "no red row where the verdict is not red");
  await page.uncheck("#only-red");
  assert.strictEqual(await rows().count(), all);
}

async function play(page) {
  const at = () => text(page, "#now");
  const before = [await at(), await picture(page)];
  await page.selectOption("#speed", "4");
  await page.click("#play");
  await page.waitForTimeout(250);
  if (await text(page, "#play") === "Pause") await page.click("#play");
  assert.notStrictEqual(await at(), before[0], "time runs");
  assert.notStrictEqual(await picture(page), before[1], "the machine moves");
  await page.evaluate(() => { const time = document.getElementById("time"); time.value = "500"; time.dispatchEvent(new Event("input")); });
  const scrubbed = [await at(), await picture(page)];
  await page.focus("#scene");
  await page.keyboard.press(".");
  assert.notStrictEqual(await at(), scrubbed[0], "a key steps");
  await page.keyboard.press(",");
  assert.strictEqual(await at(), scrubbed[0], "and back");
}

async function orbit(page) {
  await page.locator("#scene").scrollIntoViewIfNeeded();
  const before = await picture(page);
  await page.focus("#scene");
  await page.keyboard.press("ArrowLeft");
  const turned = await picture(page);
  assert.notStrictEqual(turned, before, "a key turns the view");
  const box = await page.locator("#scene").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 40, box.y + box.height / 2 + 25, { steps: 4 });
  await page.mouse.up();
  const dragged = await picture(page);
  assert.notStrictEqual(dragged, turned, "the mouse turns the view");
  await page.mouse.wheel(0, 240);
  await page.waitForTimeout(50);
  assert.notStrictEqual(await picture(page), dragged, "the wheel zooms");
  await page.keyboard.press("Home");
}

async function hover(page) {
  const over = page.locator(".u-over").first();
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  await page.mouse.move(box.x + 0.3 * box.width, box.y + box.height / 2);
  const first = [await text(page, ".chart .values"), await text(page, "#now")];
  await page.mouse.move(box.x + 0.7 * box.width, box.y + box.height / 2);
  const second = [await text(page, ".chart .values"), await text(page, "#now")];
  assert(first[0].startsWith("t = ") && first[0] !== second[0], "the cursor tells values");
  assert.notStrictEqual(first[1], second[1], "the view follows the cursor");
}

async function tryPage(browser, file) {
  const troubles = [];
  const page = await browser.newPage({ viewport: { width: 1400, height: 1000 } });
  page.on("console", (message) => { if (message.type() !== "log") troubles.push(message.text()); });
  page.on("pageerror", (error) => troubles.push(error.stack));
  page.on("dialog", (dialog) => { troubles.push("a dialog opened: " + dialog.message()); dialog.dismiss(); });
  page.on("request", (request) => { if (!request.url().startsWith("file://")) troubles.push("it asked for " + request.url()); });
  await page.goto("file://" + file);
  await page.waitForFunction(() => performance.getEntriesByType("paint").length > 0);
  const paint = await page.evaluate(() => performance.getEntriesByType("paint")[0].startTime);
  const name = path.basename(file, ".html");
  assert((await text(page, "#sentence")).length > 20, "the verdict is a sentence");
  if (await page.locator("#picture").isVisible()) {
    await sortAndFilter(page);
    await hover(page);
    await play(page);
    await orbit(page);
  }
  await page.screenshot({ path: path.join(pictures, name + ".png"), fullPage: true });
  const light = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  await page.click("#theme");
  assert.notStrictEqual(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), light, "dark and light");
  await page.screenshot({ path: path.join(pictures, name + ".dark.png") });
  await page.setViewportSize({ width: 360, height: 740 });
  await page.waitForTimeout(150);
  assert(await page.evaluate(() => document.documentElement.scrollWidth) <= 362, "nothing overflows a narrow screen");
  await page.screenshot({ path: path.join(pictures, name + ".narrow.png"), fullPage: true });
  await page.emulateMedia({ media: "print" });
  assert(!(await page.locator("#play").isVisible()), "no buttons on paper");
  assert.deepStrictEqual(troubles, [], "no errors, no breach of the policy, no network");
  await page.close();
  console.log(`${name}: works; first paint after ${Math.round(paint)} ms`);
}

(async () => {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM || "/usr/bin/chromium", args: flags });
  try {
    for (const file of pages) await tryPage(browser, file);
  } finally {
    await browser.close();
  }
})().catch((error) => { console.error(error); process.exit(1); });
