"""The only folder that imports wgpu.

Reading order: drivers, adapters, errors, layouts, context, buffers, buffer_pool, resource_cache, shaders, dispatch,
self_test, device, device_points, uniforms, chunking, timing.
"""
