"""Models in motion: `animate`, `turntable`, and the `Animation` that they make."""

from .animation import Animation, animate, turntable

__all__ = ["Animation", "animate", "turntable"]
