"""Images, colours, colormaps, and the comparison of images, with NumPy and Pillow.

Reading order: image, colors, colormaps, compare.
"""
