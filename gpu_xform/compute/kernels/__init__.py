"""Kernels: the dispatches of each family of compute shaders.

Reading order: job, reduction, convolution_job, transform, few, reduce, skin, store, convolve.
"""
