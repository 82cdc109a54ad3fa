"""Pictures, one after another, as files: one module a format."""
