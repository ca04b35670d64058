# SPDX-License-Identifier: Apache-2.0
"""LiDARs in other engines, each against its own geometry in double precision and against its own rays or pictures, a
million beams each. Each is skipped without its package."""

import subprocess
import sys
import warnings

import exact
import numpy as np
import pytest

import gnosphere
from gnosphere import adapter, primitives

NONE = gnosphere.Effects.none()
BEAMS = 340_000  # in each of three states
PRECISION = 1e-5
"""Metres. These engines keep coordinates in single precision, or we do: the grounds reach 50 m and more, where a step
of single precision is 4e-6 m."""


def everywhere(count: int, range_max: float = 100, seed: int = 0) -> gnosphere.Sensor:
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    return listed(directions / np.linalg.norm(directions, axis=1, keepdims=True), 0, range_max)


def listed(directions, range_min: float, range_max: float) -> gnosphere.Sensor:
    sensor = gnosphere.Sensor()
    sensor.name, sensor.range_min, sensor.range_max = "everywhere", range_min, range_max
    sensor.patterns = [gnosphere.BeamList(directions)]
    return sensor


def world_directions(sensor, pose):
    return gnosphere.beams_of(sensor).directions.astype(float) @ adapter.rows_of(pose)[:3, :3].T


POSE = gnosphere.Pose((0.1, 0.2, 1.1), (0.1, 0.2, 0.3, 0.9))


def assert_right(world, sensor, pose, ranges, owners, precision=PRECISION):
    """No answer is off by more than the precision; returns the exact answers."""
    answers = world.check(pose.position, world_directions(sensor, pose), ranges, owners, precision, sensor.range_max)
    wrong = answers.wrong
    shown = [(ranges[i], answers.ranges[i], owners[i], answers.owners[i]) for i in wrong[:5]]
    assert not len(wrong), f"{len(wrong)} of {len(ranges)}: {shown}"
    assert (answers.owners != owners).sum() < 1e-3 * len(ranges)  # ties are few
    return answers


@pytest.fixture
def bullet():
    pb = pytest.importorskip("pybullet")
    client = pb.connect(pb.DIRECT)
    yield pb, client
    pb.disconnect(client)


def bullet_rays(pb, sensor, pose):
    ends = np.array(pose.position) + sensor.range_max * world_directions(sensor, pose)
    answers = []
    for first in range(0, len(ends), 10000):
        run = ends[first : first + 10000]
        answers += pb.rayTestBatch([pose.position] * len(run), run.tolist())
    bodies = np.array([answer[0] for answer in answers])
    ranges = np.array([answer[2] for answer in answers]) * sensor.range_max
    return np.where(bodies < 0, np.nan, ranges), bodies


BULLET = 1.1e-3
"""Metres. Bullet's rays against convex shapes stop where a squared distance is at most ten times the epsilon of single
precision (btSubSimplexConvexCast.cpp), and its results are shares of a ray of 100 m."""


def test_pybullet_against_its_ray_tests(bullet, device, tmp_path):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    rng, depth = np.random.default_rng(3), 2e-4
    corners = rng.uniform(-0.8, 0.8, (30, 1, 3)) + rng.uniform(-0.3, 0.3, (30, 3, 3))
    soup = np.round(corners.reshape(-1, 3), 5), np.arange(90).reshape(-1, 3)
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in soup[0]] + [f"f {a} {b} {c}" for a, b, c in soup[1] + 1]
    (tmp_path / "soup.obj").write_text("\n".join(lines) + "\n")
    kinds = [
        (pb.GEOM_BOX, {"halfExtents": [0.4, 0.5, 0.6]}, exact.box((0.4, 0.5, 0.6))),
        (pb.GEOM_SPHERE, {"radius": 0.5}, exact.sphere(0.5)),
        (pb.GEOM_CYLINDER, {"radius": 0.4, "height": 1.1}, exact.cylinder(0.4, 0.55)),
        (pb.GEOM_CAPSULE, {"radius": 0.3, "height": 0.8}, exact.capsule(0.3, 0.4)),
        (pb.GEOM_MESH, {"fileName": str(tmp_path / "soup.obj"), "flags": pb.GEOM_FORCE_CONCAVE_TRIMESH}, None),
    ]
    bodies = {}
    for i in range(20):
        kind, size, distance = kinds[i % len(kinds)]
        angle = 2 * np.pi * i / 20
        shape = pb.createCollisionShape(kind, **size)
        body = pb.createMultiBody(0, shape, -1, [4 * np.cos(angle), 4 * np.sin(angle), 0.4 * (i % 4)])
        bodies[body] = distance
    ground = pb.createMultiBody(0, pb.createCollisionShape(pb.GEOM_BOX, halfExtents=[50, 50, 1]), -1, [0, 0, -3])
    sensor = everywhere(BEAMS)
    lidar = Lidar(sensor, effects=NONE, options=gnosphere.SimulatorOptions(device), tolerance=depth)
    for _ in range(3):
        world = exact.World()
        world.mesh(ground, *primitives.box((50, 50, 1)), adapter.rows_of(gnosphere.Pose((0, 0, -3))))
        for body, distance in bodies.items():
            place = adapter.rows_of(gnosphere.Pose(*pb.getBasePositionAndOrientation(body)))
            if distance is None:
                world.mesh(body, *soup, place)
            else:
                world.solid(body, distance, place, 0.9, depth)
        scan = lidar.scan(POSE)
        assert_right(world, sensor, POSE, scan.ranges, lidar.body_ids(scan))
        theirs, hits = bullet_rays(pb, sensor, POSE)
        assert_right(world, sensor, POSE, theirs, hits, BULLET)
        assert len(set(hits)) == 22
        for body in bodies:
            position, _ = pb.getBasePositionAndOrientation(body)
            turn = rng.normal(size=4)
            moved = np.array(position) + rng.uniform(-0.2, 0.2, 3)
            pb.resetBasePositionAndOrientation(body, moved, turn / np.linalg.norm(turn))


@pytest.mark.parametrize("normal", ((0, 0, 1), (0, 1, 0), (1, 0, 0), (0.3, 0.4, -0.5), (0, 0, -2)))
@pytest.mark.parametrize("turned", (False, True))
def test_pybullet_planes_along_their_normals(bullet, device, normal, turned):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    own = {}
    if turned:
        own["collisionFramePosition"] = [0.1, 0.2, 0.3]
        own["collisionFrameOrientation"] = pb.getQuaternionFromEuler([0.5, 0.6, 0.7])
    shape = pb.createCollisionShape(pb.GEOM_PLANE, planeNormal=normal, **own)
    pb.createMultiBody(0, shape, -1, [0.5, -0.4, 0.3], pb.getQuaternionFromEuler([0.3, 0.2, 0.1]))
    sensor = everywhere(20000, 50)
    scan = Lidar(sensor, effects=NONE, options=gnosphere.SimulatorOptions(device)).scan(gnosphere.Pose())
    theirs, _ = bullet_rays(pb, sensor, gnosphere.Pose())
    assert np.isfinite(theirs).sum() > 5000
    np.testing.assert_allclose(scan.ranges, theirs, rtol=1e-3, atol=BULLET)


def test_a_plane_of_pybullet_whose_normal_is_not_told(bullet, device):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    pb.createMultiBody(0, -1, pb.createVisualShape(pb.GEOM_PLANE, planeNormal=[0, 1, 0]))
    with pytest.warns(UserWarning, match="leaves out normals of planes that are only seen, which PyBullet does not"):
        Lidar(everywhere(10), effects=NONE, options=gnosphere.SimulatorOptions(device))


def test_what_pybullet_does_not_tell_is_left_out(bullet, device):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    box = pb.createCollisionShape(pb.GEOM_BOX, halfExtents=[0.5] * 3)
    pb.createMultiBody(0, box, -1, [5, 0, 0])
    field = pb.createCollisionShape(
        pb.GEOM_HEIGHTFIELD, heightfieldData=[0.0] * 64, numHeightfieldRows=8, numHeightfieldColumns=8
    )
    bodies = [pb.createMultiBody(0, field), pb.createMultiBody(1, box, -1, [2, 0, 0], useMaximalCoordinates=True)]
    told = ("shapes of the type 9, whose triangles PyBullet does not tell", "bodies with maximal coordinates or soft")
    for ignored in ([], bodies[:1], bodies[1:], bodies):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            lidar = Lidar(
                listed([[1, 0, 0]], 0, 100), ignore_bodies=ignored, effects=NONE,
                options=gnosphere.SimulatorOptions(device),
            )  # fmt: skip
        text = "".join(str(warning.message) for warning in caught)
        assert [what in text for what in told] == [body not in ignored for body in bodies]
        np.testing.assert_allclose(lidar.scan(gnosphere.Pose()).ranges, [4.5], atol=PRECISION)


def test_a_mesh_of_pybullet_that_is_not_found_is_left_out(bullet, device, tmp_path):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    (tmp_path / "wall.obj").write_text("v 3 -1 -1\nv 3 2 -1\nv 3 -1 2\nf 1 2 3\n")
    pb.setAdditionalSearchPath(str(tmp_path))
    pb.createMultiBody(0, -1, pb.createVisualShape(pb.GEOM_MESH, fileName="wall.obj"))
    sensor, options = listed([[1, 0, 0]], 0, 100), gnosphere.SimulatorOptions(device)
    lidar = Lidar(sensor, folders=[str(tmp_path)], effects=NONE, options=options)
    assert lidar.scan(gnosphere.Pose()).ranges.tolist() == [3]
    with pytest.warns(UserWarning, match=r"leaves out the mesh .*wall.obj, which is not found \(1\)"):
        (tmp_path / "wall.obj").unlink()
        lidar = Lidar(sensor, effects=NONE, options=options)
    assert np.isnan(lidar.scan(gnosphere.Pose()).ranges).all()


COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>
<unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 100 0 0 0 300 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION"
source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><translate>0 0 200
</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes><scene>
<instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_collada_in_pybullet(bullet, device, tmp_path):
    """A triangle of 1 m by 3 m, 2 m above the ground. Bullet does not apply the up axis, either."""
    pytest.importorskip("collada")
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    (tmp_path / "m.dae").write_text(COLLADA)
    mesh = '<{0}><geometry><mesh filename="m.dae"/></geometry></{0}>'
    (tmp_path / "m.urdf").write_text(
        '<robot name="m"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
        f'izz="1"/></inertial>{mesh.format("visual")}{mesh.format("collision")}</link></robot>'
    )
    body = pb.loadURDF(str(tmp_path / "m.urdf"), useFixedBase=True)
    lowest, highest = pb.getAABB(body)
    np.testing.assert_allclose([lowest, highest], [[0, 0, 2], [1, 3, 2]], atol=0.1)  # Bullet adds a margin
    lidar = Lidar(listed([[0, 0, 1]], 0, 100), effects=NONE, options=gnosphere.SimulatorOptions(device))
    for x, y, seen in ((0.1, 2.5, True), (0.9, 0.1, True), (0.9, 2.5, False)):
        expected = [2 if seen else np.nan]
        np.testing.assert_allclose(lidar.scan(gnosphere.Pose((x, y, 0))).ranges, expected, atol=PRECISION)


def test_pybullet_robots(bullet, device):
    pb, _ = bullet
    pybullet_data = pytest.importorskip("pybullet_data")
    from gnosphere.engines.pybullet import Lidar

    pb.setAdditionalSearchPath(pybullet_data.getDataPath())
    pb.loadURDF("plane.urdf")
    arm = pb.loadURDF("kuka_iiwa/model.urdf", [1.5, 0, 0], useFixedBase=True)
    robot = pb.loadURDF("r2d2.urdf", [-1.5, 0, 0.5])
    lidar = Lidar(
        everywhere(30000), effects=NONE, fields="class", classes={"lbr_iiwa*": 5}, ignore_bodies=[robot],
        options=gnosphere.SimulatorOptions(device), folders=[pybullet_data.getDataPath()],
    )  # fmt: skip
    boxes = []
    for angle in (0.0, 1.2):
        for joint in range(pb.getNumJoints(arm)):
            pb.resetJointState(arm, joint, angle * (-1) ** joint)
        scan = lidar.scan(gnosphere.Pose((0, 0, 1)))
        bodies = lidar.body_ids(scan)
        assert robot not in bodies and (bodies == arm).sum() > 100
        assert set(scan.column(gnosphere.Field.class_id)[bodies == arm].tolist()) == {5}
        points = scan.points[bodies == arm] + [0, 0, 1]
        lows, highs = zip(*(pb.getAABB(arm, link) for link in range(-1, pb.getNumJoints(arm))))
        assert np.all(points > np.min(lows, axis=0) - 0.02) and np.all(points < np.max(highs, axis=0) + 0.02)
        boxes.append(points.max(axis=0))
    assert np.abs(boxes[0] - boxes[1]).max() > 0.1  # the arm has moved


def test_sapien_against_its_meshes_and_its_own_picture(device):
    """Two users of Vulkan in one process, and the same points from both."""
    sapien = pytest.importorskip("sapien")
    from gnosphere.engines.sapien import Lidar

    scene = sapien.Scene()
    scene.add_ground(-1)
    rng = np.random.default_rng(4)
    things = []
    for i in range(12):
        builder = scene.create_actor_builder()
        if i % 4 == 0:
            builder.add_box_visual(half_size=[0.3, 0.4, 0.5], material=[0.2, 0.4, 0.6])
        elif i % 4 == 1:
            builder.add_sphere_visual(radius=0.4)
        elif i % 4 == 2:
            builder.add_capsule_visual(radius=0.2, half_length=0.4)
        else:
            builder.add_cylinder_visual(sapien.Pose([0.1, 0, 0], [0.6, 0, 0.8, 0]), radius=0.3, half_length=0.5)
        things.append(builder.build_kinematic(name=f"thing{i}"))
    size = 600
    camera = scene.add_camera("camera", size, size, 1.2, 0.1, 50)
    lens = np.linalg.inv(camera.get_intrinsic_matrix().astype(float))
    pixels = np.stack([*np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5), np.ones((size, size))], axis=-1)
    rays = pixels.reshape(-1, 3) @ lens.T
    directions = np.stack([rays[:, 2], -rays[:, 0], -rays[:, 1]], axis=1)  # x forward, y left, z up
    sensor = listed(directions / np.linalg.norm(directions, axis=1, keepdims=True), 0.1, 50)
    lidar = Lidar(
        scene, sensor, effects=NONE, fields="class", classes={"thing*": 4}, options=gnosphere.SimulatorOptions(device)
    )
    of_instance = np.array([entity.per_scene_id for entity in lidar.entities] + [0])
    sizes = {"Box": [0.3, 0.4, 0.5], "Sphere": [0.4] * 3, "Cylinder": [0.5, 0.3, 0.3], "Capsule": [1] * 3}
    for _ in range(3):
        for i, entity in enumerate(things):
            turn = rng.normal(size=4)
            place = [3 + 0.7 * (i % 4), 1.2 * (i // 4) - 1.2, 0.9 * (i % 3) - 0.5] + rng.uniform(-0.2, 0.2, 3)
            entity.set_pose(sapien.Pose(place, turn / np.linalg.norm(turn)))
        world = exact.World()
        for entity in scene.entities:
            body = entity.find_component_by_type(sapien.render.RenderBodyComponent)
            for shape in body.render_shapes if body else ():
                place = entity.pose.to_transformation_matrix().astype(float)
                place = place @ shape.local_pose.to_transformation_matrix()
                scale = sizes.get(type(shape).__name__.removeprefix("RenderShape"), getattr(shape, "scale", 1))
                for part in shape.parts:
                    world.mesh(entity.per_scene_id, part.vertices * np.array(scale, float), part.triangles, place)
        scan = lidar.scan(gnosphere.Pose())
        owners = of_instance[np.minimum(scan.instances, len(lidar.entities))]
        assert_right(world, sensor, gnosphere.Pose(), scan.ranges, np.where(owners == 0, -1, owners))
        assert (scan.column(gnosphere.Field.class_id) == 4).sum() > 50000
        scene.update_render()
        camera.take_picture()
        picture = camera.get_picture("Position").reshape(-1, 4)[:, :3].astype(float)  # x right, y up, z backward
        segments = camera.get_picture("Segmentation").reshape(-1, 4)[:, 1].astype(int)
        theirs = np.where(segments > 0, np.linalg.norm(picture, axis=1), np.nan)
        # Pixels are rastered with corners on a grid of 1/256 of a pixel (subPixelPrecisionBits of lavapipe).
        precision = PRECISION + np.nan_to_num(theirs) * abs(lens[0, 0]) / 256
        assert_right(world, sensor, gnosphere.Pose(), theirs, np.where(segments > 0, segments, -1), precision)


def test_sapien_shows_bodies_that_are_not_hidden(device):
    sapien = pytest.importorskip("sapien")
    from gnosphere.engines.sapien import Lidar

    scene, entity = sapien.Scene(), sapien.Entity()
    bodies = [sapien.render.RenderBodyComponent() for _ in range(2)]
    for body, place in zip(bodies, (2, 4)):
        shape = sapien.render.RenderShapeBox([0.5] * 3, sapien.render.RenderMaterial())
        shape.local_pose = sapien.Pose([place, 0, 0])
        body.attach(shape)
        entity.add_component(body)
    scene.add_entity(entity)

    def seen():
        sensor = listed([[1, 0, 0], [-1, 0, 0]], 0, 100)  # from between the two
        lidar = Lidar(scene, sensor, effects=NONE, options=gnosphere.SimulatorOptions(device))
        return np.isfinite(lidar.scan(gnosphere.Pose((3, 0, 0))).ranges).tolist()

    assert seen() == [True, True]
    bodies[0].visibility = 0.0
    assert seen() == [True, False]
    bodies[1].disable()
    assert seen() == [False, False]
    bodies[0].visibility = 0.5
    assert seen() == [False, True]


def test_panda3d_against_its_rays(device):
    core = pytest.importorskip("panda3d.core")
    from gnosphere.engines.panda3d import Lidar

    def node(name, triangles):
        """A node of single and of shared vertices."""
        data = core.GeomVertexData(name, core.GeomVertexFormat.getV3n3(), core.Geom.UHStatic)
        data.setNumRows(len(triangles[0]))
        writer = core.GeomVertexWriter(data, "vertex")
        for corner in triangles[0]:
            writer.setData3(*map(float, corner))
        parts = core.GeomTriangles(core.Geom.UHStatic)
        for face in triangles[1]:
            parts.addVertices(*map(int, face))
        geom = core.Geom(data)
        geom.addPrimitive(parts)
        made = core.GeomNode(name)
        made.addGeom(geom)
        return made

    def corners_of(path):
        """The triangles of a node, by Panda3D's reader."""
        found = []
        for geom in path.node().getGeoms():
            reader = core.GeomVertexReader(geom.getVertexData(), "vertex")
            for part in geom.decompose().getPrimitives():
                for i in range(part.getNumVertices()):
                    reader.setRow(part.getVertex(i))
                    found.append([*reader.getData3()])
        return np.array(found), np.arange(len(found)).reshape(-1, 3)

    root = core.NodePath("root")
    rng = np.random.default_rng(5)
    paths = []
    for i in range(12):
        shape = primitives.box((0.4, 0.5, 0.6)) if i % 2 else primitives.sphere(0.6, 1e-2)
        parent = root.attachNewNode(f"parent{i}")
        parent.attachNewNode(node(f"thing{i}", shape)).setScale(1, 0.7, 1.2)
        paths.append(parent)
    card = core.CardMaker("ground")
    card.setFrame(-30, 30, -30, 30)
    ground = root.attachNewNode(card.generate())
    ground.setPosHpr(0, 0, -2, 0, -90, 0)
    ground.setColor(0.1, 0.2, 0.3, 1)
    sensor = everywhere(BEAMS, 40)
    lidar = Lidar(root, sensor, effects=NONE, ignore_below=[paths[0]], options=gnosphere.SimulatorOptions(device))
    traverser, queue = core.CollisionTraverser(), core.CollisionHandlerQueue()
    ray = core.CollisionRay()
    probe = core.CollisionNode("ray")
    probe.addSolid(ray)
    probe.setFromCollideMask(core.GeomNode.getDefaultCollideMask())
    traverser.addCollider(root.attachNewNode(probe), queue)
    for _ in range(3):
        for path in paths:
            path.setPosHpr(*(rng.uniform(1.2, 5, 3) * rng.choice([-1, 1], 3)), *rng.uniform(0, 360, 3))
        world = exact.World()
        for number, path in enumerate(lidar.nodes):
            if not paths[0].isAncestorOf(path):
                world.mesh(number, *corners_of(path), np.array([[*row] for row in path.getMat(root).rows]).T)
        scan = lidar.scan(POSE)
        owners = np.where(np.isnan(scan.ranges), -1, scan.instances.astype(int))
        assert_right(world, sensor, POSE, scan.ranges, owners)
        # A ray of Panda3D takes a tenth of a millisecond and more, so not all of them.
        some = listed(gnosphere.beams_of(sensor).directions[:20000], 0, 40)
        theirs, hits = np.full(20000, np.nan), np.full(20000, -1)
        for i, direction in enumerate(world_directions(some, POSE)):
            ray.setOrigin(*POSE.position)
            ray.setDirection(*direction)
            traverser.traverse(root)
            for entry in queue.getEntries():
                far = (entry.getSurfacePoint(root) - core.LPoint3(*POSE.position)).length()
                if not paths[0].isAncestorOf(entry.getIntoNodePath()) and not far >= theirs[i] and far < 40:
                    theirs[i], hits[i] = far, lidar.nodes.index(entry.getIntoNodePath())
        assert_right(world, some, POSE, theirs, hits, 2 * PRECISION)  # places in the world, in single precision


def test_panda3d_shows_what_is_not_hidden(device):
    core = pytest.importorskip("panda3d.core")
    from gnosphere.engines.panda3d import Lidar

    root, squares = core.NodePath("root"), []
    for x in (2, 4, 6):
        data = core.GeomVertexData("square", core.GeomVertexFormat.getV3(), core.Geom.UHStatic)
        writer = core.GeomVertexWriter(data, "vertex")
        for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            writer.addData3(x, y, z)
        faces = core.GeomTriangles(core.Geom.UHStatic)
        faces.addVertices(0, 1, 2)
        faces.addVertices(0, 2, 3)
        geom = core.Geom(data)
        geom.addPrimitive(faces)
        squares.append(core.GeomNode("square"))
        squares[-1].addGeom(geom)

    def seen():
        lidar = Lidar(root, listed([[1, 0, 0]], 0, 100), effects=NONE, options=gnosphere.SimulatorOptions(device))
        return lidar.scan(gnosphere.Pose()).ranges[0]

    def below(node):
        root.getChildren().detach()
        top = root.attachNewNode("top").attachNewNode(node)
        return [top.attachNewNode(square) for square in squares]

    paths = below(core.PandaNode("all"))
    assert seen() == 2
    paths[0].hide()
    assert seen() == 4
    paths[1].getParent().hide()
    assert np.isnan(seen())
    paths[2].showThrough()
    assert seen() == 6
    for path in paths:
        path.show()
    switch, sequence, levels = core.SwitchNode("switch"), core.SequenceNode("sequence"), core.LODNode("levels")
    below(switch)
    switch.setVisibleChild(1)
    assert seen() == 4
    below(sequence)
    sequence.pose(2)
    assert seen() == 6
    for far, near in ((1000, 50), (10, 0), (50, 10)):
        levels.addSwitch(far, near)
    below(levels)
    assert seen() == 4  # the finest level is the second


def test_drake_against_its_signed_distances(device):
    pytest.importorskip("pydrake")
    from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Role, Sphere
    from pydrake.math import RigidTransform, RollPitchYaw
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
    from pydrake.multibody.tree import SpatialInertia
    from pydrake.systems.framework import DiagramBuilder

    from gnosphere.engines.drake import Lidar

    builder = DiagramBuilder()
    plant, graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    friction, color = CoulombFriction(1, 1), [0.2, 0.4, 0.6, 1]
    shapes = [Box(0.4, 0.5, 0.6), Sphere(0.4), Cylinder(0.3, 0.8), Capsule(0.2, 0.6), Ellipsoid(0.3, 0.4, 0.5)]
    solids = [
        exact.box((0.2, 0.25, 0.3)), exact.sphere(0.4), exact.cylinder(0.3, 0.4), exact.capsule(0.2, 0.3),
        exact.ellipsoid((0.3, 0.4, 0.5)),
    ]  # fmt: skip
    bodies = []
    for i in range(10):
        body = plant.AddRigidBody(f"body{i}", SpatialInertia.SolidBoxWithMass(1, 0.2, 0.4, 0.6))
        local = RigidTransform(RollPitchYaw(0.1 * i, 0.2, 0.3), [0.1, 0, 0.05])
        plant.RegisterVisualGeometry(body, local, shapes[i % 5], f"visual{i}", color)
        plant.RegisterCollisionGeometry(body, local, shapes[i % 5], f"collision{i}", friction)
        bodies.append(body)
    down = RigidTransform([0, 0, -2])
    plant.RegisterVisualGeometry(plant.world_body(), down, HalfSpace(), "ground", color)
    plant.RegisterCollisionGeometry(plant.world_body(), down, HalfSpace(), "ground", friction)
    plant.Finalize()
    mast, depth = plant.GetBodyFrameIdOrThrow(bodies[0].index()), 1e-3
    sensor = everywhere(BEAMS, 20)
    lidar = builder.AddSystem(
        Lidar(
            graph.model_inspector(),
            sensor,
            parent=mast,
            pose=RigidTransform([0, 0, 0.1]),
            role=Role.kIllustration,
            ignore_frames=[mast],
            effects=NONE,
            tolerance=depth,
            options=gnosphere.SimulatorOptions(device),
        )  # fmt: skip
    )
    builder.Connect(graph.get_query_output_port(), lidar.get_input_port(0))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inspector = graph.model_inspector()
    rng = np.random.default_rng(6)
    for _ in range(3):
        for i, body in enumerate(bodies):
            place = [0, 0, 0] if i == 0 else rng.uniform(1, 3, 3) * rng.choice([-1, 1], 3)
            pose = RigidTransform(RollPitchYaw(*rng.uniform(-3, 3, 3)), place)
            plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, pose)
        query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(context))
        world = exact.World()
        for number, geometry in enumerate(lidar.geometries):
            place = query.GetPoseInWorld(geometry).GetAsMatrix34()
            name = inspector.GetName(geometry).partition("visual")[2]
            if not name:
                world.mesh(number, *primitives.plane(1000, 1000), place)
            elif name != "0":
                world.solid(number, solids[int(name) % 5], place, 0.6, depth)
        frame = query.GetPoseInWorld(mast) @ RigidTransform([0, 0, 0.1])
        pose = adapter.pose_of(frame.translation(), frame.rotation().matrix())
        scan = lidar.scan(query)
        owners = np.where(np.isnan(scan.ranges), -1, scan.instances.astype(int))
        assert_right(world, sensor, pose, scan.ranges, owners)
        points = lidar.get_output_port(0).Eval(lidar.GetMyContextFromRoot(context)).xyzs()
        assert points.shape[1] == (owners >= 0).sum() > 0.4 * BEAMS
        own = set(inspector.GetGeometries(mast))
        for point in frame.multiply(points.astype(float)).T:
            near = [
                answer.distance for answer in query.ComputeSignedDistanceToPoint(point, 0.01) if answer.id_G not in own
            ]
            assert min(np.abs(near), default=1) < depth + PRECISION
            assert min(near) > -depth - PRECISION  # nothing is hit behind a surface


@pytest.mark.parametrize("scale", ((1, 1, 1), (1, 2, 3)))
def test_a_convex_of_drake_is_its_hull(device, tmp_path, scale):
    """The prism over an L is there as a Mesh; a Convex has the corner that it lacks, too, up to x + y = 3."""
    pytest.importorskip("pydrake")
    from pydrake.geometry import Convex, GeometryInstance, Mesh, ProximityProperties, Role, SceneGraph
    from pydrake.math import RigidTransform
    from pydrake.systems.framework import DiagramBuilder

    from gnosphere.engines.drake import Lidar

    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    lines = [f"v {x} {y} {z}" for z in (0, 1) for x, y in outline]
    lines += ["f 1 4 3 2", "f 1 6 5 4", "f 7 8 9 10", "f 7 10 11 12"]
    lines += [f"f {i + 1} {(i + 1) % 6 + 1} {(i + 1) % 6 + 7} {i + 7}" for i in range(6)]
    file = tmp_path / "corner.obj"
    file.write_text("\n".join(lines) + "\n")
    for shape, there in ((Mesh, [True, False, False]), (Convex, [True, True, False])):
        builder = DiagramBuilder()
        graph = builder.AddSystem(SceneGraph())
        source = graph.RegisterSource("source")
        made = GeometryInstance(RigidTransform(), shape(str(file), scale), "corner")
        graph.AssignRole(source, graph.RegisterAnchoredGeometry(source, made), ProximityProperties())
        lidar = Lidar(
            graph.model_inspector(), listed([[0, 0, -1]], 0, 100), role=Role.kProximity, effects=NONE,
            options=gnosphere.SimulatorOptions(device),
        )  # fmt: skip
        diagram = builder.Build()
        context = diagram.CreateDefaultContext()
        query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(context))
        for (x, y), seen in zip(((0.5, 0.7), (1.3, 1.4), (1.7, 1.6)), there):
            lidar._pose = RigidTransform([x * scale[0], y * scale[1], 5])
            expected = 5 - scale[2] if seen else np.nan
            np.testing.assert_allclose(lidar.scan(query).ranges, [expected], atol=PRECISION)


def in_a_process_without_sapien(test, file=__file__):
    """Whether a test was run in one: sapien and bpy have a libOpenImageDenoise.so.2 each, and a process loads one."""
    if "sapien" in sys.modules:
        name = f"{file}::{test}"
        subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", name], check=True)
        return True
    return False


def test_blender_instances_of_geometry_nodes(device):
    """Nodes put a high box on each corner of a square."""
    if in_a_process_without_sapien("test_blender_instances_of_geometry_nodes"):
        return
    bpy = pytest.importorskip("bpy")
    from gnosphere.engines.blender import Lidar

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, -1))
    tree = bpy.data.node_groups.new("boxes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints")
    first, last, cube, spread = map(tree.nodes.new, names)
    join = tree.nodes.new("GeometryNodeJoinGeometry")
    cube.inputs["Size"].default_value = (0.5, 0.5, 3)
    tree.links.new(first.outputs[0], spread.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], spread.inputs["Instance"])
    tree.links.new(spread.outputs[0], join.inputs[0])
    tree.links.new(first.outputs[0], join.inputs[0])
    tree.links.new(join.outputs[0], last.inputs[0])
    bpy.context.object.modifiers.new("boxes", "NODES").node_group = tree
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sensor, pose = everywhere(20000), gnosphere.Pose((0.1, 0.05, 0))
    lidar = Lidar(depsgraph, sensor, effects=NONE, options=gnosphere.SimulatorOptions(device))
    scan = lidar.scan(depsgraph, pose)
    world = exact.World()
    world.mesh(0, *primitives.plane(2, 2), adapter.rows_of(gnosphere.Pose((0, 0, -1))))
    for x in (-2, 2):
        for y in (-2, 2):
            world.mesh(1, *primitives.box((0.25, 0.25, 1.5)), adapter.rows_of(gnosphere.Pose((x, y, -1))))
    owners = np.where(np.isnan(scan.ranges), -1, np.minimum(scan.instances, 1).astype(int))
    assert len(lidar.names) == 5
    assert_right(world, sensor, pose, scan.ranges, owners)


def test_blender_objects_that_only_make_instances(device):
    """Nodes put a box in place of a square, which itself has no faces then."""
    if in_a_process_without_sapien("test_blender_objects_that_only_make_instances"):
        return
    bpy = pytest.importorskip("bpy")
    from gnosphere.engines.blender import Lidar

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=4)
    tree = bpy.data.node_groups.new("boxes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints")
    first, last, cube, spread = map(tree.nodes.new, names)
    tree.links.new(first.outputs[0], spread.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], spread.inputs["Instance"])
    tree.links.new(spread.outputs[0], last.inputs[0])
    bpy.context.object.modifiers.new("boxes", "NODES").node_group = tree
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sensor = listed([[1, 0, 0], [0, 1, 0]], 0, 100)
    lidar = Lidar(depsgraph, sensor, effects=NONE, options=gnosphere.SimulatorOptions(device))
    assert len(lidar.names) == 4
    bpy.context.object.location.x = 1
    depsgraph.update()
    found = lidar.scan(depsgraph, gnosphere.Pose((-5, 2, 0))).ranges
    np.testing.assert_allclose(found, [3.5, np.nan], atol=PRECISION)  # a box of 1 m at -1, 2


def test_blender_materials_of_slots(device):
    """Each side of a box has the material of its slot, which an object may choose in place of its mesh."""
    if in_a_process_without_sapien("test_blender_materials_of_slots"):
        return
    bpy = pytest.importorskip("bpy")
    from gnosphere.engines.blender import Lidar

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add(size=2)
    box, made = bpy.context.object, {}
    for name, color in (("dark", (0.1, 0.1, 0.1, 1)), ("light", (0.7, 0.7, 0.7, 1)), ("own", (0.4, 0.4, 0.4, 1))):
        made[name] = bpy.data.materials.new(name)
        made[name].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
        box.data.materials.append(made[name])
    plain = bpy.data.materials.new("plain")
    plain.node_tree.nodes.clear()
    plain.diffuse_color = (0.9, 0.9, 0.9, 1)
    box.material_slots[0].link, box.material_slots[0].material = "OBJECT", plain
    for side in box.data.polygons:
        side.material_index = 1 if side.normal.x > 0.5 else 2 if side.normal.y > 0.5 else 0
    sensor = listed([[-1, 0, 0], [0, -1, 0], [0, 0, -1]], 0, 100)
    effects = gnosphere.Effects.none()
    effects.intensity.use = gnosphere.EffectUse.on
    options = {"fields": "intensity", "effects": effects, "options": gnosphere.SimulatorOptions(device)}

    def intensities(lidar):
        lidar.move([adapter.rows_of(gnosphere.Pose())])
        places = [(5, 0, 0), (0, 5, 0), (0, 0, 5)]
        shots = [gnosphere.Shot(gnosphere.Pose(place)) for place in places]
        return [lidar.cast(shot).column(gnosphere.Field.intensity)[i] for i, shot in enumerate(shots)]

    shapes = adapter.Shapes()
    sides = [shapes.material((value,) * 3) for value in (0.7, 0.4, 0.9)]
    vertices, faces = primitives.box((1, 1, 1))
    first, second, third = vertices[faces].transpose(1, 0, 2)
    along = np.abs(np.cross(second - first, third - first)).argmax(axis=1)
    shapes.instance(shapes.mesh((vertices, faces), np.array(sides)[along]))
    expected = intensities(adapter.Lidar(shapes, sensor, **options))
    assert len(set(expected)) == 3
    assert intensities(Lidar(bpy.context.evaluated_depsgraph_get(), sensor, **options)) == pytest.approx(expected)
    nodes = made["light"].node_tree
    nodes.links.new(nodes.nodes.new("ShaderNodeRGB").outputs[0], nodes.nodes["Principled BSDF"].inputs["Base Color"])
    made["light"].diffuse_color = (0.7, 0.7, 0.7, 1)
    with pytest.warns(UserWarning, match=r"leaves out the nodes of the Base Color of materials, which .* \(1\)"):
        lidar = Lidar(bpy.context.evaluated_depsgraph_get(), sensor, **options)
    assert intensities(lidar) == pytest.approx(expected)


def test_blender_against_its_ray_casts(device):
    if in_a_process_without_sapien("test_blender_against_its_ray_casts"):
        return
    bpy = pytest.importorskip("bpy")
    from mathutils import Vector

    from gnosphere.engines.blender import Lidar

    bpy.ops.wm.read_factory_settings(use_empty=True)
    rng = np.random.default_rng(7)
    things = []
    for i in range(9):
        add = (
            bpy.ops.mesh.primitive_cube_add,
            bpy.ops.mesh.primitive_ico_sphere_add,
            bpy.ops.mesh.primitive_monkey_add,
        )[i % 3]
        add(location=rng.uniform(2, 6, 3) * rng.choice([-1, 1], 3))
        things.append(bpy.context.object)
        if i % 3 == 2:
            things[-1].modifiers.new("finer", "SUBSURF").levels = 1
    bpy.ops.mesh.primitive_plane_add(size=60, location=(0, 0, -7))
    things.append(bpy.context.object)
    marked = bpy.data.collections.new("vehicles")
    bpy.context.scene.collection.children.link(marked)
    marked.objects.link(things[0])
    sensor = everywhere(BEAMS, 100)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    lidar = Lidar(
        depsgraph, sensor, effects=NONE, fields="class", classes={"vehicles": 2},
        options=gnosphere.SimulatorOptions(device),
    )  # fmt: skip
    numbers = {thing.name: i for i, thing in enumerate(things)}
    of_instance = np.array([numbers[name] for name in lidar.names] + [-1])
    for _ in range(3):
        for thing in things[:-1]:
            thing.rotation_euler = rng.uniform(0, 6, 3)
        depsgraph.update()
        world = exact.World()
        for number, thing in enumerate(things):
            shape = thing.evaluated_get(depsgraph).to_mesh()
            shape.calc_loop_triangles()
            corners = [vertex.co[:] for vertex in shape.vertices]
            world.mesh(number, corners, [triangle.vertices[:] for triangle in shape.loop_triangles], thing.matrix_world)
        scan = lidar.scan(depsgraph, POSE)
        owners = of_instance[np.minimum(scan.instances, len(lidar.names))]
        assert_right(world, sensor, POSE, scan.ranges, owners)
        classes = scan.column(gnosphere.Field.class_id)
        assert {lidar.names[number] for number in scan.instances[classes == 2]} == {things[0].name}
        theirs, hits, start = np.full(BEAMS, np.nan), np.full(BEAMS, -1), Vector(POSE.position)
        cast = bpy.context.scene.ray_cast
        for i, direction in enumerate(world_directions(sensor, POSE).tolist()):
            hit, place, _, _, thing, _ = cast(depsgraph, start, Vector(direction))
            if hit:
                theirs[i], hits[i] = (place - start).length, numbers[thing.name]
        assert_right(world, sensor, POSE, theirs, hits)
