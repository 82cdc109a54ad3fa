"""The host's kernels: what the compute shaders do, by loops over the processors that numba compiles, or by NumPy.

Reading order: compile, packed_loops, loops, tap_groups, convolution_loops, choose, vectorized, convolution_vectorized,
blas, transform, own_matrices, skin, reduce, store, convolve.
"""
