"""Arrays in, arrays out, computed on the device: transforms, point buffers, files of points, convolution of images.

Reading order: _arrays, _precision, _skinning, kernels, host, backend, _small, _own_matrices, _rebased, point_buffer,
mesh_buffer, transform, parts, device_plugin, cluster, streaming, convolution.
"""
