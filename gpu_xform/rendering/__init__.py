"""Pictures of models: the public functions over both back ends.

Reading order: annotate, sheets, raster, preview, vector, contact_sheet.
"""
