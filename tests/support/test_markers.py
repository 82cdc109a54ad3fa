"""Markers: `make test-quick` leaves out what needs a browser or a screen, by whatever way a test comes to it."""

import pytest

from tests.support.browser import Browser
from tests.support.markers import MARKING_FIXTURES


@pytest.fixture
def tab(browser: Browser) -> Browser:
    return browser


def test_a_fixture_of_a_fixture_marks(tab: Browser, request: pytest.FixtureRequest) -> None:
    assert tab.evaluate("1 + 1") == 2
    assert request.node.get_closest_marker("browser") is not None
    assert request.node.get_closest_marker("screen") is None


def test_other_tests_are_not_marked(request: pytest.FixtureRequest) -> None:
    assert not any(request.node.get_closest_marker(name) for name in MARKING_FIXTURES)


def test_every_marker_is_declared(pytestconfig: pytest.Config) -> None:
    declared = {line.partition(":")[0] for line in pytestconfig.getini("markers")}
    assert {*MARKING_FIXTURES, "slow"} <= declared
