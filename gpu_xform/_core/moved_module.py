"""A stand-in for a module that has moved."""

from importlib import import_module
from types import ModuleType
from typing import Any


class MovedModule(ModuleType):
    """A module under its old name, which looks its names up where they are now, when they are first used."""

    def __init__(self, name: str, new_name: str) -> None:
        super().__init__(name, f"Moved to `{new_name}`.")
        self._new_name = new_name

    def __getattr__(self, name: str) -> Any:
        """Return what the module of today holds; tools ask every module for names such as `__file__`."""
        if name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        return getattr(import_module(self._new_name), name)
