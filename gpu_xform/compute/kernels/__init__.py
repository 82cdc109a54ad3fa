"""The dispatches of each family of compute shaders."""
