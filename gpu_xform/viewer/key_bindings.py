"""What the pointer and the keys do, in words; `controls` does it."""

from ..drawing.enums import HIDDEN_STYLES
from ..geometry.edges import EDGE_SETS

POINTER = (
    ("drag", "turn"),
    ("drag with Shift", "move; likewise with the right or the middle button"),
    ("wheel, + and -", "closer to what is under the pointer, or farther"),
    ("arrows", "turn by 15 degrees"),
)
KEYS = (
    ("E", f"edges: {', '.join(EDGE_SETS)}"),
    ("D", f"hidden edges: {', '.join(HIDDEN_STYLES)}"),
    ("F", "paint the faces, or do not"),
    ("C", "a colour for each face, or one for all"),
    ("A", "smooth lines, or rough ones: fast"),
    ("B", "background: the first, light, dark"),
    ("P", "perspective, or a parallel view"),
    ("1, 2, 3", "front, right, above; with Shift back, left, below"),
    ("R, Home", "the first view again"),
    ("Backspace", "the first style again"),
    ("S", "save the picture: MODEL-1.png, MODEL-2.png, ..."),
    ("H, ?", "show the keys, or hide them"),
    ("Q, Esc", "close"),
)
HELP = POINTER + KEYS
