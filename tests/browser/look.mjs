// Looks at the report of every verb: `node look.mjs FOLDER [--pictures]`, FOLDER with one results folder for each.

import assert from "node:assert/strict";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const folder = resolve(process.argv[2]);
const screens = resolve(import.meta.dirname, "../../docs/src/screens");
const withPictures = process.argv.includes("--pictures");

/** Bytes of a page, s until it is loaded and drawn, and CSS pixels of a phone. */
const MOST_BYTES = 3e6;
const MOST_SECONDS = 1;
const PHONE = { width: 420, height: 860 };
const DESK = { width: 1280, height: 900 };
/** A4 within margins of a centimetre. */
const PAPER = { width: 718, height: 1046 };
const PICTURE = { width: 1000, height: 700 };

if (withPictures) mkdirSync(screens, { recursive: true });
const profile = mkdtempSync(join(tmpdir(), "exid-browser-"));
const browser = await chromium.launchPersistentContext(profile, {
  executablePath: process.env.CHROMIUM,
  headless: true,
  viewport: DESK,
  args: [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
  ],
});

/** A page of the browser that has opened the report, and what it complained of. */
async function open(file, { viewport = DESK, colorScheme = "light" } = {}) {
  const page = await browser.newPage();
  const complaints = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  page.on("pageerror", error => complaints.push(String(error)));
  page.on("request", request => request.url().startsWith("file:") || complaints.push(`loads ${request.url()}`));
  await page.setViewportSize(viewport);
  await page.emulateMedia({ colorScheme });
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector("html.alive", { timeout: 10_000 });
  return { page, complaints };
}

/** s from the start of loading until the script has drawn everything: the least of three, since whatever else runs here only adds to it. */
async function seconds(page) {
  const times = [];
  for (let k = 0; k < 3; k++) {
    if (k > 0) await page.reload();
    await page.waitForSelector("html.alive");
    times.push(await page.evaluate(() => performance.getEntriesByName("drawn")[0].startTime / 1000));
  }
  return Math.min(...times);
}

const overflow = page => page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);

/** Widths of the time axes of all linked charts, s. */
const spans = page =>
  page.evaluate(() => [...document.querySelectorAll("#explorer .charts .uplot")].map(box => box.dataset.span).map(Number));

async function zooms(page) {
  const chart = page.locator("#explorer .charts .u-over").first();
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  const before = await spans(page);
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 40);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 40, { steps: 5 });
  await page.mouse.up();
  const after = await spans(page);
  assert.ok(before.length > 1, "several charts are linked");
  after.forEach((span, k) => assert.ok(Math.abs(span / before[k] - 0.2) < 0.03, `chart ${k} shows ${span} s of ${before[k]} s`));
  await page.mouse.dblclick(box.x + 0.5 * box.width, box.y + 40);
  const whole = await spans(page);
  whole.forEach((span, k) => assert.ok(Math.abs(span / before[k] - 1) < 1e-6, "a double click shows all again"));
  await page.locator("#explorer .charts").focus();
  await page.keyboard.press("+");
  const keyed = await spans(page);
  keyed.forEach((span, k) => assert.ok(Math.abs(span / before[k] - 0.5) < 1e-6, "the plus key halves the stretch"));
  await page.keyboard.press("0");
}

/** Without a script there are still pictures in the place of charts. */
async function still(file) {
  const page = await browser.newPage();
  const session = await browser.newCDPSession(page);
  await session.send("Emulation.setScriptExecutionDisabled", { value: true });
  await page.goto(pathToFileURL(file).href);
  const [charts, pictures] = [await page.locator("#explorer").count(), await page.locator("noscript svg").count()];
  assert.ok(charts === 0 || pictures > 0 || file.includes("simulate"), "still pictures without a script");
  assert.ok((await page.locator("section").count()) > 1, "sections without a script");
  await page.close();
}

async function sorts(page) {
  const head = page.locator("#parameters th button").nth(1);
  if ((await head.count()) === 0) return;
  const values = () =>
    page.evaluate(() => [...document.querySelectorAll("#parameters tbody tr")].map(row => Number.parseFloat(row.cells[1].textContent)));
  await head.click();
  const sorted = (await values()).filter(Number.isFinite);
  assert.ok(sorted.length > 2 && sorted.every((value, k) => k === 0 || value >= sorted[k - 1]), "a click on a head sorts");
  await head.click();
  await head.click();
}

/** Text on its ground: WCAG 2.2 asks for a contrast of 4.5. */
const pale = page =>
  page.evaluate(() => {
    const channel = c => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    const light = ([r, g, b]) => 0.2126 * channel(r / 255) + 0.7152 * channel(g / 255) + 0.0722 * channel(b / 255);
    const parse = colour => colour.match(/[\d.]+/g).map(Number);
    const ground = element => {
      for (let at = element; at; at = at.parentElement) {
        const [r, g, b, a = 1] = parse(getComputedStyle(at).backgroundColor);
        if (a > 0.99) return [r, g, b];
      }
      return [255, 255, 255];
    };
    const found = [];
    for (const element of document.querySelectorAll("p, td, th, dt, dd, h1, h2, h3, a, button, figcaption, small, summary, code, label, .badge")) {
      if (!element.textContent.trim() || !element.checkVisibility()) continue;
      const [a, b] = [light(parse(getComputedStyle(element).color)), light(ground(element))];
      const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
      if (contrast < 4.5) found.push(`${element.tagName} ${element.className} ${element.textContent.slice(0, 30)}: ${contrast.toFixed(2)}`);
    }
    return found.slice(0, 5);
  });

/** What the first screen shows of a verb's answer: the first finding of a diagnosis, the figures of a fit, the head of its load. */
const ANSWERS = {
  diagnose: ["#missing h3"],
  seven: ["#missing h3"],
  fit: ["#summary .result div:last-child", "#load h2"],
  fit_arm: ["#summary .result div:last-child", "#joints h2"],
};

async function opensWithAnswer(page, verb) {
  for (const answer of ANSWERS[verb] ?? []) {
    const box = await page.locator(answer).first().boundingBox();
    assert.ok(box && box.y + box.height <= DESK.height, `${answer} is on the first screen, not at ${box?.y} px`);
  }
}

/** Notes on the inputs of a result are folded where there are several. */
async function foldsNotes(page) {
  const several = (await page.locator("#mistakes .card.note").count()) > 1;
  const open = await page.locator("#mistakes .card.note:visible").count();
  assert.ok(!several || open === 0, `${open} notes take the room of the result`);
}

/** Parts of the page that are wider than the box they stand in: the menu, tables, and what cells of tables hold. */
const clipped = page =>
  page.evaluate(() => {
    const boxes = document.querySelectorAll("nav > div, .scroll, .scroll > table > tbody > tr > td");
    const wide = [...boxes].filter(box => box.checkVisibility() && box.scrollWidth > box.clientWidth + 1);
    return wide.slice(0, 5).map(box => `${box.tagName} ${box.textContent.slice(0, 40)}: ${box.scrollWidth} px in ${box.clientWidth} px`);
  });

/** On a phone every cell says which column it is of. */
const unlabelled = page =>
  page.evaluate(() => {
    const cells = [...document.querySelectorAll(".scroll > table > tbody > tr > td")].filter(cell => cell.checkVisibility());
    const isBare = cell => cell.dataset.label && !getComputedStyle(cell, "::before").content.includes(cell.dataset.label);
    return cells.filter(isBare).length;
  });

/** Colours that tell something and that a printer leaves out: keys of pictures and charts, bars of errors. */
const unprinted = page =>
  page.evaluate(() => {
    const telling = [...document.querySelectorAll(".key, .u-marker, .meter, .meter > span")];
    return telling.filter(element => getComputedStyle(element).printColorAdjust !== "exact").length;
  });

/** The widest chart, CSS pixels, between the events of printing and after them; charts take their size before anything else happens. */
const printedWidths = page =>
  page.evaluate(async () => {
    const widest = async event => {
      window.dispatchEvent(new Event(event));
      await Promise.resolve();
      return Math.max(0, ...[...document.querySelectorAll(".chart .u-wrap")].map(chart => chart.offsetWidth));
    };
    return [await widest("beforeprint"), await widest("afterprint")];
  });

const background = page => page.evaluate(() => getComputedStyle(document.body).backgroundColor);

/** The report in a results folder. */
const reportIn = verb => ["report.html", "fleet.html"].map(name => join(folder, verb, name)).find(existsSync);

/** What the guide shows of reports: where a picture begins, and in which colours. */
const PICTURES = {
  check: [{ name: "check" }],
  fit: [{ name: "fit_dark", at: "#signals", colorScheme: "dark" }],
  diagnose: [
    { name: "diagnose" },
    { name: "diagnose_signals", at: "#signals" },
    { name: "diagnose_law", at: "#explorer > .over" },
    { name: "diagnose_phone", viewport: PHONE, colorScheme: "dark" },
  ],
  design: [{ name: "design_motion", at: "#motion" }],
  simulate: [{ name: "simulate", at: "#simulation" }],
  trials: [{ name: "trials" }],
  rollout: [{ name: "rollout_windows", at: "#explorer" }],
  fleet: [{ name: "fleet" }],
};

async function pictures(verb, file) {
  for (const { name, at, viewport = PICTURE, colorScheme } of PICTURES[verb] ?? []) {
    const { page } = await open(file, { viewport, colorScheme });
    if (at) await page.locator(at).first().evaluate(element => element.scrollIntoView({ block: "start" }));
    await page.screenshot({ path: join(screens, `${name}.png`), scale: "css" });
    await page.close();
  }
}

async function look(verb) {
  const file = reportIn(verb);
  const bytes = statSync(file).size;
  assert.ok(bytes < MOST_BYTES, `${bytes} bytes`);
  const { page, complaints } = await open(file);
  const time = await seconds(page);
  assert.ok(time < MOST_SECONDS, `drawn after ${time} s`);
  assert.ok((await overflow(page)) <= 0, "the desk overflows");
  await opensWithAnswer(page, verb);
  if (verb !== "check") await foldsNotes(page);
  assert.deepEqual(await clipped(page), [], "cut on the desk");
  if (await page.locator("#explorer").count()) await zooms(page);
  await sorts(page);
  const paleLight = await pale(page);
  assert.deepEqual(paleLight, [], "contrast on light");
  const light = await background(page);
  await page.locator("#theme").click();
  const [printed, shown] = await printedWidths(page);
  assert.ok(printed <= PAPER.width, `a chart of ${printed} px is cut on paper`);
  assert.ok(shown === 0 || shown > PAPER.width / 2, `a chart of ${shown} px after printing`);
  const toggled = await background(page);
  assert.notEqual(toggled, light, "the button changes the colours");
  assert.deepEqual(await pale(page), [], "contrast on dark");
  await page.close();

  const dark = await open(file, { colorScheme: "dark" });
  assert.equal(await background(dark.page), toggled, "the system's dark is that of the button");
  await dark.page.close();

  const phone = await open(file, { viewport: PHONE });
  const wide = await overflow(phone.page);
  assert.ok(wide <= 0, `a phone overflows by ${wide} px`);
  assert.deepEqual(await clipped(phone.page), [], "cut on a phone");
  assert.equal(await unlabelled(phone.page), 0, "cells on a phone without a label");
  await phone.page.close();

  const paper = await open(file, { viewport: PAPER });
  await paper.page.emulateMedia({ media: "print" });
  const beyond = await overflow(paper.page);
  assert.ok(beyond <= 0, `a printed page is ${beyond} px too wide`);
  assert.equal(await unprinted(paper.page), 0, "colours that are not printed");
  await paper.page.close();

  await still(file);

  const all = [...complaints, ...dark.complaints, ...phone.complaints, ...paper.complaints];
  assert.deepEqual(all, [], "the browser complains of nothing");
  if (withPictures) await pictures(verb, file);
  console.log(`${verb}: ${(bytes / 1e6).toFixed(2)} MB, drawn after ${time.toFixed(2)} s`);
}

let failed = 0;
try {
  const verbs = readdirSync(folder).filter(reportIn);
  assert.ok(verbs.length >= 9, `reports of ${verbs}`);
  for (const verb of verbs) {
    try {
      await look(verb);
    } catch (error) {
      failed += 1;
      console.error(`${verb}: ${error.message}`);
    }
  }
} finally {
  await browser.close();
  rmSync(profile, { recursive: true, force: true });
}
process.exitCode = failed ? 1 : 0;
