"""Model files: one module per format, with a reader of bytes, a writer of bytes, or both.

Reading order: _text, _line_names, _warn, _losses, limits, _concatenate, _beside, _growing_array, npy, obj_materials,
obj_attributes, obj_forms, obj_free_forms, obj_statements, obj_blocks, obj_lines, obj_write, obj, off_attributes, off,
ply_header, ply_writer, ply, las_header, laz, las, stl, vrml_values, vrml_names, vrml_syntax, vrml_nodes, vrml_shapes,
vrml_extrusions, vrml_primitives, vrml_placements, vrml_attributes, vrml_transforms, vrml_faces, vrml_builder, vrml,
gltf_draco_counts, gltf_draco, gltf_accessors, gltf_schema, gltf_placements, gltf_document, gltf_animations,
gltf_attributes, gltf_meshes, gltf_nodes, gltf_write, gltf, glb, threemf_properties, threemf_parts, threemf, step_text,
step_process, step, _xml, collada_geometries, collada_materials, collada_nodes, collada_placing, collada, urdf_files,
urdf, isolation_values, isolation_models, isolation, registry.
"""

from .registry import load_mesh, load_scene, save_mesh

__all__ = ["load_mesh", "load_scene", "save_mesh"]
