"""Pictures as data: layers and a camera become a draw list, which any back end draws.

Reading order: enums, lengths, dash_patterns, page, camera, depth, view, edge_sample, attribute_colors, point_array,
label_options, section_options, layer, style_signature, layer_colors, point_colors, cloud_points, draw_list, limits,
mesh_parts, silhouettes, tangent_edges, dash_chains, shading, boxes, geometry_source, large_buffers, cloud_source,
framing, thin, covers, intersections, layer_placement, build_layer, build_draw_list, sections, layer_labels, keys,
axes_layout, load_models, prepare, sheet, legible_style.
"""
