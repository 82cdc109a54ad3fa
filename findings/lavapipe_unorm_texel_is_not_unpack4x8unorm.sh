#!/usr/bin/env bash
# wgpu 0.32.0 (wgpu-native), Mesa lavapipe 22.3.6 (LLVM 15.0.6), Linux x86-64.
#
# Behaviour: a shader that reads the byte k of an `rgba8unorm` texture with textureLoad gets k * (1 / 255) in single
# precision; unpack4x8unorm of the same byte gives k / 255. The two differ in the last bit for a part of the bytes, so that
# a compositing pass moved from a storage buffer to a texture changes pixels that lie on a tie.
# `round(textureLoad(...) * 255.0) / 255.0` brings them together again.
#
# The guess before: both are the same correctly rounded quotient; 256 values leave no room to differ.
#
# Seen:
#   bytes that differ: 126 of 256, by at most 1 ulp
#   bytes that differ after rounding: 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install wgpu==0.32.0 numpy==2.2.6
XDG_RUNTIME_DIR="$folder" "$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import wgpu
from wgpu.backends.wgpu_native.extras import set_instance_extras

set_instance_extras(backends=["Vulkan"])
adapter = next(a for a in wgpu.gpu.enumerate_adapters_sync() if "llvmpipe" in a.info["device"])
device = adapter.request_device_sync()
SHADER = """
@group(0) @binding(0) var texels: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> packed: array<u32>;
@group(0) @binding(2) var<storage, read_write> result: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = textureLoad(texels, vec2<u32>(id.x, 0u), 0).x;
    result[id.x] = vec4(texel, unpack4x8unorm(packed[id.x]).x, round(texel * 255.0) / 255.0, 0.0);
}
"""
values = np.arange(256, dtype=np.uint8)
pixels = np.zeros((1, 256, 4), np.uint8)
pixels[0, :, 0] = values
texture = device.create_texture(
    size=(256, 1, 1), format="rgba8unorm", usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
)
device.queue.write_texture({"texture": texture}, pixels, {"bytes_per_row": 1024, "rows_per_image": 1}, (256, 1, 1))
packed = device.create_buffer_with_data(data=pixels, usage=wgpu.BufferUsage.STORAGE)
result = device.create_buffer(size=256 * 16, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
pipeline = device.create_compute_pipeline(
    layout="auto", compute={"module": device.create_shader_module(code=SHADER), "entry_point": "main"}
)
resources = [texture.create_view(), {"buffer": packed, "offset": 0, "size": packed.size}, {"buffer": result, "offset": 0, "size": result.size}]
group = device.create_bind_group(
    layout=pipeline.get_bind_group_layout(0),
    entries=[{"binding": k, "resource": resource} for k, resource in enumerate(resources)],
)
encoder = device.create_command_encoder()
compute = encoder.begin_compute_pass()
compute.set_pipeline(pipeline)
compute.set_bind_group(0, group)
compute.dispatch_workgroups(4)
compute.end()
device.queue.submit([encoder.finish()])
texel, unpacked, rounded, _ = np.frombuffer(device.queue.read_buffer(result), np.float32).reshape(256, 4).T
ulps = np.abs(texel.view(np.int32) - unpacked.view(np.int32))
n_differ, n_after = int((ulps > 0).sum()), int((rounded != unpacked).sum())
print(f"bytes that differ: {n_differ} of 256, by at most {ulps.max()} ulp")
print(f"bytes that differ after rounding: {n_after}")
assert n_differ > 0 and ulps.max() == 1 and n_after == 0
PYTHON
