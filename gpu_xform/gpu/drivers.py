"""What is installed: what to install on a machine without a Vulkan driver, and what the drivers can show."""

import ctypes
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


class _Extension(ctypes.Structure):
    """VkExtensionProperties."""

    _fields_ = (("name", ctypes.c_char * 256), ("version", ctypes.c_uint32))


def find_instance_extensions() -> frozenset[str] | None:
    """Return the extensions that some installed Vulkan driver of this Linux knows, or None if they cannot be told."""
    try:
        enumerate_extensions = ctypes.CDLL("libvulkan.so.1").vkEnumerateInstanceExtensionProperties
    except (OSError, AttributeError):
        return None
    n_found = ctypes.c_uint32()
    if enumerate_extensions(None, ctypes.byref(n_found), None) != 0:
        return None
    found = (_Extension * n_found.value)()
    if enumerate_extensions(None, ctypes.byref(n_found), found) != 0:
        return None
    return frozenset(extension.name.decode() for extension in found)


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
