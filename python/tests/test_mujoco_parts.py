# SPDX-License-Identifier: Apache-2.0
"""Skins, flexes, materials, names and rays of MuJoCo models, against MuJoCo's own and closed forms. Skipped without the
package mujoco."""

import re

import numpy as np
import pytest
from conftest import REPOSITORY

from test_mujoco import write_png

import gnosphere
from gnosphere import robotics

mujoco = pytest.importorskip("mujoco")
gm = pytest.importorskip("gnosphere.mujoco")

NONE = gnosphere.Effects.none()


def model_of(text: str):
    """A model of MJCF without its outermost element, and its data."""
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def listed(directions, range_max: float = 100.0) -> gnosphere.Sensor:
    return gnosphere.Sensor(range_min=0, range_max=range_max, patterns=[gnosphere.BeamList(directions)])


SKIN = """<worldbody><body name="low" pos="2 0 0" euler="10 20 30"><joint type="ball"/><geom size=".01" group="4"/>
<body name="high" pos="0 0 1"><joint axis="0 1 0"/><geom size=".01" group="4"/></body></body></worldbody>
<deformable><skin name="skin" inflate="{}" vertex="2 -1 0 2 1 0 2 1 1 2 -1 1 2.5 0 .5" face="0 1 2 0 2 3 0 1 4 1 2 4">
<bone body="low" bindpos="2 0 .1" bindquat=".9 .1 .3 .2" vertid="0 1 2 4" vertweight="1 .75 .25 .5"/>
<bone body="high" bindpos="2 0 1" bindquat=".8 -.1 .3 .4" vertid="1 2 3 4" vertweight=".25 .75 1 .5"/></skin>
</deformable>"""


@pytest.mark.parametrize("inflate", (0, 0.05))
def test_the_vertices_of_a_skin_are_those_that_mujoco_draws(inflate):
    model, data = model_of(SKIN.format(inflate))
    camera, options, scene = mujoco.MjvCamera(), mujoco.MjvOption(), mujoco.MjvScene(model, 100)
    options.flags[mujoco.mjtVisFlag.mjVIS_SKIN] = 1
    skin = gm.shapes.Skin(model, 0)
    for state in ((1, 0, 0, 0, 0), (0.9, 0.1, 0.2, 0.3, 0.7)):
        data.qpos[:] = state
        mujoco.mj_forward(model, data)
        mujoco.mjv_updateScene(model, data, options, None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
        drawn = np.reshape(scene.skinvert, (-1, 3))
        np.testing.assert_allclose(skin.positions(data), drawn, atol=1e-6)


def test_flexes_and_skins_belong_to_groups_and_classes(device):
    """Two cloths over each other and a skin under them, each in a group of its own."""
    cloth = """<body name="of {1}" pos="0 0 {0}"><flexcomp name="{1}" type="grid" count="{3}" spacing=".3 .3 .3"
        dim="2" radius=".001" group="{2}"><edge equality="true"/></flexcomp></body>"""
    text = f"""<worldbody>{cloth.format(2, "lower", 0, "5 5 1")}{cloth.format(3, "upper", 3, "4 7 1")}
        <body name="bone"><geom size=".01" group="5"/></body></worldbody><asset>
        <material name="fur" rgba=".2 .4 .6 1"/></asset><deformable><skin name="hide" group="4" material="fur"
        vertex="-1 -1 1 1 -1 1 1 1 1 -1 1 1" face="0 1 2 0 2 3"><bone body="bone" bindpos="0 0 0" bindquat="1 0 0 0"
        vertid="0 1 2 3" vertweight="1 1 1 1"/></skin></deformable>"""
    model, data = model_of(text)
    classes = {"lower": 2, "upper": 3, "hide": 4}
    chosen = [
        (None, 1, 4), ((1, 1, 1, 0, 0, 0), 2, 2), (np.array([0, 0, 0, 1, 0, 0], np.uint8), 3, 3),
        ((0, 0, 0, 0, 1, 0), 1, 4), ((0, 0, 0, 0, 0, 0), np.nan, 0),
    ]  # fmt: skip
    beyond = [((0, 0, 0, 0, 0, 1), 2, 2), ((1, 0, 0, 0, 0, 0), 1, 4)]  # with the flexes behind the last group
    for i, (groups, distance, kind) in enumerate(chosen + beyond):
        if i == len(chosen):
            model.flex_group[:], model.skin_group[:] = 9, -3
        lidar = gm.Lidar(
            model, listed([[0, 0, 1]]), pose=gnosphere.Pose((0.05, 0.06, 0)), geomgroup=groups, classes=classes,
            fields="class", effects=NONE, options=gnosphere.SimulatorOptions(device),
        )  # fmt: skip
        scan = lidar.scan(data)
        np.testing.assert_allclose(scan.ranges, [distance], atol=1e-3)
        assert scan["class"].tolist() == [kind]
        if kind == 4:
            scene = lidar._shapes.shapes.scene()
            fur = scene.materials[scene.meshes[scene.instances[scan.instances[0]].mesh].parts[0].material]
            assert (fur.name, fur.base_color) == ("fur", pytest.approx((0.2, 0.4, 0.6, 1)))


def test_colours_are_those_of_geoms_unless_a_material_has_them():
    """A geom with a material has the colour of the material, unless it states one of its own."""
    model, _ = model_of("""<asset><material name="paint" rgba=".2 .4 .6 1"/></asset><worldbody>
        <geom name="a" size=".1" material="paint"/><geom name="b" size=".1" material="paint" rgba="1 0 0 .5"/>
        <geom name="c" size=".1" rgba="0 1 0 1"/><body name="box"><geom size=".1"/></body></worldbody>""")
    scene = gm.Lidar(model, "VLP-16", effects=NONE)._shapes.shapes.scene()
    materials = [scene.materials[scene.meshes[instance.mesh].parts[0].material] for instance in scene.instances]
    assert [material.name for material in materials] == ["paint", "paint", "", ""]
    colours = [(0.2, 0.4, 0.6, 1), (1, 0, 0, 0.5), (0, 1, 0, 1), (0.5, 0.5, 0.5, 1)]
    np.testing.assert_allclose([material.base_color for material in materials], colours, atol=1e-6)
    assert [instance.name for instance in scene.instances] == ["a", "b", "c", "box"]  # by its body without a name
    assert all(material.double_sided for material in materials)


def test_classes_by_the_names_of_geoms_meshes_and_bodies():
    mesh = 'vertex="0 0 0 1 0 0 0 1 0 0 0 1"'
    model, _ = model_of(f"""<asset><mesh name="hull" {mesh}/><mesh name="wing" {mesh}/></asset><worldbody>
        <geom name="own" type="mesh" mesh="hull"/><geom type="mesh" mesh="hull"/>
        <body name="plane"><geom name="left" type="mesh" mesh="wing"/><geom size=".1"/></body></worldbody>""")
    for classes, expected in (
        ({"hull": 1, "plane": 2}, [1, 1, 2, 2]), ({"own": 3, "wing*": 4}, [3, 0, 4, 0]),
        ({"left": 5, "p*": 6}, [0, 0, 5, 6]),
    ):  # fmt: skip
        lidar = gm.Lidar(model, "VLP-16", classes=classes, effects=NONE)
        assert [instance.class_id for instance in lidar._shapes.shapes.instances] == expected


def test_geoms_beyond_the_last_group_count_as_of_the_last(device):
    """As for mj_ray(), which clamps the group of a geom."""
    model, data = model_of('<worldbody><geom type="box" size=".5 .5 .5" pos="5 0 0" group="5"/></worldbody>')
    for group, groups in ((9, (0, 0, 0, 0, 0, 1)), (-3, (1, 0, 0, 0, 0, 0))):
        model.geom_group[0] = group
        geom = np.zeros(1, np.int32)
        theirs = mujoco.mj_ray(
            model, data, np.zeros(3), np.array([1.0, 0, 0]), np.array(groups, np.uint8), 1, -1, geom, None
        )
        lidar = gm.Lidar(
            model, listed([[1, 0, 0]]), geomgroup=groups, effects=NONE, options=gnosphere.SimulatorOptions(device)
        )
        assert lidar.scan(data).ranges == pytest.approx([theirs]) == [4.5]


def test_a_texture_repeats_over_a_mesh_and_may_let_a_part_of_the_light_through(device, tmp_path):
    """A square of 2 m whose texture stands on it twice: its left half has an alpha below a half."""
    write_png(tmp_path / "net.png")
    (tmp_path / "model.xml").write_text("""<mujoco><asset><texture name="net" type="2d" file="net.png" nchannel="4"/>
        <material name="net" texture="net" texrepeat="2 1"/><mesh name="panel" vertex="0 -1 -1 0 1 -1 0 1 1 0 -1 1
        .1 0 -1" face="0 1 2 0 2 3 0 1 4" texcoord="0 0 1 0 1 1 0 1 1 1" inertia="shell"/></asset><worldbody>
        <geom type="mesh" mesh="panel" material="net" pos="4 0 0"/></worldbody></mujoco>""")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    model.tex_data.reshape(8, 8, 4)[:, :4, 3] = 100
    effects = gnosphere.Effects.none()
    effects.cut_outs.use = gnosphere.EffectUse.automatic
    y = np.linspace(-0.95, 0.95, 20)
    directions = np.stack([0 * y + 4, y, 0 * y + 0.2], axis=1)
    sensor = listed(directions / np.linalg.norm(directions, axis=1)[:, None])
    lidar = gm.Lidar(model, sensor, effects=effects, options=gnosphere.SimulatorOptions(device))
    assert np.isnan(lidar.scan(data).ranges).tolist() == ((y + 1) % 1 < 0.5).tolist()


TWO_WALLS = """<worldbody><geom name="near" type="box" size=".5 .5 .5" pos="4 0 0"/>
<geom name="far" type="box" size=".5 .5 .5" pos="9 0 0" group="2"/><geom type="box" size="9 .5 9" pos="0 -7 0"/>
<body name="robot"><freejoint/><geom type="box" size=".2 .2 .2"/></body></worldbody>"""


def test_rays_turn_with_the_matrix_of_their_frame(device):
    """A quarter of a turn about z takes x to y, and the frame's -x to the wall at y -7."""
    model, data = model_of(TWO_WALLS)
    rays = gm.Rays(model, [[2.0, 0, 0], [-1.0, 0, 0]], bodyexclude=1, options=gnosphere.SimulatorOptions(device))
    distances, geoms = rays.cast(data, [0, 0, 0])
    assert distances == pytest.approx([1.75, -1]) and geoms.tolist() == [0, -1]
    distances, geoms = rays.cast(data, [0, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 1])
    assert distances == pytest.approx([-1, 6.5]) and geoms.tolist() == [-1, 2]
    rays.aim([[1.0, 0, 0]])  # still does not see its body
    assert rays.cast(data, [0, 0, 0])[0] == pytest.approx([3.5])


def test_each_call_of_the_drop_in_counts_as_it_is_made(device):
    """Bodies, groups, cutoffs, directions, counts and models of earlier calls are not those of a later one."""
    models = [
        model_of(TWO_WALLS),
        model_of(TWO_WALLS.replace('size=".5 .5 .5" pos="9 0 0"', 'size="1.5 .5 .5" pos="8 0 0"')),
    ]
    every, behind = None, np.array([0, 0, 1, 0, 0, 0], np.uint8)
    calls = [
        (0, every, 1, 1e3, [1, 0, 0]), (0, every, -1, 1e3, [1, 0, 0]), (0, behind, 1, 1e3, [1, 0, 0]),
        (1, behind, 1, 1e3, [1, 0, 0]), (0, behind, 1, 5.0, [1, 0, 0]), (0, every, 1, 1e3, [0, -1, 0]),
        (0, every, 1, 1e3, [1, 0, 0]), (1, behind, 1, 1e3, [1, 0, 0]), (0, every, -1, 1e3, [1, 0, 0]),
    ]  # fmt: skip
    for number, groups, exclude, cutoff, way in calls:
        model, data = models[number]
        vec = np.array([way, way], float).reshape(-1)
        answers = []
        for function in (mujoco.mj_multiRay, gm.mj_multiRay):
            geoms, distances = np.zeros(2, np.int32), np.zeros(2)
            function(model, data, np.zeros(3), vec, groups, 1, exclude, geoms, distances, None, 2, cutoff)
            answers.append((*distances, *geoms))
        assert answers[0] == pytest.approx(answers[1], abs=1e-5), (number, groups, exclude, cutoff, way)
    gm.mj_multiRay(model, data, np.zeros(3), np.eye(3).reshape(-1), every, 1, 1, geoms, distances, None, 1, 1e3)
    assert distances.tolist() == [pytest.approx(3.5), answers[1][1]]  # one ray was asked for


def test_rangefinders_of_several_bodies_have_the_cutoffs_that_are_given(device):
    """Two bodies that turn, with sites whose axes z lie askew; a finder does not see its own body."""
    site = """<site name="{0}1" euler="0 90 0" pos=".1 0 0"/><site name="{0}2" euler="0 80 20"/>
        <site name="{0}3" euler="90 0 0"/>"""
    text = f"""<worldbody><geom type="box" size=".5 30 30" pos="12 0 0"/><geom type="box" size="30 .5 30" pos="0 -9 0"/>
        <body name="a" euler="0 0 20"><geom type="box" size=".5 .5 .5"/>{site.format("a")}</body>
        <body name="b" pos="0 3 0" euler="0 10 -20"><geom type="box" size=".5 .5 .5"/>{site.format("b")}</body>
        </worldbody>
        <sensor>{"".join(f'<rangefinder site="{name}" cutoff="{cutoff}"/>' for name, cutoff in (
            ("b1", 0), ("a1", 5), ("a2", 0), ("b3", 8), ("a3", 0), ("b2", 11)))}</sensor>"""
    model, data = model_of(text)
    expected = data.sensordata.copy()
    options = gnosphere.SimulatorOptions(device)
    assert (expected > 0).all() and len(set(expected.round(3))) == 6
    assert gm.Rangefinders(model, options=options).read(data) == pytest.approx(expected, abs=1e-5)
    free = {name: value for name, value in zip(("b1", "a1", "a2", "b3", "a3", "b2"), expected)}
    names = ["a3", "b1", "a2"]
    for cutoff in (0.0, 12.0, 9.3):
        found = gm.Rangefinders(model, sites=names, cutoff=cutoff, options=options).read(data)
        assert found == pytest.approx([min(free[name], cutoff or np.inf) for name in names], abs=1e-5)


def test_a_plane_without_an_end_along_one_axis_follows_the_sensor_along_it_alone(device):
    """It is 2 m wide along x, and has no end along y."""
    model, data = model_of('<worldbody><geom type="plane" size="1 0 .1"/></worldbody>')
    tessellation = gm.Tessellation(plane=50)
    for x, y, seen in ((0, 0, True), (0, 5000, True), (0.9, -300, True), (1.1, 5000, False)):
        lidar = gm.Lidar(
            model, listed([[0, 0, -1]]), pose=gnosphere.Pose((x, y, 3)), tessellation=tessellation, effects=NONE,
            options=gnosphere.SimulatorOptions(device),
        )  # fmt: skip
        assert np.isfinite(lidar.scan(data).ranges).tolist() == [seen]


def test_what_hangs_from_the_world_is_not_of_its_tree():
    """To exclude the tree of the world hides what the world itself carries, not every body."""
    model, _ = model_of("""<worldbody><geom size=".1"/><body name="a"><freejoint/><geom size=".1"/><body name="b">
        <geom size=".1"/></body></body><body name="c"><geom size=".1"/></body></worldbody>""")
    for tree, hidden in (("world", [0]), ("a", [1, 2]), (["b", "c"], [2, 3]), (-1, [])):
        lidar = gm.Lidar(model, "VLP-16", effects=NONE)
        assert lidar._shapes.instances_of((), tree).tolist() == hidden


def test_worlds_have_scenes_and_warnings_of_their_own(device):
    """Two models in turn, whose meshes have the same numbers and other shapes; only the first has what is left out. A
    warning counts what each model lacks, however many worlds have the model."""
    mesh = '<asset><mesh name="m" vertex="{0} -1 -1 {0} 1 -1 {0} 0 1 {1} 0 0"/></asset>'
    rope = """<body name="end" pos="9 9 9"><flexcomp name="rope" type="grid" count="4 1 1" spacing=".2 .2 .2" dim="1"
        radius=".01"/>
        </body>"""
    texts = [mesh.format(x, 2 * x) + '<worldbody><geom type="mesh" mesh="m"/>{}</worldbody>' for x in (3, 5)]
    models, datas = zip(*(model_of(text.format(more)) for text, more in zip(texts, (rope, ""))))
    options = gnosphere.SimulatorOptions(device)
    with pytest.warns(UserWarning, match=r"gnosphere.mujoco leaves out flexes of one dimension \(1\)$"):
        worlds = gm.Worlds([*models, models[1]], listed([[1, 0, -0.1]] / np.hypot(1, 0.1)), fields="x", effects=NONE,
                           options=options)  # fmt: skip
    batch = worlds.scan([*datas, datas[1]])
    assert batch.points.shape[-1] == 3
    np.testing.assert_allclose(batch.points[:, 0, 0], [3, 5, 5], rtol=1e-5)
    two, _ = model_of(texts[1].format(rope + rope.replace('"end"', '"other end"').replace('"rope"', '"cord"')))
    with pytest.warns(UserWarning, match=r"gnosphere.mujoco leaves out flexes of one dimension \(3\)$"):
        gm.Worlds([models[0], two, models[0]], listed([[1.0, 0, 0]]), effects=NONE, options=options)


RAIL = """<worldbody><geom type="plane" size="0 0 .1" pos="0 0 -1"/><geom type="box" size=".5 9e3 9" pos="20 0 0"/>
<body name="car"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<geom size=".1" group="3"/><site name="roof"/></body></worldbody>"""


def drive(model, data, lidar, places):
    """Records the car at places, pairs of a time and of x and y."""
    for time, x, y in places:
        data.time, data.qpos[:] = time, (x, y)
        mujoco.mj_forward(model, data)
        lidar.record(data)


def test_a_sensor_is_where_the_records_between_have_it(device):
    """It goes to and fro within a turn, so its mean motion says little."""
    model, data = model_of(RAIL)
    times = np.arange(0, 0.11, 0.01)
    sensor = gnosphere.Sensor(range_min=0, range_max=100, rotation_period=0.1)
    sensor.patterns = [gnosphere.BeamList([[1.0, 0, 0]] * 11, times=times)]
    lidar = gm.Lidar(model, sensor, site="roof", options=gnosphere.SimulatorOptions(device))
    places = [(0.02 * i, 3.0 * (i % 2), 0) for i in range(6)]
    drive(model, data, lidar, places)
    expected = 19.5 - np.interp(times, *np.array(places).T[:2])
    np.testing.assert_allclose(lidar.scan(data).ranges, expected, atol=0.01)  # at 150 m/s


def test_the_ground_is_below_a_sensor_that_moves_far_from_the_origin(device):
    model, data = model_of(RAIL)
    sensor = gnosphere.Sensor(range_min=0, range_max=100, rotation_period=0.1)
    sensor.patterns = [gnosphere.BeamList([[0, 0, -1.0]] * 3, times=[0, 0.05, 0.1])]
    tessellation = gm.Tessellation(plane=30)
    lidar = gm.Lidar(
        model, sensor, site="roof", tessellation=tessellation, options=gnosphere.SimulatorOptions(device)
    )  # fmt: skip
    drive(model, data, lidar, [(0, 0, 5000), (0.1, 1, 5001)])
    np.testing.assert_allclose(lidar.scan(data).ranges, [1, 1, 1], atol=1e-3)


def test_patterns_that_last_for_other_times_have_turns_of_their_own(device):
    """The second pattern lasts for half of the time of the first one."""
    model, data = model_of(RAIL)
    sensor = gnosphere.Sensor(range_min=0, range_max=100)
    sensor.patterns = [
        gnosphere.BeamList([[1.0, 0, 0]] * 3, times=np.array([0, 0.5, 1]) * last) for last in (0.1, 0.05)
    ]
    lidar = gm.Lidar(model, sensor, site="roof", options=gnosphere.SimulatorOptions(device))
    for turn, duration in enumerate((0.1, 0.05, 0.1)):
        start = float(turn)
        drive(model, data, lidar, [(start, 0, 0), (start + 0.05, 5, 0), (start + 0.1, 10, 0)])
        expected = 9.5 + 100 * (duration - np.array([0, 0.5, 1]) * duration)
        np.testing.assert_allclose(lidar.scan(data).ranges, expected, atol=1e-4)


MACHINE = """<worldbody><geom name="floor" type="plane" size="2 2 .1"/><body name="cart" pos="0 0 1"><freejoint/>
<geom name="box" type="box" size=".1 .2 .3" pos=".1 .2 .3" quat=".9 .1 .2 .3"/>
<body pos="0 0 1"><joint name="hinge" axis="0 1 0" range="-1 2" limited="true"/><joint axis="1 0 0"/>
<joint name="ball" type="ball"/><geom name="ball" type="sphere" size=".5" pos="1 0 0"/>
<body name="end" pos="1 0 0" euler="10 20 30"><joint name="slide" type="slide" axis="0 0 1"/>
<geom name="tip" type="box" size=".1 .1 .1"/><geom name="hull" type="box" size=".2 .2 .2" group="3"/></body></body>
</body></worldbody>"""


def test_joints_and_geoms_of_mjcf_are_where_mujoco_has_them(tmp_path):
    file = tmp_path / "machine.xml"
    file.write_text(f'<mujoco><compiler angle="radian"/>{MACHINE}</mujoco>')
    for collisions, names in ((False, ["floor", "box", "ball", "tip"]), (True, ["hull"])):
        robot = robotics.load(file, collisions=collisions)
        assert not robot.left_out
        assert robot.joint_limits == {"hinge": (-1, 2), "slide": (-np.inf, np.inf)}
        model = mujoco.MjModel.from_xml_path(str(file))
        data = mujoco.MjData(model)
        for hinge, slide in ((0, 0), (0.7, 0.4), (-0.5, -3)):
            rows = robot.move({"hinge": hinge, "slide": slide})
            data.joint("hinge").qpos, data.joint("slide").qpos = hinge, slide
            mujoco.mj_kinematics(model, data)
            geoms = [model.geom(name).id for name in names]
            expected = np.concatenate([data.geom_xmat.reshape(-1, 3, 3), data.geom_xpos[:, :, None]], axis=2)[geoms]
            np.testing.assert_allclose(rows, expected, atol=1e-9)
    assert robotics.load(file).frames == ["world", "cart", "body 2", "end"]
    counts = [robotics.load(file, tolerance=tolerance).scene.meshes[2].triangle_count() for tolerance in (1e-2, 1e-4)]
    assert counts[1] > 20 * counts[0]


def test_what_robots_of_mjcf_lack_is_told(tmp_path):
    file = tmp_path / "cloth.xml"
    file.write_text(
        """<mujoco><worldbody><body name="a"><flexcomp name="cloth" type="grid" count="3 3 1" spacing=".2 .2 .2"
        dim="2" radius=".001"><edge equality="true"/></flexcomp></body></worldbody></mujoco>"""
    )
    with pytest.warns(UserWarning, match=r"leaves out flexes and skins, which gnosphere.mujoco has \(1\)$"):
        assert not robotics.load(file).frames


def test_the_page(tmp_path, monkeypatch, recwarn):
    """The blocks of docs/mujoco.md run one after the other, without a warning, on a robot of 50 steps a turn; with fewer
    worlds and seconds than there."""
    body = '<freejoint/><geom size=".2"/><site name="lidar" pos="0 0 .5"/>'
    walls = '<geom name="floor" type="plane" size="0 0 1"/><geom name="wall east" type="box" size=".1 3 1" pos="5 0 1"/>'
    robot = f'<mujoco><worldbody>{walls}<body name="torso" pos="0 0 .5">{body}</body></worldbody></mujoco>'
    (tmp_path / "robot.xml").write_text(robot)
    monkeypatch.chdir(tmp_path)
    page = (REPOSITORY / "docs" / "mujoco.md").read_text()
    assert page.count("data.time < 10:") == 1 and page.count("1024") >= 3
    page = page.replace("data.time < 10:", "data.time < 0.01:").replace("1024", "3")
    first, moving, worlds = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    names: dict = {}
    exec(compile(first, "docs/mujoco.md", "exec"), names)
    assert set(names["geoms"]) == {-1, 0, 1} and set(names["scan"]["class"]) == {0, 1, 2}
    exec(compile(moving, "docs/mujoco.md", "exec"), names)
    assert names["scan"].skewed
    exec(compile(worlds, "docs/mujoco.md", "exec"), names)
    assert names["batch"].ranges.shape == (3, 28800) and set(names["geoms"].ravel()) == {-1, 0, 1}
    assert not recwarn.list
