// Opens pages of machines and of nights in a browser from file:// and uses them: node page_test.js PLAYWRIGHT_FOLDER PICTURE_FOLDER PAGE...
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

/** Sorts by the column "same state", and leaves the rows that hold `word`. */
async function sortAndFilter(page, word) {
  const rows = () => page.locator("#table tbody tr");
  const all = await rows().count();
  assert(all > 0, "the table has rows");
  const column = 1 + (await page.locator("#table thead th").allTextContents()).indexOf("same state");
  const digits = async () => (await page.locator(`#table tbody tr td:nth-child(${column})`).allTextContents()).filter((s) => s !== "-").map(Number);
  await page.click(`#table thead th:nth-child(${column}) button`);
  const up = await digits();
  assert.deepStrictEqual(up, [...up].sort((a, b) => a - b), "sorted upwards");
  await page.click(`#table thead th:nth-child(${column}) button`);
  const down = await digits();
  assert.deepStrictEqual(down, [...down].sort((a, b) => b - a), "sorted downwards");
  assert(down.length < 2 || down[0] > down[down.length - 1], "there was something to sort");
  assert.strictEqual(await page.getAttribute(`#table thead th:nth-child(${column})`, "aria-sort"), "descending");
  await page.fill("#filter", word);
  const some = await rows().count();
  assert(some > 0 && some < all, "the filter leaves some rows");
  await page.fill("#filter", "");
  await page.check("#only-red");
  const red = await rows().count();
  assert(red === 0 || await page.locator("#sentence.differ").count() === 1, "no red row where the verdict is not red");
  await page.uncheck("#only-red");
  assert.strictEqual(await rows().count(), all);
}

/** No line leaves the picture. */
async function fits(page) {
  const marks = await page.evaluate(() => {
    const shown = document.getElementById("scene");
    const { width, height } = shown;
    const pen = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
    pen.drawImage(shown, 0, 0);
    const read = (...box) => pen.getImageData(...box).data.filter((_, k) => k % 4 === 3).filter(Boolean).length;
    return read(0, 0, width, 1) + read(0, height - 1, width, 1) + read(0, 0, 1, height) + read(width - 1, 0, 1, height);
  });
  assert.strictEqual(marks, 0, "the machine stands within the picture");
}

/** The slider-crank of the paper moves in the plane across z: it is looked at from there, its links drawn as what they are. */
async function drawsThePaper(page) {
  const { normal, shapes, travel } = await page.evaluate(() => {
    const { machine, runs } = JSON.parse(document.getElementById("data").textContent).machines[0];
    const shown = new concord.Picture(machine, new concord.Poses(runs.frames, runs.frames.runs[0]));
    const slide = machine.joints.findIndex((joint) => joint.type === "translational");
    return { normal: shown.normal(), shapes: machine.bodies.map((body, i) => [body.name, shown.shapes[i]]), travel: shown.travels[slide] };
  });
  assert(Math.abs(Math.abs(normal[2]) - 1) < 1e-6, "the camera faces the plane of motion");
  const shape = Object.fromEntries(shapes);
  assert.strictEqual(shape.crank.points.length, 2, "a crank is a rod between its two pins");
  assert(Object.values(shape).some((one) => one && one.beam), "a flexible rod is drawn along its nodes");
  assert(travel.most > travel.least, "a slide has a guide as long as its way");
  assert.match(await text(page, "#provenance"), /^Model .*slider_crank_flexible\.toml \(FNV-1a [0-9a-f]{16}\), judged by concord .*, rtol 1e-9, until 0\.1 s, seed \d+$/);
}

/** Who is to blame, and the rows against the reference. */
async function explains(page) {
  assert.match(await text(page, "#blame"), /To blame: neither solver, but the statement, at joint hinge/);
  const rows = page.locator("#explanations table tbody tr");
  assert.strictEqual(await rows.count(), 1, "one column of the reference");
  assert.match(await rows.first().textContent(), /hinge on pendulum.*F_x.*wrong/);
  assert.strictEqual(await page.locator(".note", { hasText: "to blame" }).count(), 0, "said once");
  assert.match(await text(page, "#about-plots"), /Rings: the reference\./);
  assert.match(await text(page, "#charts"), /F_x/);
  assert.strictEqual(await page.locator("#side option:checked").textContent(), "pendulum", "the side that differs is shown");
}

/** The printed tables: forces of each joint and side, the pose at the start; and what energy drifts. */
async function tells(page, name) {
  const heads = await page.locator("#told thead tr").allTextContents();
  assert(heads.some((head) => head.startsWith("jointonpeak F [N]at t [s]peak T [N m]")), `no table of forces: ${heads}`);
  assert(heads.some((head) => head.startsWith("jointcoordinateat the start")), `no pose at the start: ${heads}`);
  assert.match(await text(page, "#solver-table"), /energy drift.* J at t = .* s, allowed .* J/);
  const told = await page.locator("#told p", { hasText: "wrenches in the axes of body crank" }).count();
  assert.strictEqual(told, name === "axes" ? 1 : 0, "axes that are not those of the sides are told");
  if (name !== "agrees") return;
  assert.strictEqual(await page.locator("#told table").first().locator("tbody tr").count(), 8, "a row for each joint and side");
  assert.match(heads[1], /^forcealongpeak/);
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

/** A night: what changed, by its kinds; the chosen case with its words, trend and steps; by mouse and by keys. */
async function useNight(page) {
  await sortAndFilter(page, await text(page, "#table tbody tr td"));
  const changes = () => page.locator("#changes tbody tr").count();
  const all = await changes();
  for (const kind of await page.locator("#turns button").allTextContents()) {
    const [count, ...what] = kind.split(" ");
    await page.click(`#turns button:text-is("${kind}")`);
    assert.strictEqual(await changes(), Number(count), `all that is ${what.join(" ")}`);
    const said = new Set(await page.locator("#changes tbody tr td:first-child").allTextContents());
    assert.deepStrictEqual([...said], [what.join(" ")]);
    await page.click(`#turns button:text-is("${kind}")`);
  }
  assert.strictEqual(await changes(), all);
  await page.focus("#table tbody tr");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  const second = await text(page, "#table tbody tr:nth-child(2) td");
  assert.strictEqual(await text(page, "#case-name"), second, "keys choose a case");
  assert.strictEqual(await page.evaluate(() => document.activeElement.id), "case-name", "and lead to it");
  await page.locator("#table tbody tr", { hasText: "<img src=x" }).first().click();
  assert((await text(page, "#case-name")).startsWith("<img src=x"), "a name is text");
  await page.waitForTimeout(700);  // it scrolls there
  const over = page.locator(".u-over").first();
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  await page.mouse.move(box.x + 0.3 * box.width, box.y + box.height / 2);
  const first = await text(page, ".chart .values");
  await page.mouse.move(box.x + 0.9 * box.width, box.y + box.height / 2);
  const last = await text(page, ".chart .values");
  assert(/^night \d+, \d{4}-\d\d-\d\d, \S+: \w/.test(last), `the cursor tells the night, not ${last}`);
  const nights = await page.locator("#nights tbody tr").count();
  assert(nights < 2 || first !== last, "and another one elsewhere");
}

/** A comparison that does not agree has a page of its own beside the night's; what agrees has none. */
async function leadsToItsPage(page) {
  const choose = async (name) => {
    await page.fill("#filter", name);
    await page.locator("#table tbody tr").first().click();
    await page.fill("#filter", "");
  };
  await choose("steady");
  assert(!(await page.locator("#case-page").isVisible()), "what agrees has no page");
  await choose("unknown");
  await page.click("#case-page");
  await page.waitForLoadState();
  assert.match(await text(page, "#sentence"), /There is no verdict on /);
  await page.goBack();
}

/** What the nights of make_history.py hold. */
async function readStories(page) {
  const since = await text(page, "#messages li");
  assert(/^Since the night before \(night 99, .*\): 4 of 60 cases changed .*: machine_03, machine_04, machine_05, machine_06\.$/.test(since), since);
  const choose = async (name) => {
    await page.fill("#filter", name);
    await page.locator("#table tbody tr").first().click();
  };
  await choose("machine_03");
  assert((await text(page, "#case-words")).includes("last words: stage: same run\nt = 0.417 s: <b>the loop</b>"), "last words");
  await choose("machine_05");
  assert((await text(page, "#case-words")).includes("to blame: relative, at joint D"), "who is to blame");
  await choose("machine_07");
  const steps = await page.locator("#case-steps li").allTextContents();
  assert.strictEqual(steps.length, 3);
  assert(steps.every((step) => /worse in night 61: joint A on crank, F_x and 1 more, .*; commit \w+ before, \w+ after$/.test(step)), steps[0]);
  const [, before, after] = steps[0].match(/commit (\w+) before, (\w+) after$/);
  assert.notStrictEqual(before, after);
  await page.click("summary");
  assert.strictEqual(await page.locator("#nights tbody tr").count(), 100);
  await page.locator("#nights tbody tr").nth(39).click();
  assert((await text(page, ".chart .values")).startsWith("night 61, "), "a line of the table is a place in the plots");
  await page.click("summary");
  await page.fill("#filter", "");
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
  const shows = await page.locator("#picture").isVisible();
  assert(!(name === "refused" && shows), "no empty picture where there is no machine");
  if (shows) {
    await fits(page);
    await tells(page, name);
    await sortAndFilter(page, "F_x");
    await hover(page);
    await play(page);
    await orbit(page);
  }
  if (await page.locator("#turns").count() > 0) await useNight(page);
  if (name === "night") await leadsToItsPage(page);
  if (name === "nights") await readStories(page);
  if (name === "differs") await explains(page);
  if (name === "agrees") await drawsThePaper(page);
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
  assert(!(await page.locator(".row:visible, header button:visible").count()), "no buttons on paper");
  const isNight = await page.locator("#turns").count() > 0;
  await page.setViewportSize({ width: isNight ? 1020 : 700, height: 1000 });  // a sheet of A4 between its margins
  await page.waitForTimeout(150);
  const cutOff = await page.evaluate(() => [...document.querySelectorAll("td, th")].filter((cell) => cell.getBoundingClientRect().right > document.documentElement.clientWidth).length);
  assert.strictEqual(cutOff, 0, "no column of a table is cut off on paper");
  if (await page.locator(".chart canvas").count() > 0 && await page.locator("#owner").count() > 0) {
    assert(/^(joint|element) .+ on .+$/.test(await page.locator("#plotted:visible").innerText()), "curves on paper say whose they are");
  }
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
