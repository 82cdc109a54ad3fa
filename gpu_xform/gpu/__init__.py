"""The only folder that imports wgpu."""
