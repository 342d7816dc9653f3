// Pictures side by side, or two over each other, moved and enlarged together. They are those that stand in the page.

const MOST_ZOOM = 32;

function readShots(gallery) {
  return Array.from(gallery.querySelectorAll(".shots"), (group) => ({
    scene: group.dataset.scene,
    light: group.dataset.light,
    top: Number(group.dataset.top),
    shots: Array.from(group.querySelectorAll("figure"), (figure) => ({
      name: figure.dataset.name,
      picture: figure.querySelector(".shot"),
      map: figure.querySelector(".map"),
      missing: figure.querySelector(".none")?.textContent,
      caption: figure.querySelector("figcaption").lastChild.textContent.trim(),
    })),
  }));
}

// The samples of a picture, taken once.
const samplesOf = new WeakMap();
function samples(image) {
  if (!samplesOf.has(image)) {
    const [width, height] = [image.naturalWidth, image.naturalHeight];
    const canvas = make("canvas", { width, height });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    samplesOf.set(image, { width, height, bytes: context.getImageData(0, 0, width, height).data });
  }
  return samplesOf.get(image);
}
// The value of a map at a place, both 0 to 1, as a share of its range; the map is a JPEG, so some percent of it may be off.
function valueAt(map, x, y) {
  const { width, height, bytes } = samples(map);
  const at = (Math.min(height - 1, Math.floor(y * height)) * width + Math.min(width - 1, Math.floor(x * width))) * 4;
  return ofViridis(bytes.subarray(at, at + 3));
}

// What of the pictures is seen: `x`, `y` the upper left corner as a share of the picture, `zoom` how much larger than whole.
class View {
  constructor(changed) {
    Object.assign(this, { x: 0, y: 0, zoom: 1, changed });
  }
  set(x, y, zoom) {
    this.zoom = Math.min(MOST_ZOOM, Math.max(1, zoom));
    const most = 1 - 1 / this.zoom;
    this.x = Math.min(most, Math.max(0, x));
    this.y = Math.min(most, Math.max(0, y));
    this.changed();
  }
  // Enlarges around a place of the frame, both 0 to 1.
  enlarge(factor, px = 0.5, py = 0.5) {
    const zoom = Math.min(MOST_ZOOM, Math.max(1, this.zoom * factor));
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

function startViewer(root) {
  const gallery = root.querySelector(".gallery");
  const groups = readShots(gallery);
  if (groups.length === 0) return;
  const { map, unit } = gallery.dataset;
  const unique = (values) => [...new Set(values)];
  const scenes = unique(groups.map((g) => g.scene));
  const lights = unique(groups.map((g) => g.light));
  const names = groups[0].shots.map((s) => s.name);
  const hasMaps = groups.some((g) => g.shots.some((s) => s.map));

  const scene = choice("Scene", scenes, show);
  const light = choice("Luminance", lights.map((l) => `${l} cd/m²`), show);
  const what = choice("Show", ["Pictures", map], show);
  const mode = choice("View", ["Side by side", "Before and after"], show);
  const last = names.length - 1;
  const before = choice("Left", names, show, Math.max(0, last - 1));
  const after = choice("Right", names, show, last);
  const slider = make("input", { type: "range", min: 0, max: 100, value: 50, "aria-label": "Where the left picture ends, percent of the width", input: split });
  const reading = make("output", { "aria-live": "polite" });
  const values = make("p", { class: "values" });
  const legend = make("div", { class: "legend" });
  const stage = make("div", {
    class: "stage", tabindex: 0, role: "application", "aria-label": "Pictures that move together", "aria-describedby": "viewer-help",
  });
  const view = new View(place);
  const button = (text, name, click) => make("button", { type: "button", "aria-label": name, click }, text);

  gallery.classList.add("taken");
  gallery.before(
    make("div", { class: "choices" }, scene.element, light.element, hasMaps ? what.element : null, names.length > 1 ? mode.element : null, before.element, after.element),
    stage,
    slider,
    make("div", { class: "zooms" },
      button("−", "Smaller", () => view.enlarge(0.5)), button("+", "Larger", () => view.enlarge(2)), button("Whole", "Whole picture", () => view.set(0, 0, 1)),
      reading, legend),
    hasMaps ? values : null,
    make("p", { class: "help", id: "viewer-help" },
      "Wheel, pinch or + and − enlarge, dragging or the arrows move, 0 shows the whole. All pictures move together."));

  let frames = [];
  function current() {
    return groups.find((g) => g.scene === scenes[scene.value()] && g.light === lights[light.value()]);
  }
  // The picture of a shot, or in words that there is none.
  function imageOf(shot, showMap) {
    const source = (showMap && shot.map) || shot.picture;
    if (!source) return make("p", { class: "none" }, shot.missing ?? "No picture.");
    return make("img", { src: source.src, alt: source.alt, draggable: "false", width: source.getAttribute("width"), height: source.getAttribute("height") });
  }
  function captionOf(shot, showMap) {
    return [make("b", {}, shot.name), ` ${shot.caption}`, showMap && !shot.map && shot.picture ? ` (no map of ${map}: the picture)` : ""];
  }
  function show() {
    const group = current();
    const showMap = hasMaps && what.value() === 1;
    const two = mode.value() === 1 && names.length > 1;
    for (const c of [before, after]) c.element.hidden = !two;
    slider.hidden = !two;
    stage.classList.toggle("two", two);
    if (!group) {
      frames = [];
      stage.replaceChildren(make("p", { class: "none" }, "There are no pictures of this scene in this light."));
    } else if (two) {
      const [a, b] = [group.shots[before.value()], group.shots[after.value()]];
      const over = make("div", { class: "over" }, imageOf(b, showMap));
      const frame = make("div", { class: "frame" }, imageOf(a, showMap), over, make("i", { class: "edge" }));
      frames = [frame];
      stage.replaceChildren(make("figure", {}, frame, make("figcaption", {},
        make("span", {}, ...captionOf(a, showMap)), make("span", {}, ...captionOf(b, showMap)))));
    } else {
      frames = group.shots.map((s) => make("div", { class: "frame" }, imageOf(s, showMap)));
      stage.replaceChildren(...group.shots.map((s, i) => make("figure", {}, frames[i], make("figcaption", {}, ...captionOf(s, showMap)))));
    }
    const count = two ? 1 : frames.length;
    stage.style.setProperty("--across", count <= 4 ? count : count <= 6 ? 3 : 4);
    legend.replaceChildren(...(showMap && unit && group ? [make("span", {}, "0"), make("i", { class: "ramp" }), make("span", {}, `${group.top} ${unit} and more`)] : []));
    const size = stage.querySelector("img");
    if (size) root.style.setProperty("--ratio", size.getAttribute("width") / size.getAttribute("height"));
    split();
    place();
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

  // The maps' values under the pointer, of every camera, whether maps or pictures are shown.
  function point(px, py) {
    const group = current();
    const maps = group?.shots.filter((s) => s.map?.naturalWidth) ?? [];
    if (maps.length === 0) return;
    const [x, y] = [view.x + px / view.zoom, view.y + py / view.zoom];
    if (x < 0 || y < 0 || x >= 1 || y >= 1) return;
    const { width, height } = samples(maps[0].map);
    const value = (s) => {
      const share = valueAt(s.map, x, y);
      return share > 0.995 ? `${s.name} ${group.top} or more` : `${s.name} ${Number((share * group.top).toPrecision(2))}`;
    };
    values.textContent = `Row ${Math.floor(y * height)}, column ${Math.floor(x * width)}: ${map}, ${unit}, about ${maps.map(value).join(", ")}`;
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
    if (!at || (view.zoom === 1 && event.deltaY > 0 && !event.ctrlKey)) return;
    event.preventDefault();
    view.enlarge(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.06 : 0.002)), at.x, at.y);
  }, { passive: false });
  stage.addEventListener("pointerleave", () => { values.textContent = ""; });
  stage.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
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
}

startViewer(document.getElementById("viewer"));
startKernels(document.getElementById("compare"));
