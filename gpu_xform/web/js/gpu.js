// A draw list to pixels by WebGPU, with the WGSL stages that Python runs: what `raster/rasterizer.py`, `raster/triangles.py`,
// `raster/line_stage.py` and `raster/compute/lines.py` do, for a picture of one tile whose last stage draws into a canvas.
import { depthSlopePerPixel } from "./camera.js";
import { COLOR, HIDDEN } from "./draw_list.js";
import { flattenColumns } from "./matrices.js";
import { findBindings, resolveImports } from "./wgsl.js";

const WORKGROUP_SIZE = 256;
const MAX_WORKGROUPS = 65535;
const POINTS_PER_INVOCATION = 4;
const CLIP_POSITION_BYTES = 16;
const PICTURE_FORMAT = "rgba8unorm";
const TILE_VERTICES = 3;
const MAX_K = 4; // edges that a pixel tells apart

// Buffers and pipelines of one device.
class Context {
  constructor(device, program) {
    Object.assign(this, { device, program });
    this.sources = new Map();
    this.pipelines = new Map();
    this.pool = new Map();
    this.kept = new WeakMap();
  }

  source(stage) {
    if (!this.sources.has(stage)) {
      const code = resolveImports(this.program.files, this.program.stages[stage].file);
      const module = this.device.createShaderModule({ code, label: stage });
      this.sources.set(stage, { module, bindings: findBindings(code) });
    }
    return this.sources.get(stage);
  }

  pipeline(stage, constants, format = null) {
    const key = JSON.stringify([stage, format, constants]);
    if (!this.pipelines.has(key)) {
      const { module, bindings } = this.source(stage), points = this.program.stages[stage].entry_points;
      const part = kind => ({ module, entryPoint: points[kind], constants });
      const handle = format
        ? this.device.createRenderPipeline({
            layout: "auto", label: stage, vertex: part("vertex"),
            fragment: { ...part("fragment"), targets: [{ format }] },
          })
        : this.device.createComputePipeline({ layout: "auto", label: stage, compute: part("compute") });
      this.pipelines.set(key, { handle, bindings });
    }
    return this.pipelines.get(key);
  }

  bind({ handle, bindings }, resources) {
    const entries = Object.entries(bindings).map(([name, binding]) => {
      const part = resources[name];
      return { binding, resource: part instanceof GPUTextureView ? part : { buffer: part } };
    });
    return this.device.createBindGroup({ layout: handle.getBindGroupLayout(0), entries });
  }

  // A buffer that grows, kept under a name from picture to picture.
  scratch(name, nBytes, usage = 0) {
    const size = Math.max(16, 4 * Math.ceil(nBytes / 4));
    let buffer = this.pool.get(name);
    if (!buffer || buffer.size < size) {
      buffer?.destroy();
      const { STORAGE, COPY_DST, COPY_SRC, UNIFORM } = GPUBufferUsage;
      buffer = this.device.createBuffer({ size, label: name, usage: STORAGE | COPY_DST | COPY_SRC | UNIFORM | usage });
      this.pool.set(name, buffer);
    }
    return buffer;
  }

  write(name, array) {
    const buffer = this.scratch(name, array.byteLength);
    this.device.queue.writeBuffer(buffer, 0, array);
    return buffer;
  }

  // The buffer of an array that does not change, as long as the array lives.
  keep(array) {
    if (!this.kept.has(array)) {
      const buffer = this.device.createBuffer({
        size: Math.max(16, array.byteLength), usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST,
      });
      this.device.queue.writeBuffer(buffer, 0, array);
      this.kept.set(array, buffer);
    }
    return this.kept.get(array);
  }

  texture(name, size) {
    const key = `texture ${name}`, known = this.pool.get(key);
    if (known && known.width === size[0] && known.height === size[1]) return known;
    known?.destroy();
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING;
    this.pool.set(key, this.device.createTexture({ size, format: PICTURE_FORMAT, usage }));
    return this.pool.get(key);
  }

  // A WGSL struct in a uniform buffer, laid out as `gpu/layouts.py` says.
  struct(name, layout, fields) {
    const { size, fields: places } = this.program.layouts[layout], view = new DataView(new ArrayBuffer(size));
    const put = ({ offset, type, fields: inner }, value) => {
      if (inner) Object.entries(inner).forEach(([key, place]) => put({ ...place, offset: offset + place.offset }, value[key]));
      else [value].flat(2).forEach((number, i) => view[`set${type}`](offset + 4 * i, number, true));
    };
    Object.entries(fields).forEach(([key, value]) => put(places[key], value));
    return this.write(name, new Uint8Array(view.buffer));
  }
}

const countWorkgroups = n => Math.max(1, Math.min(Math.ceil(n / WORKGROUP_SIZE), MAX_WORKGROUPS));
const alignPoints = n => POINTS_PER_INVOCATION * Math.ceil(n / POINTS_PER_INVOCATION);

// One picture being recorded.
class Picture {
  constructor(context, encoder, view, list, finalView, finalFormat) {
    Object.assign(this, { context, encoder, view, list, finalView, finalFormat });
    this.constants = context.program.constants;
    const { size } = view, hides = list.drawables.some(({ faces }) => faces);
    this.margin = hides ? this.depthMargin() : 0;
    this.nPixels = size[0] * size[1];
    this.nDepths = (size[0] + 2 * this.margin) * (size[1] + 2 * this.margin);
    this.picture = null; // what has been drawn
    this.textureNumber = 0;
    this.tile = context.struct("tile", "TILE", {
      size, origin: [0, 0], extent: size, depth_origin: [-this.margin, -this.margin],
      depth_extent: size.map(side => side + 2 * this.margin),
      depth_slope_per_pixel: depthSlopePerPixel(view.clipFromWorld, size[0]), background: view.background,
    });
  }

  dispatch(stage, constants, bindings, x, y = 1) {
    const { context } = this, pipeline = context.pipeline(stage, { workgroup_size: WORKGROUP_SIZE, ...constants });
    const pass = this.encoder.beginComputePass();
    pass.setPipeline(pipeline.handle);
    pass.setBindGroup(0, context.bind(pipeline, bindings));
    if (x instanceof GPUBuffer) pass.dispatchWorkgroupsIndirect(x, 0);
    else pass.dispatchWorkgroups(x, y);
    pass.end();
  }

  depthMargin() {
    const { list, constants } = this;
    const tested = list.drawables.flatMap(({ lines }) => lines.filter(({ hidden }) => hidden !== HIDDEN.show));
    if (!tested.length) return 0;
    const widest = Math.max(...tested.map(({ lineWidth }) => lineWidth ?? 1));
    return Math.min(constants.MAX_DEPTH_MARGIN_PX, Math.ceil(0.5 * widest) + 6);
  }

  record() {
    const { list } = this, drawables = [...list.drawables, ...(list.covers ?? [])];
    const projected = drawables.map((drawable, i) => this.project(drawable, i));
    const own = projected.slice(0, list.drawables.length);
    const faces = this.depthPrepass(own, "faces");
    const covers = list.covers ? this.depthPrepass(projected.slice(own.length), "covers") : faces;
    const jobs = own.flatMap(drawable => drawable.lines.map(lines => [drawable, lines, lines.isCovered ? covers : faces]));
    const shown = jobs.filter(([, lines, hiders]) => lines.nEdges && !(lines.hidden === HIDDEN.only && hiders.isEmpty));
    this.nComposites = shown.length + Number(faces.hasColors);
    if (this.nComposites === 0) this.clear();
    if (faces.hasColors) {
      const palette = this.context.write("palette", Uint32Array.from(list.palette));
      this.composite("composite_triangles", { has_light: Number(faces.hasLight), has_depth_cue: Number(faces.hasDepthCue) }, { tile: this.tile, visibility: faces.visibility, palette });
    }
    shown.forEach((job, number) => this.draw(...job, number));
  }

  // The points of all instances in clip space.
  project({ mesh, matrices, ...drawable }, number) {
    const { context } = this, stride = alignPoints(mesh.nPoints), n = matrices.length;
    const clipPositions = context.scratch(`clip positions ${number}`, n * stride * CLIP_POSITION_BYTES);
    const bindings = {
      vertex_transform: context.struct(`vertex transform ${number}`, "VERTEX_TRANSFORM", { n_packets: stride / POINTS_PER_INVOCATION }),
      matrices: context.write(`matrices ${number}`, Float32Array.from(matrices.flatMap(flattenColumns))),
      points: context.keep(mesh.keep("packed points", () => mesh.packedPoints)),
      clip_positions: clipPositions,
    };
    this.dispatch("vertex_transform", {}, bindings, Math.ceil(stride / (POINTS_PER_INVOCATION * WORKGROUP_SIZE)), n);
    return { ...drawable, mesh, matrices, clipPositions, stride, nInstances: n };
  }

  // The depths of all faces, and the colours of those that are filled, as indices of the palette.
  depthPrepass(projected, name) {
    const { context, constants, nDepths } = this, batches = projected.filter(({ faces }) => faces);
    const counts = batches.map(({ faces, nInstances }) => (nInstances * faces.triangles.length) / 3);
    const hasColors = batches.some(({ faces }) => faces.colorIndices);
    const hasDepthCue = batches.some(({ faces }) => faces.colorIndices && faces.depthCue.amount > 0);
    const hasLight = batches.some(({ faces }) => faces.cornerNormals);
    const most = Math.max(constants.MAX_FEW_TRIANGLES, nDepths / constants.PIXELS_PER_FLAT);
    const hasFlats = counts.some(count => count <= most), depthBytes = 4 * nDepths * (1 + Number(hasFlats));
    const stage = {
      isEmpty: !batches.length, hasColors, hasLight, hasDepthCue, hasFlats,
      depths: context.scratch(`${name}: depths`, batches.length ? depthBytes : 4),
      visibility: context.scratch(`${name}: visibility`, hasColors ? 4 * nDepths : 4),
    };
    if (stage.isEmpty) return stage;
    const large = context.scratch(`${name}: large`, 16 + 4 * Math.max(...counts), GPUBufferUsage.INDIRECT);
    const record = writesVisibility => batches.forEach(({ faces, stride, nInstances, clipPositions }, i) => {
      if (writesVisibility && !faces.colorIndices) return;
      const n = faces.triangles.length / 3, key = `${name} ${i} ${Number(writesVisibility)}`;
      const struct = context.struct(key, "FACES", {
        depth_cue: faces.depthCue, n_triangles: n, instance_stride: stride, first_id: faces.firstColor,
        writes_visibility: Number(writesVisibility), light_from_normals: faces.lightFromNormals,
      });
      const bindings = {
        tile: this.tile, faces: struct, clip_positions: clipPositions, triangles: context.keep(faces.triangles),
        face_depths: stage.depths, visibility: stage.visibility, large_triangles: large,
        color_indices: faces.colorIndices ? context.keep(faces.colorIndices) : context.scratch("no colour indices", 4),
        corner_normals: faces.cornerNormals ? context.keep(faces.cornerNormals) : context.scratch("no colour indices", 4),
      };
      const own = { has_visibility: Number(hasColors), writes_ids: 0, has_flats: Number(hasFlats), has_light: Number(hasLight), has_depth_cue: Number(hasDepthCue) };
      this.encoder.clearBuffer(large, 0, 16);
      this.dispatch("depth_small_triangles", { ...own, leaves_others: 0 }, { ...bindings, left_triangles: context.scratch("none left", 20) }, countWorkgroups(n), nInstances);
      this.dispatch("depth_large_triangles", own, bindings, large);
    });
    this.encoder.clearBuffer(stage.depths, 0, depthBytes);
    record(false);
    if (hasColors) {
      this.encoder.clearBuffer(stage.visibility, 0, 4 * nDepths);
      record(true);
    }
    return stage;
  }

  draw(drawable, lines, hiders, number) {
    const { context, constants, encoder } = this, { nInstances, stride, clipPositions, matrices } = drawable;
    const nEdges = nInstances * lines.nEdges;
    const width = Math.ceil((lines.lineWidth ?? 1) * Math.SQRT2) + 2;
    const style = context.struct(`line style ${number}`, "LINE_STYLE", {
      depth_cue: lines.depthCue, color: lines.color, line_width: lines.lineWidth ?? 1, opacity: lines.opacity,
      n_edges: lines.nEdges, instance_stride: stride,
      edge_bits: Math.max(32 - Math.clz32(nEdges), constants.MIN_EDGE_BITS), log2_lanes: this.chooseLog2Lanes(lines, width, nEdges),
      ...this.dashFields(lines.dash),
    });
    const isDashed = lines.dash.length > 0 && lines.chains && !(hiders.isEmpty && lines.hidden === HIDDEN.dash);
    const put = (name, array) => (lines.key ? context.keep(array) : context.write(`${name} ${number}`, array));
    const bindings = {
      tile: this.tile, style, clip_positions: clipPositions, edges: put("edges", lines.edges),
      face_depths: hiders.depths,
      dash_starts: isDashed ? this.measureDashes(lines, style, clipPositions, nInstances, number) : context.scratch("no dashes", 4),
      colors: lines.colors ? put("colours", lines.colors) : context.scratch("no colours", 4),
    };
    const isSimple = lines.dash.length === 2 && lines.dash[0] >= constants.MIN_SIMPLE_DASH_PX;
    const opacity = {
      hidden: hiders.isEmpty ? HIDDEN.show : lines.hidden, dashes: isDashed ? (isSimple ? 1 : 2) : 0,
      is_silhouette: Number(lines.areSilhouettes), has_flats: Number(hiders.hasFlats && lines.hidden !== HIDDEN.show),
      has_depth_cue: Number(lines.depthCue.amount > 0),
    };
    const perPixel = context.scratch("per pixel", 4 * this.nPixels);
    encoder.clearBuffer(perPixel, 0, 4 * this.nPixels);
    const covers = { covers_edges: 0, is_instanced: Number(matrices.length > 1) };
    if (lines.lineWidth === null) {
      const isUniform = lines.colors === null && lines.depthCue.amount === 0 && !lines.dash.length && ![HIDDEN.dash, HIDDEN.fade].includes(lines.hidden);
      const keyed = { ...bindings, depth_keys: perPixel }, own = { ...opacity, is_uniform_style: Number(isUniform) };
      this.dispatch("rasterize_aliased_lines", own, keyed, countWorkgroups(lines.nEdges), nInstances);
      this.composite("composite_aliased_lines", { ...own, color_mode: lines.colorMode, ...covers }, keyed);
      return;
    }
    const k = nEdges <= constants.MAX_EDGES_FOR_DEEP_K_BUFFER ? 4 : 2, hasBuffer = lines.colors !== null;
    const kBuffer = context.scratch("k-buffer", hasBuffer ? 4 * k * this.nPixels : 4);
    if (hasBuffer) encoder.clearBuffer(kBuffer, 0, 4 * k * this.nPixels);
    const [steps, mayOverflow] = this.chooseAbsorbanceSteps(lines, nEdges);
    const look = { color_mode: lines.colorMode, k, is_wide: Number(lines.lineWidth > constants.MAX_NARROW_WIDTH_PX) };
    const counted = { absorbance_steps_per_e: steps };
    const all = { ...bindings, absorbance: perPixel, k_buffer: kBuffer, seen_edges: context.scratch("no list", 20) };
    const own = {
      ...opacity, ...look, ...counted, has_transparency: Number(lines.hasTransparency), is_listed: 0, is_instanced: 0,
      min_transmittance: constants.MIN_TRANSMITTANCE, may_overflow: Number(mayOverflow),
    };
    const nLanes = 2 ** this.chooseLog2Lanes(lines, width, nEdges);
    this.dispatch("accumulate_lines", own, all, countWorkgroups(lines.nEdges * nLanes), nInstances);
    if (lines.colorMode === COLOR.uniform) {
      this.composite("composite_lines", { ...counted, ...covers }, all);
    } else {
      this.composite("composite_colored_lines", { ...opacity, ...look, ...counted, ...covers }, all);
    }
  }

  // Invocations per edge, as a power of two.
  chooseLog2Lanes(lines, width, nEdges) {
    const { constants } = this, maxColumns = lines.arePoints ? width : constants.TILE_SIDE_PX;
    const needed = (maxColumns * Math.min(width, constants.TILE_SIDE_PX)) / constants.MAX_PIXELS_PER_INVOCATION;
    const wanted = Math.min(constants.BUSY_INVOCATIONS / nEdges, maxColumns / constants.MIN_COLUMNS_PER_INVOCATION);
    return Math.max(0, Math.ceil(Math.log2(Math.max(needed, wanted))));
  }

  chooseAbsorbanceSteps(lines, nEdges) {
    const { ABSORBANCE_STEPS_PER_E, MIN_TRANSMITTANCE } = this.constants;
    const light = 1 - lines.color[3] * lines.opacity * Math.min(1, 1.5 * lines.lineWidth);
    const absorbance = -Math.log(Math.max(light, MIN_TRANSMITTANCE));
    const fitting = ABSORBANCE_STEPS_PER_E.find(steps => nEdges * (absorbance * steps + 1) < 2 ** 32);
    return fitting ? [fitting, false] : [ABSORBANCE_STEPS_PER_E[0], true];
  }

  dashFields(dash) {
    const { constants } = this, bounds = [0];
    dash.forEach(length => bounds.push(bounds[bounds.length - 1] + length));
    const padded = first => Array.from({ length: constants.MAX_DASHES }, (_, i) => (2 * i < dash.length ? bounds[2 * i + first] : constants.NO_DASH_PX));
    return { dash_period_px: bounds[bounds.length - 1] || 1, dash_begins: padded(0), dash_ends: padded(1) };
  }

  measureDashes(lines, style, clipPositions, nInstances, number) {
    const { context, constants } = this, nSections = Math.ceil(lines.nEdges / constants.EDGES_PER_SECTION);
    const starts = context.scratch(`dash starts ${number}`, 4 * nInstances * lines.nEdges);
    const bindings = {
      tile: this.tile, style, clip_positions: clipPositions, dash_starts: starts,
      chains: lines.key ? context.keep(lines.chains) : context.write(`chains ${number}`, lines.chains),
      section_ends: context.scratch(`dash section ends ${number}`, 8 * nSections * nInstances),
    };
    for (const isAdding of [0, 1]) {
      this.dispatch("measure_chains", { is_adding: isAdding }, bindings, countWorkgroups(nSections), nInstances);
    }
    return starts;
  }

  // Draws over all pixels: what is there is read from one texture, and the whole goes to another, at last to the canvas.
  composite(stage, constants, bindings) {
    const { context, encoder } = this, isLast = --this.nComposites === 0, isFirst = this.picture === null;
    const format = isLast ? this.finalFormat : PICTURE_FORMAT;
    const pipeline = context.pipeline(stage, { ...constants, is_first: Number(isFirst) }, format);
    const view = isLast ? this.finalView : context.texture(this.textureNumber ^= 1, this.view.size).createView();
    const destination = (this.picture ?? context.texture("none", [1, 1]).createView());
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: "clear", storeOp: "store", clearValue: [0, 0, 0, 0] }] });
    pass.setPipeline(pipeline.handle);
    pass.setBindGroup(0, context.bind(pipeline, { ...bindings, destination }));
    pass.draw(TILE_VERTICES);
    pass.end();
    this.picture = view;
  }

  // A picture of nothing but the background.
  clear() {
    const [r, g, b, a] = this.view.background;
    this.encoder.beginRenderPass({
      colorAttachments: [{ view: this.finalView, loadOp: "clear", storeOp: "store", clearValue: { r, g, b, a } }],
    }).end();
  }
}

// The program of a page (its WGSL files, stages, layouts and constants) on a device; null where there is none.
export async function openGpu(program, canvas, isOpaque) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return null;
  const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
  const device = await adapter.requestDevice({ requiredLimits: { maxStorageBufferBindingSize, maxBufferSize } });
  const target = canvas.getContext("webgpu");
  if (!target) return null;
  const format = navigator.gpu.getPreferredCanvasFormat(), context = new Context(device, program);
  target.configure({ device, format, alphaMode: isOpaque ? "opaque" : "premultiplied" });

  // Draws a list as a view of `size`, `clipFromWorld` (reversed-Z) and a premultiplied `background` sees it.
  function draw(list, view, constants, texture = null) {
    const encoder = device.createCommandEncoder();
    const final = texture ?? target.getCurrentTexture();
    new Picture(context, encoder, view, list, final.createView(), final.format).record();
    device.queue.submit([encoder.finish()]);
  }

  // The pixels of a picture, four bytes each, premultiplied.
  async function readPixels(list, view, constants) {
    const [width, height] = view.size, usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC;
    const texture = device.createTexture({ size: view.size, format: PICTURE_FORMAT, usage });
    draw(list, view, constants, texture);
    const rowBytes = 256 * Math.ceil((4 * width) / 256);
    const buffer = device.createBuffer({ size: rowBytes * height, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ });
    const encoder = device.createCommandEncoder();
    encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: rowBytes }, view.size);
    device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const mapped = new Uint8Array(buffer.getMappedRange()), pixels = new Uint8Array(4 * width * height);
    for (let y = 0; y < height; y++) pixels.set(mapped.subarray(y * rowBytes, y * rowBytes + 4 * width), 4 * y * width);
    buffer.destroy();
    texture.destroy();
    return pixels;
  }

  return {
    name: "WebGPU", draw, readPixels, device,
    maxPixels: Math.floor(maxStorageBufferBindingSize / (4 * MAX_K)),
    whenDone: () => device.queue.onSubmittedWorkDone(),
    whenLost: device.lost,
  };
}
