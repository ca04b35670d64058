# SPDX-License-Identifier: Apache-2.0
"""LiDARs in MuJoCo, beam by beam against its own rays. Skipped without the package mujoco."""

import importlib.util
import os
import types
import warnings
from pathlib import Path

import exact
import numpy as np
import pytest

import gnosphere
from gnosphere import adapter, patterns, primitives

mujoco = pytest.importorskip("mujoco")
gm = pytest.importorskip("gnosphere.mujoco")

NONE = gnosphere.Effects.none()
PRECISION = 1e-5
"""Of a range, and metres: our ranges and corners are single precision, MuJoCo's meshes are, too."""
MUJOCO = 1e-7
"""The same of mj_multiRay(), which computes in double precision."""


def sphere_of_beams(count: int, range_max: float = 200, seed: int = 0) -> gnosphere.Sensor:
    """Beams in random directions, without order."""
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    sensor = gnosphere.Sensor()
    sensor.name, sensor.range_min, sensor.range_max = "everywhere", 0, range_max
    sensor.patterns = [gnosphere.BeamList(directions / np.linalg.norm(directions, axis=1, keepdims=True))]
    return sensor


def options(device) -> gnosphere.SimulatorOptions:
    return gnosphere.SimulatorOptions(device)


def world_directions(sensor, pose):
    return gnosphere.beams_of(sensor).directions.astype(float) @ adapter.rows_of(pose)[:3, :3].T


def multi_ray(model, data, sensor, pose, geomgroup=None, static=1, exclude=-1):
    """Distances and geoms of the beams of a sensor, by MuJoCo."""
    vec = world_directions(sensor, pose)
    count = len(vec)
    geoms, distances = np.zeros(count, np.int32), np.zeros(count)
    groups = None if geomgroup is None else np.array(geomgroup, np.uint8)
    mujoco.mj_multiRay(
        model,
        data,
        np.array(pose.position),
        vec.reshape(-1),
        groups,
        static,
        exclude,
        geoms,
        distances,
        None,
        count,
        1e6,
    )
    return distances, geoms


def soup(count: int = 40, seed: int = 3) -> str:
    """Vertices and faces of a mesh of single triangles."""
    rng = np.random.default_rng(seed)
    corners = (rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-0.4, 0.4, (count, 3, 3))).reshape(-1, 3)
    vertices = " ".join(f"{value:.5f}" for value in corners.ravel())
    return f'vertex="{vertices}" face="{" ".join(map(str, range(3 * count)))}" inertia="shell"'


def every_type() -> "mujoco.MjModel":
    """A model with every type of geom around the origin, all but two of which move."""
    types = [
        'type="sphere" size=".7"', 'type="capsule" size=".4 .8"', 'type="ellipsoid" size=".4 .8 1.2"',
        'type="cylinder" size=".4 .8"', 'type="box" size=".4 .8 .6"', 'type="mesh" mesh="hull"',
        'type="mesh" mesh="soup"',
    ]  # fmt: skip
    bodies = ""
    for i, geom in enumerate(types * 2):
        angle = 2 * np.pi * i / len(types) / 2
        place = f"{4 * np.cos(angle):.4f} {4 * np.sin(angle):.4f} {0.5 * (i % 3):.4f}"
        bodies += (
            f'<body name="body{i}" pos="{place}" euler="{20 * i} {35 * i} {10 * i}"><freejoint/><geom {geom}/></body>'
        )
    hull = " ".join(f"{value:.4f}" for value in np.random.default_rng(5).normal(size=60) * 0.6)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><asset><hfield name="hills" nrow="15" ncol="21" size="3 2 .8 .3"/>
        <mesh name="hull" vertex="{hull}"/><mesh name="soup" {soup()}/></asset>
        <worldbody><geom name="floor" type="plane" size="0 0 .1" pos="0 0 -2" euler="1 2 3"/>
        <geom name="small" type="plane" size="1 2 .1" pos="0 0 3" euler="170 10 0"/>
        <geom name="hills" type="hfield" hfield="hills" pos="9 1 -1.5" euler="0 0 30"/>
        <site name="mast" pos=".1 .2 .3" euler="3 4 50"/>{bodies}</worldbody></mujoco>"""
    )
    model.hfield_data[:] = np.random.default_rng(1).uniform(0, 1, model.hfield_data.shape)
    return model


CURVED = ("SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER")


def type_of(model, geom: int) -> str:
    return mujoco.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_")


def exact_world(model, data, depth, seen=None):
    """The geoms of a model, those with alpha by default. Triangles of curved ones lie at most `depth` inside them."""
    world = exact.World()
    for geom in range(model.ngeom):
        material = model.geom_matid[geom]
        alpha = (model.geom_rgba[geom] if material < 0 else model.mat_rgba[material])[3]
        if alpha == 0 if seen is None else geom not in seen:
            continue
        kind, size, number = type_of(model, geom), model.geom_size[geom], model.geom_dataid[geom]
        place = np.column_stack([data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]])
        if kind == "PLANE":
            far = np.where(size[:2] > 0, size[:2], 1e5)
            world.mesh(geom, *primitives.plane(*far), place, front_only=True)
        elif kind == "HFIELD":
            rows, columns, first = model.hfield_nrow[number], model.hfield_ncol[number], model.hfield_adr[number]
            x, y, top, base = model.hfield_size[number]
            heights = top * model.hfield_data[first : first + rows * columns].astype(float)
            world.mesh(geom, *primitives.height_field(heights.reshape(rows, columns), x, y, base), place)
        elif kind in ("MESH", "SDF"):
            vertices = model.mesh_vert[model.mesh_vertadr[number] :][: model.mesh_vertnum[number]]
            faces = model.mesh_face[model.mesh_faceadr[number] :][: model.mesh_facenum[number]]
            world.mesh(geom, vertices, faces, place)
        elif kind == "BOX":
            world.mesh(geom, *primitives.box(size), place)
        elif kind == "SPHERE":
            world.solid(geom, exact.sphere(size[0]), place, size[0], depth)
        elif kind == "CAPSULE":
            world.solid(geom, exact.capsule(size[0], size[1]), place, size[0] + size[1], depth)
        elif kind == "CYLINDER":
            world.solid(geom, exact.cylinder(size[0], size[1]), place, np.hypot(size[0], size[1]), depth)
        elif kind == "ELLIPSOID":
            world.solid(geom, exact.ellipsoid(size), place, size.max(), depth)
    return world


def compare(model, data, lidar, scan, pose, seen=None, **settings):
    """Asserts that a scan is what MuJoCo's rays find, and returns how many beams of each type were compared. What
    differs by more than the precision must be right in double precision, or a tie there."""
    sensor = lidar.sensors[0]
    distances, geoms = multi_ray(model, data, sensor, pose, **settings)
    distances[distances > sensor.range_max] = -1
    geoms[distances < 0] = -1
    owners = lidar.geom_ids(scan)
    ours = np.where(owners < 0, -1, scan.ranges)
    precision = PRECISION * np.maximum(distances, 1)
    differ = np.flatnonzero((owners != geoms) | (np.abs(ours - distances) > precision))
    answers = exact_world(model, data, lidar.tolerance, seen).check(
        pose.position, world_directions(sensor, pose)[differ], scan.ranges[differ], owners[differ], precision[differ],
        sensor.range_max,
    )  # fmt: skip
    wrong = [(ours[i], distances[i], owners[i], geoms[i]) for i in differ[answers.wrong]]
    assert not wrong, (len(wrong), wrong[:5])
    kinds = np.array([type_of(model, geom) for geom in range(model.ngeom)] + ["NONE"])
    found, counts = np.unique(kinds[geoms[owners == geoms]], return_counts=True)
    return dict(zip(found.tolist(), counts.tolist()))


def test_tolerances_are_finite_and_above_0():
    for tolerance in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match=f"the tolerance must be finite and above 0 m, not {tolerance}"):
            gm.Tessellation(tolerance=tolerance)


def test_every_type_of_geom_against_mj_multi_ray(device):
    """A million beams, of which none is off by more than the precision, neither of MuJoCo's nor of ours."""
    model = every_type()
    data = mujoco.MjData(model)
    sensor = sphere_of_beams(340000)
    lidar = gm.Lidar(
        model, sensor, site="mast", effects=NONE, geomgroup=None, options=options(device),
        tessellation=gm.Tessellation(tolerance=5e-4),
    )  # fmt: skip
    into = gnosphere.Scan()
    totals: dict[str, int] = {}
    rng = np.random.default_rng(2)
    kinds = np.array([type_of(model, geom) for geom in range(model.ngeom)] + ["NONE"])
    for _ in range(3):
        mujoco.mj_kinematics(model, data)
        pose = lidar.pose(data)
        scan = lidar.scan(data, into=into)
        distances, geoms = multi_ray(model, data, sensor, pose)
        theirs = np.where((geoms < 0) | (distances > sensor.range_max), np.nan, distances)
        geoms[np.isnan(theirs)] = -1
        world = exact_world(model, data, 5e-4)
        size = np.maximum(np.nan_to_num(theirs), 1)
        for ranges, owners, precision in (
            (scan.ranges, lidar.geom_ids(scan), PRECISION * size), (theirs, geoms, MUJOCO * size),
        ):  # fmt: skip
            answers = world.check(
                pose.position, world_directions(sensor, pose), ranges, owners, precision, sensor.range_max
            )
            wrong = [(ranges[i], answers.ranges[i], owners[i], answers.owners[i]) for i in answers.wrong]
            assert not wrong, (len(wrong), wrong[:5])
            assert (answers.owners != owners).sum() < 1e-3 * len(ranges)  # ties are few
        for kind, count in zip(*np.unique(kinds[geoms], return_counts=True)):
            totals[kind] = totals.get(kind, 0) + count
        data.qpos.reshape(-1, 7)[:, :3] += rng.uniform(-0.3, 0.3, (model.nbody - 1, 3))
        data.qpos.reshape(-1, 7)[:, 3:] = rng.normal(size=(model.nbody - 1, 4))
        model.site_pos[0] += rng.uniform(-0.1, 0.1, 3)
    assert min(totals[kind] for kind in ("PLANE", "HFIELD", "BOX", "MESH", *CURVED)) > 3000, totals


def test_groups_alpha_bodies_and_static_geoms_are_chosen_as_mj_ray_does(device):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><asset><material name="clear" rgba="1 1 1 0"/></asset><worldbody>
        <geom type="box" size=".1 3 3" pos="9 0 0" group="0"/>
        <geom type="box" size=".1 2 3" pos="-9 0 0" rgba="1 0 0 0"/><geom type="box" size=".1 2 3" pos="-7 0 0"
        material="clear"/> <geom type="box" size=".1 2 3" pos="-8 0 0" material="clear" rgba="1 0 0 1"/>
        <body name="robot"><freejoint/><geom type="box" size=".1 .1 .1" pos="0.5 0 0" group="2"/>
          <body name="arm" pos="1 0 0"><joint/><geom type="box" size=".1 .3 .3" group="2"/>
            <body name="hand" pos="1 0 0"><joint/><geom type="box" size=".1 .6 .6" group="1"/></body></body>
          <body name="tail" pos="-1 0 0"><geom type="box" size=".1 .3 .3" group="3"/></body></body>
        <body name="mocap" mocap="true" pos="0 3 0"><geom type="box" size="1 .1 1" group="4"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    sensor = sphere_of_beams(4000)
    pose = gnosphere.Pose()
    bodies = {name: model.body(name).id for name in ("robot", "arm", "hand", "tail")}
    for settings, ours in (
        ({}, {"geomgroup": None}),
        ({"geomgroup": (1, 1, 1, 0, 0, 0)}, {}),
        ({"geomgroup": (0, 0, 0, 1, 1, 0)}, {"geomgroup": (0, 0, 0, 1, 1, 0)}),
        ({"static": 0}, {"geomgroup": None, "flg_static": False}),
        ({"exclude": bodies["arm"]}, {"geomgroup": None, "bodyexclude": "arm"}),
    ):
        lidar = gm.Lidar(model, sensor, effects=NONE, options=options(device), **ours)
        lidar.tolerance = 1e-3
        seen = set(multi_ray(model, data, sensor, pose, **settings)[1].tolist())
        counts = compare(model, data, lidar, lidar.scan(data), pose, seen, **settings)
        assert counts["BOX"] > 100
    lidar = gm.Lidar(model, sensor, effects=NONE, geomgroup=None, treeexclude="robot", options=options(device))
    seen = set(lidar.geom_ids(lidar.scan(data)).tolist())
    of_robot = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] in bodies.values()]
    assert seen.isdisjoint(of_robot) and len(seen) == 3  # the wall, the mocap body, nothing
    other = lidar.add(sensor, pose=gnosphere.Pose((0, 0, 0.1)), bodyexclude=["arm", bodies["tail"]], effects=NONE)
    seen = set(lidar.geom_ids(lidar.scan(data, other)).tolist())
    assert model.body("hand").geomadr[0] in seen and model.body("arm").geomadr[0] not in seen


OTHER = """<mujoco><worldbody><geom type="plane" size="0 0 1" pos="0 0 -1"/><site name="mast" pos="0 0 1"/>
<body name="a" pos="2 0 0"><freejoint/><geom type="box" size=".5 .4 .3"/></body>
<body name="b" pos="0 2 1"><flexcomp name="cloth" type="grid" count="6 6 1" spacing=".2 .2 .2" dim="2" radius=".001">
<edge equality="true"/></flexcomp></body></worldbody></mujoco>"""


def test_many_worlds_scan_as_each_alone(device):
    """Two models, one of them with a flex, each in several states."""
    first, second = every_type(), mujoco.MjModel.from_xml_string(OTHER)
    models = [first, second, first, first, second]
    settings = {"site": "mast", "effects": NONE, "fields": "normal", "options": options(device)}
    sensor = sphere_of_beams(3000)
    worlds = gm.Worlds(models, sensor, **settings)
    alone = {model: gm.Lidar(model, sensor, **settings) for model in (first, second)}
    datas = [mujoco.MjData(model) for model in models]
    rng, batch = np.random.default_rng(8), gnosphere.Batch()
    for _ in range(2):
        for data, model in zip(datas, models):
            data.qpos += rng.uniform(-0.2, 0.2, model.nq)
            mujoco.mj_forward(model, data)
        worlds.scan(datas, into=batch)
        geoms = worlds.geom_ids(batch)
        assert batch.ranges.shape == geoms.shape == (5, 3000)
        for view, (data, model) in enumerate(zip(datas, models)):
            scan = alone[model].scan(data)
            np.testing.assert_array_equal(batch.ranges[view], scan.ranges)
            np.testing.assert_array_equal(geoms[view], alone[model].geom_ids(scan))
            normal = gnosphere.Field.normal
            np.testing.assert_array_equal(batch.column(normal)[view], scan.column(normal))
        assert len({batch.ranges[view].tobytes() for view in range(5)}) == 5
        del geoms
    hidden = gm.Worlds([second, second], sensor, bodyexclude="a", **settings)
    geoms = hidden.geom_ids(hidden.scan([datas[1], datas[4]]))
    assert set(np.unique(geoms)) == {-1, 0}
    with pytest.raises(ValueError, match="there are 2 worlds, so scan\\(\\) needs as many MjData, not 1"):
        hidden.scan(datas[:1])


def test_each_world_may_have_several_sensors(device):
    """With their own places, fields, noise and bodies that they do not see, and as those of one model."""
    model = every_type()
    noisy = gnosphere.Effects.none()
    noisy.range_noise.use, noisy.range_noise.sigma = "on", 0.02
    first = (sphere_of_beams(500), {"site": "mast", "effects": NONE})
    below = patterns.grid((1.6, 1.0), 0.2, level=-0.6)
    second = (
        below,
        {"pose": gnosphere.Pose((0, 0, 0.1)), "bodyexclude": "body3", "effects": noisy, "fields": "normal"},
    )
    worlds = gm.Worlds([model] * 3, first[0], **first[1], options=options(device))
    alone = gm.Lidar(model, first[0], **first[1], options=options(device))
    assert worlds.add(second[0], **second[1]) == alone.add(second[0], **second[1]) == 1
    datas = [mujoco.MjData(model) for _ in range(3)]
    rng = np.random.default_rng(4)
    for step in range(2):
        for data in datas:
            data.qpos += rng.uniform(-0.2, 0.2, model.nq)
            mujoco.mj_forward(model, data)
        for number in (0, 1, 1):
            batch = worlds.scan(datas, number)
            for view, data in enumerate(datas):
                scan = alone.scan(data, number)
                np.testing.assert_array_equal(batch.ranges[view], scan.ranges)
                np.testing.assert_array_equal(worlds.geom_ids(batch)[view], alone.geom_ids(scan))
            assert ("normal" in batch) == (number == 1)
    assert worlds.frames == alone.frames == [6, 12]


def test_worlds_take_the_states_of_all_worlds_as_arrays(device):
    """As MJX and MuJoCo Warp have them."""
    model = every_type()
    settings = {"site": "mast", "effects": NONE, "options": options(device)}
    worlds = gm.Worlds([model] * 3, sphere_of_beams(2000), deformables=False, **settings)
    datas = [mujoco.MjData(model) for _ in range(3)]
    for number, data in enumerate(datas):
        data.qpos += np.random.default_rng(number).uniform(-0.2, 0.2, model.nq)
        mujoco.mj_forward(model, data)
    names = ("geom_xpos", "geom_xmat", "site_xpos", "site_xmat")
    states = types.SimpleNamespace(**{name: np.stack([getattr(data, name) for data in datas]) for name in names})
    states.geom_xmat = states.geom_xmat.reshape(3, -1, 3, 3)
    of_each, of_all = worlds.scan(datas), worlds.scan(states)
    np.testing.assert_array_equal(of_all.ranges, of_each.ranges)
    np.testing.assert_array_equal(of_all.instances, of_each.instances)
    assert len({ranges.tobytes() for ranges in of_all.ranges}) == 3
    with pytest.raises(ValueError, match=r"geom_xpos has the shape \(\d+, 3\), without a dimension of worlds"):
        worlds.scan(datas[0])
    states.site_xpos[1] = np.nan
    with pytest.raises(ValueError, match="the sensor of world 1 has the pose"):
        worlds.scan(states)
    deforming = mujoco.MjModel.from_xml_string(OTHER)
    with pytest.raises(ValueError, match="a model has flexes or skins, so scan\\(\\) needs MjData of each world"):
        gm.Worlds([deforming], "VLP-16", **settings).scan(states)


def patterns_in_a_box(turns):
    """A box of 10 m around the origin, its state, and a sensor whose patterns are a beam each, `turns` from its x axis.
    A beam meets the side ahead after 5 m over the cosine of its turn."""
    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom type="box" size="5 5 5"/></worldbody></mujoco>')
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    sensor = gnosphere.Sensor()
    sensor.range_max, sensor.range_min = 100, 0
    sensor.patterns = [gnosphere.BeamList([[np.cos(turn), np.sin(turn), 0]]) for turn in turns]
    return model, data, sensor


def test_each_world_goes_through_all_patterns_of_its_sensor(device):
    turns = np.radians([0, 30, 40])
    model, data, sensor = patterns_in_a_box(turns)
    for count in (1, 2, 3, 4):
        worlds = gm.Worlds([model] * count, sensor, effects=NONE, options=options(device))
        ranges = np.array([worlds.scan([data] * count).ranges[:, 0] for _ in range(3)])
        for of_world in ranges.T:
            np.testing.assert_allclose(np.sort(of_world), 5 / np.cos(turns), rtol=1e-5)


def test_sensors_that_scan_in_turns_go_through_all_their_patterns(device):
    turns = np.radians([0, 40])
    model, data, sensor = patterns_in_a_box(turns)
    lidar = gm.Lidar(model, sensor, effects=NONE, options=options(device))
    lidar.add(sphere_of_beams(10), effects=NONE)
    ranges = []
    for _ in range(2):
        ranges.append(lidar.scan(data).ranges[0])
        lidar.scan(data, 1)
    np.testing.assert_allclose(ranges, 5 / np.cos(turns), rtol=1e-5)


def test_what_changes_in_the_model_moves_the_sensor(device):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom name="wall" type="box" size=".5 50 50" pos="10 0 0"/>
        <body name="car" pos="1 0 0"><joint type="slide" axis="1 0 0"/><geom size=".1" mass="1"/>
        <site name="roof" pos="0.5 0 0" euler="0 0 90"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    ahead = gnosphere.Sensor()
    ahead.range_max, ahead.range_min = 100, 0
    ahead.patterns = [gnosphere.BeamList([[1.0, 0, 0], [0, -1, 0]])]
    lidar = gm.Lidar(model, ahead, site="roof", treeexclude="car", effects=NONE, options=options(device))
    turned = lidar.add(
        ahead, site="roof", pose=gnosphere.Pose((0, -0.25, 0), (0, 0, -np.sqrt(0.5), np.sqrt(0.5))), effects=NONE
    )
    lidar.add(ahead, pose=lambda data: gnosphere.Pose((data.time, 0, 0)), treeexclude="car", effects=NONE)
    for x in (0.0, 1.0, 2.0):
        data.qpos[0], data.time = x, x
        mujoco.mj_kinematics(model, data)
        assert np.isnan(lidar.scan(data).ranges[0])
        assert lidar.scan(data).ranges[1] == pytest.approx(8 - x)  # the site looks to the left
        assert lidar.scan(data, turned).ranges[0] == pytest.approx(7.75 - x)
        assert lidar.scan(data, 2).ranges[0] == pytest.approx(9.5 - x)
    with pytest.raises(TypeError, match="not a function"):
        gm.Lidar(model, ahead, site="roof", pose=lambda data: gnosphere.Pose())
    with pytest.raises(KeyError, match="nowhere"):
        gm.Lidar(model, ahead, site="nowhere")


def step_and_record(model, data, lidar, steps):
    """Steps the simulation and records each step."""
    for _ in range(steps):
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        lidar.record(data)


def forward_beams():
    """A sensor whose 11 beams look along x, one each 10 ms, and their times."""
    sensor = gnosphere.Sensor()
    sensor.range_max, sensor.range_min, sensor.rotation_period = 100, 0, 0.1
    times = np.linspace(0, 0.1, 11)
    sensor.patterns = [gnosphere.BeamList(np.tile([1.0, 0, 0], (11, 1)), times=times)]
    return sensor, times


def test_the_sensor_and_the_geoms_move_within_a_scan(device):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody>
        <body name="wall" pos="20 0 0"><joint name="wall" type="slide" axis="1 0 0"/><geom type="box" size=".5 50 50"
        mass="1"/></body> <body name="car"><joint name="car" type="slide" axis="1 0 0"/><geom size=".1" mass="1"
        group="3"/><site name="roof"/></body> </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.joint("car").qvel, data.joint("wall").qvel = 10, -5
    sensor, times = forward_beams()
    lidar = gm.Lidar(model, sensor, site="roof", options=options(device))
    for turn in range(2):
        mujoco.mj_forward(model, data)
        start = float(data.site("roof").xpos[0] - data.body("wall").xpos[0])
        lidar.record(data)
        step_and_record(model, data, lidar, 10)
        scan = lidar.scan(data)
        assert scan.ranges == pytest.approx(-start - 0.5 - 15 * times, abs=2e-5)
    still = gm.Lidar(model, sensor, site="roof", options=options(device)).scan(data)
    assert still.ranges == pytest.approx(np.full(11, scan.ranges[-1]), abs=2e-5)
    lidar.record(data)
    with pytest.raises(ValueError, match="ends at the time"):
        lidar.scan(data)
    assert lidar.scan(data).ranges.tobytes() == still.ranges.tobytes()  # the record is gone


@pytest.mark.parametrize("field", ("radial_speed", "velocity"))
def test_speeds_that_are_0_without_records_are_warned_of_once(device, field):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody><geom type="box" size=".5 50 50" pos="20 0 0"/>
        <body name="car"><joint type="slide" axis="1 0 0"/><geom size=".1" mass="1" group="3"/><site name="roof"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def told_of(lidar, scans=2):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            for _ in range(scans):
                last = lidar.scan(data)
        assert all(str(warning.filename) == __file__ for warning in told)
        return [str(warning.message) for warning in told], last

    def lidar_of(sensor, fields=field):
        return gm.Lidar(model, sensor, site="roof", fields=fields, options=options(device))

    def check_recorded(sensor, steps, tolerance):
        """With records there is no warning, and the speed is that of the robot."""
        lidar = lidar_of(sensor)
        lidar.record(data)
        step_and_record(model, data, lidar, steps)
        told, scan = told_of(lidar, 1)
        assert told == []
        if field == "radial_speed":
            assert scan["radial_speed"] == pytest.approx(-10, abs=tolerance)

    sensor, _ = forward_beams()
    assert told_of(lidar_of(sensor))[0] == []  # nothing moves
    data.qvel = 10
    begin = "gnosphere.mujoco: radial_speed and velocity are 0, although things move, because "
    lidar = lidar_of(sensor)
    assert told_of(lidar)[0] == [
        begin + "a scan without record() is one of a standing model; call record() at the start of the scan and after "
        "each mj_step()"
    ]
    assert told_of(lidar_of(sensor, "range"))[0] == []
    check_recorded(sensor, 10, 1e-3)
    at_once, _ = forward_beams()
    at_once.name, at_once.rotation_period, at_once.patterns = "flash", 0, [gnosphere.BeamList([[1.0, 0, 0]])]
    told, _ = told_of(lidar_of(at_once))
    assert told == [
        begin
        + "flash fires all beams at once; with a rotation_period of 0.001 s, and record() after each mj_step(), it "
        "measures them"
    ]
    at_once.rotation_period = 0.001
    check_recorded(at_once, 1, 1e-2)


@pytest.mark.parametrize("sensor_motion", (False, True))
@pytest.mark.parametrize("object_motion", (False, True))
def test_a_motion_that_is_not_simulated_leaves_its_part_as_at_the_end(device, sensor_motion, object_motion):
    """A sensor goes forward at 10 m/s and a wall comes at 5 m/s. What stands is where it is at the end of the turn."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody>
        <body name="wall" pos="20 0 0"><joint name="wall" type="slide" axis="1 0 0"/><geom type="box" size=".5 9 9"/>
        </body><body name="car"><joint name="car" type="slide" axis="1 0 0"/><geom type="sphere" size=".1" group="3"/>
        <site name="roof"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.joint("car").qvel, data.joint("wall").qvel = 10, -5
    sensor, times = forward_beams()
    effects = gnosphere.Effects.none()
    use = {False: gnosphere.EffectUse.off, True: gnosphere.EffectUse.on}
    effects.sensor_motion.use, effects.object_motion.use = use[sensor_motion], use[object_motion]
    lidar = gm.Lidar(model, sensor, site="roof", effects=effects, options=options(device))
    mujoco.mj_forward(model, data)
    lidar.record(data)
    step_and_record(model, data, lidar, 10)
    speed = 10 * sensor_motion + 5 * object_motion
    assert lidar.scan(data).ranges == pytest.approx(18 + speed * (0.1 - times), abs=2e-5)


def approaching_wall():
    """A wall whose front is 19.5 m before the sensor and comes at 5 m/s."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody>
        <body name="wall" pos="20 0 0"><joint name="wall" type="slide" axis="1 0 0"/><geom type="box" size=".5 9 9"/>
        </body><site name="roof"/></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.joint("wall").qvel = -5
    return model, data


def test_each_sensor_scans_with_the_records(device):
    model, data = approaching_wall()
    sensor, times = forward_beams()
    lidar = gm.Lidar(model, sensor, site="roof", options=options(device))
    assert lidar.add(sensor, site="roof") == 1
    flash = gnosphere.Sensor()  # fires at once
    flash.range_max, flash.range_min, flash.patterns = 100, 0, [gnosphere.BeamList([[1.0, 0, 0]])]
    assert lidar.add(flash, site="roof") == 2
    for order in ((0, 1), (2, 1, 0), (1, 2, 0)):
        mujoco.mj_forward(model, data)
        lidar.record(data)
        step_and_record(model, data, lidar, 10)
        end = float(data.body("wall").xpos[0]) - 0.5
        for number in order:
            expected = [end] if number == 2 else end + 5 * (0.1 - times)
            assert lidar.scan(data, number).ranges == pytest.approx(expected, abs=2e-5)
        assert lidar.scan(data, order[-1]).ranges == pytest.approx(end, abs=2e-5)  # its records are used


def test_a_sensor_that_fires_at_once_leaves_the_records_to_the_others(device):
    """The wall comes nearer in the first half of the turn alone."""
    model, data = approaching_wall()
    sensor, times = forward_beams()
    lidar = gm.Lidar(model, sensor, site="roof", options=options(device))
    flash = gnosphere.Sensor(range_max=100, patterns=[gnosphere.BeamList([[1.0, 0, 0]])])
    lidar.add(flash, site="roof")
    mujoco.mj_forward(model, data)
    lidar.record(data)
    step_and_record(model, data, lidar, 5)
    assert lidar.scan(data, 1).ranges == pytest.approx([19.25], abs=2e-5)
    data.joint("wall").qvel = 0
    step_and_record(model, data, lidar, 5)
    assert lidar.scan(data).ranges == pytest.approx(19.5 - 0.25 * times / 0.1, abs=2e-5)
    lidar.record(data)
    step_and_record(model, data, lidar, 3)
    added = lidar.add(sensor, site="roof")  # the records have no pose of it
    for number in (0, added):
        assert lidar.scan(data, number).ranges == pytest.approx(19.25, abs=2e-5)


def test_the_sensors_behind_a_number_that_is_given_again_stay(device):
    model = mujoco.MjModel.from_xml_string(CART)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def sensors_of(lidar):
        """The sensors after the one in the middle has been replaced."""
        for count in (4, 5):
            lidar.add(sphere_of_beams(count), site="roof", effects=NONE)
        lidar.simulator.remove_sensor(1)
        assert lidar.add(sphere_of_beams(6), site="roof", effects=NONE) == 1
        return lidar

    lidar = sensors_of(gm.Lidar(model, sphere_of_beams(3), site="roof", effects=NONE, options=options(device)))
    assert [lidar.scan(data, number).beam_count() for number in range(3)] == [3, 6, 5]
    worlds = sensors_of(gm.Worlds([model], sphere_of_beams(3), site="roof", effects=NONE, options=options(device)))
    assert [worlds.scan([data], number).beams for number in range(3)] == [3, 6, 5]


CART = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody>
<geom type="box" size=".1 50 50" pos="40 0 0"/>
<body name="cart"><joint name="cart" type="slide" axis="1 0 0"/><geom type="box" size=".01 9 9" pos="5.01 0 0"/>
<body name="wheel" pos="0 0 3"><joint name="wheel" axis="0 0 1"/><geom type="box" size=".1 .1 .1"/></body>
<site name="roof"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("span", [0.02, 0.05, 0.1, 0.3])
@pytest.mark.parametrize("every", [1, 2])
def test_what_a_sensor_carries_stands_still_however_long_the_records_are(device, span, every):
    """A plate 5 m ahead on the cart of the sensor, and a wall that the cart approaches at 10 m/s."""
    model = mujoco.MjModel.from_xml_string(CART)
    data = mujoco.MjData(model)
    data.joint("cart").qvel, data.joint("wheel").qvel = 10, 20
    puck = gnosphere.builtin_sensor("Puck")  # some of its beams fire after the end of the turn
    puck.rotation_period = 0.1
    ahead = gnosphere.Sensor()
    ahead.range_max, ahead.range_min, ahead.rotation_period = 100, 0, 0.1
    times = np.linspace(0, 0.1, 11)
    ahead.patterns = [gnosphere.BeamList([[1.0, 0, 0]] * 11, origins=[[6.0, 0, 0]] * 11, times=times)]
    effects = gnosphere.Effects.none()
    effects.sensor_motion.use = effects.object_motion.use = gnosphere.EffectUse.automatic
    for sensor in (puck, ahead):
        mujoco.mj_resetData(model, data)
        data.joint("cart").qvel, data.joint("wheel").qvel = 10, 20
        mujoco.mj_forward(model, data)
        lidar = gm.Lidar(model, sensor, site="roof", effects=effects, options=options(device))
        lidar.record(data)
        for step in range(round(span / 0.01)):
            mujoco.mj_step(model, data)
            mujoco.mj_kinematics(model, data)
            if step % every == 0:
                lidar.record(data)
        scan = lidar.scan(data)
        if sensor is puck:
            plate = scan.points[(lidar.geom_ids(scan) == 1) & (np.abs(scan.points[:, 0] - 5) < 1)]
            assert len(plate) > 1000
            assert plate[:, 0] == pytest.approx(np.full(len(plate), 5.0), abs=1e-4)
        else:
            end = float(data.site("roof").xpos[0])
            assert scan.ranges == pytest.approx(39.9 - 6 - end + 10 * (0.1 - times), abs=2e-5)


@pytest.mark.parametrize("angle", [1.2, 3.0, np.pi - 1e-9])
def test_maps_between_two_maps(angle):
    """A body that turns about an axis of its own, at a third of the way, at both ends and beyond."""
    axis = np.array([1.0, 2.0, -2.0]) / 3

    def at(share):
        x, y, z = axis
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + np.sin(share * angle) * cross + (1 - np.cos(share * angle)) * cross @ cross
        return np.column_stack([turn @ np.diag([1, 2, 3]), [share, 4, -2 * share]])[None]

    for share in (-1.5, 0, 1 / 3, 1, 2.4):
        assert gm.lidar.between(at(0), at(1), share) == pytest.approx(at(share), abs=1e-12)
    for same in (np.eye(4)[None, :3], at(0.3)):
        assert gm.lidar.between(same, same, 0.7) == pytest.approx(same, abs=1e-12)


def test_half_a_turn_goes_about_its_axis():
    """Whether forwards or back is open, so the turn at half of the way is one that makes the whole when done twice."""
    for axis in (*np.eye(3), np.array([1.0, 2.0, -2.0]) / 3):
        whole = 2 * np.outer(axis, axis) - np.eye(3)
        maps = np.zeros((2, 1, 3, 4))
        maps[0, 0, :, :3], maps[1, 0, :, :3] = np.eye(3), whole
        half = gm.lidar.between(maps[0], maps[1], 0.5)[0, :, :3]
        assert half @ axis == pytest.approx(axis, abs=1e-12)
        assert half @ half == pytest.approx(whole, abs=1e-12)
        assert np.trace(half) == pytest.approx(1, abs=1e-12)


def test_lists_of_beams_with_times_see_motion(device):
    """The time of a list without a rotation period is that of its last beam."""
    model = mujoco.MjModel.from_xml_string(CART)
    data = mujoco.MjData(model)
    data.joint("cart").qvel = 10
    mujoco.mj_forward(model, data)
    sensor = gnosphere.Sensor()
    sensor.range_max, sensor.range_min = 100, 0
    times = np.linspace(0, 0.05, 6)
    sensor.patterns = [gnosphere.BeamList([[1.0, 0, 0]] * 6, origins=[[6.0, 0, 0]] * 6, times=times)]
    lidar = gm.Lidar(model, sensor, site="roof", options=options(device))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lidar.record(data)
    step_and_record(model, data, lidar, 5)
    end = float(data.site("roof").xpos[0])
    assert lidar.scan(data).ranges == pytest.approx(39.9 - 6 - end + 10 * (0.05 - times), abs=2e-5)


def test_only_the_records_of_a_turn_are_kept(device):
    model = mujoco.MjModel.from_xml_string(CART)
    data = mujoco.MjData(model)
    lidar = gm.Lidar(model, "Puck", site="roof", effects=NONE, options=options(device))
    for _ in range(50):
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        lidar.record(data)
        lidar.record(data)  # of the same time, so it replaces the one before
    assert len(lidar._records) <= 12
    assert lidar.scan(data).beam_count() == 16 * 1808


def test_arguments_that_are_refused_when_a_lidar_is_made(device):
    model = mujoco.MjModel.from_xml_string(CART)
    for site in (None, "roof"):
        with pytest.raises(TypeError, match=r"pose must be a gnosphere.Pose or a function of MjData, not \(0, 0, 1\)"):
            gm.Lidar(model, "VLP-16", site=site, pose=(0, 0, 1))
    with pytest.raises(TypeError, match=r"Worlds: models is one MjModel; give one for each"):
        gm.Worlds(model, "VLP-16", site="roof")


def test_records_end_with_their_episode(device):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><site name="lidar"/><body name="wall" pos="5 0 0"><joint name="wall" type="slide"
        axis="1 0 0"/><geom type="box" size=".5 50 50"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    sensor = gnosphere.Sensor()
    sensor.range_max, sensor.rotation_period = 100, 0.1
    sensor.patterns = [gnosphere.BeamList([[1.0, 0, 0]], times=[0.05])]
    lidar = gm.Lidar(model, sensor, site="lidar", options=options(device))

    def begin(time: float, place: float) -> None:
        mujoco.mj_resetData(model, data)
        data.joint("wall").qpos, data.time = place, time
        mujoco.mj_forward(model, data)

    for records in (0, 1):  # of the next episode
        begin(0.3, 0)
        lidar.record(data)
        data.time = 0.4
        lidar.record(data)
        begin(0.1, 4)
        for _ in range(records):
            lidar.record(data)
            data.time = 0.2
        assert lidar.scan(data).ranges == pytest.approx([8.5])
    begin(0.5, 0)
    lidar.record(data)
    lidar.reset()
    begin(0.6, 4)
    assert lidar.scan(data).ranges == pytest.approx([8.5])
    with pytest.warns(UserWarning, match="record.. changes nothing, because VLP-16 fires all beams at once"):
        gm.Lidar(model, "VLP-16", site="lidar", options=options(device)).record(data)
    with pytest.raises(ValueError, match="call mj_forward"):
        lidar.scan(mujoco.MjData(model))
    empty = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(ValueError, match="of a model of 0 geoms; this one has 1"):
        lidar.update(mujoco.MjData(empty))
    with pytest.raises(ValueError, match="geomgroup has 2 flags"):
        gm.Lidar(model, sensor, site="lidar", geomgroup=(1, 1))
    for body in (-2, 2):
        with pytest.raises(ValueError, match=f"no body {body} to exclude; the model has 2 bodies"):
            gm.Lidar(model, sensor, site="lidar", bodyexclude=body)
    everything = gm.Lidar(model, sensor, site="lidar", bodyexclude=-1, treeexclude=-1, options=options(device))
    assert everything.scan(data).ranges == pytest.approx([8.5])


def test_materials_classes_and_the_alpha_of_textures(device, tmp_path):
    write_png(tmp_path / "net.png")
    (tmp_path / "model.xml").write_text(
        """<mujoco><asset><texture name="net" type="2d" file="net.png" nchannel="4"/>
        <material name="net" texture="net"/><material name="paint" rgba=".2 .4 .6 1"/>
        <mesh name="panel" vertex="0 -1 -1 0 1 -1 0 1 1 0 -1 1 .1 0 0" face="0 1 2 0 2 3 1 2 4"
        texcoord="0 0 1 0 1 1 0 1 1 1" inertia="shell"/>
        </asset><worldbody><geom name="panel" type="mesh" mesh="panel" material="net" pos="4 0 0"/>
        <geom name="wall-1" type="box" size=".1 9 9" pos="8 0 0" material="paint"/>
        <body name="robot" pos="0 0 -3"><geom type="sphere" size=".5" rgba="1 1 0 1"/></body></worldbody></mujoco>"""
    )
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    lidar = gm.Lidar(
        model, sphere_of_beams(20000), fields="class,material", classes={"*": 9, "wall*": 3, "rob?t": 4},
        effects=only_holes(), options=options(device),
    )  # fmt: skip
    scan = lidar.scan(data)
    geoms, classes = lidar.geom_ids(scan), scan.column(gnosphere.Field.class_id)
    assert [set(classes[geoms == geom].tolist()) for geom in range(3)] == [{9}, {3}, {4}]
    assert set(classes[geoms == -1].tolist()) == {0}
    # Half of the picture, where u is less than a half, has no alpha: y is less than 0 there.
    on_panel = scan.points[geoms == 0]
    assert len(on_panel) > 50 and on_panel[:, 1].min() >= -1e-3
    through = scan.points[geoms == 1] * (4 / 7.9)
    inside = (np.abs(through[:, 1]) < 0.99) & (np.abs(through[:, 2]) < 0.99)
    assert inside.sum() > 50 and through[inside][:, 1].max() <= 1e-3


def only_holes() -> gnosphere.Effects:
    effects = gnosphere.Effects.none()
    effects.cut_outs.use = gnosphere.EffectUse.automatic
    return effects


def write_png(path: Path) -> None:
    """A picture of 8 x 8 texels whose left half has no alpha."""
    import struct
    import zlib

    texels = np.full((8, 8, 4), 255, np.uint8)
    texels[:, :4, 3] = 0
    rows = b"".join(b"\0" + row.tobytes() for row in texels)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", 8, 8, 8, 6, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    body = b"".join(struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def test_flexes_and_skins_move(device):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body name="a" pos="0 0 1"><flexcomp name="cloth" type="grid" count="6 6 1" spacing=".2
        .2 .2" dim="2" radius=".001"><edge equality="true"/></flexcomp></body>
        <body name="b" pos="3 0 1"><flexcomp name="jelly" type="grid" count="4 4 4" spacing=".2 .2 .2" dim="3"
        radius=".001"> <elasticity young="1e4"/></flexcomp></body>
        <body name="c" pos="6 0 1"><flexcomp name="rope" type="grid" count="6 1 1" spacing=".2 .2 .2" dim="1"
        radius=".01"/></body> </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    up = gnosphere.Sensor()
    up.range_max, up.range_min = 100, 0
    up.patterns = [gnosphere.BeamList([[0, 0, 1.0], [0, 0, -1.0]])]
    with pytest.warns(UserWarning, match=r"leaves out flexes of one dimension \(1\)"):
        lidar = gm.Lidar(model, up, pose=gnosphere.Pose((0.05, 0.06, 0)), effects=NONE, options=options(device))
    block = lidar.add(up, pose=gnosphere.Pose((3.05, 0.06, 0)), effects=NONE)
    for fall in (0, 40):
        for _ in range(fall):
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        scan, below = lidar.scan(data), lidar.scan(data, block)
        cloth = data.flexvert_xpos[:36]
        assert scan.ranges[0] == pytest.approx(cloth[:, 2].mean(), abs=5e-3)
        assert below.ranges[0] == pytest.approx(data.flexvert_xpos[36:100, 2].min(), abs=5e-3)
        assert lidar.geom_ids(scan)[0] == -1 and scan.instances[0] == len(lidar.geoms)
    assert cloth[:, 2].mean() < 0.99


def test_a_skin_follows_its_bones(device):
    model = mujoco.MjModel.from_xml_string(SKIN)
    data = mujoco.MjData(model)
    sensor = gnosphere.Sensor()
    sensor.range_max, sensor.range_min = 100, 0
    sensor.patterns = [gnosphere.BeamList([[1.0, 0, 0]])]
    lidar = gm.Lidar(model, sensor, pose=gnosphere.Pose((0, 0, 0.9)), effects=NONE, options=options(device))
    for angle in (0.0, 0.3):
        data.qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        # At z = 0 the skin follows the lower bone, which stands still, at z = 1 the upper one, which turns about y at
        # z = 0.
        top = np.array([2 + np.sin(angle), np.cos(angle)])
        expected = 2 + (top[0] - 2) * 0.9 / top[1]
        assert lidar.scan(data).ranges[0] == pytest.approx(expected, abs=1e-4)
    assert expected > 2.2


SKIN = """<mujoco><worldbody><body name="low" pos="2 0 0"><geom size=".01" group="4"/>
<body name="high"><joint type="hinge" axis="0 1 0"/><geom size=".01" group="4"/></body></body></worldbody>
<deformable><skin name="skin" vertex="2 -1 0 2 1 0 2 1 1 2 -1 1" face="0 1 2 0 2 3">
<bone body="low" bindpos="2 0 0" bindquat="1 0 0 0" vertid="0 1" vertweight="1 1"/>
<bone body="high" bindpos="2 0 0" bindquat="1 0 0 0" vertid="2 3" vertweight="1 1"/></skin></deformable></mujoco>"""


def test_the_drop_in_for_mj_multi_ray(device):
    model = every_type()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for scale, seed in ((1.0, 1), (2.5, 2), (2.5, 2)):
        vec = scale * gnosphere.beams_of(sphere_of_beams(3000, seed=seed)).directions
        arguments = (
            model,
            data,
            np.array([0.1, 0.2, 0.3]),
            vec.reshape(-1),
            np.array([1, 0, 0, 0, 0, 0], np.uint8),
            1,
            3,
        )
        answers = []
        for function in (mujoco.mj_multiRay, gm.mj_multiRay):
            geoms, distances = np.zeros(3000, np.int32), np.zeros(3000)
            function(*arguments, geoms, distances, None, 3000, 150.0)
            answers.append((distances, geoms))
        (theirs, their_geoms), (ours, our_geoms) = answers
        assert (our_geoms == their_geoms).mean() > 0.995
        flat = (our_geoms == their_geoms) & (their_geoms >= 0) & (model.geom_type[their_geoms] >= 6)
        assert np.abs(ours - theirs)[flat].max() < 2e-5
        assert set(ours[our_geoms < 0]) == {-1}
    with pytest.raises(ValueError, match="normal"):
        gm.mj_multiRay(*arguments, geoms, distances, np.zeros(9000), 3000, 150.0)
    for wrong in (np.zeros((2, 1500), order="F"), distances.astype(np.float32), distances[:9], distances.tolist()):
        with pytest.raises(TypeError, match="mj_multiRay: dist must be"):
            gm.mj_multiRay(*arguments, geoms, wrong, None, 3000, 150.0)
    with pytest.raises(TypeError, match="mj_multiRay: geomid must be a contiguous array of int32"):
        gm.mj_multiRay(*arguments, geoms.astype(np.int64), distances, None, 3000, 150.0)
    for cutoff in (0.0, -1.0):
        gm.mj_multiRay(*arguments, geoms, distances, None, 3000, cutoff)
        assert set(distances) == {-1} and set(geoms) == {-1}


def test_a_ray_without_a_length_leaves_the_others_as_they_were(device):
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="box" size="1 9 9" pos="5 0 0"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def cast(vec):
        geoms, distances = np.zeros(1, np.int32), np.zeros(1)
        gm.mj_multiRay(model, data, np.zeros(3), np.array(vec), None, 1, -1, geoms, distances, None, 1, 100.0)
        return distances[0]

    rays = gm.Rays(model, [[1.0, 0, 0]], options=options(device))
    for _ in range(2):
        assert cast([1.0, 0, 0]) == pytest.approx(4)
        for wrong in ([0.0, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]):
            with pytest.raises(ValueError, match="the direction of ray 0 is .*, which has no length"):
                cast(wrong)
            with pytest.raises(ValueError, match="which has no length"):
                rays.aim([wrong])
        assert rays.cast(data, np.zeros(3))[0] == pytest.approx(4)
    rays.aim([[2.0, 0, 0]])
    assert rays.cast(data, np.zeros(3))[0] == pytest.approx(2)


def test_the_drop_in_for_rangefinders(device):
    sites = "".join(f'<site name="s{i}" pos="0 0 .1" euler="90 {20 * i} 0" size=".01"/>' for i in range(18))
    fingers = "".join(f'<rangefinder site="s{i}" cutoff="{4 if i % 5 else 0}"/>' for i in range(18))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><geom type="box" size=".1 6 6" pos="3 0 0"/><geom type="box" size="6 .1 6" pos="0 5 0"/>
        <body name="robot" pos="0 0 .5"><freejoint/><geom type="box" size=".2 .2 .2"/>{sites}
        <body pos="0 0 1"><geom type="box" size=".1 .1 .1"/><site name="top" euler="0 90 0"/></body></body></worldbody>
        <sensor>{fingers}<rangefinder site="top"/></sensor></mujoco>"""
    )
    data = mujoco.MjData(model)
    finders = gm.Rangefinders(model, options=options(device))
    for angle in (0.0, 0.4):
        data.qpos[3:7] = np.cos(angle / 2), 0, 0, np.sin(angle / 2)
        mujoco.mj_forward(model, data)
        expected = data.sensordata.copy()
        assert len(expected) == 19 and (expected > 0).sum() > 5 and (expected < 0).sum() > 3
        assert finders.read(data) == pytest.approx(expected, abs=1e-5)
    assert gm.Rangefinders(model, sites=["top"], options=options(device)).read(data) == pytest.approx(expected[-1:])


PUBLIC_MODELS = {
    "dm_control": (
        "suite/dog.xml", "third_party/kinova/jaco_arm.xml", "suite/quadruped.xml", "suite/humanoid_CMU.xml",
        "locomotion/walkers/assets/rodent.xml", "locomotion/walkers/assets/fruitfly_v2/floor.xml",
        "mjcf/test_assets/model_with_assets.xml",
    ),
    "gymnasium_robotics": (
        "envs/assets/fetch/pick_and_place.xml", "envs/assets/hand/manipulate_egg.xml", "envs/assets/hand/manipulate_pen.xml",
        "envs/assets/adroit_hand/adroit_hammer.xml", "envs/assets/adroit_hand/adroit_door.xml",
        "envs/assets/kitchen_franka/kitchen_assets/kitchen_env_model.xml",
    ),
}  # fmt: skip


def compare_whole_model(file, beams, device):
    """Compares a model in its initial pose and returns how many beams agree; None if MuJoCo refuses the model."""
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError:
        return None
    data, sensor = mujoco.MjData(model), sphere_of_beams(beams, 100, seed=4)
    mujoco.mj_forward(model, data)
    size, middle = model.stat.extent, np.array(model.stat.center)
    pose = gnosphere.Pose(tuple(middle + size * np.array([0.3, 0.4, 0.5])), (0.1, 0.2, 0.3, 0.9))
    tolerance = min(1e-3 * size, 2e-4)  # also of a finger in a kitchen
    lidar = gm.Lidar(
        model, sensor, pose=pose, effects=NONE, geomgroup=None, deformables=False, options=options(device),
        tessellation=gm.Tessellation(tolerance=tolerance),
    )  # fmt: skip
    lidar.tolerance = tolerance
    agreed = compare(model, data, lidar, lidar.scan(data), pose)
    with_skins = gm.Lidar(model, sensor, pose=pose, effects=NONE, geomgroup=None, options=options(device))
    on_skins = (with_skins.scan(data).instances == len(lidar.geoms)).sum()
    assert (on_skins > beams // 400) == (model.nskin > 0), file
    return sum(agreed.values())


@pytest.mark.parametrize("package", PUBLIC_MODELS)
def test_public_models_against_mj_multi_ray(device, package):
    """Models of packages of which only the files are read."""
    found = importlib.util.find_spec(package)
    if not found or not found.submodule_search_locations:
        pytest.skip(f"{package} is not installed")
    folder = Path(found.submodule_search_locations[0])
    for file in PUBLIC_MODELS[package]:
        assert compare_whole_model(folder / file, 20000, device) > 500, file


def test_every_model_of_a_folder(device):
    """Whatever the folder GNOSPHERE_MODELS has: what MuJoCo reads agrees with its rays, with one warning at most."""
    if "GNOSPHERE_MODELS" not in os.environ:
        pytest.skip("GNOSPHERE_MODELS names no folder")
    agreed = []
    for file in sorted(Path(os.environ["GNOSPHERE_MODELS"]).rglob("*.xml")):
        if b"<mujoco" in file.read_bytes():
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                agreed.append(compare_whole_model(file, 5000, device))
            assert len([each for each in told if "gnosphere" in str(each.message)]) <= 2, file  # of two lidars
    read = [number for number in agreed if number is not None]
    print(f"{len(read)} of {len(agreed)} files are models, {sum(read)} beams agree")
    assert read
