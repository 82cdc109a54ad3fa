#!/usr/bin/env bash
# wgpu 0.32.0 (wgpu-native), Mesa lavapipe 22.3.6 (LLVM 15.0.6), Linux x86-64 with AVX2.
#
# Behaviour: a compute shader whose invocations stride over n elements, `for (var i = id.x; i < n; i += STRIDE)`, and have one
# element each, takes 1.8 times as long as one that leaves the same loop by `if i >= n { break; }` at the end of its body. With
# `continuing { i += STRIDE; break if i >= n; }`, WGSL's own form of a loop that is tested at its end, it takes as long as
# with `for`. Results are equal to the last bit.
#
# The guess before: whoever has one element goes through the body once, wherever the loop has its test; the second test
# fails, and costs a comparison.
#
# Seen (medians of 15, equal sums), with other work on both processors, in two runs:
#   for 405, break if 492, break at the end 229 ms: 1.77 and 2.15; 397, 385, 218 ms: 1.82 and 1.77
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install wgpu==0.32.0 numpy==2.2.6
XDG_RUNTIME_DIR="$folder" "$folder/venv/bin/python" - <<'PYTHON'
import statistics
import time

import wgpu
from wgpu.backends.wgpu_native.extras import set_instance_extras

N, WORKGROUP, ROUNDS = 1 << 20, 256, 15
set_instance_extras(backends=["Vulkan"])
adapter = next(a for a in wgpu.gpu.enumerate_adapters_sync() if "llvmpipe" in a.info["device"])
device = adapter.request_device_sync()
BODY = "var x = vec4<f32>(vec4(i, i + 1u, i + 2u, i + 3u));\n" + "x = sqrt(x + 1.5) * 3.0 + x.yzwx;\n" * 40 + "sums[i] = dot(x, vec4(1.0));"
LOOPS = {
    "for": "for (var i = id.x; i < n; i += stride) { BODY }",
    "break if": "var i = id.x; loop { BODY continuing { i += stride; break if i >= n; } }",
    "break at the end": "var i = id.x; loop { BODY i += stride; if i >= n { break; } }",
}
sums = device.create_buffer(size=4 * N, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)


def prepare(loop):
    code = f"""
@group(0) @binding(0) var<storage, read_write> sums: array<f32>;
@compute @workgroup_size({WORKGROUP})
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {{
    let n = arrayLength(&sums);
    let stride = n_workgroups.x * {WORKGROUP}u;
    {loop.replace("BODY", BODY)}
}}"""
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": device.create_shader_module(code=code), "entry_point": "main"}
    )
    resource = {"buffer": sums, "offset": 0, "size": sums.size}
    group = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0), entries=[{"binding": 0, "resource": resource}]
    )

    def run():
        encoder = device.create_command_encoder()
        compute = encoder.begin_compute_pass()
        compute.set_pipeline(pipeline)
        compute.set_bind_group(0, group)
        compute.dispatch_workgroups(N // WORKGROUP)
        compute.end()
        start = time.perf_counter()
        device.queue.submit([encoder.finish()])
        device.queue.read_buffer(sums, 0, 16)  # waits
        seconds = time.perf_counter() - start
        return seconds, device.queue.read_buffer(sums).tobytes()

    return run


runs = {name: prepare(loop) for name, loop in LOOPS.items()}
seconds, results = {name: [] for name in runs}, set()
for turn in range(ROUNDS + 1):
    for name, run in runs.items():
        taken, result = run()
        results.add(result)
        if turn:  # the first compiles
            seconds[name].append(taken)
assert len(results) == 1, "the sums differ"
medians = {name: statistics.median(own) for name, own in seconds.items()}
print("; ".join(f"{name}: {own * 1e3:.0f} ms" for name, own in medians.items()))
ratios = [medians[name] / medians["break at the end"] for name in ("for", "break if")]
print(f"for and break if take {ratios[0]:.2f} and {ratios[1]:.2f} of the time of break at the end")
assert ratios[0] > 1.5
PYTHON
