# SPDX-License-Identifier: Apache-2.0
"""What adapters of engines read beside shapes: formats of vertices, colours, names, frames of inertia, clients, and
what is ignored. Each is skipped without its package."""

import numpy as np
import pytest
from test_engines import NONE, PRECISION, everywhere, in_a_process_without_sapien, listed, world_directions

import gnosphere
from gnosphere import adapter, primitives


@pytest.fixture
def scenes(monkeypatch):
    """The scenes that are made of shapes during a test."""
    made, real = [], adapter.Shapes.scene

    def scene(self):
        made.append(real(self))
        return made[-1]

    monkeypatch.setattr(adapter.Shapes, "scene", scene)
    return made


def colours(scene) -> list[tuple[float, ...]]:
    """The colour of each instance."""
    meshes = [scene.meshes[instance.mesh] for instance in scene.instances]
    return [pytest.approx(tuple(scene.materials[mesh.parts[0].material].base_color), abs=1e-6) for mesh in meshes]


def options(device):
    return {"effects": NONE, "options": gnosphere.SimulatorOptions(device)}


def panda_geom(core, x, columns=("vertex",), double=False, first=0, connected=True):
    """A square of 2 m across the x axis at x, whose four corners follow `first` others; its triangles name their
    corners, or have them in a row."""
    layout = core.GeomVertexArrayFormat()
    for column in columns:
        kind = core.Geom.CPoint if column == "vertex" else core.Geom.CNormal
        layout.addColumn(column, 3, core.Geom.NTFloat64 if double else core.Geom.NTFloat32, kind)
    form = core.GeomVertexFormat(layout)
    data = core.GeomVertexData("square", core.GeomVertexFormat.registerFormat(form), core.Geom.UHStatic)
    corners = [(x, -1, -1), (x, 1, -1), (x, 1, 1), (x, -1, 1)]
    corners = corners if connected else [corners[k] for k in (0, 1, 2, 0, 2, 3)]
    writers = {column: core.GeomVertexWriter(data, column) for column in columns}
    for corner in [(0.5, 0, 0)] * first + corners:
        for column, writer in writers.items():
            writer.addData3(*(corner if column == "vertex" else (-1, 0, 0)))
    faces = core.GeomTriangles(core.Geom.UHStatic)
    if connected:
        faces.addVertices(first, first + 1, first + 2)
        faces.addVertices(first, first + 2, first + 3)
    else:
        faces.addConsecutiveVertices(first, 6)
    geom = core.Geom(data)
    geom.addPrimitive(faces)
    return geom


@pytest.mark.parametrize("double", (False, True))
@pytest.mark.parametrize("columns", (("vertex",), ("normal", "vertex")))
@pytest.mark.parametrize(("first", "connected"), ((0, True), (2, True), (0, False), (3, False)))
def test_formats_of_vertices_of_panda3d(device, double, columns, first, connected):
    core = pytest.importorskip("panda3d.core")
    from gnosphere.engines.panda3d import Lidar

    root = core.NodePath("root")
    node = core.GeomNode("square")
    node.addGeom(panda_geom(core, 3, columns, double, first, connected))
    root.attachNewNode(node)
    way = np.array([[1, 0, 0], [1, 0.3, 0.2], [1, -0.3, 0.3], [1, 0.4, 0]])
    lidar = Lidar(root, listed(way / np.linalg.norm(way, axis=1)[:, None], 0, 100), **options(device))
    expected = 3 * np.linalg.norm(way, axis=1)
    expected[3] = np.nan
    np.testing.assert_allclose(lidar.scan(gnosphere.Pose()).ranges, expected, atol=PRECISION)


def test_colours_names_and_frames_of_panda3d(device, scenes):
    """The colour of a vertex is no flat one; a geom's state comes after its node's; the world is the root's frame."""
    core = pytest.importorskip("panda3d.core")
    from gnosphere.engines.panda3d import Lidar

    def painted(r, g, b):
        material = core.Material()
        material.setDiffuse((r, g, b, 1))
        return core.RenderState.make(core.MaterialAttrib.make(material))

    above = core.NodePath("above")
    above.setPos(100, 0, 0)
    root = above.attachNewNode("root")
    node = core.GeomNode("wall 7")
    lines = core.Geom(panda_geom(core, 1).getVertexData())
    lines.addPrimitive(core.GeomLines(core.Geom.UHStatic))
    node.addGeom(lines)  # has no triangles
    node.addGeom(panda_geom(core, 3), painted(0.1, 0.2, 0.3))
    node.addGeom(panda_geom(core, 5))
    street = root.attachNewNode("street")
    wall = street.attachNewNode(node)
    wall.setMaterial(painted(0.4, 0.5, 0.6).getAttrib(core.MaterialAttrib).getMaterial())
    plain = core.GeomNode("plain")
    plain.addGeom(panda_geom(core, 7))
    last = root.attachNewNode(plain)
    last.setPos(2, 0, 0)
    settings = options(device)
    lidar = Lidar(root, listed([[1, 0, 0]], 0, 200), classes={"street": 4, "plain": 5}, **settings)
    assert colours(scenes[-1]) == [(0.5, 0.5, 0.5, 1), (0.1, 0.2, 0.3, 1), (0.4, 0.5, 0.6, 1)]
    found = [(instance.name, instance.class_id) for instance in scenes[-1].instances]
    assert found == [("plain", 5), ("wall 7", 4), ("wall 7", 4)]
    assert lidar.scan(gnosphere.Pose()).ranges == pytest.approx([3])
    street.setColor(0.75, 0.25, 0.125, 1)
    last.setAttrib(core.ColorAttrib.makeVertex())
    for hidden, seen in (([wall], 9), ([street], 9), ([last], 3), ([wall, last], np.nan), ([root], np.nan)):
        lidar = Lidar(root, listed([[1, 0, 0]], 0, 200), ignore_below=hidden, **settings)
        np.testing.assert_allclose(lidar.scan(gnosphere.Pose()).ranges, [seen], atol=PRECISION)
    assert colours(scenes[-1]) == [(0.5, 0.5, 0.5, 1), (0.75, 0.25, 0.125, 1), (0.75, 0.25, 0.125, 1)]


ROBOT = """<robot name="rover"><link name="base"><inertial><origin xyz="0.3 -0.2 0.1" rpy="0.3 0.2 0.9"/>
<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>{base}</link>
<link name="arm"><inertial><origin xyz="0.1 0.4 -0.2" rpy="0.5 0.1 -0.4"/><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>{arm}</link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""

SHAPE = """<{0}><origin xyz="0.2 0.1 0.3" rpy="0.4 0.5 0.6"/><geometry>{1}</geometry>{2}</{0}>"""


def test_links_of_pybullet_are_where_its_rays_meet_them_in_the_client_that_is_given(device, tmp_path, scenes):
    """A base and a link with frames of inertia that are turned, and a mesh of another size than its file. There is a
    wall in the first client, which the LiDAR in the second one does not see."""
    pb = pytest.importorskip("pybullet")
    from gnosphere.engines.pybullet import Lidar

    vertices, faces = primitives.box((0.5, 0.25, 0.1))
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (tmp_path / "box.obj").write_text("\n".join(lines) + "\n")
    paint = '<material name="blue"><color rgba="0.1 0.2 0.75 1"/></material>'

    def both(geometry, material=""):
        return SHAPE.format("visual", geometry, material) + SHAPE.format("collision", geometry, "")

    text = ROBOT.format(
        base=both('<box size="0.6 0.5 0.4"/>', paint), arm=both('<mesh filename="box.obj" scale="1 2 3"/>')
    )
    (tmp_path / "robot.urdf").write_text(text)
    clients = [pb.connect(pb.DIRECT) for _ in range(2)]
    try:
        wall = pb.createCollisionShape(pb.GEOM_BOX, halfExtents=[1, 90, 90], physicsClientId=clients[0])
        for x in (-3, 3):
            pb.createMultiBody(0, wall, -1, [x, 0, 0], physicsClientId=clients[0])
        turn = pb.getQuaternionFromEuler([0.3, -0.2, 0.5])
        chosen = {"physicsClientId": clients[1]}
        flags = pb.URDF_USE_INERTIA_FROM_FILE
        body = pb.loadURDF(str(tmp_path / "robot.urdf"), [1.5, 0.4, -0.5], turn, flags=flags, **chosen)
        floor = pb.createCollisionShape(pb.GEOM_PLANE, planeNormal=[0, 0.6, 0.8], **chosen)
        pb.createMultiBody(0, floor, -1, [0, 0, -2], **chosen)
        sensor = everywhere(6000, 40)
        lidar = Lidar(
            sensor, client=clients[1], classes={"rov*": 3, "base": 5, "arm*": 4}, fields="class", **options(device)
        )
        assert [(one.name, one.class_id) for one in scenes[-1].instances][:2] == [("rover", 3), ("arm", 4)]
        assert colours(scenes[-1])[0] == (0.1, 0.2, 0.75, 1)
        ends = sensor.range_max * world_directions(sensor, gnosphere.Pose())
        for angle in (0.0, 1.1):
            pb.resetJointState(body, 0, angle, **chosen)
            scan = lidar.scan(gnosphere.Pose())
            answers = pb.rayTestBatch([[0, 0, 0]] * len(ends), ends.tolist(), **chosen)
            theirs = np.array([answer[2] for answer in answers]) * sensor.range_max
            bodies = np.array([answer[0] for answer in answers])
            links = np.array([answer[1] for answer in answers])
            own = lidar.body_ids(scan)
            same = own == bodies
            assert same.mean() > 0.99 and min(((links == link) & (bodies == body)).sum() for link in (-1, 0)) > 20
            for of_link in (links == -1) & (bodies == body), (links == 0) & (bodies == body), bodies > body:
                assert np.quantile(np.abs(scan.ranges - theirs)[same & of_link], 0.9) < 4e-3
            assert set(scan["class"][same & (links == 0) & (bodies == body)].tolist()) <= {3, 4}
    finally:
        for client in clients:
            pb.disconnect(client)


def test_links_of_pybullet_keep_up_with_their_base_in_a_step(device):
    """A box and another one beside it, which go on by 1 m in a step."""
    pb = pytest.importorskip("pybullet")
    from gnosphere.engines.pybullet import Lidar

    client = pb.connect(pb.DIRECT)
    try:
        box = pb.createCollisionShape(pb.GEOM_BOX, halfExtents=[0.25] * 3, physicsClientId=client)
        body = pb.createMultiBody(
            1, box, -1, [5, 0, 0], linkMasses=[1], linkCollisionShapeIndices=[box], linkVisualShapeIndices=[-1],
            linkPositions=[[0, 2, 0]], linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0, 0, 0]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0], linkJointTypes=[pb.JOINT_FIXED],
            linkJointAxis=[[0, 0, 1]], physicsClientId=client,
        )  # fmt: skip
        pb.setTimeStep(0.1, client)
        pb.changeDynamics(body, -1, linearDamping=0, physicsClientId=client)
        pb.resetBaseVelocity(body, [10, 0, 0], physicsClientId=client)
        sensor = listed([[1, 0, 0], [1, 0, 0]], 0, 100)
        sensor.patterns = [gnosphere.BeamList([[1, 0, 0]] * 2, [[0, 0, 0], [0, 2, 0]])]
        lidar = Lidar(sensor, client=client, **options(device))
        for x in (5, 6, 7):
            np.testing.assert_allclose(lidar.scan(gnosphere.Pose()).ranges, [x - 0.25] * 2, atol=1e-3)
            pb.stepSimulation(client)
    finally:
        pb.disconnect(client)


def test_colours_classes_and_sizes_of_sapien(device, tmp_path, scenes):
    sapien = pytest.importorskip("sapien")
    from gnosphere.engines.sapien import Lidar

    vertices, faces = primitives.box((0.5, 0.5, 0.5))
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (tmp_path / "box.obj").write_text("\n".join(lines) + "\n")
    scene, entities = sapien.Scene(), []
    for name, place in (("mesh", [5, 0, 0]), ("ball", [8, 0, 0]), ("robot", [2, 0, 0])):
        builder = scene.create_actor_builder()
        if name == "mesh":
            builder.add_visual_from_file(str(tmp_path / "box.obj"), scale=[2, 1, 1])
        elif name == "ball":
            builder.add_sphere_visual(radius=0.25, material=[0.2, 0.4, 0.6])
        else:
            builder.add_box_visual(half_size=[0.5, 0.25, 0.25], material=[0.1, 0.3, 0.9])
        builder.set_initial_pose(sapien.Pose(place))
        entities.append(builder.build_kinematic(name=name))
        entities[-1].set_pose(sapien.Pose(place))
    sensor = listed([[1, 0, 0]], 0, 100)
    for hidden, seen, kind in ((["robot"], 4, 1), (["robot", "mesh"], 7.75, 2), ([], 1.5, 0)):
        ignored = [entity for entity in entities if entity.name in hidden]
        lidar = Lidar(
            scene, sensor, ignore_entities=ignored, classes={"mesh": 1, "b*": 2}, fields="class", **options(device)
        )  # fmt: skip
        scan = lidar.scan(gnosphere.Pose())
        np.testing.assert_allclose(scan.ranges, [seen], atol=1e-3)
        assert scan["class"].tolist() == [kind]
    assert colours(scenes[-1])[-2:] == [(0.2, 0.4, 0.6, 1), (0.1, 0.3, 0.9, 1)]


def test_colours_classes_and_patterns_of_drake(device, scenes):
    """A sensor with two patterns that take turns, before two boxes."""
    pytest.importorskip("pydrake")
    from pydrake.geometry import Box, GeometryInstance, IllustrationProperties, Rgba, Role, SceneGraph
    from pydrake.math import RigidTransform
    from pydrake.systems.framework import DiagramBuilder

    from gnosphere.engines.drake import Lidar

    builder = DiagramBuilder()
    graph = builder.AddSystem(SceneGraph())
    source = graph.RegisterSource("source")
    for name, place, colour in (("wall", [4, 0, 0], (0.2, 0.4, 0.6, 1)), ("door", [0, 7, 0], None)):
        made = GeometryInstance(RigidTransform(place), Box(2, 2, 2), name)
        properties = IllustrationProperties()
        if colour:
            properties.AddProperty("phong", "diffuse", Rgba(*colour))
        made.set_illustration_properties(properties)
        graph.RegisterAnchoredGeometry(source, made)
    sensor = gnosphere.Sensor(
        range_max=100, patterns=[gnosphere.BeamList([[1, 0, 0]]), gnosphere.BeamList([[0, 1, 0]])]
    )
    lidar = Lidar(
        graph.model_inspector(), sensor, role=Role.kIllustration, classes={"wall": 3, "*door": 4}, fields="class",
        **options(device),
    )  # fmt: skip
    assert colours(scenes[-1]) == [(0.2, 0.4, 0.6, 1), (0.5, 0.5, 0.5, 1)]
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(context))
    for distance, kind in ((3, 3), (6, 4), (3, 3)):
        scan = lidar.scan(query)
        assert scan.ranges == pytest.approx([distance]) and scan["class"].tolist() == [kind]


def test_what_blender_hides_and_the_lidar_ignores(device, scenes):
    if in_a_process_without_sapien("test_what_blender_hides_and_the_lidar_ignores", __file__):
        return
    bpy = pytest.importorskip("bpy")
    from gnosphere.engines.blender import Lidar

    bpy.ops.wm.read_factory_settings(use_empty=True)
    boxes = []
    for number, x in enumerate((3, 6, 9)):
        bpy.ops.mesh.primitive_cube_add(size=2, location=(x, 0, 0))
        boxes.append(bpy.context.object)
        boxes[-1].name = f"box {number}"
    glass = bpy.data.materials.new("glass")
    glass.node_tree.nodes.clear()
    glass.diffuse_color = (0.2, 0.4, 0.6, 0.25)
    boxes[1].data.materials.append(glass)
    veil = bpy.data.materials.new("veil")  # whose alpha comes of a node, so it is as in the viewport
    shader = veil.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.5, 0.25, 0.75, 1)
    veil.node_tree.links.new(veil.node_tree.nodes.new("ShaderNodeValue").outputs[0], shader.inputs["Alpha"])
    veil.diffuse_color = (1, 1, 1, 0.5)
    boxes[2].data.materials.append(veil)
    # An object whose instances are shown in its place.
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(0, 20, 0))
    bpy.context.object.parent = boxes[0]
    boxes[0].instance_type, boxes[0].show_instancer_for_viewport = "VERTS", False
    depsgraph = bpy.context.evaluated_depsgraph_get()
    with pytest.warns(
        UserWarning, match=r"leaves out the nodes of the Alpha of materials, which are as in the viewport"
    ):
        lidar = Lidar(depsgraph, listed([[1, 0, 0]], 0, 100), **options(device))
    assert lidar.scan(depsgraph, gnosphere.Pose()).ranges == pytest.approx([5])
    assert "box 0" not in lidar.names
    assert colours(scenes[-1])[lidar.names.index("box 1")] == (0.2, 0.4, 0.6, 0.25)
    assert colours(scenes[-1])[lidar.names.index("box 2")] == (0.5, 0.25, 0.75, 0.5)
    with pytest.warns(UserWarning, match="leaves out the nodes of the Alpha"):
        lidar = Lidar(depsgraph, listed([[1, 0, 0]], 0, 100), ignore_objects=["box 1"], **options(device))
    assert lidar.scan(depsgraph, gnosphere.Pose()).ranges == pytest.approx([8])
