# SPDX-License-Identifier: Apache-2.0
"""Deformable meshes, clips, and what a rolling shutter sees of them."""

import numpy as np
import pytest
from conftest import at, beams

import gnosphere

MIDDLE = 4  # the beam along x
MAPS = np.array(
    [[[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0]], [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, -2]]], np.float64
)
UPPER = np.array([0, 0, 0.25, 0.25, 1, 1])  # how much the vertices of the strip follow joint 1; joint 0 has the rest
SWELL = np.linspace(0, 1, 18).reshape(6, 3)


def strip(**changes) -> gnosphere.Mesh:
    """Two squares, one above the other, whose vertices follow two joints and a morph target."""
    upward = np.repeat([-1.0, 0.0, 1.0], 2)
    positions = np.stack([0 * upward, np.tile([-1.0, 1.0], 3), upward], axis=1)
    faces = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]]
    given = {
        "origin": (0, 0, 7), "joint_count": 2, "joints": np.tile([1, 0], (6, 1)),
        "joint_weights": np.stack([UPPER, 1 - UPPER], axis=1), "morph_targets": [SWELL],
    } | changes  # fmt: skip
    return gnosphere.Mesh(positions, faces, [gnosphere.MeshPart(0, 4, 0)], **given)


def plate() -> gnosphere.Mesh:
    """A square of 2 x 2 m, square to the x axis, with one joint."""
    positions = [[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]]
    faces, parts = [[0, 1, 2], [0, 2, 3]], [gnosphere.MeshPart(0, 2, 0)]
    joints, weights = np.zeros((4, 1), int), np.ones((4, 1))
    return gnosphere.Mesh(positions, faces, parts, joint_count=1, joints=joints, joint_weights=weights)


@pytest.fixture
def moving() -> gnosphere.Simulator:
    """The plate 10 m ahead of a fan of beams, on the reference."""
    scene = gnosphere.Scene([gnosphere.Material("grey")], [plate()], [gnosphere.Instance(0, at(10))])
    sensor = beams()
    sensor.rotation_period = 0.1
    effects = gnosphere.Effects.none()
    effects.object_motion.use = gnosphere.EffectUse.on
    request = gnosphere.SensorRequest(sensor, effects, [gnosphere.Field.time, gnosphere.Field.velocity])
    return gnosphere.Simulator(scene, request, gnosphere.SimulatorOptions(gnosphere.device_by_name("reference")))


def test_deformed_positions_are_those_of_glTF():
    mesh = strip()
    assert mesh.deformable() and (mesh.joint_count, mesh.influences) == (2, 2)
    deformation = gnosphere.Deformation(MAPS, [0.25])
    rest = mesh.positions.astype(np.float64) + 0.25 * SWELL + mesh.origin
    lower, upper = (rest @ joint[:, :3].T + joint[:, 3] for joint in MAPS)
    expected = (1 - UPPER)[:, None] * lower + UPPER[:, None] * upper - mesh.origin
    made = gnosphere.deformed_positions(mesh, deformation)
    assert made.dtype == np.float32 and made.shape == (6, 3)
    assert np.abs(made - expected).max() < 3e-6
    assert np.abs(expected - mesh.positions).max() > 1
    assert np.array_equal(gnosphere.deformed_positions(mesh, gnosphere.Deformation()), mesh.positions)


def test_what_was_given_is_read_back():
    mesh = strip(deformation=gnosphere.Deformation([gnosphere.Transform(rows) for rows in MAPS], np.ones(1)))
    assert mesh.joints.dtype == np.uint16 and mesh.joints.tolist() == [[1, 0]] * 6
    assert mesh.joint_weights.dtype == np.float32 and np.array_equal(mesh.joint_weights[:, 0], UPPER)
    (target,) = mesh.morph_targets
    assert target.dtype == np.float32 and np.array_equal(target, SWELL.astype(np.float32))
    assert np.array_equal(mesh.deformation.joints, MAPS) and mesh.deformation.morph_weights.tolist() == [1]
    for view in (mesh.joints, mesh.joint_weights, target, mesh.deformation.joints):
        assert not view.flags.writeable
    del mesh
    assert target[5, 2] == 1  # the view keeps the mesh
    rigid = strip(joint_count=0, joints=None, joint_weights=None, morph_targets=())
    assert not rigid.deformable() and rigid.joints.shape == (6, 0) and rigid.deformation.empty()


def test_a_deformation_moves_the_scan(moving):
    def distance() -> float:
        return float(moving.scan(gnosphere.Pose()).ranges[MIDDLE])

    assert distance() == pytest.approx(10)
    moving.set_deformation(0, gnosphere.Deformation([at(3)]))
    assert distance() == pytest.approx(13)
    moving.set_deformation(0, gnosphere.Deformation())
    assert distance() == pytest.approx(10)
    with pytest.raises(gnosphere.Error, match="2 joints"):
        moving.set_deformation(0, gnosphere.Deformation(MAPS))
    with pytest.raises(gnosphere.Error, match="follows joints"):
        moving.set_positions(0, np.zeros((4, 3)))


def test_a_rolling_shutter_sees_a_mesh_where_it_is_when_the_beam_fires(moving):
    shot = gnosphere.Shot(mesh_motions=[gnosphere.MeshMotion(0, gnosphere.Deformation([at(-2)]))])
    assert shot.mesh_motions[0].mesh == 0 and shot.mesh_motions[0].end.joints[0, 0, 3] == -2
    scan = gnosphere.Scan()
    moving.scan_into(shot, scan)
    times = scan.column(gnosphere.Field.time)
    assert np.ptp(times) == pytest.approx(0.008)
    assert np.abs(scan.points[:, 0] - (10 - 20 * times)).max() < 1e-4  # 2 m in the 0.1 s of a turn
    assert np.abs(scan.column(gnosphere.Field.velocity) - [-20, 0, 0]).max() < 1e-3
    shot.mesh_motions = ()
    moving.scan_into(shot, scan)
    assert np.abs(scan.points[:, 0] - 10).max() < 1e-5


def walk(square: gnosphere.Mesh) -> gnosphere.Scene:
    """The square on a node that walks 4 m along x in 2 s, and a plate whose joint follows the node."""
    Property = gnosphere.Track.Property
    nodes = [gnosphere.Node("base", translation=(0, 1, 0)), gnosphere.Node("foot", parent=0, scale=(2, 2, 2))]
    times = np.array([0, 2])
    tracks = [
        gnosphere.Track(1, Property.translation, times, [[0, 0, 0], [4, 0, 0]]),
        gnosphere.Track(0, Property.rotation, times, [[0, 0, 0, 1], [0, 0, np.sqrt(0.5), np.sqrt(0.5)]]),
    ]
    animation = gnosphere.SceneAnimation(
        nodes, [gnosphere.Clip("Walk", 2, tracks)],
        [gnosphere.AnimatedInstance(0, 1, offset=at(3)), gnosphere.AnimatedInstance(1, 0, skin=0)],
        [gnosphere.Skin([1], [at(-1)], "legs")], root=at(100),
    )  # fmt: skip
    instances = [gnosphere.Instance(0), gnosphere.Instance(1), gnosphere.Instance(0, at(7))]
    return gnosphere.Scene([gnosphere.Material()], [square, plate()], instances, animation=animation)


def test_the_state_of_a_scene_at_a_time_of_a_clip(square):
    scene = walk(square)
    gnosphere.validate(scene)
    clip = gnosphere.clip_named(scene, "Walk")

    def expected(share: float) -> np.ndarray:
        """Of the node `foot`: base * (translation, scale)."""
        c, s = np.cos(share * np.pi / 2), np.sin(share * np.pi / 2)
        base = np.array([[c, -s, 0, 0], [s, c, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]])
        foot = np.diag([2.0, 2, 2, 1])
        foot[0, 3] = 4 * share
        return base @ foot

    def shift(x: float) -> np.ndarray:
        return np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    for seconds, end, share in [
        (0, gnosphere.ClipEnd.loop, 0), (0.5, gnosphere.ClipEnd.loop, 0.25), (3.5, gnosphere.ClipEnd.loop, 0.75),
        (3.5, gnosphere.ClipEnd.hold, 1), (-1, gnosphere.ClipEnd.hold, 0),
    ]:  # fmt: skip
        state = gnosphere.state_at(scene, clip, seconds, end)
        rows = [transform.rows for transform in state.transforms]
        assert np.allclose(rows[0], (shift(100) @ expected(share) @ shift(3))[:3], atol=1e-6)
        assert np.array_equal(rows[1], shift(100)[:3]) and np.array_equal(rows[2], shift(7)[:3])
        assert state.deformations[0].empty()
        assert np.allclose(state.deformations[1].joints[0], (expected(share) @ shift(-1))[:3], atol=1e-6)
    at_rest = gnosphere.state_at(scene, gnosphere.Clip(), 1)
    assert np.array_equal(at_rest.transforms[0].rows[:, 3], [106, 1, 0])


def test_an_animation_is_read_back_and_assigned_whole(square, tmp_path):
    scene = walk(square)
    animation = scene.animation
    track = animation.clips[0].tracks[0]
    assert (track.node, track.property, track.interpolation) == (
        1, gnosphere.Track.Property.translation, gnosphere.Track.Interpolation.linear,
    )  # fmt: skip
    assert track.times.tolist() == [0, 2] and track.values.tolist() == [[0, 0, 0], [4, 0, 0]]
    assert animation.nodes[0].parent == gnosphere.NO_NODE and animation.nodes[1].scale == (2, 2, 2)
    assert animation.instances[0].skin == gnosphere.NO_SKIN and animation.skins[0].joints.tolist() == [1]
    assert animation.skins[0].inverse_binds[0, 0, 3] == -1
    with pytest.raises(AttributeError):
        track.node = 0
    gnosphere.write_glb(scene, tmp_path / "walk.glb")
    again = gnosphere.load_scene(tmp_path / "walk.glb")
    assert [clip.name for clip in again.animation.clips] == ["Walk"] and again.left_out == ()
    assert sorted(mesh.joint_count for mesh in again.meshes) == [0, 1]
    scene.animation = gnosphere.SceneAnimation()
    assert scene.animation.clips == () and len(animation.clips) == 1
    with pytest.raises(gnosphere.Error, match="the scene has none"):
        gnosphere.clip_named(scene, "Walk")


def test_what_cannot_be_right_is_refused(square):
    def refused(words: str, make, *arguments, **named):
        with pytest.raises(gnosphere.Error, match=words) as raised:
            make(*arguments, **named)
        assert raised.value.code == gnosphere.ErrorCode.invalid_argument

    refused(r"joints has the shape \(12,\); it must be \(n, m\)", strip, joints=np.zeros(12, int))
    refused("joints and joint_weights have 6 and 5 rows", strip, joint_weights=np.ones((5, 2)))
    refused("have 2 and 3 columns", strip, joint_weights=np.ones((6, 3)))
    refused("joints holds 1; it must be less than joint_count, 1", strip, joint_count=1)
    refused("joints holds 70000, which does not fit the type uint16", strip, joints=np.full((6, 2), 70000))
    refused("given together", strip, joints=None)
    targets = [np.zeros((6, 3)), np.zeros((5, 3))]
    refused(r"morph_targets\[1\] has 5 rows; there are 6 vertices", strip, morph_targets=targets)
    refused(r"morph_targets\[0\] has the shape \(6, 2\)", strip, morph_targets=np.zeros((1, 6, 2)))
    refused("its deformation has 1 joints and 0 morph weights", strip, deformation=gnosphere.Deformation([at(0)]))
    refused(r"joints has the shape \(3, 4\); it must be \(n, 3, 4\)", gnosphere.Deformation, MAPS[0])
    refused("2 joints and 0 morph weights", gnosphere.deformed_positions, strip(), gnosphere.Deformation(MAPS))
    heavy = gnosphere.Scene([gnosphere.Material()], [strip(joint_weights=np.ones((6, 2)))])
    refused("sum to 2", gnosphere.validate, heavy)

    translation = gnosphere.Track.Property.translation
    refused("2 and 1 rows", gnosphere.Track, 0, translation, [0, 1], [[0, 0, 0]])
    refused("there must be a key", gnosphere.Track, 0, translation, [], [])
    scene = walk(square)
    refused("need 4, there are 3", gnosphere.state_at, scene, one_track(0, gnosphere.Track.Property.rotation), 0)
    refused("node 9 does not exist", gnosphere.state_at, scene, one_track(9, translation), 0)
    scene.instances[1].mesh = 0
    refused("its skin has 1 joints, its mesh has 0", gnosphere.state_at, scene, gnosphere.Clip(), 0)
    scene.instances[1].mesh = 5
    refused("mesh 5 does not exist", gnosphere.state_at, scene, gnosphere.Clip(), 0)


def one_track(node: int, property: gnosphere.Track.Property) -> gnosphere.Clip:
    return gnosphere.Clip("odd", 1, [gnosphere.Track(node, property, [0], [[0, 0, 0]])])
