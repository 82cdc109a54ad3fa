"""Hints about drivers."""

import sys

import pytest

from gpu_xform.gpu import drivers


@pytest.mark.parametrize(
    ("release", "expected"),
    [
        ({"ID": "debian"}, "sudo apt-get install -y mesa-vulkan-drivers libvulkan1"),
        ({"ID": "ubuntu", "ID_LIKE": "debian"}, "sudo apt-get install"),
        ({"ID": "rocky", "ID_LIKE": "rhel centos fedora"}, "sudo dnf install"),
        ({"ID": "alpine"}, "sudo apk add"),
        ({"ID": "other"}, "lavapipe"),
        (None, "lavapipe"),
    ],
)
def test_the_hint_names_the_systems_own_package(
    release: dict[str, str] | None, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read() -> dict[str, str]:
        if release is None:
            raise OSError
        return release

    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr("platform.freedesktop_os_release", read)
    assert expected in drivers.suggest_driver()
    monkeypatch.setattr(sys, "platform", "win32")
    assert "driver" in drivers.suggest_driver()
