#!/usr/bin/env bash
# cascadio 0.1.1 (Open CASCADE 8.0), NumPy 2.2.6.
#
# Behaviour: with include_brep=True the GLB says for each triangle which face of the solid it is of (TM_brep_faces). If
# faces differ in colour, a mesh has a primitive per colour, and only the first of them has the extension: the faces of all
# others are lost, without a word. Readers that take a missing extension for a file without faces see a part of the solid.
#
# The guess before: every primitive has the extension, with an index for each of its triangles.
#
# Seen, of a cylinder whose three faces are red, green and blue:
#   64 triangles, 64 indices, of ['cylinder']
#   30 triangles, no extension
#   30 triangles, no extension
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install cascadio==0.1.1 numpy==2.2.6
cat > "$folder/cylinder.step" <<'STEP'
ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','2026-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
#1 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#2 = ( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) );
#3 = ( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() );
#4 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2,#3)) REPRESENTATION_CONTEXT('','3D') );
#5 = APPLICATION_CONTEXT('automotive design');
#6 = APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#5);
#7 = CARTESIAN_POINT('',(0.0,0.0,0.0));
#8 = DIRECTION('',(0.0,0.0,1.0));
#9 = DIRECTION('',(1.0,0.0,0.0));
#10 = AXIS2_PLACEMENT_3D('',#7,#8,#9);
#11 = CARTESIAN_POINT('',(1.0,0.0,0.0));
#12 = VERTEX_POINT('',#11);
#13 = CARTESIAN_POINT('',(0.0,0.0,0.0));
#14 = DIRECTION('',(0.0,0.0,1.0));
#15 = DIRECTION('',(1.0,0.0,0.0));
#16 = AXIS2_PLACEMENT_3D('',#13,#14,#15);
#17 = CIRCLE('',#16,1.0);
#18 = EDGE_CURVE('',#12,#12,#17,.T.);
#19 = CARTESIAN_POINT('',(1.0,0.0,2.0));
#20 = VERTEX_POINT('',#19);
#21 = CARTESIAN_POINT('',(0.0,0.0,2.0));
#22 = DIRECTION('',(0.0,0.0,1.0));
#23 = DIRECTION('',(1.0,0.0,0.0));
#24 = AXIS2_PLACEMENT_3D('',#21,#22,#23);
#25 = CIRCLE('',#24,1.0);
#26 = EDGE_CURVE('',#20,#20,#25,.T.);
#27 = DIRECTION('',(0.0,0.0,1.0));
#28 = VECTOR('',#27,1.);
#29 = CARTESIAN_POINT('',(1.0,0.0,0.0));
#30 = LINE('',#29,#28);
#31 = EDGE_CURVE('',#12,#20,#30,.T.);
#32 = ORIENTED_EDGE('',*,*,#18,.T.);
#33 = ORIENTED_EDGE('',*,*,#18,.F.);
#34 = ORIENTED_EDGE('',*,*,#26,.T.);
#35 = ORIENTED_EDGE('',*,*,#26,.F.);
#36 = ORIENTED_EDGE('',*,*,#31,.T.);
#37 = ORIENTED_EDGE('',*,*,#31,.F.);
#38 = CARTESIAN_POINT('',(0.0,0.0,0.0));
#39 = DIRECTION('',(0.0,0.0,1.0));
#40 = DIRECTION('',(1.0,0.0,0.0));
#41 = AXIS2_PLACEMENT_3D('',#38,#39,#40);
#42 = CYLINDRICAL_SURFACE('',#41,1.0);
#43 = CARTESIAN_POINT('',(0.0,0.0,2.0));
#44 = DIRECTION('',(0.0,0.0,1.0));
#45 = DIRECTION('',(1.0,0.0,0.0));
#46 = AXIS2_PLACEMENT_3D('',#43,#44,#45);
#47 = PLANE('',#46);
#48 = CARTESIAN_POINT('',(0.0,0.0,0.0));
#49 = DIRECTION('',(0.0,0.0,-1.0));
#50 = DIRECTION('',(1.0,0.0,0.0));
#51 = AXIS2_PLACEMENT_3D('',#48,#49,#50);
#52 = PLANE('',#51);
#53 = EDGE_LOOP('',(#32,#36,#35,#37));
#54 = FACE_OUTER_BOUND('',#53,.T.);
#55 = ADVANCED_FACE('',(#54),#42,.T.);
#56 = EDGE_LOOP('',(#34));
#57 = FACE_OUTER_BOUND('',#56,.T.);
#58 = ADVANCED_FACE('',(#57),#47,.T.);
#59 = EDGE_LOOP('',(#33));
#60 = FACE_OUTER_BOUND('',#59,.T.);
#61 = ADVANCED_FACE('',(#60),#52,.T.);
#62 = CLOSED_SHELL('',(#55,#58,#61));
#63 = MANIFOLD_SOLID_BREP('',#62);
#64 = ADVANCED_BREP_SHAPE_REPRESENTATION('c',(#10,#63),#4);
#65 = PRODUCT_CONTEXT('',#5,'mechanical');
#66 = PRODUCT('c','c','',(#65));
#67 = PRODUCT_DEFINITION_FORMATION('','',#66);
#68 = PRODUCT_DEFINITION_CONTEXT('part definition',#5,'design');
#69 = PRODUCT_DEFINITION('design','',#67,#68);
#70 = PRODUCT_DEFINITION_SHAPE('','',#69);
#71 = SHAPE_DEFINITION_REPRESENTATION(#70,#64);
#72 = COLOUR_RGB('',1.,0.,0.);
#73 = FILL_AREA_STYLE_COLOUR('',#72);
#74 = FILL_AREA_STYLE('',(#73));
#75 = SURFACE_STYLE_FILL_AREA(#74);
#76 = SURFACE_SIDE_STYLE('',(#75));
#77 = SURFACE_STYLE_USAGE(.BOTH.,#76);
#78 = PRESENTATION_STYLE_ASSIGNMENT((#77));
#79 = STYLED_ITEM('color',(#78),#55);
#80 = COLOUR_RGB('',0.,1.,0.);
#81 = FILL_AREA_STYLE_COLOUR('',#80);
#82 = FILL_AREA_STYLE('',(#81));
#83 = SURFACE_STYLE_FILL_AREA(#82);
#84 = SURFACE_SIDE_STYLE('',(#83));
#85 = SURFACE_STYLE_USAGE(.BOTH.,#84);
#86 = PRESENTATION_STYLE_ASSIGNMENT((#85));
#87 = STYLED_ITEM('color',(#86),#58);
#88 = COLOUR_RGB('',0.,0.,1.);
#89 = FILL_AREA_STYLE_COLOUR('',#88);
#90 = FILL_AREA_STYLE('',(#89));
#91 = SURFACE_STYLE_FILL_AREA(#90);
#92 = SURFACE_SIDE_STYLE('',(#91));
#93 = SURFACE_STYLE_USAGE(.BOTH.,#92);
#94 = PRESENTATION_STYLE_ASSIGNMENT((#93));
#95 = STYLED_ITEM('color',(#94),#61);
#96 = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#79,#87,#95),#4);
ENDSEC;
END-ISO-10303-21;
STEP
"$folder/venv/bin/python" - "$folder/cylinder.step" <<'PYTHON'
import json
import struct
import sys
from pathlib import Path

import cascadio

glb = cascadio.load(Path(sys.argv[1]).read_bytes(), include_brep=True)
document = json.loads(glb[20 : 20 + struct.unpack("<I", glb[12:16])[0]])
(mesh,) = document["meshes"]
seen = []
for primitive in mesh["primitives"]:
    count = document["accessors"][primitive["indices"]]["count"] // 3
    extension = primitive.get("extensions", {}).get("TM_brep_faces")
    if extension is None:
        seen.append(f"{count} triangles, no extension")
    else:
        n_indices = document["accessors"][extension["faceIndices"]]["count"]
        seen.append(f"{count} triangles, {n_indices} indices, of {[face['type'] for face in extension['faces']]}")
print("\n".join(seen))
assert seen == ["64 triangles, 64 indices, of ['cylinder']"] + ["30 triangles, no extension"] * 2, seen
PYTHON
