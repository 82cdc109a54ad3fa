"""An interactive window onto models.

Reading order: key_bindings, orbit, style_overrides, controls, help_overlay, session, window.
"""
