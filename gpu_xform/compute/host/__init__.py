"""The host's kernels: what the compute shaders do, by loops over the processors that numba compiles, or by NumPy.

Reading order: compile, loops, choose, vectorized, blas, transform, skin, reduce, store.
"""
