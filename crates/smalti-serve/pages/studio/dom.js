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

/** Shows a message until it is dismissed or another one takes its place. Trouble interrupts a screen reader, a note does not. @param {string} text @param {"trouble" | "note"} [kind] */
export function tell(text, kind = "note") {
  const place = byId("message", HTMLElement);
  for (const of of ["note", "trouble"]) byId(of, HTMLElement).textContent = of === kind ? text : "";
  if (text) place.dataset.kind = kind;
  else delete place.dataset.kind;
}

/** Removes a message, if it is still shown. @param {string} text */
export function untell(text) {
  if (["note", "trouble"].some((kind) => byId(kind, HTMLElement).textContent === text)) tell("");
}

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
