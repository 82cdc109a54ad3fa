"""Models to pictures: how they look, where they are seen from, what a device draws, and what it becomes."""
