"""Viewer: an interactive window in which models are seen from all sides.

Reading order: orbit, style_overrides, key_bindings, controls, live_springs, help_overlay, session, canvas,
notebook, window.
"""
