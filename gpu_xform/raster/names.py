"""The names of the rasterisers, one source of them: nothing else is imported for the help of the command line."""

from typing import Literal, TypeAlias, get_args

RasterizerName: TypeAlias = Literal["auto", "render", "compute"]
RASTERIZERS: tuple[RasterizerName, ...] = get_args(RasterizerName)
