import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from gpu_xform import load_mesh
from gpu_xform.cli import main
from gpu_xform.errors import MissingExtraError

CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
  <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
RELATIONSHIPS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
  <Relationship Id="rel0" Target="/3D/3dmodel.model"
    Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
# A tetrahedron, a pair of them of which the second is turned and moved, and the pair ten to the right.
MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
  <resources>
    <object id="1" type="model">
      <mesh>
        <vertices>
          <vertex x="0" y="0" z="0"/>
          <vertex x="1" y="0" z="0"/>
          <vertex x="0" y="2" z="0"/>
          <vertex x="0" y="0" z="3.5"/>
        </vertices>
        <triangles>
          <triangle v1="0" v2="2" v3="1"/>
          <triangle v1="0" v2="1" v3="3"/>
          <triangle v1="1" v2="2" v3="3"/>
          <triangle v1="2" v2="0" v3="3"/>
        </triangles>
      </mesh>
    </object>
    <object id="2" type="model">
      <components>
        <component objectid="1"/>
        <component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>
      </components>
    </object>
  </resources>
  <build>
    <item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>
  </build>
</model>
"""
TETRAHEDRON = np.array([(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3.5)])
TURNED = np.array([(0, 0, 5), (0, 1, 5), (-2, 0, 5), (0, 0, 8.5)])


@pytest.fixture
def pair(tmp_path: Path) -> Path:
    path = tmp_path / "pair.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as container:
        container.writestr("[Content_Types].xml", CONTENT_TYPES)
        container.writestr("_rels/.rels", RELATIONSHIPS)
        container.writestr("3D/3dmodel.model", MODEL)
    return path


def test_every_item_stands_where_its_transforms_put_it(pair: Path) -> None:
    mesh = load_mesh(pair)
    assert mesh.n_faces == 8
    corners = mesh.positions[mesh.indices].reshape(8, 3, 3)
    triangles = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    expected = np.concatenate([points[triangles] + (10, 0, 0) for points in (TETRAHEDRON, TURNED)])
    assert sorted(corners.tolist()) == sorted(expected.tolist())


@pytest.mark.parametrize("library", ["lxml.etree", "networkx"])
def test_without_its_libraries_the_error_says_what_to_install(
    library: str, pair: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError, match=r"^3MF needs lxml and networkx: pip install 'gpu_xform\[3mf\]'$"):
        load_mesh(pair)
    assert main(["transform", str(pair), str(pair.with_name("pair.obj"))]) == 2
    assert "pip install 'gpu_xform[3mf]'" in capsys.readouterr().err
