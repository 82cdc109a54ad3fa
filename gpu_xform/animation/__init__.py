"""Models in motion: `animate`, `turntable`, and the `Animation` that they make.

Reading order: encoders, poses, motion, animation.
"""

from .animation import Animation, animate, turntable

__all__ = ["Animation", "animate", "turntable"]
