"""The only folder that imports wgpu: adapters, the device, its buffers, shaders and dispatches.

Reading order: drivers, type_lookups, adapters, errors, layouts, context, buffers, buffer_pool, resource_cache, stages,
wgsl, shaders, dispatch, timestamps, trace, self_test, device, uniforms, chunking, device_points, timing, debug.
"""
