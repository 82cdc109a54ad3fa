"""Pointers of Git LFS, which stand in a checkout for files that have not been fetched."""

_BEGINNING = b"version https://git-lfs.github.com/spec/"

MAX_POINTER_BYTES = 1024  # by its specification
POINTER_WORDS = "a pointer of Git LFS, not the file itself, which git lfs pull fetches"


def is_lfs_pointer(data: bytes) -> bool:
    """Return whether a file that begins with `data` is a pointer."""
    return data.startswith(_BEGINNING)
