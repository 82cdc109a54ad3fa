"""One file a format; `load_mesh` and `save_mesh` choose among them."""
