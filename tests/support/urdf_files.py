"""URDF robots written by hand, and the mesh files that they name."""

# A base, an arm that turns about an axis that is not of length 1, a slider, and two fingers that follow in a chain.
ARM = """<?xml version="1.0"?>
<robot name="arm">
  <material name="blue"><color rgba="0.2 0.4 0.8 1"/></material>
  <link name="base">
    <visual><geometry><box size="0.4 0.3 0.1"/></geometry><material name="blue"/></visual>
    <collision><geometry><box size="9 9 9"/></geometry></collision>
  </link>
  <link name="upper">
    <visual name="tube">
      <origin xyz="0 0 0.25"/><geometry><cylinder radius="0.05" length="0.5"/></geometry>
      <material name=""><color rgba="1 0 0 0.5"/></material>
    </visual>
  </link>
  <link name="slider"><visual><geometry><sphere radius="0.08"/></geometry></visual></link>
  <link name="finger"><visual><geometry><mesh filename="meshes/tetra.stl" scale="1 -2 1"/></geometry></visual></link>
  <link name="tip"><visual><geometry><mesh filename="package://arm_description/meshes/tetra.stl"/></geometry></visual></link>
  <link name="tool"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/><axis xyz="0 3 4"/>
    <limit lower="-1.5" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="upper"/><child link="slider"/>
    <origin xyz="0 0 0.5" rpy="0 0 1.2"/><axis xyz="0 0 -2"/>
    <limit lower="0" upper="0.3" effort="1" velocity="1"/>
  </joint>
  <joint name="finger" type="continuous">
    <parent link="slider"/><child link="finger"/>
    <origin xyz="0.2 0 0"/><axis xyz="1 0 0"/><mimic joint="slide" multiplier="-4" offset="0.25"/>
  </joint>
  <joint name="tip_joint" type="revolute">
    <parent link="finger"/><child link="tip"/>
    <origin xyz="0 0.1 0"/><mimic joint="finger" multiplier="0.5" offset="-0.1"/>
    <limit lower="-0.01" upper="0.01" effort="1" velocity="1"/>
  </joint>
  <joint name="mount" type="fixed"><parent link="tip"/><child link="tool"/><origin xyz="0 0 0.05"/></joint>
</robot>
"""
TETRAHEDRON = """solid tetra
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0.1 0
vertex 0.1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0 0.2
endloop
endfacet
endsolid tetra
"""
TRIANGLE_DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
  <library_effects><effect id="e"><profile_COMMON><technique sid="common"><lambert>
    <diffuse><color>1 0.2 0.4 1</color></diffuse>
  </lambert></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="9">0 0 0 10 0 0 0 20 30</float_array>
      <technique_common><accessor source="#pa" count="3" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n"><translate>100 0 0</translate>
    <instance_geometry url="#g"><bind_material><technique_common>
      <instance_material symbol="s" target="#m"/>
    </technique_common></bind_material></instance_geometry>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""
