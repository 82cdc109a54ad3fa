"""Hints about drivers: what to install on a machine without a Vulkan driver."""

import platform
import sys

PACKAGES = {
    "debian": "apt-get install -y mesa-vulkan-drivers libvulkan1",
    "fedora": "dnf install -y mesa-vulkan-drivers vulkan-loader",
    "rhel": "dnf install -y mesa-vulkan-drivers vulkan-loader",
    "suse": "zypper install -y libvulkan_lvp libvulkan1",
    "arch": "pacman -S --needed vulkan-swrast vulkan-icd-loader",
    "alpine": "apk add mesa-vulkan-swrast vulkan-loader",
}


def suggest_driver() -> str:
    """Say in one line how this system gets a driver; on Linux that is Mesa's lavapipe, which needs no GPU."""
    if sys.platform != "linux":
        return "Update the driver of the graphics card."
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        release = {}
    for system in [release.get("ID", ""), *release.get("ID_LIKE", "").split()]:
        if system in PACKAGES:
            return f"Install one that needs no GPU: sudo {PACKAGES[system]}"
        if system in {"ubuntu", "linuxmint"}:
            return f"Install one that needs no GPU: sudo {PACKAGES['debian']}"
    return "Install Mesa's lavapipe, which needs no GPU (the Vulkan software driver), and the Vulkan loader."
