"""What the site says about the project: its addresses, as pyproject.toml has them."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
URLS: dict[str, str] = _PROJECT["urls"]
REPOSITORY, SITE = URLS["Repository"], URLS["Documentation"]
