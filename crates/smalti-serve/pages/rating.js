// @ts-check
// The steps of a rating: consent, display, training, pairs with breaks, the end.
import { element, ratioWarning, setUpDisplay } from "./display.js";
import { PairView } from "./pair.js";
import { Refused, Server } from "./server.js";

/** Seconds that a pair takes, for the time that is stated. */
const SECONDS_PER_PAIR = 8;
const SECTIONS = ["welcome", "display", "pause", "pair", "done"];
const root = document.documentElement;

/** What the browser keeps: storage may be forbidden, and then the page must not be reloaded. @param {string} key @param {string | null} [value] */
function kept(key, value) {
  try {
    if (value === undefined) return localStorage.getItem(key);
    if (value === null) localStorage.removeItem(key);
    else localStorage.setItem(key, value);
  } catch { /* nothing is kept */ }
  return null;
}

function setUpTheme() {
  const wish = matchMedia("(prefers-color-scheme: dark)");
  const button = element("theme", HTMLButtonElement);
  const isDark = () => (root.dataset.theme || (wish.matches ? "dark" : "light")) === "dark";
  const tell = () => {
    button.textContent = isDark() ? "Light" : "Dark";
    button.setAttribute("aria-label", isDark() ? "Switch to light colours" : "Switch to dark colours");
  };
  const before = kept("smalti-theme");
  if (before === "dark" || before === "light") root.dataset.theme = before;
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    kept("smalti-theme", root.dataset.theme);
    tell();
  });
  wish.addEventListener("change", tell);
  tell();
}

/** Shows a section and reads its heading to screen readers. @param {string} id */
function show(id) {
  const isNew = element(id, HTMLElement).hidden;
  for (const section of SECTIONS) element(section, HTMLElement).hidden = section !== id;
  if (isNew) document.getElementById(`${id}-title`)?.focus();
  if (isNew) scrollTo(0, 0);
}

/** @param {string} text */
function trouble(text) {
  const place = element("trouble", HTMLParagraphElement);
  if (place.textContent !== text) place.textContent = text;
}

/** Waits for a click. @param {string} id */
function clicked(id) {
  return new Promise((resolve) => { element(id, HTMLButtonElement).addEventListener("click", resolve, { once: true }); });
}

/** A screen between pairs. @param {string} title @param {string} text */
async function pause(title, text) {
  element("pause-title", HTMLElement).textContent = title;
  element("pause-text", HTMLElement).textContent = text;
  show("pause");
  await clicked("go-on");
}

/** @param {Server} server @param {import("./server.js").About} about @param {string} key */
async function join(server, about, key) {
  element("pairs", HTMLElement).textContent = `There are ${about.pairs} pairs, of which the first ${about.training} are for training.`;
  element("minutes", HTMLElement).textContent = String(Math.max(1, Math.round((about.pairs * SECONDS_PER_PAIR) / 60)));
  const [consent, begin] = [element("consent", HTMLInputElement), element("begin", HTMLButtonElement)];
  const allow = () => { begin.disabled = !consent.checked; };
  consent.addEventListener("change", allow);
  allow();
  show("welcome");
  await clicked("begin");
  const display = setUpDisplay();
  show("display");
  await clicked("checked");
  const { secret } = await server.join(display());
  server.secret = secret;
  kept(key, secret);
}

/** The words before a pair, if it is not shown at once. @param {import("./server.js").Pair} pair @param {number} breakEvery @param {boolean} isFirst */
function wordsBefore(pair, breakEvery, isFirst) {
  const { number, training, pairs } = pair;
  if (number < training) {
    return isFirst && number === 0 ? ["Training", `The first ${training} pairs show what to expect. They do not count.`] : null;
  }
  if (number === training) return ["The rating begins", `Training is over. There are ${pairs - training} pairs.`];
  if ((number - training) % breakEvery === 0) {
    return ["Take a break", `${number - training} of ${pairs - training} pairs are judged. Look into the distance for a moment, and continue when you like.`];
  }
  return isFirst ? ["Welcome back", `${number} pairs are judged. You continue where you were.`] : null;
}

/** @param {import("./server.js").Pair} pair */
function tellPlace({ number, pairs, training }) {
  const isTraining = number < training;
  const [done, all] = isTraining ? [number, training] : [number - training, pairs - training];
  element("place", HTMLElement).textContent = isTraining ? "Training" : "";
  const bar = element("progress", HTMLProgressElement);
  bar.max = Math.max(1, all);
  bar.value = done;
  element("count", HTMLElement).textContent = `${done + 1} of ${all}`;
}

/** @param {Server} server @param {import("./server.js").About} about */
async function judge(server, about) {
  /** @type {(answer: { choice: import("./server.js").Side, ms: number }) => void} */
  let resolve = () => {};
  const view = new PairView((choice, ms) => resolve({ choice, ms }), about.rows, about.cols);
  let pair = await server.pair();
  let isFirst = true;
  let warned = "";
  while (!pair.done) {
    const words = wordsBefore(pair, about.break_every, isFirst);
    isFirst = false;
    if (words) await pause(words[0], words[1]);
    view.clear();
    tellPlace(pair);
    show("pair");
    const { number } = pair;
    const [left, reference, right] = await Promise.all([
      server.picture(number, "left"), server.picture(number, "reference"), server.picture(number, "right"),
    ]);
    const warning = ratioWarning(devicePixelRatio || 1);
    // A zoom that changes in between is told once.
    if (warning !== warned) trouble(warning);
    warned = warning;
    /** @type {Promise<{ choice: import("./server.js").Side, ms: number }>} */
    const answered = new Promise((r) => { resolve = r; });
    await view.open({ left, reference, right }, pair);
    const { choice, ms } = await answered;
    view.clear();
    try {
      pair = await server.answer(number, choice, ms);
    } catch (error) {
      // Another window of this browser has answered.
      if (!(error instanceof Refused && error.status === 409)) throw error;
      pair = await server.pair();
    }
  }
}

async function run() {
  setUpTheme();
  let isAway = false;
  const server = new Server((away) => {
    if (away) trouble("The server does not answer. Your answers so far are recorded; this page goes on when it is back.");
    else if (isAway) trouble("");
    isAway = away;
  });
  const about = await server.about();
  const key = `smalti-observer-${about.experiment}`;
  server.secret = kept(key) ?? "";
  if (server.secret) {
    try {
      await server.pair();
    } catch (error) {
      if (!(error instanceof Refused && error.status === 401)) throw error;
      server.secret = "";
    }
  }
  if (!server.secret) await join(server, about, key);
  await judge(server, about);
  element("place", HTMLElement).textContent = "";
  show("done");
  await clicked("another");
  kept(key, null);
  location.reload();
}

run().catch((error) => {
  trouble(error instanceof Refused ? `The server refuses this: ${error.message}.` : `This page has failed: ${error.message}. Reload it to go on.`);
});
