// @ts-check
// The report of a design as a page that stands alone: no script, nothing from elsewhere. It consists of elements and text, so that no text can become markup.
import { draw, inOneLine, make } from "./dom.js";
import { letters, share, size } from "./design.js";
import { drawnAxes, drawnCurves, frameOf, spectrum } from "./filter-plot.js";
import { FIGURES, clippingText, hasCurve, lightPlot } from "./light-plot.js";
import { text } from "./numbers.js";
import { definition, doubtsText } from "./scores.js";
import { conditions } from "./sensor.js";
import { curveText, pigmentsText } from "./shapes.js";
import { baseOf, thicknessOf } from "./thickness.js";
import { UNKNOWN, drawnTile } from "./tile-drawing.js";

/** @typedef {import("./light-plot.js").Figure} Figure */
/** @typedef {import("./dom.js").Child} Child */
/** A picture: the address of its own data, and its size. @typedef {{ source: string, width: number, height: number }} Image */
/** A design: as it is saved, with its curves, its picture and the time of its exposure, and its camera file. @typedef {{ camera: import("./design.js").Camera, curves: import("./engine.js").Curves, picture: Image, exposureMs: number, file: string, toml: string }} Side */
/**
 * What a report states. `fragment` holds the design in an address, `studio` is the address of a studio that anybody can open, if there is one.
 * `scene` is its name, `sceneInCommands` that in commands; without one, it is a photograph, and `photograph` the name of its file.
 * @typedef {{
 *   own: Side, pin: Side | undefined, reference: Image, scene: string, sceneInCommands: string | undefined, photograph: string | undefined, luminance: number, seed: number, version: string, date: string,
 *   rows: import("./scores.js").Row[], isClipped: boolean, warnings: string[], over: import("./light-plot.js").OverLight, clips: import("./light-plot.js").Clips, limits: string,
 *   fragment: string, studio: string | undefined, brand: Node, style: string,
 * }} Report
 */

/** The size of the plots. They are shown at about this size, so that their text is read on a phone and on a desk. */
const [PLOT_WIDTH, FILTERS_HEIGHT, LIGHT_HEIGHT] = [380, 220, 170];
/** A policy that allows the pictures and the style of the page and nothing else. */
const POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

const nameOf = (/** @type {Side} */ side) => inOneLine(side.camera.name);
const code = (/** @type {string} */ content) => make("code", {}, content);
/** @param {string} title @param {Child[]} content */
const section = (title, ...content) => make("section", { class: "card" }, make("h2", {}, title), ...content);
/** A table. @param {string} caption Seen above it, unless the section says it already. @param {Child[][]} head @param {Child[][][]} rows Each with its title in the first cell. @param {{ isUnseen?: boolean, kind?: string }} [as] */
function table(caption, head, rows, { isUnseen = false, kind } = {}) {
  const cells = (/** @type {Child[][]} */ all, /** @type {"col" | "row"} */ scope) => all.map((cell, i) => make(scope === "col" || i === 0 ? "th" : "td", { scope: scope === "col" || i === 0 ? scope : undefined }, ...cell));
  return make("table", { class: kind }, make("caption", { class: isUnseen ? "unseen" : undefined }, caption), make("thead", {}, make("tr", {}, ...cells(head, "col"))), make("tbody", {}, ...rows.map((row) => make("tr", {}, ...cells(row, "row")))));
}

/** @param {Image} image @param {string} alt @param {string} caption */
const figure = ({ source, width, height }, alt, caption) => make("figure", {}, make("img", { src: source, width, height, alt }), make("figcaption", {}, caption));

/** @param {Report} report */
function pictures({ own, pin, reference, scene }) {
  const learned = (/** @type {Side} */ side, /** @type {string} */ as) => figure(side.picture, `${scene}, as ${nameOf(side)} captures it`, `${as}: ${nameOf(side)}, exposed for ${Number(side.exposureMs.toPrecision(3))} ms`);
  return section("Pictures", make("div", { class: "pictures" },
    learned(own, "Design"), pin && learned(pin, "Pinned"), figure(reference, `${scene}, as the standard observer sees it`, "Reference: the scene as the standard observer sees it")),
  make("p", { class: "hint" }, `${own.picture.width} × ${own.picture.height} pixels, one for each pixel of the sensor.`));
}

/** The doubt of the page. */
const aboutDoubt = () => `The doubt states how far a change on the page of the studio can be trusted: between ten designs with the sensor and the lens of bayer at 1, 10 and 80 cd/m², 95 % of the changes agree within it with those of pipelines learned from all training scenes. It is ${doubtsText()}. Changes within it, or below the smallest relevant difference, are called neither better nor worse.`;

/** @param {Report} report */
function scores({ own, pin, rows, isClipped, clips, warnings }) {
  const head = [["Score"], [pin ? nameOf(own) : "Value"], ...(pin ? [[nameOf(pin)], ["Change"], ["Doubt"]] : [])];
  const all = rows.map(({ score, value, before, change, doubt }) => [
    [score.label, score.unit && make("span", { class: "hint" }, ` ${score.unit}`)], [value ?? "–"],
    ...(pin ? [[before ?? "–"], [make("span", { class: "delta", "data-kind": change?.kind }, change?.shown ?? "–")], [doubt ? `± ${doubt}` : "–"]] : []),
  ]);
  return section("Scores",
    table(pin ? `Scores of ${nameOf(own)}, and how they differ from those of the pinned ${nameOf(pin)}` : `Scores of ${nameOf(own)}`, head, all, { kind: "scored" }),
    pin && make("p", { class: "hint" }, aboutDoubt(), isClipped && ` More than ${clips.most} % of the samples of a picture saturate, so the page does not judge changes of the scores of the picture.`),
    make("h3", {}, "Warnings"),
    warnings.length > 0 ? make("ul", { class: "notice" }, ...warnings.map((warning) => make("li", {}, warning))) : make("p", {}, "No warnings."),
    make("h3", {}, "Definitions"), make("dl", { class: "hint" }, ...rows.flatMap(({ score }) => [make("dt", {}, score.label), make("dd", {}, definition(score))])));
}

/** The curve of a filter in words. @param {import("./design.js").Filter} filter @param {import("./engine.js").Layer[] | null} pigments */
function filterText(filter, pigments) {
  const thickness = thicknessOf(filter);
  const text = thickness === 1 ? curveText(filter) : `${curveText(baseOf(filter))}, ${thickness} times as thick`;
  return filter.samples && pigments ? `${text}. ${pigmentsText(pigments)}` : text;
}

/** The mosaic and the filters of a design. @param {Side} side @param {string} title @param {string} id A name for the colours of axes. */
function design({ camera, curves }, title, id) {
  const colors = Object.fromEntries(curves.channels.map(({ letter, color }) => [letter, color]));
  const { pattern, filters } = camera.sensor.cfa;
  const frame = frameOf(PLOT_WIDTH, FILTERS_HEIGHT, 1);
  const plot = (/** @type {import("./filter-plot.js").Kind} */ kind, /** @type {string} */ caption) => make("figure", {},
    draw("svg", { viewBox: `0 0 ${PLOT_WIDTH} ${FILTERS_HEIGHT}`, role: "img", "aria-label": `${caption}, for the filters ${curves.channels.map((c) => c.letter).join(", ")} from 380 to 780 nm` },
      spectrum(`${id}-${kind}`), ...drawnAxes(frame, `${id}-${kind}`), ...drawnCurves(frame, curves, kind)),
    make("figcaption", {}, caption));
  const cells = (/** @type {string} */ letter) => share(camera, letter).join(" of ");
  const swatch = (/** @type {string} */ letter) => draw("svg", { class: "swatch-drawing", viewBox: "0 0 10 10", "aria-hidden": "true" }, draw("rect", { width: 10, height: 10, rx: 2, fill: colors[letter] ?? UNKNOWN }));
  return section(title,
    make("div", { class: "design" }, make("figure", {}, drawnTile(pattern, colors), make("figcaption", {}, `Mosaic, ${pattern.length} × ${pattern[0].length} cells`)),
      plot("transmittance", "Transmittance of the filters"), plot("quantum_efficiency", "Quantum efficiency behind lens and infrared cut, electrons per photon")),
    make("p", { class: "hint" }, "Shaded: the light. Dashed: the lens with its infrared cut. Dotted: the sensor without filters. The colour of a curve is that of the filter as the standard observer sees it."),
    table("Filters", [["Filter"], ["Cells"], ["Curve"]], letters(camera).map((letter) => [[swatch(letter), ` ${letter}`], [cells(letter)], [filterText(filters[letter], curves.channels.find((c) => c.letter === letter)?.pigments ?? null)]]), { isUnseen: true }));
}

/** @param {Report} report */
function sensor({ own, pin, limits }) {
  const sides = [own, ...(pin ? [pin] : [])];
  const [first, ...others] = sides.map(({ camera, exposureMs }) => conditions(camera, exposureMs));
  return section("Sensor, lens and exposure",
    table("Sensor, lens and exposure", [["Condition"], ...sides.map((side) => [nameOf(side)])], first.map(([label, value], i) => [[label], [value], ...others.map((other) => [other[i][1] === value ? value : make("strong", {}, other[i][1])])]), { isUnseen: true }),
    pin && make("p", { class: "hint" }, others[0].every(([, value], i) => value === first[i][1]) ? "Both designs have these conditions." : "Bold: what differs."),
    limits !== "" && make("p", { class: "notice" }, inOneLine(limits)));
}

/** Expected figures over luminance, if they are known. @param {Report} report */
function overLight({ own, pin, over, clips }) {
  const keys = /** @type {Figure[]} */ (Object.keys(FIGURES)).filter((key) => hasCurve(over, key));
  if (keys.length === 0 || over.own.length === 0) return undefined;
  const plots = keys.map((key) => {
    const { drawn, label } = lightPlot({ width: PLOT_WIDTH, height: LIGHT_HEIGHT, scale: 1 }, over, clips, key);
    return make("figure", {}, draw("svg", { viewBox: `0 0 ${PLOT_WIDTH} ${LIGHT_HEIGHT}`, role: "img", "aria-label": label }, ...drawn), make("figcaption", {}, `${FIGURES[key]}, over luminance in cd/m²`));
  });
  const shown = (/** @type {number | undefined} */ value) => (value === undefined || !Number.isFinite(value) ? "–" : text(value, 2));
  const isCompared = pin !== undefined && over.pin.length === over.own.length;
  const rows = over.own.map((expected, i) => [
    [String(Number(expected.luminance_cd_m2.toPrecision(2)))],
    ...keys.map((key) => [shown(expected[key]), isCompared && make("small", {}, shown(over.pin[i][key]))]),
  ]);
  const line = (/** @type {string} */ kind) => draw("svg", { class: "line-drawing", viewBox: "0 0 28 8", "aria-hidden": "true" }, draw("path", { class: kind, d: "M0 4L28 4" }));
  return section("Over luminance",
    make("p", { class: "hint" }, "Expected figures of the best linear pipeline over the training scenes. They are computed from statistics of the light without a picture, and therefore differ from the scores of the picture. ",
      clippingText(clips)),
    make("p", { class: "legend" }, make("span", {}, line("own"), ` ${nameOf(own)}`), isCompared && make("span", {}, line("pinned"), ` ${nameOf(pin)}`), make("span", {}, line("here"), " luminance of the picture")),
    make("div", { class: "plots" }, ...plots),
    table(isCompared ? `Expected figures of ${nameOf(own)}, and below them those of ${nameOf(pin)}` : `Expected figures of ${nameOf(own)}`, [["cd/m²"], ...keys.map((key) => [FIGURES[key]])], rows));
}

/** A file of the folder in a command, quoted where a shell would split it or change it. Its name may be that of a scene as well. @param {string} name */
function inShell(name) {
  const path = `./${inOneLine(name)}`;
  return /^[\w./-]*$/.test(path) ? path : `'${path.replaceAll("'", "'\\''")}'`;
}

/** @param {Report} report */
function method({ own, pin, sceneInCommands, photograph = "", luminance, seed, version }) {
  const files = [own, ...(pin ? [pin] : [])].map(({ file }) => file).join(" ");
  const command = (/** @type {string} */ scenes) => make("pre", {}, code(`smalti compare ${files} --luminance ${luminance} --exposure own${scenes}`));
  return section("How the figures were made",
    make("p", {}, `The page of the studio of Smalti ${version} simulated the camera in the browser, with the library of the command. It learned the pipeline of each design at eleven exposures, from the dark to saturation, from one training scene of 160 × 160 pixels and from uniform surfaces, captured the scene once (noise seed ${seed}), and scored the whole picture against the reference. Resolution and noise are measured on targets, as by `, code("smalti compare"), "."),
    sceneInCommands === undefined && make("p", {}, "The scene is a photograph. Its spectra are estimated from its colours: smooth reflectances in daylight (Jakob and Hanika 2019). The first command reads its file."),
    make("p", {}, `For full figures, save the camera ${pin ? "files" : "file"} below and run the command. It learns from all training scenes and captures at the size of the sensor, with three noise realisations. ${pin ? "It states the differences between the two cameras with their confidence intervals." : "With a second camera in the command, it also states the differences between the two with their confidence intervals."} On the scene of this report, the intervals cover the noise:`),
    command(` --scene ${sceneInCommands ?? inShell(photograph)}`),
    make("p", {}, "On all natural scenes, they cover the scenes too:"), command(""));
}

/** @param {Report} report */
function files({ own, pin, sceneInCommands, fragment, studio }) {
  const camera = (/** @type {Side} */ side) => make("details", {}, make("summary", {}, `Camera file of ${nameOf(side)}`),
    make("p", {}, make("a", { href: `data:application/toml;charset=utf-8,${encodeURIComponent(side.toml)}`, download: side.file }, `Save ${side.file}`)), make("pre", {}, code(side.toml.split("\n").map(inOneLine).join("\n"))));
  return section(pin ? "Address and camera files" : "Address and camera file",
    studio === undefined
      ? make("p", {}, "To open this design in a studio, start ", code("smalti studio"), " and append this text to the address of its page:")
      : make("p", {}, make("a", { href: studio + fragment }, "Open this design in the studio"), ". In another studio, such as that of ", code("smalti studio"), ", append this text to the address of its page:"),
    make("p", { class: "address" }, code(fragment)), sceneInCommands === undefined && make("p", { class: "hint" }, "The photograph is not part of this text."),
    camera(own), pin && camera(pin));
}

/** The report as HTML. @param {Report} report @returns {string} */
export function reportPage(report) {
  const { own, pin, scene, luminance, seed, version, date, brand, style } = report;
  const page = document.implementation.createHTMLDocument(`${nameOf(own)}: report of the Smalti studio`);
  page.head.prepend(
    make("meta", { charset: "utf-8" }), make("meta", { "http-equiv": "Content-Security-Policy", content: POLICY }), make("meta", { name: "viewport", content: "width=device-width, initial-scale=1" }),
    make("meta", { name: "referrer", content: "no-referrer" }), make("meta", { name: "generator", content: `Smalti ${version}` }), make("link", { rel: "icon", href: "data:," }));
  const [rows, cols] = size(own.camera);
  page.body.append(
    make("header", {}, make("p", { class: "brand" }, brand, make("span", {}, "Smalti ", make("span", { class: "second" }, "studio"))),
      make("h1", {}, nameOf(own)),
      make("p", { class: "lead" }, `Colour filter array of ${rows} × ${cols} cells with ${letters(own.camera).length} filters${pin ? `, compared with the pinned ${nameOf(pin)}` : ""}`),
      make("p", { class: "hint" }, `${scene} at ${luminance} cd/m² in daylight (D65) · noise seed ${seed} · Smalti ${version} · ${date}`),
      make("p", { class: "notice" }, "The scores are those of one scene and one noise realisation, with pipelines learned from a small training scene on the page of the studio. They have no confidence intervals; ", code("smalti compare"), " states them.")),
    make("main", {},
      pictures(report), scores(report), design(own, pin ? `Mosaic and filters of ${nameOf(own)}` : "Mosaic and filters", "own"), pin && design(pin, `Mosaic and filters of ${nameOf(pin)}`, "pinned"),
      sensor(report), overLight(report) ?? "", method(report), files(report)));
  // The policy of the page of the studio, which applies to all that it makes, allows no style within a document.
  return `<!doctype html>\n<html lang="en">\n<head>${page.head.innerHTML}<style>\n${style}</style></head>\n${page.body.outerHTML}\n</html>\n`;
}
