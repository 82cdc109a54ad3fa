"""Pictures, one after another, as files: one module a format.

Reading order: frames, image_codecs, palettes, parallel, apng, gif, html, image_sequence, video, webp, registry.
"""
