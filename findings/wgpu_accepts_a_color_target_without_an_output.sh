#!/usr/bin/env bash
# wgpu 0.32.0 (wgpu-native), Mesa lavapipe 22.3.6 (LLVM 15.0.6), Linux x86-64.
#
# Behaviour: a render pipeline whose fragment shader returns nothing, but whose colour target has the default write mask
# (all channels), is made without a word and draws. The WebGPU standard calls such a pipeline invalid ("validating
# GPUFragmentState": a shader without an output for a target needs a write mask of 0), and Chromium refuses the same
# code. The texels do not keep what they held: they get what lay in a register, which Vulkan calls undefined. A write mask
# of 0 says what is meant, and works in both. (wgpu issue 9147; later releases check it.)
#
# The guess before: a GPUValidationError at create_render_pipeline, as wgpu-native checks everything else of a pipeline.
#
# Seen:
#   write mask 15: accepted, 16 fragments drawn, the texels keep what they held: no
#   write mask 0: accepted, 16 fragments drawn, the texels keep what they held: yes
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
@group(0) @binding(0) var<storage, read_write> drawn: array<atomic<u32>>;
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn mark() { atomicAdd(&drawn[0], 1u); }
"""
module = device.create_shader_module(code=SHADER)
for mask in (wgpu.ColorWrite.ALL, 0):
    pipeline = device.create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "corner"},
        primitive={"topology": "triangle-list"},
        fragment={"module": module, "entry_point": "mark", "targets": [{"format": "rgba8unorm", "write_mask": mask}]},
    )
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
    texture = device.create_texture(size=(4, 4, 1), format="rgba8unorm", usage=usage)
    drawn = device.create_buffer(size=16, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    resource = {"buffer": drawn, "offset": 0, "size": 16}
    group = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0), entries=[{"binding": 0, "resource": resource}]
    )
    encoder = device.create_command_encoder()
    attachment = {"view": texture.create_view(), "load_op": "clear", "clear_value": (1, 0, 0, 1), "store_op": "store"}
    render = encoder.begin_render_pass(color_attachments=[attachment])
    render.set_pipeline(pipeline)
    render.set_bind_group(0, group)
    render.draw(3)
    render.end()
    device.queue.submit([encoder.finish()])
    counts = np.frombuffer(device.queue.read_buffer(drawn), np.uint32)
    assert counts[0] == 16, counts  # it did draw
    read = device.queue.read_texture({"texture": texture}, {"bytes_per_row": 16, "rows_per_image": 4}, (4, 4, 1))
    texels = np.frombuffer(read, np.uint8).reshape(16, 4)
    is_kept = bool((texels == (255, 0, 0, 255)).all())
    print(f"write mask {int(mask)}: accepted, 16 fragments drawn, the texels keep what they held: {'yes' if is_kept else 'no'}")
    assert is_kept == (mask == 0), texels
PYTHON
