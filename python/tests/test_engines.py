# SPDX-License-Identifier: Apache-2.0
"""LiDARs in other engines, against their own rays or meshes. Each is skipped without its package."""

import numpy as np
import pytest

import gnosphere
from gnosphere import adapter

NONE = gnosphere.Effects.none()


def everywhere(count: int, range_max: float = 100, seed: int = 0) -> gnosphere.Sensor:
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    sensor = gnosphere.Sensor()
    sensor.name, sensor.range_min, sensor.range_max = "everywhere", 0, range_max
    sensor.patterns = [gnosphere.BeamList(directions / np.linalg.norm(directions, axis=1, keepdims=True))]
    return sensor


def world_directions(sensor, pose):
    return gnosphere.beams_of(sensor).directions @ adapter.rows_of(pose)[:3, :3].T


POSE = gnosphere.Pose((0.1, 0.2, 1.1), (0.1, 0.2, 0.3, 0.9))


@pytest.fixture
def bullet():
    pb = pytest.importorskip("pybullet")
    client = pb.connect(pb.DIRECT)
    yield pb, client
    pb.disconnect(client)


def bullet_rays(pb, sensor, pose):
    directions = world_directions(sensor, pose)
    ends = np.array(pose.position) + sensor.range_max * directions
    answers = []
    for first in range(0, len(ends), 10000):
        run = ends[first : first + 10000]
        answers += pb.rayTestBatch([pose.position] * len(run), run.tolist())
    bodies = np.array([answer[0] for answer in answers])
    return np.array([answer[2] for answer in answers]) * sensor.range_max, bodies


def box_distance(position, turn, half, origin, directions):
    """How far along rays a box begins, in double; infinity where it is missed."""
    rows = adapter.rows_of(gnosphere.Pose(position, turn))[:3, :3]
    start, ways = (np.array(origin) - position) @ rows, directions @ rows
    with np.errstate(divide="ignore"):
        ends = np.sort(np.stack([(-np.array(half) - start) / ways, (np.array(half) - start) / ways]), axis=0)
    enter, leave = ends[0].max(axis=1), ends[1].min(axis=1)
    return np.where((enter <= leave) & (enter >= 0), enter, np.inf)


def test_pybullet_against_its_ray_tests(bullet, device, tmp_path):
    pb, _ = bullet
    from gnosphere.engines.pybullet import Lidar

    rng = np.random.default_rng(3)
    corners = rng.uniform(-0.8, 0.8, (30, 1, 3)) + rng.uniform(-0.3, 0.3, (30, 3, 3))
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in corners.reshape(-1, 3)]
    lines += [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(30)]
    (tmp_path / "soup.obj").write_text("\n".join(lines) + "\n")
    kinds = [
        (pb.GEOM_BOX, {"halfExtents": [0.4, 0.5, 0.6]}), (pb.GEOM_SPHERE, {"radius": 0.5}),
        (pb.GEOM_CYLINDER, {"radius": 0.4, "height": 1.1}), (pb.GEOM_CAPSULE, {"radius": 0.3, "height": 0.8}),
        (pb.GEOM_MESH, {"fileName": str(tmp_path / "soup.obj"), "flags": pb.GEOM_FORCE_CONCAVE_TRIMESH}),
    ]  # fmt: skip
    bodies = {}
    for i in range(20):
        kind, size = kinds[i % len(kinds)]
        angle = 2 * np.pi * i / 20
        shape = pb.createCollisionShape(kind, **size)
        body = pb.createMultiBody(0, shape, -1, [4 * np.cos(angle), 4 * np.sin(angle), 0.4 * (i % 4)])
        bodies[body] = kind
    ground = pb.createMultiBody(0, pb.createCollisionShape(pb.GEOM_BOX, halfExtents=[50, 50, 1]), -1, [0, 0, -3])
    bodies[ground] = pb.GEOM_BOX
    sensor = everywhere(40000)
    lidar = Lidar(sensor, effects=NONE, options=gnosphere.SimulatorOptions(device), tolerance=2e-4)
    compared = boxes = 0
    for _ in range(3):
        scan = lidar.scan(POSE)
        distances, hits = bullet_rays(pb, sensor, POSE)
        ours, owners = scan.ranges, lidar.body_ids(scan)
        assert (owners == hits).mean() > 0.998  # outlines: tessellation, and the single precision of both
        straight = [body for body, kind in bodies.items() if kind in (pb.GEOM_BOX, pb.GEOM_MESH)] + [-1]
        flat = np.isin(hits, straight)
        assert (flat & np.isin(owners, straight) & (owners != hits)).sum() <= 4  # of 40,000, at outlines
        same = (owners == hits) & (hits >= 0)
        # rayTestBatch gives a fraction of the ray's whole length in single precision.
        error = np.abs(ours - distances)
        assert np.median(error[same & flat]) < 1e-5 and np.quantile(error[same & flat], 0.999) < 1e-3
        assert np.median(error[same & ~flat]) < 1e-3  # the tolerance, seen at an angle
        compared += int((same & flat).sum())
        # Bullet's own rays are off by millimetres on grazed boxes; the boxes themselves are exact.
        for body, kind in bodies.items():
            if kind == pb.GEOM_BOX:
                half = [50, 50, 1] if body == ground else kinds[0][1]["halfExtents"]
                place = pb.getBasePositionAndOrientation(body)
                exact = box_distance(*place, half, POSE.position, world_directions(sensor, POSE).astype(float))
                error = np.abs(ours - exact)[owners == body]
                assert np.all(error < 2e-5 * np.maximum(exact[owners == body], 1)), error.max()
                boxes += len(error)
        for body in bodies:
            if body != ground:
                position, _ = pb.getBasePositionAndOrientation(body)
                turn = rng.normal(size=4)
                pb.resetBasePositionAndOrientation(
                    body, np.array(position) + rng.uniform(-0.2, 0.2, 3), turn / np.linalg.norm(turn)
                )
    assert compared > 50000 and boxes > 50000


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


def test_sapien_against_its_own_picture(device):
    """Two users of Vulkan in one process, and the same points from both."""
    sapien = pytest.importorskip("sapien")
    from gnosphere.engines.sapien import Lidar

    scene = sapien.Scene()
    scene.add_ground(-1)
    rng = np.random.default_rng(4)
    entities = []
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
        entities.append(builder.build_kinematic(name=f"thing{i}"))
    size = 96
    camera = scene.add_camera("camera", size, size, 1.2, 0.1, 50)
    lens = np.linalg.inv(camera.get_intrinsic_matrix())
    pixels = np.stack([*np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5), np.ones((size, size))], axis=-1)
    rays = pixels.reshape(-1, 3) @ lens.T
    directions = np.stack([rays[:, 2], -rays[:, 0], -rays[:, 1]], axis=1)  # x forward, y left, z up
    sensor = gnosphere.Sensor()
    sensor.range_min, sensor.range_max = 0.1, 50
    sensor.patterns = [gnosphere.BeamList(directions / np.linalg.norm(directions, axis=1, keepdims=True))]
    lidar = Lidar(
        scene, sensor, effects=NONE, fields="class", classes={"thing*": 4}, options=gnosphere.SimulatorOptions(device)
    )
    for _ in range(2):
        for i, entity in enumerate(entities):
            turn = rng.normal(size=4)
            place = [3 + 0.7 * (i % 4), 1.2 * (i // 4) - 1.2, 0.9 * (i % 3) - 0.5] + rng.uniform(-0.2, 0.2, 3)
            entity.set_pose(sapien.Pose(place, turn / np.linalg.norm(turn)))
        scene.update_render()
        camera.take_picture()
        picture = camera.get_picture("Position").reshape(-1, 4)[:, :3]  # x right, y up, z backward
        theirs = np.stack([-picture[:, 2], -picture[:, 0], picture[:, 1]], axis=1)
        scan = lidar.scan(gnosphere.Pose())
        hit = ~np.isnan(scan.ranges)
        error = np.linalg.norm(scan.points - theirs, axis=1)[hit]
        assert hit.sum() > 0.6 * size * size and (scan.column(gnosphere.Field.class_id) == 4).sum() > 500
        assert np.median(error) < 1e-4 and (error < 2e-3).mean() > 0.99  # all but pixels at outlines


def test_panda3d_against_its_rays(device):
    core = pytest.importorskip("panda3d.core")
    from gnosphere import primitives
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
    sensor = everywhere(1500, 40)
    lidar = Lidar(root, sensor, effects=NONE, ignore_below=[paths[0]], options=gnosphere.SimulatorOptions(device))
    traverser, queue = core.CollisionTraverser(), core.CollisionHandlerQueue()
    ray = core.CollisionRay()
    probe = core.CollisionNode("ray")
    probe.addSolid(ray)
    probe.setFromCollideMask(core.GeomNode.getDefaultCollideMask())
    traverser.addCollider(root.attachNewNode(probe), queue)
    for _ in range(2):
        for path in paths:
            path.setPosHpr(*(rng.uniform(1.2, 5, 3) * rng.choice([-1, 1], 3)), *rng.uniform(0, 360, 3))
        scan = lidar.scan(POSE)
        expected = np.full(len(scan.ranges), np.nan)
        for i, direction in enumerate(world_directions(sensor, POSE)):
            ray.setOrigin(*POSE.position)
            ray.setDirection(*direction)
            traverser.traverse(root)
            points = [
                entry.getSurfacePoint(root)
                for entry in queue.getEntries()
                if not paths[0].isAncestorOf(entry.getIntoNodePath())
            ]
            near = [(point - core.LPoint3(*POSE.position)).length() for point in points]
            expected[i] = min(near, default=np.nan)
        expected[expected > 40] = np.nan
        hit = ~np.isnan(scan.ranges)
        # Panda3D's rays see the front of a triangle only, and it computes in single precision.
        assert (hit == ~np.isnan(expected)).mean() > 0.99 and hit.sum() > 500
        error = np.abs(scan.ranges - expected)[hit & ~np.isnan(expected)]
        assert np.median(error) < 1e-5 and (error < 1e-3).mean() > 0.99


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
    mast = plant.GetBodyFrameIdOrThrow(bodies[0].index())
    lidar = builder.AddSystem(
        Lidar(
            graph.model_inspector(),
            everywhere(600, 20),
            parent=mast,
            pose=RigidTransform([0, 0, 0.1]),
            role=Role.kIllustration,
            ignore_frames=[mast],
            effects=NONE,
            tolerance=1e-3,
            options=gnosphere.SimulatorOptions(device),
        )  # fmt: skip
    )
    builder.Connect(graph.get_query_output_port(), lidar.get_input_port(0))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    rng = np.random.default_rng(6)
    for _ in range(3):
        for i, body in enumerate(bodies):
            place = [0, 0, 0] if i == 0 else rng.uniform(1, 3, 3) * rng.choice([-1, 1], 3)
            pose = RigidTransform(RollPitchYaw(*rng.uniform(-3, 3, 3)), place)
            plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, pose)
        query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(context))
        points = lidar.get_output_port(0).Eval(lidar.GetMyContextFromRoot(context)).xyzs()
        assert points.shape[1] > 150
        frame = query.GetPoseInWorld(mast) @ RigidTransform([0, 0, 0.1])
        own = {g for g in graph.model_inspector().GetGeometries(mast)}
        for point in frame.multiply(points.astype(float)).T:
            near = [
                answer.distance for answer in query.ComputeSignedDistanceToPoint(point, 0.1) if answer.id_G not in own
            ]
            assert min(np.abs(near), default=1) < 1e-3 + 2e-5
            assert min(near) > -2e-3  # nothing is hit behind a surface


def test_blender_against_its_ray_casts(device):
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
            things[-1].modifiers.new("finer", "SUBSURF").levels = 2
    bpy.ops.mesh.primitive_plane_add(size=60, location=(0, 0, -7))
    marked = bpy.data.collections.new("vehicles")
    bpy.context.scene.collection.children.link(marked)
    marked.objects.link(things[0])
    sensor = everywhere(4000, 100)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    lidar = Lidar(
        depsgraph,
        sensor,
        effects=NONE,
        fields="class",
        classes={"vehicles": 2},
        options=gnosphere.SimulatorOptions(device),
    )
    for _ in range(2):
        for thing in things:
            thing.rotation_euler = rng.uniform(0, 6, 3)
        depsgraph.update()
        scan = lidar.scan(depsgraph, POSE)
        error, same = [], 0
        for i, direction in enumerate(world_directions(sensor, POSE)):
            hit, place, _, _, thing, _ = bpy.context.scene.ray_cast(depsgraph, Vector(POSE.position), Vector(direction))
            number = scan.instances[i]
            same += (lidar.names[number] if number < len(lidar.names) else None) == (thing.name if hit else None)
            if hit and number < len(lidar.names):
                error.append(abs((place - Vector(POSE.position)).length - scan.ranges[i]))
        assert same >= len(scan.ranges) - 2 and len(error) > 1000  # at outlines, rounding decides
        assert np.median(error) < 1e-5 and np.quantile(error, 0.999) < 1e-4
        classes = scan.column(gnosphere.Field.class_id)
        assert {lidar.names[number] for number in scan.instances[classes == 2]} == {things[0].name}
