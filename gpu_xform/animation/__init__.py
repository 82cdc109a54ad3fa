"""Animations: models drawn once per frame, each time with another pose; `animate`, `turntable` and `Animation`.

Reading order: encoders, poses, motion, animation.
"""

from .animation import Animation, animate, turntable

__all__ = ["Animation", "animate", "turntable"]
