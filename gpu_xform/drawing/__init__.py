"""Pictures as data: layers and a camera become a draw list, which any back end draws.

Reading order: enums, camera, depth, view, draw_list, limits, attribute_colors, layer, silhouettes, dash_chains,
layer_colors, shading, boxes, geometry_source, framing, build_draw_list, load_models, prepare.
"""
