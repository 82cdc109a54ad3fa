"""WGSL expressions evaluated on a device."""

import numpy as np

from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.dispatch import dispatch
from gpu_xform.gpu.shaders import ComputePipeline

POISON = -1234.0


def evaluate(device: GpuDevice, declarations: str, expressions: list[str], given: Buffer) -> list[float]:
    """Return the value of each expression in a shader whose `declarations` bind `given`, which is released."""
    reads = "\n".join(f"    seen[{i}] = f32({expression});" for i, expression in enumerate(expressions))
    code = f"""{declarations}
@group(0) @binding(1) var<storage, read_write> seen: array<f32>;
@compute @workgroup_size(1)
fn main() {{
{reads}
}}
"""
    module = device.context.handle.create_shader_module(code=code)
    handle = device.context.handle.create_compute_pipeline(
        layout="auto", compute={"module": module, "entry_point": "main"}
    )
    pipeline = ComputePipeline(handle, "expressions", {"given": 0, "seen": 1})
    seen = Buffer(device.context, 4 * len(expressions) + 4, label="test")
    try:
        seen.upload(np.full(len(expressions) + 1, POISON, np.float32))
        with device.encode_commands(given, seen, label="test") as encoder:
            dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, given=given, seen=seen), 1)
        with seen.map_read(seen.n_bytes) as view:
            values: list[float] = view.view(np.float32).tolist()
    finally:
        given.release()
        seen.release()
    assert values.pop() == POISON
    return values
