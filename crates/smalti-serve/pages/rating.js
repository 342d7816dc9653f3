// @ts-check
// The steps of a rating: consent, display, training, pairs with breaks, the end.
import { element, ratioWarning, setUpDisplay } from "./display.js";
import { Observers, keep, kept, newSecret } from "./observers.js";
import { PairView } from "./pair.js";
import { Refused, Server } from "./server.js";

/** Seconds that a pair takes, for the duration that the page states. */
const SECONDS_PER_PAIR = 8;
/** With fewer pairs left there is no break. */
const LEAST_AFTER_BREAK = 15;
const SECTIONS = ["resume", "welcome", "display", "pause", "pair", "done"];
const root = document.documentElement;
const ofBrowser = () => localStorage;

function setUpTheme() {
  const wish = matchMedia("(prefers-color-scheme: dark)");
  const button = element("theme", HTMLButtonElement);
  const isDark = () => (root.dataset.theme || (wish.matches ? "dark" : "light")) === "dark";
  const tell = () => button.setAttribute("aria-pressed", String(isDark()));
  const before = kept(ofBrowser, "smalti-theme");
  if (before === "dark" || before === "light") root.dataset.theme = before;
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    keep(ofBrowser, "smalti-theme", root.dataset.theme);
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
  element("not-me", HTMLButtonElement).hidden = true;
}

/** The pair of the observer whose secret the server has; null if there is no such observer. @param {Server} server */
async function pairOf(server) {
  try {
    return await server.pair();
  } catch (error) {
    if (error instanceof Refused && error.status === 401) return null;
    throw error;
  }
}

/** Asks whether somebody continues as one of the observers who began in this browser. @param {{ secret: string, pair: import("./server.js").Pair }[]} earlier */
function chosen(earlier) {
  return /** @type {Promise<string | null>} */ (new Promise((resolve) => {
    const buttons = earlier.map(({ secret, pair }) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = `Continue as observer ${pair.observer} (${pair.number} of ${pair.pairs} pairs judged)`;
      button.addEventListener("click", () => resolve(secret));
      return button;
    });
    element("earlier", HTMLElement).replaceChildren(...buttons);
    element("anew", HTMLButtonElement).addEventListener("click", () => resolve(null), { once: true });
    show("resume");
  }));
}

/**
 * Finds out who judges in this window, and gives the server the secret. After a reload it is the same observer; otherwise somebody chooses
 * to continue as one who has not finished and is in no other window, or takes part anew.
 * @param {Server} server @param {import("./server.js").About} about
 */
async function identify(server, about) {
  const observers = new Observers(about.experiment);
  const own = observers.current();
  if (own !== null && await observers.take(own, true)) {
    server.secret = own;
    if (await pairOf(server)) return observers;
    observers.finish(own);
  }
  observers.leave();
  for (;;) {
    const earlier = [];
    for (const secret of observers.unfinished()) {
      if (!(await observers.isFree(secret))) continue;
      server.secret = secret;
      const pair = await pairOf(server);
      if (pair && !pair.done) earlier.push({ secret, pair });
      else observers.finish(secret);
    }
    const secret = earlier.length > 0 ? await chosen(earlier) : null;
    if (secret === null) {
      await join(server, about, observers);
      return observers;
    }
    if (await observers.take(secret, false)) {
      observers.begin(secret);
      server.secret = secret;
      return observers;
    }
  }
}

/** @param {Server} server @param {import("./server.js").About} about @param {Observers} observers */
async function join(server, about, observers) {
  server.secret = "";
  const minutes = Math.max(1, Math.round((about.pairs * SECONDS_PER_PAIR) / 60));
  const training = about.training > 0 ? ` The first ${about.training} are for training.` : "";
  element("pairs", HTMLElement).textContent = `There are ${about.pairs} pairs.${training}`;
  element("minutes", HTMLElement).textContent = minutes === 1 ? "1 minute" : `${minutes} minutes`;
  const [consent, begin] = [element("consent", HTMLInputElement), element("begin", HTMLButtonElement)];
  const allow = () => { begin.disabled = !consent.checked; };
  consent.addEventListener("change", allow);
  allow();
  show("welcome");
  await clicked("begin");
  show("display");
  const display = setUpDisplay();
  await clicked("checked");
  const secret = newSecret();
  await observers.take(secret, false);
  // Kept before it is sent: should the page be reloaded before the reply comes, the observer is not another one.
  observers.begin(secret);
  try {
    await server.join(secret, display());
  } catch (error) {
    observers.finish(secret);
    observers.leave();
    throw error;
  }
  server.secret = secret;
}

/** The words before a pair, if it is not shown at once. @param {import("./server.js").Pair} pair @param {number} breakEvery @param {boolean} isFirst */
function wordsBefore(pair, breakEvery, isFirst) {
  const { number, training, pairs } = pair;
  const back = ["Welcome back", `You have judged ${number} of ${pairs} pairs and continue where you stopped.`];
  if (number < training) {
    if (!isFirst) return null;
    return number === 0 ? ["Training", `The first ${training} pairs show what to expect. They do not count.`] : back;
  }
  if (number === training) return ["The rating begins", `${training > 0 ? "Training is over. " : ""}There are ${pairs - training} pairs.`];
  // Near the end, a break would only delay it.
  if ((number - training) % breakEvery === 0 && pairs - number >= Math.min(breakEvery, LEAST_AFTER_BREAK)) {
    return ["Take a break", `You have judged ${number - training} of ${pairs - training} pairs. Look into the distance for a moment, and continue when you are ready.`];
  }
  return isFirst ? back : null;
}

/** @param {import("./server.js").Pair} pair */
function tellPlace({ observer, number, pairs, training }) {
  const isTraining = number < training;
  const [done, all] = isTraining ? [number, training] : [number - training, pairs - training];
  element("place", HTMLElement).textContent = `Observer ${observer}${isTraining ? " · Training" : ""}`;
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
    tellPlace(pair);
    // Where an observer continues, it may be another person who sits here now.
    element("not-me", HTMLButtonElement).hidden = !(isFirst && pair.number > 0);
    isFirst = false;
    if (words) await pause(words[0], words[1]);
    view.clear();
    show("pair");
    const { number } = pair;
    const [left, reference, right] = await Promise.all([
      server.picture(number, "left"), server.picture(number, "reference"), server.picture(number, "right"),
    ]);
    const warning = ratioWarning(devicePixelRatio || 1);
    // A zoom that changes in between is reported once.
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
      // This pair has another answer already, from a window that this one could not know of.
      if (!(error instanceof Refused && error.status === 409)) throw error;
      pair = await server.pair();
    }
  }
}

async function run() {
  setUpTheme();
  let isAway = false;
  const server = new Server((away) => {
    if (away) trouble("The server is not available at the moment. Your answers so far are recorded, and this page continues as soon as the server is available again.");
    else if (isAway) trouble("");
    isAway = away;
  });
  const about = await server.about();
  const observers = await identify(server, about);
  const beginAnew = () => {
    observers.leave();
    location.reload();
  };
  element("not-me", HTMLButtonElement).addEventListener("click", beginAnew);
  await judge(server, about);
  observers.finish(server.secret);
  element("place", HTMLElement).textContent = "";
  show("done");
  await clicked("another");
  beginAnew();
}

run().catch((error) => {
  trouble(error instanceof Refused ? `The server refuses this request: ${error.message}.` : `This page has failed: ${error.message}. Reload it to continue.`);
});
