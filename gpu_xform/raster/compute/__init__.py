"""Lines by compute shaders.

Reading order: seen_edges, lines.
"""
