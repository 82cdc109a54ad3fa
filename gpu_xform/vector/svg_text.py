"""SVG documents as text that notebooks show as the picture."""

from .._core.atomic_files import atomic_write
from .._core.public import public
from .._core.types import StrPath


@public
class SvgText(str):
    """An SVG document: a string that notebooks show as the picture it describes. `render_svg` returns it."""

    __slots__ = ()

    def save(self, path: StrPath) -> None:
        """Write the document to a file, as a whole or not at all.

        Parameters
        ----------
        path : path
            The file, in UTF-8.

        Raises
        ------
        ArgumentTypeError
            `path` is not a path.
        OSError
            The operating system refuses to write the file.
        """
        with atomic_write(path) as file:
            file.write(self.encode())

    def _repr_svg_(self) -> str:
        return str(self)
