"""The table of WGSL stages, `wgsl/stages.toml`: each stage's file, number types, entry points and constants."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources.abc import Traversable
from typing import Any

from ..errors import ShaderError

TABLE = "stages.toml"


@dataclass(frozen=True)
class Stage:
    """One row of the table.

    file : relative to the folder of the table
    number_types : what `#import real` can stand for; empty for a stage that does not import it
    entry_points : function names by pipeline stage ("compute", "vertex", "fragment")
    overrides : names of the `override` constants by WGSL type
    values : of those overrides that take a few values only
    """

    file: str
    number_types: tuple[str, ...] = ()
    entry_points: Mapping[str, str] = field(default_factory=lambda: {"compute": "main"})
    overrides: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    values: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


def read_stages(folder: Traversable) -> dict[str, Stage]:
    """Return the stages of a folder of WGSL files by name; raise `ShaderError` if its table is missing or malformed."""
    table = folder / TABLE
    try:
        rows = tomllib.loads(table.read_text("utf-8"))
        return {name: _stage(row) for name, row in rows.items()}
    except FileNotFoundError:
        raise ShaderError(f"no {TABLE} in {folder}") from None
    except (tomllib.TOMLDecodeError, TypeError, AttributeError) as error:
        raise ShaderError(f"{table}: {error}") from None


def _stage(row: Mapping[str, Any]) -> Stage:
    tables = {name: _tuples(row.get(name, {})) for name in ("overrides", "values")}
    return Stage(**{**row, **tables, "number_types": tuple(row.get("number_types", ()))})


def _tuples(lists: Mapping[str, list[Any]]) -> dict[str, tuple[Any, ...]]:
    return {name: tuple(values) for name, values in lists.items()}
