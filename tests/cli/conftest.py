from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def _run_in_empty_folder(working_folder: Path) -> Path:
    return working_folder
