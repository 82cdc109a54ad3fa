"""Pages that draw models live in a browser, by the same WGSL: `save_page`.

The scripts of the page are in `js/`, and are joined in the order of `program.SCRIPTS`.

Reading order: arrays, decimation, mesh_data, program, poster, scene, page.
"""
