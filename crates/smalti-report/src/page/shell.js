// What every page does: light and dark, tables that sort, text to copy.

// An element: properties of `attributes` that are functions listen, others are attributes; text is only ever text.
function make(name, attributes = {}, ...content) {
  return fill(document.createElement(name), attributes, content);
}
function draw(name, attributes = {}, ...content) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, content);
}
function fill(element, attributes, content) {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...content.flat().filter((c) => c !== null && c !== undefined));
  return element;
}

// A table with headings of words first, then of numbers.
function tableOf(caption, words, numbers, rows) {
  const head = (text, attributes) => make("th", { scope: "col", ...attributes }, text);
  return make("table", {}, make("caption", {}, caption),
    make("thead", {}, make("tr", {}, ...words.map((t) => head(t)), ...numbers.map((t) => head(t, { class: "number" })))), make("tbody", {}, ...rows));
}

const darkWished = matchMedia("(prefers-color-scheme: dark)");
const themeListeners = [];
const root = document.documentElement;
// Whether the page is being printed.
let onPaper = false;

function isDark() {
  return (root.dataset.theme || (darkWished.matches ? "dark" : "light")) === "dark";
}
// The colour that a variable of the style sheet has now: canvases do not know variables, and to ask lays out the page.
const themeColors = new Map();
function themeColor(name) {
  if (themeColors.has(name)) return themeColors.get(name);
  const probe = document.body.appendChild(make("i"));
  probe.style.color = `var(${name})`;
  const color = getComputedStyle(probe).color;
  probe.remove();
  themeColors.set(name, color);
  return color;
}
function themeChanged() {
  themeColors.clear();
  const button = document.getElementById("theme");
  button.textContent = isDark() ? "Light" : "Dark";
  button.setAttribute("aria-label", isDark() ? "Switch to light colours" : "Switch to dark colours");
  themeListeners.forEach((tell) => tell());
}
function remembered(value) {
  // Pages opened as files may have no storage.
  try {
    if (value === undefined) return localStorage.getItem("smalti-theme");
    localStorage.setItem("smalti-theme", value);
  } catch { /* the choice lasts as long as the page */ }
  return null;
}

function setUpTheme() {
  const kept = remembered();
  if (kept === "dark" || kept === "light") root.dataset.theme = kept;
  const button = document.getElementById("theme");
  button.hidden = false;
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    remembered(root.dataset.theme);
    themeChanged();
  });
  darkWished.addEventListener("change", themeChanged);
  // Paper is white: canvases are drawn again for it.
  let before;
  addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    onPaper = true;
    root.dataset.theme = "light";
    themeChanged();
  });
  addEventListener("afterprint", () => {
    onPaper = false;
    if (before) root.dataset.theme = before;
    else delete root.dataset.theme;
    themeChanged();
  });
  themeChanged();
}

// The number a cell begins with; cells without one go last.
function sortKey(row, column) {
  const text = row.cells[column].textContent.trim();
  const number = parseFloat(text.replace("−", "-").replaceAll("\u202f", ""));
  return Number.isNaN(number) ? text : number;
}
function makeSortable(table) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = make("button", { type: "button" }, ...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const ascending = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((h) => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      const body = table.tBodies[0];
      const sign = ascending ? 1 : -1;
      const rows = [...body.rows].map((row) => [sortKey(row, column), row]);
      rows.sort(([a], [b]) => {
        if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
        return sign * (typeof a === "number" ? a - b : a.localeCompare(b));
      });
      body.append(...rows.map(([, row]) => row));
    });
  });
}

async function copyText(text, button) {
  let done = false;
  try {
    await navigator.clipboard.writeText(text);
    done = true;
  } catch {
    // Pages opened as files may have no clipboard; the old way needs no leave.
    const area = document.body.appendChild(make("textarea", { class: "hidden-text" }));
    area.value = text;
    area.select();
    done = document.execCommand("copy");
    area.remove();
    button.focus();
  }
  const was = button.textContent;
  button.textContent = done ? "Copied" : "Select the text and copy it";
  setTimeout(() => { button.textContent = was; }, 1500);
}

setUpTheme();
document.querySelectorAll("table[data-sortable]").forEach(makeSortable);
document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-copy]");
  if (button) copyText(button.parentElement.querySelector("pre").textContent, button);
});
