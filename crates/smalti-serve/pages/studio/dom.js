// @ts-check
// Elements: found, made, filled; and what is announced to those who do not see the page.

/** An element of the page. @template {Element} T @param {string} id @param {new (...args: any[]) => T} kind @returns {T} */
export function byId(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

/** @typedef {Record<string, string | number | boolean | undefined | ((event: any) => void)>} Attributes */
/** @typedef {Node | string | undefined | false} Child */

/** @param {Element} element @param {Attributes} attributes @param {Child[]} children */
function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== undefined && value !== false) element.setAttribute(name, String(value));
  }
  for (const child of children) if (child) element.append(child);
}

/**
 * A new element. Attributes that are functions listen to the event of their name.
 * @template {keyof HTMLElementTagNameMap} K @param {K} tag @param {Attributes} [attributes] @param {Child[]} children @returns {HTMLElementTagNameMap[K]}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  fill(element, attributes, children);
  return element;
}

/** A new element of a drawing. @template {keyof SVGElementTagNameMap} K @param {K} tag @param {Attributes} [attributes] @param {Child[]} children @returns {SVGElementTagNameMap[K]} */
export function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  fill(element, attributes, children);
  return element;
}

/** Options of a list of choices. @param {HTMLSelectElement} select @param {[value: string, text: string][]} options @param {string} chosen */
export function setOptions(select, options, chosen) {
  const same = select.options.length === options.length && options.every(([value, text], i) => select.options[i].value === value && select.options[i].text === text);
  if (!same) select.replaceChildren(...options.map(([value, text]) => make("option", { value }, text)));
  select.value = chosen;
}

/** @type {number | undefined} */
let timer;
/** Tells a result politely. The last of several in quick succession is told. @param {string} text */
export function announce(text) {
  clearTimeout(timer);
  timer = window.setTimeout(() => { byId("told", HTMLElement).textContent = text; }, 250);
}

/** What an error says. @param {unknown} error */
export const message = (error) => (error instanceof Error ? error.message : String(error));

/** Characters that steer the text around them instead of standing for themselves, as the library knows them (`smalti::names::steers`). */
const STEERING = /[\p{Cc}\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufffe\uffff]/gu;
/** A text of a file in one line, without characters that steer the text around it. @param {string} text */
export const inOneLine = (text) => text.replace(/[\n\r\t]/g, " ").replace(STEERING, "\ufffd");

/** What ends the view of a note: the next action, wherever it is. */
const ACTIONS = ["pointerdown", "keydown", "input", "change", "wheel", "drop"];
/** Keys that are no action of their own. */
const QUIET_KEYS = ["Tab", "Shift", "Control", "Alt", "Meta"];

/** Puts a note out of view at the next action. Its text stays for screen readers. */
export function setUpMessages() {
  const place = byId("message", HTMLElement);
  for (const action of ACTIONS) {
    document.addEventListener(action, (event) => {
      if (place.dataset.kind !== "note" || (event.target instanceof Node && place.contains(event.target))) return;
      if (event instanceof KeyboardEvent && QUIET_KEYS.includes(event.key)) return;
      delete place.dataset.kind;
    }, { capture: true, passive: true });
  }
  byId("dismiss", HTMLButtonElement).addEventListener("click", () => tell(""));
}

/**
 * Shows a message: a note until the next action, trouble until it is dismissed or another message takes its place. Trouble interrupts a screen reader, a note does not.
 * @param {string} text @param {"trouble" | "note"} [kind]
 */
export function tell(text, kind = "note") {
  const place = byId("message", HTMLElement);
  for (const of of ["note", "trouble"]) byId(of, HTMLElement).textContent = of === kind ? text : "";
  if (text) place.dataset.kind = kind;
  else delete place.dataset.kind;
}

/** Says which numbers a field takes. @param {string} label @param {number} min @param {number} max @param {string} unit */
export const tellRange = (label, min, max, unit) => tell(`${label}: expected ${min} to ${max}${unit && ` ${unit}`}.`, "trouble");

/** Removes a message, if it is still shown. @param {string} text */
export function untell(text) {
  if (["note", "trouble"].some((kind) => byId(kind, HTMLElement).textContent === text)) tell("");
}

/** How large text is, relative to that of a window of usual width: room for it in drawings grows with it. */
export const textScale = () => Math.max(parseFloat(getComputedStyle(document.documentElement).fontSize) / 14, 1);

/** Runs at the next frame of the page, once for several calls. @param {() => void} work @returns {() => void} */
export function atFrame(work) {
  let waits = false;
  return () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      work();
    });
  };
}
