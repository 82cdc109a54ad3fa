#!/usr/bin/env bash
# cascadio 0.1.1 (Open CASCADE 8.0), NumPy 2.2.6.
#
# Behaviour: a STEP file may define its unit of length by any other unit (ISO 10303-41, conversion_based_unit): a foot as 12
# inches, an inch as 25.4 mm. If the other unit is not an SI unit, Open CASCADE takes the unit to be a millimetre, without a
# word: a ball of one foot becomes one of a millimetre. The same foot as 304.8 mm is read right.
#
# The guess before: both are 0.3048 m, for the factors need only be multiplied.
#
# Seen:
#   a foot of 304.8 mm: radius 0.304800 m
#   a foot of 12 inches of 25.4 mm: radius 0.001000 m
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install cascadio==0.1.1 numpy==2.2.6
"$folder/venv/bin/python" - <<'PYTHON'
import json
import struct

import cascadio

BALL = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','2026-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
#1=APPLICATION_CONTEXT('automotive design');
#2=APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#1);
#3=SHAPE_DEFINITION_REPRESENTATION(#4,#10);
#4=PRODUCT_DEFINITION_SHAPE('','',#5);
#5=PRODUCT_DEFINITION('design','',#6,#9);
#6=PRODUCT_DEFINITION_FORMATION('','',#7);
#7=PRODUCT('ball','ball','',(#8));
#8=PRODUCT_CONTEXT('',#1,'mechanical');
#9=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');
#10=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#11,#15),#30);
#11=AXIS2_PLACEMENT_3D('',#12,#13,#14);
#12=CARTESIAN_POINT('',(0.,0.,0.));
#13=DIRECTION('',(0.,0.,1.));
#14=DIRECTION('',(1.,0.,0.));
#15=MANIFOLD_SOLID_BREP('',#16);
#16=CLOSED_SHELL('',(#17));
#17=ADVANCED_FACE('',(#18),#22,.T.);
#18=FACE_BOUND('',#19,.T.);
#19=VERTEX_LOOP('',#20);
#20=VERTEX_POINT('',#21);
#21=CARTESIAN_POINT('',(0.,0.,-1.));
#22=SPHERICAL_SURFACE('',#11,1.);
#30=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#40,#50,#51))REPRESENTATION_CONTEXT('',''));
#40=(CONVERSION_BASED_UNIT('FOOT',#41)LENGTH_UNIT()NAMED_UNIT(#42));
#42=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
%s
#46=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#50=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#51=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
ENDSEC;
END-ISO-10303-21;
"""
FEET = {
    "a foot of 304.8 mm": "#41=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(304.8),#46);",
    "a foot of 12 inches of 25.4 mm": """#41=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(12.),#43);
#43=(CONVERSION_BASED_UNIT('INCH',#44)LENGTH_UNIT()NAMED_UNIT(#42));
#44=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#46);""",
}
seen = []
for name, definition in FEET.items():
    glb = cascadio.load((BALL % definition).encode(), tol_linear=1.0, tol_angular=0.5)
    document = json.loads(glb[20 : 20 + struct.unpack("<I", glb[12:16])[0]])
    (mesh,) = document["meshes"]
    positions = document["accessors"][mesh["primitives"][0]["attributes"]["POSITION"]]
    radius = positions["max"][2]
    seen.append(f"{radius:.6f}")
    print(f"{name}: radius {seen[-1]} m")
assert seen == ["0.304800", "0.001000"], seen
PYTHON
