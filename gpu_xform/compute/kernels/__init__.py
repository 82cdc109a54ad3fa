"""Kernels: the dispatches of each family of compute shaders.

Reading order: job, reduction, transform, reduce, skin, store, convolve.
"""
