"""STEP files (ISO 10303-21, AP214) written by hand: boxes, cylinders, balls, and assemblies of them."""

from collections.abc import Sequence
from typing import Any

MILLIMETRE = ("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )",)
METRE = ("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) )",)
INCH = (
    "( CONVERSION_BASED_UNIT('INCH',{1}) LENGTH_UNIT() NAMED_UNIT({3}) )",
    "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{2})",
    "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )",
    "DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)",
)
RED = (0.8, 0.2, 0.4)

Point = tuple[float, float, float]


class StepFile:
    """A file to which solids, products and placements are added; `text` is the whole file.

    unit : the unit of length and what it is defined by, each an entity in which {1} is the second of them
    """

    def __init__(self, unit: Sequence[str] = MILLIMETRE) -> None:
        self._lines: list[str] = []
        first = len(self._lines) + 1
        references = [f"#{first + i}" for i in range(len(unit))]
        for entity in unit:
            self.add(entity.format(*references))
        self.length = references[0]
        radian = self.add("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )")
        solid = self.add("( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() )")
        self.context = self.add(
            "( GEOMETRIC_REPRESENTATION_CONTEXT(3) "
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({self.length},{radian},{solid})) REPRESENTATION_CONTEXT('','3D') )"
        )
        self.application = self.add("APPLICATION_CONTEXT('automotive design')")
        self.add(
            f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{self.application})"
        )
        self.origin = self.placement((0, 0, 0))

    def add(self, entity: str) -> str:
        """Add an entity, and return its reference."""
        self._lines.append(entity)
        return f"#{len(self._lines)}"

    @property
    def text(self) -> bytes:
        """The file."""
        data = "".join(f"#{i} = {line};\n" for i, line in enumerate(self._lines, 1))
        head = "FILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','2026-01-01T00:00:00',(''),(''),'','','');\n"
        schema = "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\n"
        return f"ISO-10303-21;\nHEADER;\n{head}{schema}ENDSEC;\nDATA;\n{data}ENDSEC;\nEND-ISO-10303-21;\n".encode(
            "ascii"
        )

    def point(self, point: Sequence[float]) -> str:
        """Add a point."""
        return self.add(f"CARTESIAN_POINT('',({','.join(map(_real, point))}))")

    def direction(self, vector: Sequence[float]) -> str:
        """Add a direction."""
        return self.add(f"DIRECTION('',({','.join(map(_real, vector))}))")

    def placement(self, point: Sequence[float], z: Point = (0, 0, 1), x: Point = (1, 0, 0)) -> str:
        """Add axes at a point."""
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.point(point)},{self.direction(z)},{self.direction(x)})")

    def box(self, *sides: float, first: Point = (0, 0, 0)) -> str:
        """Add a box between `first` and `first` + `sides`."""
        corners = [[first[i] + (n >> i & 1) * sides[i] for i in range(3)] for n in range(8)]
        vertices = [self.add(f"VERTEX_POINT('',{self.point(corner)})") for corner in corners]
        edges: dict[tuple[int, int], str] = {}
        for a in range(8):
            for i in range(3):
                if not a >> i & 1:
                    b = a | 1 << i
                    axis = self.direction([float(j == i) for j in range(3)])
                    along = self.add(f"VECTOR('',{axis},1.)")
                    line = self.add(f"LINE('',{self.point(corners[a])},{along})")
                    edges[a, b] = self.add(f"EDGE_CURVE('',{vertices[a]},{vertices[b]},{line},.T.)")
        faces = []
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for is_far in (False, True):
                start = is_far << i
                loop = [start, start | 1 << j, start | 1 << j | 1 << k, start | 1 << k]
                loop = loop if is_far else loop[::-1]
                uses = []
                for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
                    edge, sense = (edges[a, b], ".T.") if (a, b) in edges else (edges[b, a], ".F.")
                    uses.append(self.add(f"ORIENTED_EDGE('',*,*,{edge},{sense})"))
                normal = tuple((1.0 if is_far else -1.0) * (n == i) for n in range(3))
                across = tuple(float(n == j) for n in range(3))
                plane = self.add(f"PLANE('',{self.placement(corners[start], normal, across)})")  # type: ignore[arg-type]
                faces.append(self._face(plane, uses))
        return self._solid(faces)

    def cylinder(self, radius: float, height: float) -> str:
        """Add a cylinder along z, with its foot in the origin."""
        ends, circles = [], []
        for z in (0.0, height):
            ends.append(self.add(f"VERTEX_POINT('',{self.point((radius, 0, z))})"))
            circle = self.add(f"CIRCLE('',{self.placement((0, 0, z))},{_real(radius)})")
            circles.append(self.add(f"EDGE_CURVE('',{ends[-1]},{ends[-1]},{circle},.T.)"))
        up = self.add(f"VECTOR('',{self.direction((0, 0, 1))},1.)")
        line = self.add(f"LINE('',{self.point((radius, 0, 0))},{up})")
        seam = self.add(f"EDGE_CURVE('',{ends[0]},{ends[1]},{line},.T.)")
        use = {
            (edge, sense): self.add(f"ORIENTED_EDGE('',*,*,{edge},.{sense}.)")
            for edge in (*circles, seam)
            for sense in "TF"
        }
        side = self.add(f"CYLINDRICAL_SURFACE('',{self.placement((0, 0, 0))},{_real(radius)})")
        around = [use[circles[0], "T"], use[seam, "T"], use[circles[1], "F"], use[seam, "F"]]
        top = self.add(f"PLANE('',{self.placement((0, 0, height))})")
        bottom = self.add(f"PLANE('',{self.placement((0, 0, 0), (0, 0, -1))})")
        faces = [
            self._face(side, around),
            self._face(top, [use[circles[1], "T"]]),
            self._face(bottom, [use[circles[0], "F"]]),
        ]
        return self._solid(faces)

    def ball(self, radius: float) -> str:
        """Add a ball around the origin: one face, which has one vertex and no edge."""
        vertex = self.add(f"VERTEX_POINT('',{self.point((0, 0, -radius))})")
        loop = self.add(f"VERTEX_LOOP('',{vertex})")
        bound = self.add(f"FACE_BOUND('',{loop},.T.)")
        surface = self.add(f"SPHERICAL_SURFACE('',{self.placement((0, 0, 0))},{_real(radius)})")
        return self._solid([self.add(f"ADVANCED_FACE('',({bound}),{surface},.T.)")])

    def product(self, name: str, *solids: str, color: tuple[float, float, float] | None = None) -> tuple[str, str, str]:
        """Add a product of solids, or an assembly without any; return what `place` takes."""
        items = ",".join([self.origin, *solids])
        kind = "ADVANCED_BREP_SHAPE_REPRESENTATION" if solids else "SHAPE_REPRESENTATION"
        shape = self.add(f"{kind}('{name}',({items}),{self.context})")
        context = self.add(f"PRODUCT_CONTEXT('',{self.application},'mechanical')")
        product = self.add(f"PRODUCT('{name}','{name}','',({context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        stage = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{self.application},'design')")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
        of_product = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({of_product},{shape})")
        if color is not None:
            rgb = self.add(f"COLOUR_RGB('',{','.join(map(_real, color))})")
            filled = self.add(f"FILL_AREA_STYLE_COLOUR('',{rgb})")
            area = self.add(f"FILL_AREA_STYLE('',({filled}))")
            fill = self.add(f"SURFACE_STYLE_FILL_AREA({area})")
            side = self.add(f"SURFACE_SIDE_STYLE('',({fill}))")
            use = self.add(f"SURFACE_STYLE_USAGE(.BOTH.,{side})")
            style = self.add(f"PRESENTATION_STYLE_ASSIGNMENT(({use}))")
            styled = ",".join(self.add(f"STYLED_ITEM('color',({style}),{solid})") for solid in solids)
            self.add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({styled}),{self.context})")
        return name, definition, shape

    def place(self, part: Any, into: Any, name: str, at: Sequence[float], x: Point = (1, 0, 0)) -> None:
        """Place a product in an assembly, its origin at a point, its x-axis along `x`, its z-axis along z."""
        target = self.placement(at, (0, 0, 1), x)
        move = self.add(f"ITEM_DEFINED_TRANSFORMATION('','',{self.origin},{target})")
        relation = self.add(
            f"( REPRESENTATION_RELATIONSHIP('','',{part[2]},{into[2]}) "
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move}) SHAPE_REPRESENTATION_RELATIONSHIP() )"
        )
        usage = self.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{name}','{name}','',{into[1]},{part[1]},$)")
        shape = self.add(f"PRODUCT_DEFINITION_SHAPE('Placement','Placement of an item',{usage})")
        self.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})")

    def _face(self, surface: str, uses: Sequence[str]) -> str:
        loop = self.add(f"EDGE_LOOP('',({','.join(uses)}))")
        bound = self.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        return self.add(f"ADVANCED_FACE('',({bound}),{surface},.T.)")

    def _solid(self, faces: Sequence[str]) -> str:
        shell = self.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        return self.add(f"MANIFOLD_SOLID_BREP('',{shell})")


def write_box(*sides: float, unit: Sequence[str] = MILLIMETRE) -> bytes:
    """Return a file of one box."""
    file = StepFile(unit)
    file.product("box", file.box(*sides))
    return file.text


def write_cylinder(radius: float, height: float, unit: Sequence[str] = MILLIMETRE) -> bytes:
    """Return a file of one cylinder."""
    file = StepFile(unit)
    file.product("cylinder", file.cylinder(radius, height), color=RED)
    return file.text


def write_assembly() -> bytes:
    """Return a plate with two pairs of bolts on it, of which the second bolt is turned by 90 degrees about z."""
    file = StepFile()
    bolt = file.product("bolt", file.cylinder(2, 12), color=RED)
    plate = file.product("plate", file.box(40, 30, 5))
    pair, top = file.product("pair"), file.product("assembly")
    file.place(bolt, pair, "left", (0, 0, 0))
    file.place(bolt, pair, "right", (20, 0, 0), (0, 1, 0))
    file.place(plate, top, "base", (0, 0, 0))
    file.place(pair, top, "near", (10, 10, 5))
    file.place(pair, top, "far", (10, 20, 5))
    return file.text


def _real(value: float) -> str:
    """Return a number as the format writes it, with a point."""
    text = repr(float(value)).upper()
    return text if "." in text else text.replace("E", ".E")
