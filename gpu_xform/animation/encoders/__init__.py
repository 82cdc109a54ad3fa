"""Encoders of animations: one module per file format.

Reading order: frames, image_codecs, palettes, parallel, apng, gif, html, image_sequence, video, webp, registry.
"""
