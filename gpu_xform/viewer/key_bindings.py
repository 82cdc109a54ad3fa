"""Key bindings, as the help describes them; `controls` carries them out."""

from ..drawing.enums import HIDDEN_STYLES
from ..geometry.edges import EDGE_SETS

EDGE_CYCLE = tuple(name for name in EDGE_SETS if name != "intersection")  # which most models do not have

POINTER = (
    ("drag", "rotate"),
    ("drag with Shift", "move, as do the right and the middle button"),
    ("wheel, + and -", "zoom; the wheel keeps what is under the pointer"),
    ("arrows", "rotate by 15 degrees"),
)
KEYS = (
    ("E", f"edges: {', '.join(EDGE_CYCLE)}"),
    ("D", f"hidden edges: {', '.join(HIDDEN_STYLES)}"),
    ("F", "fill the faces, or only draw lines"),
    ("C", "one colour per face, or one for all"),
    ("A", "smooth lines, or jagged ones, which are faster"),
    ("B", "background: as at first, light, dark"),
    ("P", "perspective or parallel projection"),
    ("1, 2, 3", "front, right, above; with Shift back, left, below"),
    ("R, Home", "back to the first view"),
    ("Backspace", "back to the first style"),
    ("S", "save the picture: MODEL-1.png, MODEL-2.png, ..."),
    ("H, ?", "show or hide the keys"),
    ("Q, Esc", "close"),
)
HELP = POINTER + KEYS

# Of a window that shows springs:
SIMULATION = (
    ("drag a point", "pull it; beside the model, drags rotate"),
    ("Space", "start or stop the simulation"),
    ("0", "the simulation back to its start"),
)
