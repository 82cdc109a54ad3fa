// A draw list to pixels without WebGPU: faces through a depth buffer of the script's own, and lines as strokes of a 2D
// canvas, in parts where faces hide them. Fainter with distance it draws nothing.
import { HIDDEN, COLOR, unpackColor } from "./draw_list.js";

const NEAR_PX = 1; // pixels from a line whose depths count as well, so that faces do not hide their own edges
const MAX_DEPTH_PIXELS = 1 << 21; // of more, the depth buffer is coarser than the picture
const MIN_W = 1e-9;
const RELATIVE_BIAS = 2e-4; // of the reversed-Z depth of a point, by which what hides it must be nearer
const MIN_STEPS = 2;

const cssColor = ([red, green, blue, alpha]) => `rgba(${[red, green, blue].map(value => Math.round(255 * value))},${alpha})`;

// Points in pixels of the picture with their depth, four numbers each: x, y, depth and clip-space w.
function project(mesh, [x, y, z, w], [width, height]) {
  const { points, nPoints } = mesh, out = new Float64Array(4 * nPoints);
  const row = (r, i) => r[0] * points[i] + r[1] * points[i + 1] + r[2] * points[i + 2] + r[3];
  for (let k = 0; k < nPoints; k++) {
    const i = 3 * k, ww = row(w, i);
    out[4 * k] = (0.5 + (0.5 * row(x, i)) / ww) * width;
    out[4 * k + 1] = (0.5 - (0.5 * row(y, i)) / ww) * height;
    out[4 * k + 2] = row(z, i) / ww;
    out[4 * k + 3] = ww;
  }
  return out;
}

class DepthBuffer {
  constructor([width, height]) {
    this.scale = Math.min(1, Math.sqrt(MAX_DEPTH_PIXELS / (width * height)));
    this.width = Math.ceil(width * this.scale);
    this.height = Math.ceil(height * this.scale);
    this.depths = new Float32Array(this.width * this.height);
    this.colors = new Uint32Array(this.width * this.height); // packed; 0 is none
    this.isEmpty = true;
  }

  // A triangle in front of the eye, as `color`.
  fill(points, a, b, c, color) {
    const { scale, width, height } = this;
    const [ax, ay, bx, by, cx, cy] = [a, b, c].flatMap(i => [points[4 * i] * scale, points[4 * i + 1] * scale]);
    const [az, bz, cz] = [a, b, c].map(i => points[4 * i + 2]);
    if ([a, b, c].some(i => !(points[4 * i + 3] > MIN_W)) || Math.max(az, bz, cz) > 1) return;
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (!area) return;
    this.isEmpty = false;
    const top = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5)), bottom = Math.min(height - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
    const left = Math.max(0, Math.ceil(Math.min(ax, bx, cx) - 0.5)), right = Math.min(width - 1, Math.floor(Math.max(ax, bx, cx) - 0.5));
    for (let y = top; y <= bottom; y++) {
      for (let x = left; x <= right; x++) {
        const u = ((bx - x - 0.5) * (cy - y - 0.5) - (cx - x - 0.5) * (by - y - 0.5)) / area;
        const v = ((cx - x - 0.5) * (ay - y - 0.5) - (ax - x - 0.5) * (cy - y - 0.5)) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const depth = u * az + v * bz + (1 - u - v) * cz, at = y * width + x;
        if (depth > this.depths[at]) {
          this.depths[at] = depth;
          this.colors[at] = color;
        }
      }
    }
  }

  // Whether faces hide a point, and all that is beside it.
  hides(x, y, depth) {
    const { width, height, scale } = this, px = Math.floor(x * scale), py = Math.floor(y * scale);
    const limit = depth + Math.abs(depth) * RELATIVE_BIAS;
    for (let j = py - NEAR_PX; j <= py + NEAR_PX; j++) {
      for (let i = px - NEAR_PX; i <= px + NEAR_PX; i++) {
        if (i < 0 || j < 0 || i >= width || j >= height || !(this.depths[j * width + i] > limit)) return false;
      }
    }
    return true;
  }
}

function fillDepths(buffer, drawables, projected, list) {
  drawables.forEach(({ faces }, i) => {
    if (!faces) return;
    const { triangles, colorIndices, firstColor } = faces;
    projected[i].forEach(points => {
      for (let t = 0; 3 * t < triangles.length; t++) {
        const index = colorIndices ? (colorIndices.length === 1 ? 0 : colorIndices[t]) : 0;
        const color = colorIndices ? list.palette[firstColor + index] : 0;
        buffer.fill(points, triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2], color);
      }
    });
  });
  return buffer;
}

// The parts of a segment before the eye, cut where they begin or end to be hidden: (x0, y0, x1, y1, isHidden) each.
function* cutSegment(points, a, b, buffer, size) {
  let [p, q] = [a, b].map(i => Array.from(points.subarray(4 * i, 4 * i + 4)));
  if (!(p[3] > MIN_W) || !(q[3] > MIN_W)) return;
  const isOutside = k => (p[k] < 0 && q[k] < 0) || (p[k] > size[k] && q[k] > size[k]);
  if (isOutside(0) || isOutside(1)) return;
  if (!buffer) {
    yield [p[0], p[1], q[0], q[1], false];
    return;
  }
  const length = Math.hypot(q[0] - p[0], q[1] - p[1]), n = Math.min(Math.max(MIN_STEPS, Math.ceil(length)), 1 << 13);
  const at = t => [0, 1, 2].map(k => p[k] + t * (q[k] - p[k]));
  let start = 0, isHidden = buffer.hides(...at(0.5 / n));
  for (let i = 1; i <= n; i++) {
    const next = i < n ? buffer.hides(...at((i + 0.5) / n)) : !isHidden;
    if (next === isHidden) continue;
    const [x0, y0] = at(start / n), [x1, y1] = at(i / n);
    yield [x0, y0, x1, y1, isHidden];
    [start, isHidden] = [i, next];
  }
}

export function openFlat(canvas) {
  const context = canvas.getContext("2d", { willReadFrequently: true });

  function drawLines(lines, projected, buffer, view, constants) {
    const paths = new Map(); // by colour, of visible and of hidden parts
    const pathOf = (color, isHidden) => {
      const key = `${color} ${isHidden}`;
      if (!paths.has(key)) paths.set(key, { path: new Path2D(), color, isHidden });
      return paths.get(key).path;
    };
    const colorOf = i => {
      if (lines.colorMode === COLOR.uniform) return cssColor(lines.color);
      if (lines.colorMode === COLOR.perEdge) return cssColor(unpackColor(lines.colors[i]));
      const ends = [0, 1].map(k => unpackColor(lines.colors[lines.edges[2 * i + k]]));
      return cssColor(ends[0].map((value, k) => (value + ends[1][k]) / 2));
    };
    for (const points of projected) {
      for (let i = 0; i < lines.nEdges; i++) {
        const [a, b] = [lines.edges[2 * i], lines.edges[2 * i + 1]];
        if (lines.arePoints) {
          const [x, y, depth, w] = points.subarray(4 * a, 4 * a + 4), isHidden = Boolean(buffer?.hides(x, y, depth));
          if (!(w > MIN_W)) continue;
          const path = pathOf(colorOf(i), isHidden), radius = (lines.lineWidth ?? 1) / 2;
          path.moveTo(x + radius, y);
          path.arc(x, y, radius, 0, 2 * Math.PI);
          continue;
        }
        for (const [x0, y0, x1, y1, isHidden] of cutSegment(points, a, b, buffer, view.size)) {
          const path = pathOf(colorOf(i), isHidden);
          path.moveTo(x0, y0);
          path.lineTo(x1, y1);
        }
      }
    }
    for (const { path, color, isHidden } of paths.values()) {
      const isShown = isHidden ? lines.hidden !== HIDDEN.remove : lines.hidden !== HIDDEN.only;
      if (!isShown) continue;
      const isFaded = isHidden && lines.hidden === HIDDEN.fade;
      context.globalAlpha = lines.opacity * (isFaded ? constants.HIDDEN_FADE_ALPHA : 1);
      context.setLineDash(lines.hidden === HIDDEN.dash && !isHidden ? [] : lines.dash);
      context.lineWidth = lines.lineWidth ?? 1;
      context.strokeStyle = context.fillStyle = color;
      if (lines.arePoints) context.fill(path);
      else context.stroke(path);
    }
    context.globalAlpha = 1;
    context.setLineDash([]);
  }

  function drawFaces(buffer, size) {
    const { width, height, colors } = buffer, image = new ImageData(width, height);
    new Uint32Array(image.data.buffer).set(colors);
    const layer = new OffscreenCanvas(width, height);
    layer.getContext("2d").putImageData(image, 0, 0);
    context.drawImage(layer, 0, 0, ...size);
  }

  function draw(list, view, constants) {
    const { size, background } = view, alpha = background[3] || 1;
    context.clearRect(0, 0, ...size);
    context.fillStyle = cssColor([...background.slice(0, 3).map(value => value / alpha), background[3]]);
    context.fillRect(0, 0, ...size);
    context.lineCap = "round";
    const projectAll = drawables => drawables.map(({ mesh, matrices }) => matrices.map(matrix => project(mesh, matrix, size)));
    const projected = projectAll(list.drawables);
    const faces = fillDepths(new DepthBuffer(size), list.drawables, projected, list);
    const covers = list.covers ? fillDepths(new DepthBuffer(size), list.covers, projectAll(list.covers), list) : faces;
    if (list.palette.length) drawFaces(faces, size);
    list.drawables.forEach((drawable, i) => {
      for (const lines of drawable.lines) {
        const hiders = lines.isCovered ? covers : faces;
        if (lines.hidden === HIDDEN.only && hiders.isEmpty) continue;
        const isTested = lines.hidden !== HIDDEN.show && !hiders.isEmpty;
        drawLines(lines, projected[i], isTested ? hiders : null, view, constants);
      }
    });
  }

  async function readPixels(list, view, constants) {
    const beside = new OffscreenCanvas(...view.size); // the canvas of the page has another size
    openFlat(beside).draw(list, view, constants);
    return new Uint8Array(beside.getContext("2d").getImageData(0, 0, ...view.size).data.buffer);
  }

  return { name: "Canvas 2D", draw, readPixels, maxPixels: Infinity, whenDone: async () => {}, whenLost: new Promise(() => {}) };
}
