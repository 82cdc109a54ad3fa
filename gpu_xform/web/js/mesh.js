// A mesh of a page: points in the frame in which devices hold them, faces, and the edges that follow from the faces, as
// `geometry/mesh.py` and `geometry/edges.py` find them.
import { clamp, cross, dot, subtract, unit } from "./matrices.js";

export const NO_FACE = 0xffffffff;
const MAX_EDGES_AT_POINT = 64; // where more meet, no chain of edges goes on

export class PageMesh {
  constructor(given, arrays) {
    const read = index => arrays[index] ?? null; // of what is not given too
    this.center = given.center;
    this.halfSize = given.half_size;
    this.coordinates = read(given.positions); // whole numbers of steps of the grid, three per point
    this.nPoints = this.coordinates.length / 3;
    this.indices = read(given.indices);
    const sizes = read(given.sizes); // of the faces; one if all are alike
    this.nFaces = sizes.length === 1 ? this.indices.length / sizes[0] : sizes.length;
    this.offsets = new Uint32Array(this.nFaces + 1);
    for (let f = 0; f < this.nFaces; f++) this.offsets[f + 1] = this.offsets[f] + (sizes.length === 1 ? sizes[0] : sizes[f]);
    this.points = new Float64Array(this.coordinates.length);
    for (let i = 0; i < this.points.length; i++) this.points[i] = (this.coordinates[i] | 0) * given.step;
    this.given = { triangles: read(given.triangles), triangleFaces: read(given.triangle_faces) };
    this.masks = { feature: read(given.feature), boundary: read(given.boundary) };
    this.givenCandidates = read(given.candidates);
    this.flatFaces = { faces: read(given.sliver_faces), normals: read(given.sliver_normals) };
    this.kept = new Map();
  }

  keep(key, make) {
    if (!this.kept.has(key)) this.kept.set(key, make());
    return this.kept.get(key);
  }

  point(i) {
    return [this.points[3 * i], this.points[3 * i + 1], this.points[3 * i + 2]];
  }

  // Single precision, padded to whole packets of four points.
  get packedPoints() {
    const packed = new Float32Array(12 * Math.ceil(this.nPoints / 4));
    packed.set(this.points);
    return packed;
  }

  // The directed edges of the faces, one after the other; a segment has one.
  get faceEdges() {
    return this.keep("face edges", () => {
      const starts = [], ends = [], faces = [];
      for (let f = 0; f < this.nFaces; f++) {
        const first = this.offsets[f], size = this.offsets[f + 1] - first;
        for (let k = 0; k < (size === 2 ? 1 : size); k++) {
          starts.push(this.indices[first + k]);
          ends.push(this.indices[first + ((k + 1) % size)]);
          faces.push(f);
        }
      }
      return { starts: Uint32Array.from(starts), ends: Uint32Array.from(ends), faces: Uint32Array.from(faces) };
    });
  }

  // Directed edges grouped by their points, lower one first: the rows of each group ascend, and so do the groups.
  get edgeGroups() {
    return this.keep("groups", () => {
      const { starts, ends } = this.faceEdges, n = starts.length, first = new Uint32Array(this.nPoints + 2);
      for (let i = 0; i < n; i++) first[Math.min(starts[i], ends[i]) + 2]++;
      for (let i = 1; i < first.length; i++) first[i] += first[i - 1];
      const rows = new Uint32Array(n), high = i => Math.max(starts[i], ends[i]);
      for (let i = 0; i < n; i++) rows[first[Math.min(starts[i], ends[i]) + 1]++] = i;
      for (let low = 0; low < this.nPoints; low++) {
        for (let i = first[low] + 1; i < first[low + 1]; i++) {
          const row = rows[i];
          let j = i;
          for (; j > first[low] && high(rows[j - 1]) > high(row); j--) rows[j] = rows[j - 1];
          rows[j] = row;
        }
      }
      const bounds = [];
      for (let i = 0; i < n; i++) {
        const a = rows[i], b = rows[i - 1];
        const isSame = i > 0 && high(a) === high(b) && Math.min(starts[a], ends[a]) === Math.min(starts[b], ends[b]);
        if (!isSame) bounds.push(i);
      }
      bounds.push(n);
      return { rows, bounds: Uint32Array.from(bounds) };
    });
  }

  // Each edge once, lower index first, sorted: two points each.
  get edges() {
    return this.keep("edges", () => {
      const { starts, ends } = this.faceEdges, { rows, bounds } = this.edgeGroups, pairs = [];
      for (let g = 0; g + 1 < bounds.length; g++) {
        const a = starts[rows[bounds[g]]], b = ends[rows[bounds[g]]];
        if (a !== b) pairs.push(Math.min(a, b), Math.max(a, b));
      }
      return Uint32Array.from(pairs);
    });
  }

  // The last directed edge of each group, in the order of the faces, and its face: edges in the colours of faces.
  get lastFaceEdges() {
    return this.keep("last face edges", () => {
      const { starts, ends, faces } = this.faceEdges, { rows, bounds } = this.edgeGroups;
      const last = Uint32Array.from({ length: bounds.length - 1 }, (_, g) => rows[bounds[g + 1] - 1]).sort();
      const edges = new Uint32Array(2 * last.length);
      last.forEach((row, i) => edges.set([starts[row], ends[row]], 2 * i));
      return { edges, rows: last.map(row => faces[row]) };
    });
  }

  // Rows of `edges` that a set has: "all", "feature" or "boundary".
  edgeRows(name) {
    return this.keep(`rows ${name}`, () => {
      const n = this.edges.length / 2, mask = this.masks[name], rows = [];
      for (let i = 0; i < n; i++) if (name === "all" || (mask && (mask[i >> 3] >> (i & 7)) & 1)) rows.push(i);
      return Uint32Array.from(rows);
    });
  }

  pickEdges(rows) {
    const picked = new Uint32Array(2 * rows.length);
    rows.forEach((row, i) => picked.set(this.edges.subarray(2 * row, 2 * row + 2), 2 * i));
    return picked;
  }

  // The edges between two faces, or beside one, that can be seen edge-on: (row, face, face or NO_FACE, is turned) each.
  get candidates() {
    if (this.givenCandidates) return this.givenCandidates;
    return this.keep("candidates", () => {
      const { starts, ends, faces } = this.faceEdges, { rows, bounds } = this.edgeGroups, found = [];
      let row = -1;
      for (let g = 0; g + 1 < bounds.length; g++) {
        const own = rows.subarray(bounds[g], bounds[g + 1]), a = starts[own[0]], b = ends[own[0]];
        if (a === b) continue;
        row++;
        const isSegment = i => this.offsets[faces[i] + 1] - this.offsets[faces[i]] === 2;
        const beside = Array.from(own.filter((i, k) =>
          !isSegment(i) && faces[own[k - 1]] !== faces[i] && faces[own[k + 1]] !== faces[i]));
        const hasSegment = own.some(isSegment), hasLength = subtract(this.point(a), this.point(b)).some(Boolean);
        if (!hasSegment && !(beside.length && hasLength)) continue;
        if (beside.length !== 2 || hasSegment) {
          found.push(row, NO_FACE, NO_FACE, 0);
          continue;
        }
        const [one, other] = beside, isForward = i => starts[i] < ends[i];
        found.push(row, faces[one], faces[other], Number(isForward(one) === isForward(other)));
      }
      return Uint32Array.from(found);
    });
  }

  get triangles() {
    if (this.given.triangles) return { corners: this.given.triangles, faces: this.given.triangleFaces };
    return this.keep("triangles", () => {
      const corners = [], faces = [];
      for (let f = 0; f < this.nFaces; f++) {
        for (let k = this.offsets[f] + 1; k + 1 < this.offsets[f + 1]; k++) {
          corners.push(this.indices[this.offsets[f]], this.indices[k], this.indices[k + 1]);
          faces.push(f);
        }
      }
      return { corners: Uint32Array.from(corners), faces: Uint32Array.from(faces) };
    });
  }

  // The unit Newell normals of the faces, zero without area; those of slivers are given.
  get normals() {
    return this.keep("normals", () => {
      const normals = new Float64Array(3 * this.nFaces);
      for (let f = 0; f < this.nFaces; f++) {
        const start = this.point(this.indices[this.offsets[f]]), sum = [0, 0, 0];
        for (let k = this.offsets[f] + 1; k + 1 < this.offsets[f + 1]; k++) {
          const product = cross(subtract(this.point(this.indices[k]), start), subtract(this.point(this.indices[k + 1]), start));
          product.forEach((value, j) => (sum[j] += value));
        }
        normals.set(unit(sum), 3 * f);
      }
      this.flatFaces.faces?.forEach((f, i) => normals.set(this.flatFaces.normals.subarray(3 * i, 3 * i + 3), 3 * f));
      return normals;
    });
  }

  // Normal and offset of each face's plane.
  get planes() {
    return this.keep("planes", () => {
      const planes = new Float32Array(4 * this.nFaces);
      for (let f = 0; f < this.nFaces; f++) {
        const normal = this.normals.subarray(3 * f, 3 * f + 3);
        planes.set([...normal, -dot(normal, this.point(this.indices[this.offsets[f]]))], 4 * f);
      }
      return planes;
    });
  }

  // What a camera must hold: the points of faces, or all without faces, three numbers each in the model's frame.
  get shownPoints() {
    return this.keep("shown points", () => {
      const isShown = new Uint8Array(this.nPoints);
      if (this.nFaces) this.indices.forEach(i => (isShown[i] = 1));
      else isShown.fill(1);
      const shown = [];
      for (let i = 0; i < this.nPoints; i++) {
        if (isShown[i]) for (let k = 0; k < 3; k++) shown.push(this.center[k] + this.halfSize * this.points[3 * i + k]);
      }
      return Float64Array.from(shown);
    });
  }

  // A number for each point that those share that lie at one place of the grid.
  get places() {
    return this.keep("places", () => {
      const seen = new Map(), places = new Uint32Array(this.nPoints);
      for (let i = 0; i < this.nPoints; i++) {
        const key = this.coordinates.subarray(3 * i, 3 * i + 3).join();
        if (!seen.has(key)) seen.set(key, i);
        places[i] = seen.get(key);
      }
      return places;
    });
  }

  // Edges in the order in which chains pass them, as `geometry/chains.py` joins them and `drawing/dash_chains.py` packs
  // them: (edge and flags, start, end) each. Two that are each other's most opposite at a point go on.
  chains(edges, maxTurnDegrees, constants) {
    const n = edges.length / 2, partners = this.joinEnds(edges, -Math.cos((maxTurnDegrees * Math.PI) / 180));
    const packed = new Uint32Array(3 * n), isDone = new Uint8Array(n);
    let place = 0;
    for (let edge = 0; edge < n; edge++) {
      if (isDone[edge]) continue;
      let end = 2 * edge, before;
      while ((before = partners[end]) >= 0 && (before ^ 1) !== 2 * edge) end = before ^ 1;
      if (before >= 0) end = 2 * edge; // the chain is closed
      for (let isFirst = true; end >= 0 && !isDone[end >> 1]; isFirst = false, end = partners[end ^ 1]) {
        isDone[end >> 1] = 1;
        const flags = (isFirst ? constants.CHAIN_IS_FIRST : 0) + (end & 1 ? constants.CHAIN_IS_REVERSED : 0);
        packed.set([(end >> 1) + flags, edges[end], edges[end ^ 1]], 3 * place++);
      }
    }
    return packed;
  }

  joinEnds(edges, maxCosine) {
    const partners = new Int32Array(edges.length).fill(-1), ends = new Map();
    edges.forEach((point, end) => {
      const place = this.places[point];
      if (ends.has(place)) ends.get(place).push(end);
      else ends.set(place, [end]);
    });
    const towards = end => unit(subtract(this.point(edges[end ^ 1]), this.point(edges[end])));
    for (const own of ends.values()) {
      if (own.length < 2 || own.length > MAX_EDGES_AT_POINT) continue;
      const directions = own.map(towards);
      const best = directions.map((along, i) => {
        let least = Infinity, at = -1;
        directions.forEach((other, j) => {
          const cosine = Math.fround(clamp(dot(along, other), -1, 1));
          if (j !== i && cosine < least) [least, at] = [cosine, j];
        });
        return { at, isStraight: least <= maxCosine };
      });
      best.forEach(({ at, isStraight }, i) => {
        if (isStraight && best[at].at === i && (own[at] ^ 1) !== own[i]) partners[own[i]] = own[at];
      });
    }
    return partners;
  }
}
