"""Markers that follow from the fixtures of a test."""

from collections.abc import Iterable

import pytest

MARKING_FIXTURES = ("browser", "screen")


def mark_by_fixtures(items: Iterable[pytest.Item]) -> None:
    """Give every test that uses a fixture in `MARKING_FIXTURES`, itself or through others, the marker of that name."""
    for item in items:
        for fixture in MARKING_FIXTURES:
            if fixture in getattr(item, "fixturenames", ()):
                item.add_marker(fixture)
