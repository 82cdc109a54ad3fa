// A page: its scene, the view of it, and the pictures that WebGPU draws, or a 2D canvas where there is none.
import { Orbit, fitCamera, orbitOf, reverseZ } from "./camera.js";
import { Controls } from "./controls.js";
import { buildDrawList, pointsInWorld } from "./draw_list.js";
import { unpack } from "./arrays.js";
import { openFlat } from "./flat.js";
import { openGpu } from "./gpu.js";
import { rowsOf } from "./matrices.js";
import { PageMesh } from "./mesh.js";
import { Player } from "./player.js";
import { applyOverrides, hasFaces } from "./style.js";

const MATRIX_NUMBERS = 16;
const NOTE_S = 2.5; // that a note on what a key did is shown
const HELP_KEYS = ["h", "?", "/", "F1"];

// Layers with their meshes and arrays in place of numbers.
function readScene({ arrays, ...scene }) {
  const meshes = scene.meshes.map(given => new PageMesh(given, arrays)), read = number => (number === null ? null : arrays[number]);
  let id = 0;
  const colored = colors => colors && { ...colors, id: ++id, values: "values" in colors ? read(colors.values) : undefined };
  const layers = scene.layers.map(layer => ({
    ...layer, mesh: meshes[layer.mesh], worlds: read(layer.matrices), ownEdges: read(layer.ownEdges), cornerNormals: read(layer.cornerNormals),
    colors: colored(layer.colors), fill: colored(layer.fill),
  }));
  const { camera } = scene, { center } = camera.bounds;
  const points = read(camera.points ?? null)?.map((offset, i) => center[i % 3] + offset);
  return { ...scene, layers, camera: { ...camera, points } };
}

function matricesAt({ worlds, nInstances }, frame) {
  const perFrame = MATRIX_NUMBERS * nInstances, first = worlds.length > perFrame ? frame * perFrame : 0;
  return Array.from({ length: nInstances }, (_, i) => rowsOf(worlds, first + MATRIX_NUMBERS * i));
}

// Puts all but the poster on the page.
function lay(document, { style, controls, player, help, playerHelp }, { nFrames }) {
  const part = (tag, content) => Object.assign(document.createElement(tag), content);
  document.head.append(part("style", { textContent: style }));
  const view = document.querySelector("#view");
  view.insertAdjacentHTML("beforeend", controls);
  view.insertAdjacentHTML("afterend", player);
  view.querySelector("canvas").setAttribute("aria-label", document.title);
  const list = view.querySelector("#help");
  for (const [keys, effect, key] of nFrames > 1 ? [...help, ...playerHelp] : help) {
    const row = part(key ? "button" : "div", {});
    if (key) row.dataset.key = key;
    row.append(part("b", { textContent: keys }), part("span", { textContent: effect }));
    list.append(row);
  }
}

// inflate : returns the bytes of a text of the page
export async function openPage(program, text, inflate, document) {
  const given = unpack(await inflate(text));
  const scene = readScene(given), { constants } = program, find = selector => document.querySelector(selector);
  lay(document, program, scene);
  const { bounds, fit, orbit } = scene.camera;
  const first = new Orbit({ ...orbit, bounds, constants });
  const place = (layers, frame) => layers.map(layer => ({ ...layer, matrices: matricesAt(layer, frame) }));
  const page = { isReady: false, scene, constants };

  function firstMatrix({ fit, points, orbit, bounds }, aspect) {
    return fit ? fitCamera(points, fit, aspect, constants) : new Orbit({ ...orbit, bounds, constants }).clipFromWorld(aspect);
  }
  const matrixFor = (aspect, shown) => shown?.clipFromWorld(aspect) ?? firstMatrix(scene.camera, aspect);
  const orbitFor = aspect => (fit ? orbitOf(matrixFor(aspect, null), bounds, constants).with({ up: first.up }) : first);

  // What is drawn at a frame, of a size in pixels.
  function describe(size, pixelRatio, frame, clipFromWorld, shown = scene) {
    const { overrides } = controls;
    const layers = place(shown.layers.map(layer => applyOverrides(layer, overrides, pixelRatio, constants)), frame);
    let found = null;
    const worldPoints = () => (found ??= pointsInWorld(layers));
    const [r, g, b, a] = overrides.background ?? shown.background;
    const reversed = reverseZ(clipFromWorld, worldPoints);
    const view = { size, clipFromWorld: reversed, background: [r * a, g * a, b * a, a] };
    return [buildDrawList(layers, reversed, worldPoints, constants), view];
  }

  let canvas = find("canvas"), renderer = null;
  const initial = {
    orbit: orbitFor, points: () => pointsInWorld(place(scene.layers, player.frame)),
    layer: scene.layers.find(hasFaces) ?? scene.layers[0], background: scene.background,
  };
  let isQueued = false;
  const redraw = () => {
    if (isQueued || !renderer) return;
    isQueued = true;
    requestAnimationFrame(draw);
  };

  function draw() {
    isQueued = false;
    const area = canvas.clientWidth * canvas.clientHeight, ratio = devicePixelRatio || 1;
    if (!area) return;
    const pixelRatio = Math.min(ratio, Math.sqrt(renderer.maxPixels / area));
    const size = [canvas.clientWidth, canvas.clientHeight].map(side => Math.max(1, Math.floor(side * pixelRatio)));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    renderer.draw(...describe(size, pixelRatio, player.frame, matrixFor(size[0] / size[1], controls.orbit)), constants);
    tell();
    page.nDrawn = (page.nDrawn ?? 0) + 1;
    if (!page.isReady) renderer.whenDone().then(() => {
      page.isReady = true;
      document.documentElement.classList.add("live");
    });
  }

  let told = "";
  function tell() {
    if (controls.note === told) return;
    told = controls.note;
    const note = find("#note");
    note.textContent = told;
    note.classList.toggle("shown", told !== "");
    clearTimeout(tell.timer);
    tell.timer = setTimeout(() => {
      note.classList.remove("shown");
      controls.note = told = "";
    }, 1000 * NOTE_S);
  }

  const player = new Player(find("#player"), scene.nFrames, scene.fps, redraw);
  let controls = new Controls(canvas, initial, constants, redraw);

  async function save() {
    draw();
    const blob = await new Promise(done => canvas.toBlob(done, "image/png"));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${document.title.replace(/[^\w.-]+/g, "_") || "picture"}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  const help = find("#help");
  function press(name, hasShift = false) {
    if (HELP_KEYS.includes(name)) help.hidden = !help.hidden;
    else if (name === "Escape" || name === "q") help.hidden = true;
    else if (name === "s") save();
    else if (name === " " && scene.nFrames > 1) player.toggle();
    else return controls.key(name, hasShift);
    return true;
  }
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("input, select")) return;
    if (event.key === " " && event.target.matches("button")) return;
    if (press(event.key.length === 1 ? event.key.toLowerCase() : event.key, event.shiftKey)) event.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-key]")) button.onclick = () => press(button.dataset.key);

  async function open() {
    const isFlat = new URLSearchParams(location.search).has("flat");
    const isOpaque = scene.background[3] === 1;
    const opened = isFlat ? null : await openGpu(program, canvas, isOpaque).catch(error => console.warn(error));
    renderer = opened ?? openFlat(canvas);
    page.renderer = renderer;
    document.documentElement.dataset.renderer = renderer.name;
    redraw();
    renderer.whenLost.then(() => { // a driver that restarts: a canvas has one kind of context for good
      const next = canvas.cloneNode();
      canvas.replaceWith(next);
      const { orbit: shown, overrides } = controls;
      canvas = next;
      controls = Object.assign(new Controls(canvas, initial, constants, redraw), { orbit: shown, overrides });
      new ResizeObserver(redraw).observe(canvas);
      page.renderer = renderer = openFlat(canvas);
      document.documentElement.dataset.renderer = renderer.name;
      redraw();
    });
  }
  new ResizeObserver(redraw).observe(canvas);

  // For tests and other scripts: pixels of a picture of any size, four bytes each, premultiplied.
  page.readPixels = (size, { frame = player.frame, clipFromWorld = null, pixelRatio = 1 } = {}) => {
    const matrix = clipFromWorld ?? matrixFor(size[0] / size[1], controls.orbit);
    return renderer.readPixels(...describe(size, pixelRatio, frame, matrix), constants);
  };
  page.decode = async other => unpack(await inflate(other));
  page.readPixelsOf = (other, size) => {
    const shown = readScene(other), matrix = firstMatrix(shown.camera, size[0] / size[1]);
    return renderer.readPixels(...describe(size, 1, 0, matrix, shown), constants);
  };
  Object.assign(page, { press, player, controls, redraw, drawNow: draw });
  await open();
  return page;
}
