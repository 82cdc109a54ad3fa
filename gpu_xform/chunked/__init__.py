"""Points by the billion: files and stores that are read and written a part at a time.

Reading order: protocol, partial_files, npy, las_crs, las_fields, las, ply, zarr, losses, registry, write_behind,
summary.
"""
