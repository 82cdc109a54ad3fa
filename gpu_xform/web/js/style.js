// What the keys of a page change of the models' own styles, as `viewer/style_overrides.py` does in the window. A layer
// is an object with the fields of `gpu_xform.Layer`; `edges` holds `base`, the name of a set, "own" or null, and
// whether there is a `silhouette`; `colors` holds what its lines are coloured by, `fill` what its faces are.

export const NO_OVERRIDES = { edges: null, hidden: null, filled: null, faceColors: null, antialias: null, background: null };

const onOff = value => (value ? "on" : "off");
const following = (value, cycle) => cycle[(cycle.indexOf(value) + 1) % cycle.length];

export const hasFaces = layer => layer.mesh.nFaces > 0;
export const colorsByFace = layer => layer.colors.kind === "face" || layer.colors.kind === "cycle";

function edgeSetName({ base, silhouette }) {
  if (base === "own" || (base && silhouette)) return null;
  return silhouette ? "silhouette" : base;
}
const shownEdges = (overrides, layer) => overrides.edges ?? edgeSetName(layer.edges);
const isFilled = (overrides, layer) => overrides.filled ?? layer.fill !== null;
const hasFaceColors = (overrides, layer) => overrides.faceColors ?? (colorsByFace(layer) || layer.fill?.kind === "cycle");

// Each returns overrides and a note on what has changed; `layer` has the values from which keys cycle.
export const STYLE_KEYS = {
  e(overrides, layer, constants) {
    const has = name => name === "silhouette" || layer.mesh.edgeRows(name).length > 0;
    const edges = following(shownEdges(overrides, layer), constants.EDGE_CYCLE.filter(has));
    return [{ ...overrides, edges }, `edges: ${edges}`];
  },
  d(overrides, layer, constants) {
    const given = layer.hidden === null && layer.hiddenStyle ? "dash" : layer.hidden;
    const standard = isFilled(overrides, layer) ? "remove" : "show";
    const hidden = following(overrides.hidden ?? given ?? standard, constants.HIDDEN_STYLES);
    return [{ ...overrides, hidden }, `hidden edges: ${hidden}`];
  },
  f(overrides, layer) {
    const filled = !isFilled(overrides, layer);
    return [{ ...overrides, filled }, `faces filled: ${onOff(filled)}`];
  },
  c(overrides, layer) {
    const faceColors = !hasFaceColors(overrides, layer);
    const filled = faceColors && shownEdges(overrides, layer) !== "all" ? true : overrides.filled;
    return [{ ...overrides, faceColors, filled }, `one colour per face: ${onOff(faceColors)}`];
  },
  a(overrides, layer) {
    const antialias = !(overrides.antialias ?? layer.antialias);
    return [{ ...overrides, antialias }, `smooth lines: ${onOff(antialias)}`];
  },
};

// The next of three backgrounds: the first, light and dark.
export function nextBackground(overrides, initial, constants) {
  const isSame = (a, b) => a.every((value, i) => value === b[i]);
  const others = [constants.LIGHT, constants.DARK].filter(({ color }) => !isSame(color, initial));
  const cycle = [{ name: "as at first", color: null }, ...others];
  const at = cycle.findIndex(({ color }) => color === overrides.background);
  const { name, color } = cycle[(at + 1) % cycle.length];
  return [{ ...overrides, background: color }, `background: ${name}`];
}

// The layer in the style that is shown, its lines and points `pixelRatio` times as wide.
export function applyOverrides(layer, overrides, pixelRatio, constants) {
  const shown = { ...layer, lineWidth: layer.lineWidth * pixelRatio };
  if (layer.hiddenStyle?.lineWidth) {
    shown.hiddenStyle = { ...layer.hiddenStyle, lineWidth: layer.hiddenStyle.lineWidth * pixelRatio };
  }
  let size = layer.pointSize;
  if (size === null && !hasFaces(layer) && layer.edges.base === "all") size = constants.CLOUD_POINT_SIZE_PX;
  if (size !== null) shown.pointSize = size * pixelRatio;
  if (overrides.antialias !== null) shown.antialias = overrides.antialias;
  if (hasFaces(layer)) {
    if (overrides.hidden !== null) {
      shown.hidden = overrides.hidden;
      if (overrides.hidden !== "dash" && overrides.hidden !== "fade") shown.hiddenStyle = null;
    }
    changeFaces(shown, layer, overrides, constants);
  }
  const { colors } = shown;
  const isBlack = colors.kind === "one" && colors.color.slice(0, 3).every(value => value === 0);
  if (overrides.background === constants.DARK.color && shown.fill === null && isBlack) {
    shown.colors = { kind: "one", color: [1, 1, 1, colors.color[3]] };
  }
  return shown;
}

function changeFaces(shown, layer, overrides, constants) {
  const black = { kind: "one", color: [0, 0, 0, 1] };
  if (overrides.edges !== null) {
    const isSilhouette = overrides.edges === "silhouette";
    shown.edges = { base: isSilhouette ? null : overrides.edges, silhouette: isSilhouette };
    if (layer.colors.kind === "edge" && edgeSetName(layer.edges) === null) shown.colors = black;
  }
  const cycle = layer.colors.kind === "face" ? { kind: "face", values: layer.colors.values } : { kind: "cycle" };
  const plain = { kind: "one", color: constants.DEFAULT_FILL };
  let fill = layer.fill;
  if (overrides.filled !== null) fill = overrides.filled ? fill ?? plain : null;
  if (fill !== null && overrides.faceColors !== null) {
    if (overrides.faceColors) fill = cycle;
    else if (fill.kind === "cycle") fill = plain;
  }
  shown.fill = fill;
  const isAll = shown.edges.base === "all" && !shown.edges.silhouette;
  if (overrides.faceColors && fill === null && isAll) {
    if (layer.colors.kind !== "face") shown.colors = { kind: "cycle" };
  } else if (colorsByFace(layer) && (overrides.faceColors === false || (overrides.edges !== null && !isAll))) {
    shown.colors = black;
  }
}
