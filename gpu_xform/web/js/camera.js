// Cameras, as `drawing/camera.py` fits them, and what `drawing/depth.py` reads off their matrices.
import {
  addScaled, apply, clamp, cross, dot, multiply, multiply3, orthographic, perspective, rotation, scaled, subtract,
  translation, transpose3, unit,
} from "./matrices.js";

// The smallest rotation that takes +y to `up`.
export function rotationToUp(up) {
  const axis = [up[2], 0, -up[0]];
  return rotation(axis.some(Boolean) ? axis : [1, 0, 0], Math.atan2(Math.hypot(up[0], up[2]), up[1]));
}

function viewRotation(along, up) {
  const back = unit(scaled(along, -1)), right = unit(cross(up, back));
  return [right, cross(back, right), back];
}

// The matrix of a camera that looks along `direction` from just far enough away to hold all points (flat, three numbers
// each), and its options' `fovY` if it is one in perspective.
export function fitCamera(points, { direction, up, margin, fovY, isParallel }, aspect, constants) {
  const view = viewRotation(direction, up), filled = 1 - 2 * margin, tangent = Math.tan((fovY * Math.PI) / 360) * filled;
  const [tx, ty] = [tangent * aspect, tangent];
  const low = Array(7).fill(Infinity), high = Array(7).fill(-Infinity);
  for (let i = 0; i < points.length; i += 3) {
    const p = [points[i], points[i + 1], points[i + 2]];
    const x = dot(view[0], p), y = dot(view[1], p), z = dot(view[2], p);
    [x, y, z, x + tx * z, x - tx * z, y + ty * z, y - ty * z].forEach((reach, k) => {
      if (reach < low[k]) low[k] = reach;
      if (reach > high[k]) high[k] = reach;
    });
  }
  const viewFromWorld = [...view.map(row => [...row, 0]), [0, 0, 0, 1]];
  const size = subtract(high, low);
  if (isParallel) {
    const largest = Math.max(...size);
    const half = (Math.max(size[1], size[0] / aspect, largest * 1e-6) || 1) / (2 * filled), depth = Math.max(size[2], half);
    const lens = orthographic(-half * aspect, half * aspect, -half, half, -depth, depth);
    const center = [0, 1, 2].map(k => -(low[k] + high[k]) / 2);
    return multiply(multiply(lens, translation(...center)), viewFromWorld);
  }
  const eye = [(high[3] + low[4]) / 2, (high[5] + low[6]) / 2];
  eye[2] = Math.max((high[3] - low[4]) / (2 * tx), (high[5] - low[6]) / (2 * ty));
  const extent = Math.max(...size, Math.abs(eye[2]) * 1e-6) || 1;
  eye[2] = Math.max(eye[2], high[2] + extent * constants.NEAR_FRACTION);
  const lens = perspective(fovY, aspect, (eye[2] - high[2]) / 2, (eye[2] - low[2]) * 2);
  return multiply(multiply(lens, translation(...scaled(eye, -1))), viewFromWorld);
}

// An orbit camera, as `viewer/orbit.py` has it: `axes` are the rows right, up and back in the world.
export class Orbit {
  constructor(fields) {
    Object.assign(this, fields);
  }

  with(fields) {
    return new Orbit({ ...this, ...fields });
  }

  get eye() {
    return addScaled(this.target, this.distance, this.axes[2]);
  }

  rotated(sideways, downwards) {
    const upright = dot(this.axes[1], this.up), tilted = -dot(this.axes[2], this.up);
    if (Math.hypot(upright, tilted) > this.constants.DIRECTION_EPSILON) {
      const level = Math.atan2(tilted, upright);
      downwards = clamp(downwards, level - Math.PI / 2, level + Math.PI / 2);
    }
    const turned = multiply3(rotation([1, 0, 0], downwards), this.axes);
    return this.with({ axes: multiply3(turned, rotation(this.up, sideways)) });
  }

  panned(start, end, aspect) {
    const moved = subtract(this.pointAt(start, aspect), this.pointAt(end, aspect));
    return this.with({ target: addScaled(this.target, 1, moved) });
  }

  zoomed(factor, at, aspect) {
    const { MIN_DISTANCE_RADII, MAX_DISTANCE_RADII } = this.constants, { radius } = this.bounds;
    const lowest = Math.min(MIN_DISTANCE_RADII * radius, this.distance);
    const highest = Math.max(MAX_DISTANCE_RADII * radius, this.distance);
    const distance = clamp(this.distance * factor, lowest, highest), fixed = this.pointAt(at, aspect);
    const target = addScaled(fixed, distance / this.distance, subtract(this.target, fixed));
    return this.with({ target, distance });
  }

  // A view from one of the sides that the points fill.
  seenFrom(side, points, aspect) {
    if (points.length === 0) return this;
    const [, up, back] = multiply3(this.constants.SIDES[side], transpose3(rotationToUp(this.up)));
    const { fovY, isParallel, constants } = this;
    const options = { direction: scaled(back, -1), up, margin: constants.DEFAULT_MARGIN, fovY, isParallel };
    return orbitOf(fitCamera(points, options, aspect, constants), this.bounds, constants).with({ up: this.up });
  }

  pointAt(at, aspect) {
    const half = this.halfHeight;
    const right = addScaled(this.target, (at[0] - this.shift[0]) * half * aspect, this.axes[0]);
    return addScaled(right, (at[1] - this.shift[1]) * half, this.axes[1]);
  }

  get halfHeight() {
    return this.distance * Math.tan((this.fovY * Math.PI) / 360);
  }

  clipFromWorld(aspect) {
    const eye = this.eye, view = [...this.axes.map(row => [...row, -dot(row, eye)]), [0, 0, 0, 1]];
    const depth = dot(this.axes[2], subtract(eye, this.bounds.center)), { radius } = this.bounds;
    let lens;
    if (this.isParallel) {
      const half = this.halfHeight;
      lens = orthographic(-half * aspect, half * aspect, -half, half, depth - 2 * radius, depth + 2 * radius);
      lens[0][3] += this.shift[0];
      lens[1][3] += this.shift[1];
    } else {
      const near = this.constants.NEAR_FRACTION * this.distance;
      lens = perspective(this.fovY, aspect, near, Math.max(this.constants.FAR_FRACTION * this.distance, 2 * (depth + radius)));
      lens[0][2] -= this.shift[0];
      lens[1][2] -= this.shift[1];
    }
    return multiply(lens, view);
  }
}

// The orbit that sees what a matrix shows, its `up` that of the picture.
export function orbitOf(clipFromWorld, bounds, constants) {
  const [x, y, , w] = clipFromWorld, isParallel = !w.slice(0, 3).some(Boolean);
  const common = { bounds, constants, isParallel, shift: [0, 0] };
  if (isParallel) {
    const right = unit(x), up = unit(y), back = cross(right, up);
    const lengths = [x, y].map(row => Math.hypot(row[0], row[1], row[2]) / w[3]);
    const half = 1 / lengths[1], distance = half / Math.tan((constants.DEFAULT_FOV_Y * Math.PI) / 360);
    const onPlane = addScaled(scaled(right, -x[3] / w[3] / lengths[0]), (-y[3] / w[3]) * half, up);
    const target = addScaled(onPlane, dot(back, bounds.center), back);
    return new Orbit({ ...common, target, distance, axes: [right, up, back], up, fovY: constants.DEFAULT_FOV_Y });
  }
  const scale = Math.hypot(w[0], w[1], w[2]), forward = scaled(w, 1 / scale);
  const shift = [dot(x, forward) / scale, dot(y, forward) / scale];
  const right = addScaled(scaled(x, 1 / scale), -shift[0], forward);
  const up = addScaled(scaled(y, 1 / scale), -shift[1], forward);
  const eye = solve3([x, y, w]);
  let distance = dot(forward, subtract(bounds.center, eye));
  if (distance <= constants.MIN_DISTANCE_RADII * bounds.radius) distance = bounds.radius; // it looks away
  const axes = [unit(right), unit(up), scaled(forward, -1)];
  const fovY = (2 * Math.atan(1 / Math.hypot(...up)) * 180) / Math.PI;
  return new Orbit({ ...common, target: addScaled(eye, distance, forward), distance, axes, up: axes[1], fovY, shift });
}

// The point that three rows of four numbers map to zero.
function solve3([a, b, c]) {
  const volume = dot(a, cross(b, c));
  const sum = addScaled(addScaled(scaled(cross(b, c), a[3]), b[3], cross(c, a)), c[3], cross(a, b));
  return scaled(sum, -1 / volume);
}

// The matrix with reversed-Z depth: 1 at the near plane, 0 at the far plane. Those of parallel views move in on
// `points`, a function that returns flat points of the world.
export function reverseZ(clipFromWorld, points) {
  const [x, y, z, w] = clipFromWorld, reversed = [x, y, w.map((value, j) => value - z[j]), w];
  if (w.slice(0, 3).some(Boolean)) return reversed;
  const hasPlanes = z.slice(0, 3).some(Boolean);
  const row = hasPlanes ? z : [...scaled(unit(cross(unit(x), unit(y))), -1), 0];
  let low = Infinity, high = -Infinity;
  const all = points();
  for (let i = 0; i < all.length; i += 3) {
    const depth = (row[0] * all[i] + row[1] * all[i + 1] + row[2] * all[i + 2] + row[3]) / w[3];
    low = Math.min(low, depth);
    high = Math.max(high, depth);
  }
  if (low > high) low = high = 0;
  const margin = 0.5 * (high - low) || Math.max(Math.abs(high), 1);
  [low, high] = [low - margin, high + margin];
  if (hasPlanes) [low, high] = [Math.max(low, 0), Math.min(high, 1)];
  if (low < high) reversed[2] = row.map((value, j) => (high * w[j] - value) / (high - low));
  return reversed;
}

// Where a reversed-Z view looks from, homogeneous: what its rows x, y and w map to zero, at a positive depth.
export function eyeOf([x, y, depth, w]) {
  const minor = i => {
    const [a, b, c] = [x, y, w].map(row => row.filter((_, j) => j !== i));
    return dot(a, cross(b, c));
  };
  const kernel = [0, 1, 2, 3].map(i => (i % 2 ? -1 : 1) * minor(i));
  const at = depth.reduce((sum, value, j) => sum + value * kernel[j], 0);
  return at > 0 ? kernel : kernel.map(value => -value);
}

// [a, b]: over the width of a pixel, along the view, the reversed-Z depth d changes by a d + b.
export function depthSlopePerPixel([x, y, depth, w], width) {
  const pixelsPerUnit = (Math.hypot(x[0], x[1], x[2]) * width) / 2;
  if (pixelsPerUnit === 0) return [0, 0];
  const forward = unit(cross(unit(x), unit(y))), wRate = dot(forward, w), depthRate = dot(forward, depth);
  if (wRate === 0) return [0, Math.abs(depthRate) / pixelsPerUnit];
  const rate = Math.abs(wRate) / pixelsPerUnit;
  return [rate, (-rate * depthRate) / wRate];
}

// The cue by which the farthest of the points loses `amount` of its opacity, and the nearest nothing.
export function fitDepthCue(clipFromWorld, points, amount) {
  const none = { depth_scale: 0, distance_scale: 0, offset: 0, amount: 0 };
  const isParallel = !clipFromWorld[3].slice(0, 3).some(Boolean);
  let nearest = Infinity, farthest = -Infinity;
  const all = points();
  for (let i = 0; i < all.length; i += 3) {
    const [, , z, w] = apply(clipFromWorld, [all[i], all[i + 1], all[i + 2]]);
    if (!(w > 0)) continue;
    const distance = isParallel ? -z / w : w;
    nearest = Math.min(nearest, distance);
    farthest = Math.max(farthest, distance);
  }
  if (!(farthest > nearest)) return none;
  const scale = 1 / (farthest - nearest);
  return { depth_scale: isParallel ? -scale : 0, distance_scale: isParallel ? 0 : scale, offset: -nearest * scale, amount };
}
