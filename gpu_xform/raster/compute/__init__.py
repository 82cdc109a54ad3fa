"""The rasteriser that is made of compute shaders."""
