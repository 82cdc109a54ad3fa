"""Pixels: images, colours, colormaps, and the comparison of pictures; NumPy and Pillow.

Reading order: image, colors, colormaps, compare.
"""
