"""Kernels: the dispatches of each family of compute shaders.

Reading order: job, transform, reduce, skin, convolve.
"""
