#!/usr/bin/env bash
# wgpu 0.32.0 (wgpu-native), Mesa lavapipe 22.3.6 (LLVM 15.0.6), Linux x86-64 with AVX2.
#
# Behaviour: a compute shader that gathers vec4<f32> from an `rgba32float` storage texture (access `read`) takes much less
# time than one that gathers the same numbers, at the same indices, from a storage buffer. An index into a texture of two
# dimensions costs a division and a remainder more, which the texture's time includes.
#
# The guess before: on a CPU both are memory, and the buffer is a plain load where the texture has coordinates, a format and
# edges to mind, so the buffer is as fast or faster.
#
# Seen (medians of 15, sums equal to the last bit), on two idle processors; on busy ones the ratio was as low as 0.22:
#   storage buffer: 14 ms; storage texture: 6 ms; the texture takes 0.45 of the buffer's time
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install wgpu==0.32.0 numpy==2.2.6
XDG_RUNTIME_DIR="$folder" "$folder/venv/bin/python" - <<'PYTHON'
import statistics
import time

import numpy as np
import wgpu
from wgpu.backends.wgpu_native.extras import set_instance_extras

SIDE, N_GATHERS, ROUNDS = 512, 16, 15
N = SIDE * SIDE
set_instance_extras(backends=["Vulkan"])
adapter = next(a for a in wgpu.gpu.enumerate_adapters_sync() if "llvmpipe" in a.info["device"])
device = adapter.request_device_sync(required_features=["texture-adapter-specific-format-features"])
SHADER = """
@group(0) @binding(0) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(1) SOURCE
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = vec4(0.0);
    for (var k = 0u; k < GATHERSu; k++) {
        let index = (id.x * 7u + k * 4099u) % POINTSu;
        sum += LOAD;
    }
    sums[id.x] = sum;
}
"""
BUFFER = "var<storage, read> source: array<vec4<f32>>;", "source[index]"
TEXTURE = (
    "var source: texture_storage_2d<rgba32float, read>;",
    f"textureLoad(source, vec2(index % {SIDE}u, index / {SIDE}u))",
)
numbers = np.random.default_rng(1).integers(0, 1 << 12, (SIDE, SIDE, 4)).astype(np.float32)
buffer = device.create_buffer_with_data(data=numbers, usage=wgpu.BufferUsage.STORAGE)
texture = device.create_texture(
    size=(SIDE, SIDE, 1), format="rgba32float", usage=wgpu.TextureUsage.STORAGE_BINDING | wgpu.TextureUsage.COPY_DST
)
device.queue.write_texture({"texture": texture}, numbers, {"bytes_per_row": 16 * SIDE, "rows_per_image": SIDE}, (SIDE, SIDE, 1))
sums = device.create_buffer(size=16 * N, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)


def prepare(source, load, resource):
    code = SHADER.replace("SOURCE", source).replace("LOAD", load).replace("GATHERS", str(N_GATHERS)).replace("POINTS", str(N))
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": device.create_shader_module(code=code), "entry_point": "main"}
    )
    group = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0),
        entries=[
            {"binding": 0, "resource": {"buffer": sums, "offset": 0, "size": sums.size}},
            {"binding": 1, "resource": resource},
        ],
    )

    def run():
        encoder = device.create_command_encoder()
        compute = encoder.begin_compute_pass()
        compute.set_pipeline(pipeline)
        compute.set_bind_group(0, group)
        compute.dispatch_workgroups(N // 64)
        compute.end()
        start = time.perf_counter()
        device.queue.submit([encoder.finish()])
        device.queue.read_buffer(sums, 0, 16)  # waits
        seconds = time.perf_counter() - start
        return seconds, device.queue.read_buffer(sums).tobytes()

    return run


runs = [prepare(*BUFFER, {"buffer": buffer, "offset": 0, "size": buffer.size}), prepare(*TEXTURE, texture.create_view())]
seconds, results = ([], []), set()
for turn in range(ROUNDS + 1):
    for own, run in zip(seconds, runs):
        taken, result = run()
        results.add(result)
        if turn:  # the first compiles
            own.append(taken)
assert len(results) == 1, "the sums differ"
of_buffer, of_texture = map(statistics.median, seconds)
ratio = of_texture / of_buffer
print(f"storage buffer: {of_buffer * 1e3:.0f} ms; storage texture: {of_texture * 1e3:.0f} ms; "
      f"the texture takes {ratio:.2f} of the buffer's time")
assert ratio < 0.75
PYTHON
