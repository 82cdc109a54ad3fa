"""Pages that draw models live in a browser, by the same WGSL: `save_page`.

The scripts of the page are in `js/`, and are joined in the order of `program.SCRIPTS`. Pages hold them, and the WGSL,
with short names: `short_program` makes that of the sources, which are for people to read.

Reading order: tokens, scopes, short_names, arrays, decimation, mesh_data, program, short_program, poster, scene, page.
"""
