"""The dispatches of each family of compute shaders.

Reading order: transform, reduce, skin.
"""
