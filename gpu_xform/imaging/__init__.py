"""Pixels: images, colours, colormaps, and the comparison of pictures; NumPy and Pillow."""
