// Vectors and 4x4 matrices of doubles, as rows: the product of `a` and `b` applies `b` first.

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const addScaled = (a, factor, b) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
export const scaled = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
export const unit = a => scaled(a, 1 / (Math.hypot(a[0], a[1], a[2]) || 1));
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

export const multiply = (a, b) =>
  a.map(row => [0, 1, 2, 3].map(j => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j] + row[3] * b[3][j]));
export const apply = (m, p) => m.map(row => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]);
export const rowsOf = (values, first = 0) => [0, 4, 8, 12].map(i => Array.from(values.subarray(first + i, first + i + 4)));
export const flattenColumns = m => [0, 1, 2, 3].flatMap(j => m.map(row => row[j]));

export function translation(x, y, z) {
  return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]];
}

// Row vectors of a 3x3 matrix times another.
export const multiply3 = (a, b) =>
  a.map(row => [0, 1, 2].map(j => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]));
export const transpose3 = m => [0, 1, 2].map(j => m.map(row => row[j]));

// By Rodrigues' formula.
export function rotation(axis, angle) {
  const [x, y, z] = unit(axis), c = Math.cos(angle), s = Math.sin(angle), k = 1 - c;
  return [
    [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
    [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
    [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
  ];
}

export function perspective(fovY, aspect, near, far) {
  const f = 1 / Math.tan((fovY * Math.PI) / 360);
  return [[f / aspect, 0, 0, 0], [0, f, 0, 0], [0, 0, far / (near - far), (near * far) / (near - far)], [0, 0, -1, 0]];
}

export function orthographic(left, right, bottom, top, near, far) {
  return [
    [2 / (right - left), 0, 0, -(right + left) / (right - left)],
    [0, 2 / (top - bottom), 0, -(top + bottom) / (top - bottom)],
    [0, 0, -1 / (far - near), -near / (far - near)],
    [0, 0, 0, 1],
  ];
}
