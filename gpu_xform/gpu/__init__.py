"""The only folder that imports wgpu: adapters, the device, its memory, shaders, dispatches and render passes.

Reading order: drivers, binding, type_lookups, adapters, errors, layouts, deletion_queue, context, buffers,
buffer_pool, resource_cache, stages, wgsl, shaders, textures, dispatch, timestamps, trace, self_test, device, uniforms,
chunking, device_points, timing, debug.
"""
