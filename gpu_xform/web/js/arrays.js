// Arrays as pages hold them: integers whose bytes lie plane by plane, which compress well, and floats; `arrays.py` writes
// them.

// What a page holds: a number of bytes, JSON of so many bytes, and arrays, whose places in the rest the JSON's last
// field tells.
export function unpack(bytes) {
  const nJson = new DataView(bytes.buffer).getUint32(0, true);
  const content = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + nJson)));
  const arrays = [];
  let offset = 4 + nJson;
  for (const layout of content.arrays) {
    const nBytes = layout.n * layout.columns * layout.bytes;
    arrays.push((layout.isFloat ? readFloats : readIntegers)(bytes.subarray(offset, offset + nBytes), layout, arrays));
    offset += nBytes;
  }
  return { ...content, arrays };
}

const unfold = word => (word >>> 1) ^ -(word & 1);

// Each column is the planes of its values' bytes, lowest first. They are coded as `arrays.py` says: as they are; with the
// sign in the lowest bit; so, as differences from row to row; row by row, by how far they lie below one above the largest
// before, with the sign in the lowest bit too; or by how far back they were last, 0 for the next of those that are new.
function readIntegers(bytes, { n, columns, bytes: nPlanes, coding, new: firsts }, arrays) {
  const values = new Uint32Array(n * columns), previous = new Int32Array(columns);
  let above = 0, nNew = 0;
  for (let row = 0; row < n; row++) {
    for (let column = 0; column < columns; column++) {
      let value = 0;
      for (let plane = 0; plane < nPlanes; plane++) value |= bytes[(plane * columns + column) * n + row] << (8 * plane);
      if (coding === "signed") value = unfold(value);
      else if (coding === "delta") value = previous[column] += unfold(value);
      else if (coding === "back") {
        value = (above - unfold(value)) >>> 0;
        above = Math.max(above, value + 1);
      } else if (coding === "again") value = value ? values[row * columns + column - value] : arrays[firsts][nNew++];
      values[row * columns + column] = value;
    }
  }
  return values;
}

function readFloats(bytes, { n, columns }) {
  const values = new Float64Array(n * columns), own = new Uint8Array(values.buffer);
  const count = n * columns;
  for (let row = 0; row < n; row++) {
    for (let column = 0; column < columns; column++) {
      const at = 8 * (row * columns + column);
      for (let plane = 0; plane < 8; plane++) own[at + plane] = bytes[plane * count + column * n + row];
    }
  }
  return values;
}
