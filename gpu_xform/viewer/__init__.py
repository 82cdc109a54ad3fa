"""Viewer: an interactive window in which models are seen from all sides.

Reading order: orbit, key_bindings, style_overrides, controls, live_springs, help_overlay, session, canvas,
notebook, window.
"""
