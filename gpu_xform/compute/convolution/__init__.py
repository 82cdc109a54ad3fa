"""Convolution: images in, images out, through kernels that slide over them.

Reading order: borders, pixels, transfer, filters, stencils, fourier, convolve.
"""
