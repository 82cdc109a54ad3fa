"""Lines by compute shaders.

Reading order: lines.
"""
