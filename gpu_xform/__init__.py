"""Bulk homogeneous transforms and wireframe pictures on any GPU, or on none."""

__version__ = "0.1.0"
