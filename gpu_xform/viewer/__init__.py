"""Viewer: an interactive window in which models are seen from all sides.

Reading order: key_bindings, orbit, style_overrides, controls, live_springs, help_overlay, session, canvas,
notebook, window.
"""
