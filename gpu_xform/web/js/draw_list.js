// Layers to what is drawn, as `drawing/build_draw_list.py` does: drawables with points, matrices, faces and lines.
import { eyeOf, fitDepthCue } from "./camera.js";
import { apply, cross, dot, multiply, multiply3, scaled, transpose3, unit } from "./matrices.js";
import { NO_FACE } from "./mesh.js";
import { colorsByFace } from "./style.js";

export const HIDDEN = { show: 0, remove: 1, dash: 2, fade: 3, only: 4 };
export const COLOR = { uniform: 0, perEdge: 1, perVertex: 2 };
const OPAQUE = 0xff000000;
const NO_LIGHT = Array(3).fill([0, 0, 0, 0]);
const FIRST_COLOR = Uint32Array.of(0);
const MAX_SILHOUETTE_TURN_DEGREES = 180;

export function packColor([red, green, blue, alpha]) {
  const byte = value => Math.round(255 * value);
  return (byte(red) | (byte(green) << 8) | (byte(blue) << 16) | (byte(alpha) << 24)) >>> 0;
}
export const unpackColor = packed => [0, 8, 16, 24].map(shift => ((packed >>> shift) & 255) / 255);

const transparencies = new WeakMap();
function hasTransparency(colors) {
  if (!transparencies.has(colors)) transparencies.set(colors, colors.some(color => color < OPAQUE));
  return transparencies.get(colors);
}

const hiddenMode = layer => {
  if (layer.hidden === null && layer.hiddenStyle) return HIDDEN.dash;
  return HIDDEN[layer.hidden ?? (layer.fill ? "remove" : "show")];
};

// The colours of faces, one or one per face, straight alpha, packed.
function faceColors({ kind, color, values }, nFaces, constants) {
  if (kind === "one") return Uint32Array.of(packColor(color));
  if (kind === "cycle") return Uint32Array.from({ length: nFaces }, (_, f) => packColor(constants.COLOR_CYCLE[f % constants.COLOR_CYCLE.length]));
  return values;
}

// All that is drawn of layers, whose `matrices` stand them in the world, by a reversed-Z view.
//   worldPoints : returns flat points of the world between which all lies, for depth cues
export function buildDrawList(layers, clipFromWorld, worldPoints, constants) {
  const opaque = layers.map(layer => findOpaque(layer, constants));
  const hasCovers = layers.length > 1 && opaque.some(cover => cover.some(Boolean));
  const list = { drawables: [], palette: [], covers: [] };
  let isAnyCovered = false;
  layers.forEach((layer, i) => {
    const isCovered = hasCovers && layer.hidden === null && !layer.hiddenStyle && layer.fill === null;
    isAnyCovered ||= isCovered;
    const builder = new LayerBuilder(layer, clipFromWorld, worldPoints, constants, isCovered);
    const built = builder.build(list.palette);
    list.drawables.push(...built);
    if (hasCovers && opaque[i].some(Boolean)) list.covers.push(...coversOf(layer, built, opaque[i]));
  });
  const hasOthers = list.drawables.some(({ faces }) => faces && !faces.isOpaque);
  if (!(isAnyCovered && hasOthers && list.covers.length)) list.covers = null;
  return list;
}

function findOpaque(layer, constants) {
  if (layer.fill === null || layer.alpha < 1) return [false];
  return Array.from(faceColors(layer.fill, layer.mesh.nFaces, constants), color => color >= OPAQUE);
}

function coversOf(layer, drawables, opaque) {
  const withFaces = drawables.filter(({ faces }) => faces);
  if (opaque.every(Boolean)) return withFaces.map(drawable => ({ ...drawable, lines: [] }));
  const { corners, faces } = layer.mesh.triangles, chosen = [];
  faces.forEach((f, t) => opaque[f] && chosen.push(...corners.subarray(3 * t, 3 * t + 3)));
  const triangles = layer.mesh.keep("covers", () => Uint32Array.from(chosen));
  return withFaces.map(drawable => ({ ...drawable, faces: { ...drawable.faces, triangles, colorIndices: null }, lines: [] }));
}

// Strokes of hidden parts before all others: silhouettes have strokes of both.
function putHiddenFirst(drawables) {
  const isHidden = ({ hidden }) => hidden === HIDDEN.only;
  if (drawables.filter(({ lines }) => lines.length).length < 2 || !drawables.some(({ lines }) => lines.some(isHidden))) return drawables;
  const first = drawables.map(drawable => ({ ...drawable, lines: drawable.lines.filter(isHidden) }));
  const then = drawables.map(drawable => ({ ...drawable, faces: null, lines: drawable.lines.filter(line => !isHidden(line)) }));
  return [...first.filter(({ faces, lines }) => faces || lines.length), ...then.filter(({ lines }) => lines.length)];
}

class LayerBuilder {
  constructor(layer, clipFromWorld, worldPoints, constants, isCovered) {
    Object.assign(this, { layer, mesh: layer.mesh, clipFromWorld, constants, isCovered });
    const { center, halfSize } = layer.mesh;
    const modelFromPoints = [0, 1, 2].map(i => [0, 1, 2].map(j => (i === j ? halfSize : 0)).concat(center[i]));
    modelFromPoints.push([0, 0, 0, 1]);
    const products = layer.matrices.map(world => multiply(multiply(clipFromWorld, world), modelFromPoints));
    const scale = Math.max(...products.flat(2).map(Math.abs)) || 1;
    this.clipFromPoints = products.map(matrix => matrix.map(row => row.map(value => value / scale)));
    const varies = layer.dash.length > 0 || [HIDDEN.dash, HIDDEN.fade].includes(hiddenMode(layer));
    const needsOrder = layer.colors.kind !== "one" || (!layer.antialias && varies) || layer.depthCue > 0;
    this.depthCue = needsOrder
      ? fitDepthCue(clipFromWorld, worldPoints, layer.depthCue)
      : { depth_scale: 0, distance_scale: 0, offset: 0, amount: 0 };
    this.depthCue.distance_scale *= scale;
  }

  build(palette) {
    const { layer, mesh } = this, base = layer.edges.base;
    const drawables = [], common = { mesh, matrices: this.clipFromPoints, faces: null, lines: [] };
    const isSeen = layer.alpha > 0 && !(layer.colors.kind === "one" && layer.colors.color[3] === 0);
    let faces = this.faces(palette);
    if (faces && layer.shading !== "none") {
      const lit = layer.matrices.map((matrix, i) => ({ ...faces, ...this.lightOf(matrix, faces, i) }));
      if (lit.length > 1) this.clipFromPoints.forEach((matrix, i) => drawables.push({ ...common, matrices: [matrix], faces: lit[i] }));
      faces = lit.length > 1 ? null : lit[0];
    }
    const main = { ...common, faces };
    drawables.push(main);
    if (!isSeen) return drawables;
    if (base) {
      const set = this.edgeSet(base);
      if (set.edges.length) main.lines.push(...this.strokes().map(stroke => this.colored(stroke, set)));
    }
    if (layer.edges.silhouette && !colorsByFace(layer)) {
      this.clipFromPoints.forEach(matrix => {
        const lines = this.silhouette(matrix);
        if (lines.length) drawables.push({ ...common, matrices: [matrix], lines });
      });
    }
    if (layer.pointSize !== null) drawables.push({ ...common, lines: [this.dots()] });
    return putHiddenFirst(drawables);
  }

  // The edges of a set, under a key that their mesh keeps them by, and the row of each edge's colour.
  edgeSet(base) {
    const { mesh, layer } = this;
    if (colorsByFace(layer)) return { key: "edges by face", ...mesh.lastFaceEdges };
    if (base === "own") return { key: "edges own", edges: layer.ownEdges, rows: null };
    const rows = mesh.edgeRows(base);
    return { key: `edges ${base}`, edges: base === "all" ? mesh.edges : mesh.keep(`edges ${base}`, () => mesh.pickEdges(rows)), rows };
  }

  // How lines are drawn, one after the other: hidden parts before visible ones if they differ in style.
  strokes() {
    const { layer, constants } = this, mode = hiddenMode(layer), own = layer.hiddenStyle;
    const hidden = this.isCovered ? HIDDEN.remove : mode;
    const style = {
      lineWidth: layer.antialias ? layer.lineWidth : null,
      hidden, opacity: layer.alpha, isCovered: this.isCovered, depthCue: this.depthCue, dash: [],
      color: null, arePoints: false, areSilhouettes: layer.isMeeting,
    };
    const width = style.lineWidth ?? 1, inPixels = (pattern, px) => pattern.map(length => length * px);
    const hiddenDashes = px => inPixels(constants.HIDDEN_DASHES, Math.max(px, constants.MIN_HIDDEN_DASH_WIDTH_PX));
    const dash = inPixels(layer.dash, width);
    if (hidden !== HIDDEN.dash && !own) return [{ ...style, dash }];
    if (!own && !dash.length) return [{ ...style, dash: hiddenDashes(width) }];
    const behind = { ...style, hidden: HIDDEN.only, dash: [] };
    if (layer.antialias && own?.lineWidth) behind.lineWidth = own.lineWidth;
    const widthBehind = behind.lineWidth ?? 1;
    if (hidden === HIDDEN.fade) behind.opacity *= constants.HIDDEN_FADE_ALPHA;
    if (own?.dash) behind.dash = inPixels(own.dash, widthBehind);
    else if (hidden === HIDDEN.dash) behind.dash = hiddenDashes(widthBehind);
    if (own?.color) behind.color = own.color;
    return [behind, { ...style, hidden: HIDDEN.remove, dash }];
  }

  // Lines of an edge set in a stroke's style and the layer's colours, with the chains that dashes run along.
  colored(stroke, { key, edges, rows }) {
    const { mesh, constants } = this, colors = stroke.color ? { kind: "one", color: stroke.color } : this.layer.colors;
    const lines = { ...stroke, key, edges, nEdges: edges.length / 2, color: [0, 0, 0, 1], colors: null, colorMode: COLOR.uniform };
    if (colors.kind === "one") lines.color = colors.color;
    else if (colors.kind === "vertex") Object.assign(lines, { colorMode: COLOR.perVertex, colors: colors.values });
    else {
      const values = colors.kind === "edge" ? colors.values : this.keepColors(colors);
      const packed = rows ? mesh.keep(`${key} of ${colors.id ?? "cycle"}`, () => rows.map(row => values[row])) : values;
      Object.assign(lines, { colorMode: COLOR.perEdge, colors: packed });
    }
    lines.hasTransparency = lines.colors !== null && hasTransparency(lines.colors);
    if (lines.dash.length) {
      const turn = stroke.areSilhouettes ? MAX_SILHOUETTE_TURN_DEGREES : constants.MAX_TURN_DEGREES;
      lines.chains = key ? mesh.keep(`${key} chains`, () => mesh.chains(edges, turn, constants)) : mesh.chains(edges, turn, constants);
    }
    return lines;
  }

  keepColors(colors) {
    return this.mesh.keep(`colours by face ${colors.id ?? "cycle"}`, () => faceColors(colors, this.mesh.nFaces, this.constants));
  }

  // The edges that are seen edge-on by one matrix, and those that every view shows.
  silhouette(clipFromPoints) {
    const { mesh, layer } = this, eye = eyeOf(clipFromPoints), { planes, candidates } = mesh;
    const drawn = layer.edges.base && layer.edges.base !== "own" ? mesh.edgeRows(layer.edges.base) : null;
    const isDrawn = drawn && mesh.keep(`drawn ${layer.edges.base}`, () => {
      const flags = new Uint8Array(mesh.edges.length / 2);
      drawn.forEach(row => (flags[row] = 1));
      return flags;
    });
    // As extract_silhouette.wgsl: a face that is seen edge-on looks away.
    const edgeOn = this.constants.EDGE_ON_SINE * Math.hypot(eye[0], eye[1], eye[2]), towards = new Float64Array(mesh.nFaces);
    for (let f = 0; f < mesh.nFaces; f++) {
      const at = 4 * f;
      towards[f] = planes[at] * eye[0] + planes[at + 1] * eye[1] + planes[at + 2] * eye[2] + planes[at + 3] * eye[3];
    }
    const rows = [];
    for (let i = 0; i < candidates.length; i += 4) {
      const second = candidates[i + 2];
      if (isDrawn?.[candidates[i]]) continue;
      const sign = candidates[i + 3] === 1 ? -1 : 1;
      const differ = towards[candidates[i + 1]] > edgeOn !== sign * towards[second] > edgeOn;
      if (second === NO_FACE || differ) rows.push(candidates[i]);
    }
    if (!rows.length) return [];
    const set = { key: null, edges: mesh.pickEdges(rows), rows: null };
    const { colors } = layer;
    const strokes = this.strokes().map(stroke => ({ ...stroke, areSilhouettes: true }));
    return strokes.map(stroke => {
      if (colors.kind !== "edge" || stroke.color) return this.colored(stroke, set);
      const lines = this.colored({ ...stroke, color: [0, 0, 0, 1] }, set), own = Uint32Array.from(rows, row => colors.values[row]);
      return { ...lines, colorMode: COLOR.perEdge, colors: own, hasTransparency: hasTransparency(own) };
    });
  }

  // A line without length at each point.
  dots() {
    const { mesh, layer } = this, [style] = this.strokes().slice(-1);
    const edges = mesh.keep("dots", () => Uint32Array.from({ length: 2 * mesh.nPoints }, (_, i) => i >> 1));
    const mode = this.isCovered ? HIDDEN.remove : hiddenMode(layer);
    const hidden = mode === HIDDEN.dash ? HIDDEN.remove : mode;
    const isPlain = ["edge", "face", "cycle"].includes(layer.colors.kind);
    const dots = { ...style, hidden, opacity: layer.alpha, lineWidth: layer.pointSize, dash: [], arePoints: true };
    return this.colored(isPlain ? { ...dots, color: [0, 0, 0, 1] } : dots, { key: "dots", edges, rows: null });
  }

  faces(palette) {
    const { layer, mesh, constants } = this, mode = hiddenMode(layer);
    if ((mode === HIDDEN.show && layer.fill === null) || mesh.nFaces === 0) return null;
    const { corners, faces } = mesh.triangles;
    if (!corners.length) return null;
    const result = { triangles: corners, colorIndices: null, cornerNormals: null, lightFromNormals: NO_LIGHT, firstColor: palette.length, depthCue: this.depthCue, isOpaque: false };
    if (layer.fill === null) return result;
    const own = faceColors(layer.fill, mesh.nFaces, constants);
    const clear = color => packColor([...unpackColor(color).slice(0, 3), unpackColor(color)[3] * layer.alpha]);
    const transparent = layer.alpha < 1 ? own.map(clear) : own;
    const shaded = layer.shading !== "flat" ? [transparent] : layer.matrices.map(matrix => this.shade(transparent, matrix));
    shaded.forEach(colors => colors.forEach(color => palette.push(color)));
    const isOne = own.length === 1 && layer.shading !== "flat";
    result.colorIndices = isOne ? FIRST_COLOR : faces;
    if (layer.shading === "smooth") result.cornerNormals = layer.cornerNormals;
    result.isOpaque = layer.alpha >= 1 && own.every(color => color >= OPAQUE);
    return result;
  }

  // What differs between the faces of instances, each in a light of its own.
  lightOf(worldFromModel, { firstColor }, number) {
    const { layer, mesh } = this;
    if (layer.shading === "flat") return { firstColor: firstColor + (layer.fill ? number * mesh.nFaces : 0) };
    const towardsEye = this.towardsEye(), smallest = towardsEye.map(Math.abs);
    const axis = [0, 0, 0];
    axis[smallest.indexOf(Math.min(...smallest))] = 1;
    const aside = unit(cross(towardsEye, axis)), frame = [aside, cross(towardsEye, aside), towardsEye];
    const rows = multiply3(frame, transpose3(cofactorsOf(worldFromModel)));
    const largest = Math.max(...rows.flat().map(Math.abs)) || 1;
    return { lightFromNormals: rows.map(row => [...row.map(value => value / largest), 0]) };
  }

  towardsEye() {
    const { clipFromWorld } = this, w = clipFromWorld[3];
    return unit(w.slice(0, 3).some(Boolean) ? scaled(w, -1) : eyeOf(clipFromWorld));
  }

  // Lambert's law with a lamp at the eye, as `drawing/shading.py` has it.
  shade(colors, worldFromModel) {
    const { mesh, constants } = this, towardsEye = this.towardsEye(), cofactors = cofactorsOf(worldFromModel);
    const shaded = new Uint32Array(mesh.nFaces);
    for (let f = 0; f < mesh.nFaces; f++) {
      const [x, y, z] = mesh.normals.subarray(3 * f, 3 * f + 3);
      const normal = [0, 1, 2].map(j => x * cofactors[0][j] + y * cofactors[1][j] + z * cofactors[2][j]);
      const light = constants.AMBIENT + (1 - constants.AMBIENT) * Math.abs(dot(unit(normal), towardsEye));
      const [red, green, blue, alpha] = unpackColor(colors[colors.length === 1 ? 0 : f]);
      shaded[f] = packColor([red * light, green * light, blue * light, alpha]);
    }
    return shaded;
  }
}

// What rows of normals are multiplied by to go to the world.
function cofactorsOf(worldFromModel) {
  const [a, b, c] = [0, 1, 2].map(j => worldFromModel.slice(0, 3).map(row => row[j]));
  return [cross(b, c), cross(c, a), cross(a, b)];
}

// Points of the world, three numbers each, of all layers where they stand: what cameras hold and depths span.
export function pointsInWorld(layers) {
  const found = [];
  for (const { mesh, matrices } of layers) {
    for (const matrix of matrices) {
      const { shownPoints } = mesh;
      for (let i = 0; i < shownPoints.length; i += 3) {
        const [x, y, z, w] = apply(matrix, shownPoints.subarray(i, i + 3));
        if (w > 0) found.push(x / w, y / w, z / w);
      }
    }
  }
  return found;
}
