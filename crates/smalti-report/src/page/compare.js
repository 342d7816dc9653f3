// Pictures side by side, or two over each other, moved and enlarged together. They are those that stand in the page.

const MAX_ZOOM = 32;

function readShots(gallery, kinds) {
  return Array.from(gallery.querySelectorAll(".shots"), (group) => ({
    scene: group.dataset.scene,
    light: group.dataset.light,
    tops: JSON.parse(group.dataset.tops),
    shots: Array.from(group.querySelectorAll("figure"), (figure) => ({
      name: figure.dataset.name,
      reference: figure.classList.contains("reference"),
      picture: figure.querySelector(".shot"),
      maps: kinds.map((_, i) => figure.querySelector(`.map[data-map="${i}"]`)),
      missing: figure.querySelector(".none")?.textContent,
      caption: figure.querySelector("figcaption").lastChild.textContent.trim(),
    })),
  }));
}

// The values of a map, 0 to 255, taken once.
const valuesOf = new WeakMap();
function values(map) {
  if (!valuesOf.has(map)) {
    const [width, height] = [map.naturalWidth, map.naturalHeight];
    const context = make("canvas", { width, height }).getContext("2d", { willReadFrequently: true });
    context.drawImage(map, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    valuesOf.set(map, { width, height, steps: Uint8Array.from({ length: width * height }, (_, i) => data[4 * i]) });
  }
  return valuesOf.get(map);
}
// A map in the colours of its legend, made once.
const COLORS = Array.from({ length: 256 }, (_, i) => between((i / 255) * (VIRIDIS.length - 1)));
function colored(map) {
  const found = values(map);
  if (!found.src) {
    const { width, height, steps } = found;
    const image = new ImageData(width, height);
    image.data.fill(255);
    steps.forEach((step, i) => image.data.set(COLORS[step], 4 * i));
    const canvas = make("canvas", { width, height });
    canvas.getContext("2d").putImageData(image, 0, 0);
    found.src = canvas.toDataURL();
  }
  return found.src;
}
// What a map says at a place, both 0 to 1; the map is a JPEG, so some percent of its range may be off.
function valueAt(map, top, x, y) {
  const { width, height, steps } = values(map);
  const step = steps[Math.min(height - 1, Math.floor(y * height)) * width + Math.min(width - 1, Math.floor(x * width))];
  return step > 253 ? `${top} or more` : String(Number(((step / 255) * top).toPrecision(2)));
}

// What of the pictures is seen: `x`, `y` the upper left corner as a share of the picture, `zoom` how much larger than whole.
class View {
  constructor(changed) {
    Object.assign(this, { x: 0, y: 0, zoom: 1, changed });
  }
  set(x, y, zoom) {
    this.zoom = Math.min(MAX_ZOOM, Math.max(1, zoom));
    const most = 1 - 1 / this.zoom;
    this.x = Math.min(most, Math.max(0, x));
    this.y = Math.min(most, Math.max(0, y));
    this.changed();
  }
  // Enlarges around a place of the frame, both 0 to 1.
  enlarge(factor, px = 0.5, py = 0.5) {
    const zoom = Math.min(MAX_ZOOM, Math.max(1, this.zoom * factor));
    this.set(this.x + px / this.zoom - px / zoom, this.y + py / this.zoom - py / zoom, zoom);
  }
  // Moves by a share of the frame.
  move(dx, dy) {
    this.set(this.x + dx / this.zoom, this.y + dy / this.zoom, this.zoom);
  }
  place(image) {
    image.style.transform = `scale(${this.zoom}) translate(${-100 * this.x}%, ${-100 * this.y}%)`;
    image.classList.toggle("crisp", this.zoom > 1);
  }
}

function choice(label, options, changed, chosen = 0) {
  const select = make("select", { change: changed }, options.map((o, i) => make("option", { value: i, selected: i === chosen }, o)));
  return { select, element: make("label", {}, label, select), value: () => Number(select.value) };
}

// A slider over the luminances, from dim to bright, with a name below each place.
function lightSlider(lights, changed) {
  const text = (i) => `${lights[i]} cd/m²`;
  const input = make("input", { type: "range", min: 0, max: lights.length - 1, step: 1, value: 0, "aria-label": "Luminance", input: () => { tell(); changed(); } });
  // As many names as can be read; the output tells the others.
  const each = Math.ceil(lights.length / 7);
  const names = lights.map((light, i) => make("span", {}, i % each === 0 || i === lights.length - 1 ? light : ""));
  const reading = make("output", {});
  function tell() {
    input.setAttribute("aria-valuetext", text(input.value));
    reading.textContent = text(input.value);
  }
  tell();
  return {
    element: make("div", { class: "light" }, make("span", { class: "light-head" }, "Luminance ", reading), input,
      make("div", { class: "light-names", "aria-hidden": "true" }, ...names)),
    value: () => Number(input.value),
    set(i) {
      input.value = i;
      tell();
    },
  };
}

function startViewer(root) {
  const gallery = root.querySelector(".gallery");
  const kinds = JSON.parse(gallery.dataset.maps);
  const groups = readShots(gallery, kinds);
  if (groups.length === 0) return;
  const unique = (values) => [...new Set(values)];
  const scenes = unique(groups.map((g) => g.scene));
  const lights = unique(groups.map((g) => g.light)).sort((a, b) => a - b);
  const names = groups[0].shots.map((s) => s.name);
  const hasMaps = groups.some((g) => g.shots.some((s) => s.maps.some(Boolean)));
  const hasValues = hasMaps && kinds.some((k) => k.unit);

  const scene = choice("Scene", scenes, show);
  const light = lightSlider(lights, show);
  const what = choice("Show", ["Pictures", ...kinds.map((k) => k.name)], show);
  const mode = choice("View", ["Side by side", "Before and after"], show);
  const last = names.length - 1;
  const before = choice("Left", names, show, Math.max(0, last - 1));
  const after = choice("Right", names, show, last);
  const slider = make("input", { type: "range", min: 0, max: 100, value: 50, "aria-label": "Where the left picture ends, percent of the width", input: split });
  const reading = make("output", { "aria-live": "polite" });
  const told = make("div", { class: "values" });
  const about = make("p", { class: "help about-map" });
  const legend = make("div", { class: "legend" });
  const stage = make("div", {
    class: "stage", tabindex: 0, role: "application", "aria-label": "Pictures that move together", "aria-describedby": "viewer-help",
  });
  const view = new View(place);
  const button = (text, name, click) => make("button", { type: "button", "aria-label": name, click }, text);

  // With more cameras than fit, the reference stays and the others scroll below it, one at a time.
  function turn(by) {
    const figure = stage.querySelector("figure:last-of-type");
    if (figure) stage.scrollBy({ left: by * (figure.offsetWidth + parseFloat(getComputedStyle(stage).columnGap)) });
  }
  const previous = button("‹", "Previous camera", () => turn(-1));
  const next = button("›", "Next camera", () => turn(1));
  function scrolled() {
    const over = stage.scrollWidth - stage.clientWidth;
    previous.hidden = over <= 1;
    next.hidden = over <= 1;
    previous.disabled = stage.scrollLeft <= 1;
    next.disabled = stage.scrollLeft >= over - 1;
    stage.classList.toggle("turned", stage.scrollLeft > 1);
  }
  stage.addEventListener("scroll", scrolled);
  new ResizeObserver(scrolled).observe(stage);

  gallery.classList.add("taken");
  gallery.before(
    make("div", { class: "choices" }, scene.element, hasMaps ? what.element : null, names.length > 1 ? mode.element : null, before.element, after.element, lights.length > 1 ? light.element : null),
    stage,
    slider,
    make("div", { class: "zooms" }, previous, next,
      button("−", "Smaller", () => view.enlarge(0.5)), button("+", "Larger", () => view.enlarge(2)), button("Whole", "Whole picture", () => view.set(0, 0, 1)),
      reading, legend),
    ...(hasMaps ? [about] : []),
    ...(hasValues ? [told] : []),
    make("p", { class: "help", id: "viewer-help" },
      `Wheel, pinch or + and − enlarge, dragging or the arrows move, 0 shows the whole. All pictures move together. Shift with an arrow, or the buttons ‹ and ›, show cameras further along.${hasValues ? " The values of all maps under the cursor are shown below the pictures." : ""}`));

  let frames = [];
  function current() {
    return groups.find((g) => g.scene === scenes[scene.value()] && g.light === lights[light.value()]);
  }
  // The picture of a shot or its map of a kind (-1 for none), or in words that there is none.
  function imageOf(shot, kind) {
    const map = shot.maps[kind];
    const source = map || shot.picture;
    if (!source) return make("p", { class: "none" }, shot.missing ?? "No picture.");
    const src = map && kinds[kind].unit && map.naturalWidth ? colored(map) : source.src;
    return make("img", { src, alt: source.alt, draggable: "false", width: source.getAttribute("width"), height: source.getAttribute("height") });
  }
  function captionOf(shot, kind) {
    const instead = kind >= 0 && !shot.maps[kind] && shot.picture;
    return [make("b", {}, shot.name), ` ${shot.caption}`, instead ? ` (no ${kinds[kind].name}: the picture)` : ""];
  }
  function show() {
    const group = current();
    const kind = hasMaps ? what.value() - 1 : -1;
    const two = mode.value() === 1 && names.length > 1;
    for (const c of [before, after]) c.element.hidden = !two;
    slider.hidden = !two;
    stage.classList.toggle("two", two);
    if (!group) {
      frames = [];
      stage.replaceChildren(make("p", { class: "none" }, "There are no pictures of this scene in this light."));
    } else if (two) {
      const [a, b] = [group.shots[before.value()], group.shots[after.value()]];
      const over = make("div", { class: "over" }, imageOf(b, kind));
      const frame = make("div", { class: "frame" }, imageOf(a, kind), over, make("i", { class: "edge" }));
      frames = [frame];
      stage.replaceChildren(make("figure", {}, frame, make("figcaption", {},
        make("span", {}, ...captionOf(a, kind)), make("span", {}, ...captionOf(b, kind)))));
    } else {
      frames = group.shots.map((s) => make("div", { class: "frame" }, imageOf(s, kind)));
      const left = stage.scrollLeft;
      stage.replaceChildren(...group.shots.map((s, i) => make("figure", { class: s.reference ? "reference" : null }, frames[i], make("figcaption", {}, ...captionOf(s, kind)))));
      stage.scrollLeft = left;
    }
    stage.style.setProperty("--count", two ? 1 : Math.max(1, frames.length));
    const mapped = kind >= 0 && group?.shots.some((s) => s.maps[kind]);
    about.textContent = mapped ? kinds[kind].about : "";
    legend.replaceChildren(...(mapped && kinds[kind].unit
      ? [make("span", {}, "0"), make("i", { class: "ramp" }), make("span", {}, `${group.tops[kind]} ${kinds[kind].unit} and more`)] : []));
    told.replaceChildren();
    const size = stage.querySelector("img");
    if (size) root.style.setProperty("--ratio", size.getAttribute("width") / size.getAttribute("height"));
    split();
    place();
    scrolled();
  }
  function split() {
    const frame = frames[0];
    const over = frame?.querySelector(".over");
    if (!over) return;
    over.style.clipPath = `inset(0 0 0 ${slider.value}%)`;
    frame.querySelector(".edge").style.left = `${slider.value}%`;
  }
  function place() {
    stage.querySelectorAll("img").forEach((image) => view.place(image));
    stage.classList.toggle("near", view.zoom > 1);
    const size = stage.querySelector("img");
    const middle = (at, whole) => Math.round((at + 0.5 / view.zoom) * whole);
    reading.textContent = view.zoom === 1 || !size ? ""
      : `${shown(view.zoom)}× around row ${middle(view.y, size.getAttribute("height"))}, column ${middle(view.x, size.getAttribute("width"))}`;
  }

  // The maps' values under the pointer, of every camera, whether maps or pictures are shown: a line for each kind.
  function point(px, py) {
    const group = current();
    const [x, y] = [view.x + px / view.zoom, view.y + py / view.zoom];
    if (x < 0 || y < 0 || x >= 1 || y >= 1) return;
    let place = null;
    const lines = kinds.map(({ name, unit }, kind) => {
      const shots = unit && group ? group.shots.filter((s) => s.maps[kind]?.naturalWidth) : [];
      if (shots.length === 0) return null;
      const size = (of) => Number(shots[0].maps[kind].getAttribute(of));
      place = `Row ${Math.floor(y * size("height"))}, column ${Math.floor(x * size("width"))} (counted from 0)`;
      const all = shots.flatMap((s, i) => [i > 0 ? " · " : " ", make("span", {}, `${s.name} `, make("b", {}, valueAt(s.maps[kind], group.tops[kind], x, y)))]);
      return make("p", { class: what.value() - 1 === kind ? "chosen" : null }, `${name} (${unit}), about:`, ...all);
    });
    if (!place) return;
    // The room stays, so that nothing below jumps.
    told.classList.add("used");
    told.replaceChildren(make("p", {}, place), ...lines.filter(Boolean));
  }

  const placeIn = (event) => {
    const frame = event.target.closest(".frame");
    if (!frame) return null;
    const box = frame.getBoundingClientRect();
    return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height, box };
  };
  stage.addEventListener("wheel", (event) => {
    const at = placeIn(event);
    // The whole picture cannot become smaller: the page scrolls on.
    const along = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (!at || along || (view.zoom === 1 && event.deltaY > 0 && !event.ctrlKey)) return;
    event.preventDefault();
    view.enlarge(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.06 : 0.002)), at.x, at.y);
  }, { passive: false });
  stage.addEventListener("pointerleave", () => { told.replaceChildren(); });
  stage.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.shiftKey && step && step[0] !== 0) {
      turn(Math.sign(step[0]));
      event.preventDefault();
      return;
    }
    if (event.key === "+" || event.key === "=") view.enlarge(1.5);
    else if (event.key === "-") view.enlarge(1 / 1.5);
    else if (event.key === "0") view.set(0, 0, 1);
    else if (step && view.zoom > 1) view.move(...step);
    else return;
    // Without a pointer, of the middle.
    point(0.5, 0.5);
    event.preventDefault();
  });

  // One finger or the mouse moves, two enlarge.
  const held = new Map();
  stage.addEventListener("pointerdown", (event) => {
    const at = placeIn(event);
    if (!at || event.button !== 0) return;
    held.set(event.pointerId, { x: event.clientX, y: event.clientY, box: at.box });
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    const was = held.get(event.pointerId);
    const under = was ? null : placeIn(event);
    if (under) point(under.x, under.y);
    if (!was) return;
    const [x, y] = [event.clientX, event.clientY];
    const others = [...held].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
    if (others.length === 1) {
      const [o] = others;
      const far = (ax, ay) => Math.max(20, Math.hypot(ax - o.x, ay - o.y));
      view.enlarge(far(x, y) / far(was.x, was.y), ((x + o.x) / 2 - was.box.left) / was.box.width, ((y + o.y) / 2 - was.box.top) / was.box.height);
    } else if (others.length === 0 && view.zoom > 1) {
      view.move((was.x - x) / was.box.width, (was.y - y) / was.box.height);
    } else if (others.length === 0 && !slider.hidden) {
      slider.value = (100 * (x - was.box.left)) / was.box.width;
      split();
    }
    Object.assign(was, { x, y });
  });
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) => held.delete(event.pointerId));

  show();
  // Shows a crop in the viewer: its scene and light, enlarged around its middle.
  return function look({ scene: wantedScene, light: wantedLight, x, y, width }) {
    scene.select.value = Math.max(0, scenes.indexOf(wantedScene));
    light.set(Math.max(0, lights.indexOf(wantedLight)));
    show();
    const zoom = Math.min(MAX_ZOOM, Math.max(1, 0.7 / width));
    view.set(x - 0.5 / zoom, y - 0.5 / zoom, zoom);
    root.scrollIntoView({ block: "start" });
    stage.focus({ preventScroll: true });
  };
}

function startCrops(look) {
  for (const row of document.querySelectorAll(".across")) row.addEventListener("scroll", () => row.classList.toggle("turned", row.scrollLeft > 1));
  for (const crop of document.querySelectorAll(".telling")) {
    const { scene, light, x, y, width } = crop.dataset;
    const click = () => look({ scene, light, x: Number(x), y: Number(y), width: Number(width) });
    crop.querySelector(".where > div").append(make("button", { type: "button", click }, "Show in the viewer", make("span", { class: "hidden-text" }, ` (${scene})`)));
  }
}

const look = startViewer(document.getElementById("viewer"));
if (look) startCrops(look);
startKernels(document.getElementById("compare"));
