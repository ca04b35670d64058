# SPDX-License-Identifier: Apache-2.0
"""Robots and worlds from URDF, SDF, MJCF and USD, against other readers, other rays and closed forms. Each format is
skipped without its package."""

import os
import re
import signal
import subprocess
import sys
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY

import gnosphere
from gnosphere import adapter, primitives, robotics
from gnosphere.robotics.resources import Resources, parse_xml
from gnosphere.robotics.robot_scene import Parts

NONE = gnosphere.Effects.none()

SENSOR = """<sensor name="{name}" type="{kind}"><pose>{pose}</pose><update_rate>10</update_rate><{tag}><scan>
<horizontal><samples>90</samples><min_angle>-1.57</min_angle><max_angle>1.57</max_angle></horizontal>
<vertical><samples>3</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></vertical></scan>
<range><min>0.1</min><max>30</max></range></{tag}></sensor>"""


def sensor(name="top", kind="gpu_lidar", tag="lidar", pose="0 0 0 0 0 0"):
    return SENSOR.format(name=name, kind=kind, tag=tag, pose=pose)


def everywhere(count, seed=0, range_max=100.0):
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    made = gnosphere.Sensor()
    made.name, made.range_min, made.range_max = "everywhere", 0, range_max
    made.patterns = [gnosphere.BeamList(directions / np.linalg.norm(directions, axis=1, keepdims=True))]
    return made


def quiet(file, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return robotics.load(file, **options)


def corners(robot):
    """The corners of each instance in the world."""
    scene = robot.scene
    result = []
    for instance in scene.instances:
        mesh, rows = scene.meshes[instance.mesh], instance.transform.rows
        used = mesh.positions[np.unique(mesh.indices)] + np.array(mesh.origin)
        result.append(used @ rows[:, :3].T + rows[:, 3])
    return result


URDF = """<robot name="arm">
<material name="red"><color rgba="0.8 0.1 0.1 1"/></material>
<link name="base"><visual name="plinth"><geometry><box size="0.4 0.6 0.2"/></geometry><material name="red"/></visual>
  <collision><geometry><sphere radius="0.5"/></geometry></collision></link>
<link name="upper"><visual><origin xyz="0 0 0.5" rpy="0 0 0.3"/><geometry><cylinder radius="0.1" length="1"/></geometry>
  </visual></link>
<link name="tip"><visual><geometry><mesh filename="package://arm_description/meshes/tip.obj" scale="0.1 0.2 0.3"/>
  </geometry></visual><visual><geometry><cone radius="1" length="1"/></geometry></visual></link>
<link name="follower"><visual><geometry><sphere radius="0.05"/></geometry></visual></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
  <axis xyz="0 1 0"/><limit lower="-1" upper="1"/></joint>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="tip"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
  <limit lower="0" upper="0.5"/></joint>
<joint name="echo" type="continuous"><parent link="base"/><child link="follower"/><origin xyz="1 0 0"/>
  <axis xyz="0 0 1"/><mimic joint="shoulder" multiplier="2" offset="0.1"/></joint>
<gazebo reference="tip">{lidar}</gazebo></robot>"""


@pytest.fixture
def arm(tmp_path):
    pytest.importorskip("yourdfpy")
    meshes = tmp_path / "packages" / "arm_description" / "meshes"
    meshes.mkdir(parents=True)
    (meshes / "tip.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(lidar=sensor(tag="ray", kind="gpu_ray", pose="0.1 0 0.2 0 0 1.5707963267948966")))
    return file


def test_urdf_at_positions_of_its_joints(arm, tmp_path):
    with pytest.warns(UserWarning, match=r"leaves out .*no box, sphere, cylinder, capsule or mesh \(1\)") as told:
        robot = robotics.load(arm, search=[tmp_path / "packages"], classes={"tip": 4, "plinth": 2})
    assert len(told) == 1 and len(robot.left_out) == 1
    assert robot.frames == ["base", "upper", "tip", "follower"]
    assert robot.joint_limits == {"shoulder": (-1, 1), "slide": (0, 0.5)}
    assert [instance.class_id for instance in robot.scene.instances] == [2, 0, 4, 0]
    np.testing.assert_allclose(robot.scene.materials[0].base_color, (0.8, 0.1, 0.1, 1), rtol=1e-6)
    rows = robot.move({"shoulder": 0.5, "slide": 0.2})
    tip = np.array([1.2 * np.sin(0.5), 0, 0.1 + 1.2 * np.cos(0.5)])
    np.testing.assert_allclose(rows[2, :, 3], tip, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(rows[2, :, :3], axis=0), (0.1, 0.2, 0.3), atol=1e-12)
    np.testing.assert_allclose(rows[3, 0, :2], (np.cos(1.1), -np.sin(1.1)), atol=1e-12)  # 2 * 0.5 + 0.1
    mounted = robot.sensors[0]
    assert (mounted.name, mounted.frame, mounted.rate, mounted.sensor.beam_count()) == ("top", "tip", 10, 270)
    assert mounted.sensor.scan_period == 0.1
    turned = np.array([[np.cos(0.5), 0, np.sin(0.5)], [0, 1, 0], [-np.sin(0.5), 0, np.cos(0.5)]])
    np.testing.assert_allclose(robot.pose("top").position, tip + turned @ [0.1, 0, 0.2], atol=1e-12)
    np.testing.assert_allclose(adapter.rows_of(robot.pose())[:3, 0], turned @ [0, 1, 0], atol=1e-9)
    with pytest.raises(ValueError, match="there is no joint 'knee' that can be moved; there are shoulder, slide$"):
        robot.move({"knee": 1})
    for wrong, kind in (("high", ValueError), (None, TypeError)):
        with pytest.raises(kind, match=f"the position of the joint 'slide' must be a number, not {wrong!r}"):
            robot.move({"shoulder": 0.1, "slide": wrong})
    with pytest.raises(ValueError, match="the position of the joint 'slide' must be finite, is nan"):
        robot.move({"slide": float("nan")})
    assert robot.joints == {"shoulder": 0.5, "slide": 0.2}
    with pytest.warns(UserWarning, match=r"the joint 'slide' is at 0.7, beyond its limits 0..0.5") as told:
        robot.move({"shoulder": 1, "slide": 0.7})
    assert len(told) == 1 and told[0].filename == __file__
    assert robot.joints == {"shoulder": 1, "slide": 0.7}
    with pytest.raises(ValueError, match="there is no lidar 'front'; the file has top"):
        robot.lidar("front")


SDF = """<sdf version="1.9"><model name="m"><link name="base">{pose}<visual name="v"><geometry>{shape}</geometry>
</visual>{sensor}</link></model></sdf>"""

BALL = "<sphere><radius>1</radius></sphere>"


@pytest.mark.parametrize(
    ("pose", "shape", "sentence"),
    [
        ("<pose>0 0 nan 0 0 0</pose>", BALL, "a <pose> is '0 0 nan 0 0 0'; its numbers must be finite"),
        ("<pose>0 0 1 0 0</pose>", BALL, "a <pose> has 5 numbers; it must have 6"),
        ("<pose>0 0 x 0 0 0</pose>", BALL, "a <pose> is '0 0 x 0 0 0', which are no numbers"),
        ('<pose rotation_format="quat_xyzw">0 0 1 0 0 0</pose>', BALL, "a <pose> has 6 numbers; it must have 7"),
        ("", "<box><size>1 2</size></box>", "the <size> of a <box> has 2 numbers; it must have 3"),
        ("", "<plane><size>1 2 3</size></plane>", "the <size> of a <plane> has 3 numbers; it must have 2"),
        ("", "<plane><normal>0 0 0</normal></plane>", "a normal must have a length above 0"),
        ("", "<ellipsoid><radii>1</radii></ellipsoid>", "the <radii> of an <ellipsoid> has 1 numbers; it must have 3"),
    ],
)
def test_numbers_of_sdf_that_are_wrong(tmp_path, pose, shape, sentence):
    (tmp_path / "m.sdf").write_text(SDF.format(pose=pose, shape=shape, sensor=""))
    with pytest.raises(ValueError, match=re.escape(f"m.sdf: {sentence}")):
        robotics.load(tmp_path / "m.sdf")


def test_sizes_of_sdf_that_no_shape_has_are_left_out(tmp_path):
    (tmp_path / "m.sdf").write_text(SDF.format(pose="", shape="<box><size>1 1 -2</size></box>", sensor=""))
    with pytest.warns(UserWarning, match="leaves out a shape: the sizes of a box must be finite and not negative"):
        assert robotics.load(tmp_path / "m.sdf").frames == []


def test_noise_of_a_lidar_of_sdf_names_the_lidar_and_the_effect_that_gives_it(tmp_path):
    noise = "<noise><type>gaussian</type><mean>0</mean><stddev>0.02</stddev></noise>"
    noisy = sensor().replace("</scan>", "</scan>" + noise)
    (tmp_path / "m.sdf").write_text(SDF.format(pose="", shape="<box><size>1 1 1</size></box>", sensor=noisy))
    told = "noise of the lidar 'm::top', which the effect `range-noise` with sigma 0.02 gives"
    with pytest.warns(UserWarning, match=told):
        assert list(robotics.load(tmp_path / "m.sdf").left_out) == [told]


@pytest.mark.parametrize("form", ["sdf", "urdf"])
def test_a_sonar_of_sdf_and_of_urdf_is_told(tmp_path, form):
    if form == "urdf":
        pytest.importorskip("yourdfpy")
    inside = "<sonar><min>0.02</min><max>3</max><radius>0.5</radius></sonar>"
    sonar = f'<sensor name="us" type="sonar">{inside}</sensor><sensor name="eye" type="camera"/>'
    shape = "<box><size>1 1 1</size></box>"
    text = {
        "sdf": SDF.format(pose="", shape=shape, sensor=sensor() + sonar),
        "urdf": f'<robot name="r"><link name="base"/><gazebo reference="base">{sonar}</gazebo></robot>',
    }
    file = tmp_path / f"m.{form}"
    file.write_text(text[form])
    name = {"sdf": "m::us", "urdf": "us"}[form]
    told = f"the sonar '{name}', whose wide beam would be a list of beams: docs/limits.md"
    with pytest.warns(UserWarning, match=told):
        assert list(robotics.load(file).left_out) == [told]


def test_a_column_of_sdf_that_is_twice_there_is_told(tmp_path):
    """Both ends of a whole turn are beams in SDF, and look to the same side."""
    whole = sensor().replace("-1.57", "-3.14159265").replace("1.57", "3.14159265").replace(">90<", ">720<")
    shape = "<box><size>1 1 1</size></box>"
    (tmp_path / "m.sdf").write_text(SDF.format(pose="", shape=shape, sensor=whole))
    with pytest.warns(UserWarning, match="of 'm::top' the last column, which looks where the first does"):
        robot = robotics.load(tmp_path / "m.sdf")
    assert robot.sensors[0].sensor.columns == 719
    assert list(robot.left_out) == ["of 'm::top' the last column, which looks where the first does"]
    assert [what.partition(",")[0] for what in robot.assumed] == [
        "that a target of 10 % is seen up to the largest range"
    ] and robot.assumed[0].endswith(" (the lidar m::top)")


NESTED = """<sdf version="1.9"><model name="rover"><link name="base">{box}</link>
<model name="arm"><link name="upper">{box}</link><frame name="tip" attached_to="upper"><pose>0 0 1 0 0 0</pose></frame>
<model name="hand"><link name="palm">{box}</link><frame name="grip"/></model>
<joint name="wrist" type="fixed"><parent>tip</parent><child>hand</child></joint></model>
<frame name="mark" attached_to="arm::tip"/>
<joint name="lift" type="prismatic"><parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
<link name="tool"><pose relative_to="arm::tip"/>{box}</link>
<joint name="fix" type="fixed"><parent>{parent}</parent><child>tool</child></joint></model></sdf>"""

BOX = '<visual name="v"><geometry><box><size>.2 .2 .2</size></box></geometry></visual>'


@pytest.mark.parametrize(
    "parent", ("arm::upper", "arm::tip", "arm", "mark", "arm::hand", "arm::hand::grip", "lift", "arm::wrist")
)
def test_joints_of_sdf_whose_parents_are_in_models_inside(tmp_path, parent):
    (tmp_path / "m.sdf").write_text(NESTED.format(box=BOX, parent=parent))
    robot = quiet(tmp_path / "m.sdf", joints={"lift": 2.0})
    heights = {frame: points.mean(axis=0)[2] for frame, points in zip(robot.frames, corners(robot))}
    expected = {"rover::base": 0, "rover::arm::upper": 2, "rover::arm::hand::palm": 2, "rover::tool": 3}
    assert heights == pytest.approx(expected, abs=1e-6)


def test_a_joint_of_sdf_whose_parent_is_not_there_is_told(tmp_path):
    for parent in ("arm::elbow", "elbow"):
        (tmp_path / "m.sdf").write_text(NESTED.format(box=BOX, parent=parent))
        with pytest.warns(UserWarning, match=f"the joint rover::fix, whose parent '{parent}' is not there"):
            assert len(robotics.load(tmp_path / "m.sdf").frames) == 4
    circle = NESTED.replace('attached_to="arm::tip"', 'attached_to="mark"')
    (tmp_path / "m.sdf").write_text(circle.format(box=BOX, parent="mark"))
    with pytest.raises(ValueError, match="the frame 'mark' is attached to itself"):
        robotics.load(tmp_path / "m.sdf")


def test_a_joint_of_sdf_with_the_name_of_a_link(tmp_path):
    (tmp_path / "m.sdf").write_text(
        f"""<sdf version="1.5"><model name="m"><joint name="arm" type="prismatic"><parent>base</parent>
        <child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
        <link name="base">{BOX}</link><link name="arm">{BOX}</link></model></sdf>"""
    )
    with pytest.raises(ValueError, match="there is no joint 'am' that can be moved; there is arm$"):
        robotics.load(tmp_path / "m.sdf", joints={"am": 2.0})
    heights = [points.mean(axis=0)[2] for points in corners(quiet(tmp_path / "m.sdf", joints={"arm": 2.0}))]
    assert heights == pytest.approx([0, 2], abs=1e-6)


@pytest.mark.parametrize("version", ("1.3", "1.4", "1.5", "1.9"))
@pytest.mark.parametrize("included", (False, True))
def test_axes_of_sdf_1_4_are_in_the_frame_of_the_model(tmp_path, version, included):
    """A joint along z of a link that is turned about x, in a model that is turned about z."""
    model = f"""<model name="m"><link name="a">{BOX}</link><link name="b"><pose>0 0 0 1.5707963267948966 0 0</pose>{BOX}
        </link><joint name="j" type="prismatic"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
        {{}}</model>"""
    pose = "<pose>0 0 0 0 0 1.5707963267948966</pose>"
    file = tmp_path / "m.sdf"
    file.write_text(f'<sdf version="{version}">{model.format("" if included else pose)}</sdf>')
    if included:
        file = tmp_path / "w.sdf"
        file.write_text(f'<sdf version="1.9"><world name="w"><include><uri>m.sdf</uri>{pose}</include></world></sdf>')
    moved = corners(quiet(file, joints={"j": 1.0}))[1].mean(axis=0)
    expected = (0, 0, 1) if version < "1.5" else (1, 0, 0)
    np.testing.assert_allclose(moved, expected, atol=1e-6)


def test_things_of_sdf_with_one_name_have_places_of_their_own(tmp_path):
    part = f"""<model name="part"><pose>0 {{}} 0 0 0 0</pose><link name="l">{BOX}</link><link name="l">
        <pose>0 0 1 0 0 0</pose>{BOX}</link></model>"""
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9">{part.format(0)}</sdf>')
    include = "<include><uri>part.sdf</uri><pose>0 4 0 0 0 0</pose></include>"
    joints = "".join(
        f"""<joint name="j" type="prismatic"><parent>part::l</parent><child>{child}</child><axis><xyz>1 0 0</xyz></axis>
        </joint>"""
        for child in ("part::l 2", "part 2::l")
    )
    (tmp_path / "w.sdf").write_text(
        f'<sdf version="1.9"><model name="m">{include}{part.format(2)}{part.format(3)}{joints}</model></sdf>'
    )
    with pytest.warns(UserWarning, match="leaves out the name 'l' of another link, which is 'l 2' here"):
        robot = robotics.load(tmp_path / "w.sdf", joints={"j": 5.0, "j 2": 6.0})
    assert robot.left_out == {
        "the name 'l' of another link, which is 'l 2' here": 3,
        "the name 'part' of another model, which is 'part 2' here": 1,
        "the name 'part' of another model, which is 'part 3' here": 1,
        "the name 'j' of another joint, which is 'j 2' here": 1,
    }
    places = {frame: points.mean(axis=0) for frame, points in zip(robot.frames, corners(robot))}
    expected = {
        "m::part::l": (0, 2, 0), "m::part::l 2": (5, 2, 1), "m::part 2::l": (6, 3, 0), "m::part 2::l 2": (0, 3, 1),
        "m::part 3::l": (0, 4, 0), "m::part 3::l 2": (0, 4, 1),
    }  # fmt: skip
    assert places.keys() == expected.keys()
    for frame, place in expected.items():
        np.testing.assert_allclose(places[frame], place, atol=1e-6)


def test_a_submesh_is_an_object_of_an_obj(tmp_path):
    pieces = [f"o {name}\nv 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\n" for name, z in (("low", 0), ("high", 2))]
    (tmp_path / "parts.obj").write_text("".join(pieces))
    text = """<sdf version="1.9"><model name="m"><link name="l"><visual name="v"><geometry><mesh><uri>parts.obj</uri>
        <submesh><name>{}</name></submesh></mesh></geometry></visual></link></model></sdf>"""
    (tmp_path / "m.sdf").write_text(text.format("high"))
    (points,) = corners(quiet(tmp_path / "m.sdf"))
    assert sorted(points.tolist()) == [[0, 0, 2], [0, 1, 2], [1, 0, 2]]
    (tmp_path / "m.sdf").write_text(text.format("middle"))
    with pytest.warns(UserWarning, match=r"leaves out the mesh parts.obj, which has no triangles in 'middle' \(1\)"):
        assert not robotics.load(tmp_path / "m.sdf").frames


def test_a_laser_retro_is_told(tmp_path):
    retro = BOX.replace("</visual>", "<laser_retro>100</laser_retro></visual>")
    for visual, left_out in ((BOX, {}), (retro, {"<laser_retro>, whose scale is the simulator's": 1})):
        text = f'<sdf version="1.9"><model name="m"><link name="l">{visual}</link></model></sdf>'
        (tmp_path / "m.sdf").write_text(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert robotics.load(tmp_path / "m.sdf").left_out == left_out


def test_what_a_world_has_besides_its_models_is_told(tmp_path):
    """The poses of Gazebo Classic's <state> would replace those of models; particles would scatter beams."""
    emitter = '<particle_emitter name="smoke" type="box"/>'
    model = f'<model name="m"><link name="l">{BOX}{2 * emitter}</link></model>'
    state = '<state world_name="w"><model name="m"><pose>9 0 0 0 0 0</pose></model></state>'
    text = f'<sdf version="1.9"><world name="w">{model}{state}{emitter}<actor name="a"/></world></sdf>'
    (tmp_path / "w.sdf").write_text(text)
    with pytest.warns(UserWarning, match="leaves out "):
        world = robotics.load(tmp_path / "w.sdf")
    assert world.left_out == {"<particle_emitter>": 3, "<actor>": 1, "<state>": 1}
    np.testing.assert_allclose(corners(world)[0].mean(axis=0), 0, atol=1e-6)


def chain_of_mimics(kind, first="j"):
    """Links a, b, c and d, each on the one before; the joint k mimics `first`, and l mimics k."""
    links = "abcd"
    if kind == "urdf":
        shape = '<visual><geometry><box size=".1 .1 .1"/></geometry></visual>'
        joint = """<joint name="{}" type="prismatic"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>
            <limit lower="-9" upper="9" effort="1" velocity="1"/>{}</joint>"""
        mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'
        text = '<robot name="m">{}</robot>'
    else:
        shape = BOX
        joint = """<joint name="{}" type="prismatic"><parent>{}</parent><child>{}</child>
            <axis><xyz>0 0 1</xyz>{}</axis></joint>"""
        mimic = '<mimic joint="{}"><multiplier>{}</multiplier><offset>{}</offset></mimic>'
        text = '<sdf version="1.11"><model name="m">{}</model></sdf>'
    body = "".join(f'<link name="{link}">{shape}</link>' for link in links)
    body += joint.format("j", "a", "b", "") + joint.format("k", "b", "c", mimic.format(first, 2, 0.5))
    return text.format(body + joint.format("l", "c", "d", mimic.format("k", 3, 0.25)))


@pytest.mark.parametrize("kind", ("urdf", "sdf"))
def test_a_mimic_of_a_mimic(tmp_path, kind):
    if kind == "urdf":
        pytest.importorskip("yourdfpy")
    file = tmp_path / f"m.{kind}"
    file.write_text(chain_of_mimics(kind))
    robot = quiet(file, joints={"j": 1.0})
    heights = [points.mean(axis=0)[2] for points in corners(robot)]
    assert heights == pytest.approx([0, 1, 1 + 2.5, 1 + 2.5 + 7.75], abs=1e-6)
    for first, sentence in (
        ("nope", "the motion of the joint '.*k', which mimics '.*nope', which is not there"),
        ("l", "the motion of the joint '.*k', which mimics joints in a circle"),
    ):
        file.write_text(chain_of_mimics(kind, first))
        with pytest.warns(UserWarning, match=sentence):
            robot = robotics.load(file, joints={"j": 1.0})
        assert len(robot.left_out) == 2  # the other one is l


def test_a_material_of_urdf_that_a_visual_defines_for_others(tmp_path):
    pytest.importorskip("yourdfpy")
    shape = '<visual><geometry><{}/></geometry><material name="{}">{}</material></visual>'
    ink = '<color rgba="0.25 0.5 0.75 1"/>'
    (tmp_path / "m.urdf").write_text(
        '<robot name="m"><material name="red"><color rgba="1 0 0 1"/></material><link name="a">'
        + shape.format('box size="1 1 1"', "ink", "")
        + shape.format('capsule radius="1" length="1"', "ink", "")
        + shape.format('box size="2 2 2"', "ink", ink)
        + shape.format('box size="3 3 3"', "red", '<color rgba="0 1 0 1"/>')
        + shape.format('box size="4 4 4"', "red", "")
        + "</link></robot>"
    )
    scene = quiet(tmp_path / "m.urdf").scene
    colors = [scene.materials[scene.meshes[i.mesh].parts[0].material].base_color[:3] for i in scene.instances]
    blue = (0.25, 0.5, 0.75)
    assert colors == [blue, blue, (0, 1, 0), (1, 0, 0), blue]  # capsules are last


@pytest.mark.parametrize(
    "ends, sentence",
    (
        ('<parent link="a"/><child link="nope"/>', "the joint 'j' has the child 'nope', which is no link"),
        ('<parent link="nope"/><child link="a"/>', "the joint 'j' has the parent 'nope', which is no link"),
        ('<parent link="a"/>', "the joint 'j' has no <child> link"),
    ),
)
def test_a_joint_of_urdf_without_its_links(tmp_path, ends, sentence):
    pytest.importorskip("yourdfpy")
    file = tmp_path / "m.urdf"
    joint = f'<joint name="j" type="fixed">{ends}</joint>'
    file.write_text(f'<robot name="m"><link name="a"/><link name="b"/>{joint}</robot>')
    with pytest.raises(ValueError, match=f"m.urdf: {sentence}"):
        robotics.load(file)


@pytest.mark.parametrize("kind, refused", (("revolute", True), ("prismatic", True), ("fixed", False)))
def test_a_joint_of_urdf_that_moves_needs_an_axis_with_a_direction(tmp_path, kind, refused):
    pytest.importorskip("yourdfpy")
    file = tmp_path / "m.urdf"
    ends = '<parent link="a"/><child link="b"/><limit lower="0" upper="1" effort="1" velocity="1"/><axis xyz="0 0 0"/>'
    joint = f'<joint name="j" type="{kind}">{ends}</joint>'
    file.write_text(f'<robot name="m"><link name="a"/><link name="b"/>{joint}</robot>')
    if refused:
        with pytest.raises(ValueError, match="m.urdf: the axis of the joint 'j' is 0 0 0, which has no direction"):
            robotics.load(file)
    else:
        assert not robotics.load(file).joint_limits


def test_the_world_of_urdf_need_not_be_a_link(tmp_path):
    pytest.importorskip("yourdfpy")
    for world in ("", '<link name="world"/>'):
        (tmp_path / "m.urdf").write_text(
            f"""<robot name="m"><link name="a"><visual><geometry><box size="1 1 1"/></geometry></visual></link>{world}
            <joint name="j" type="fixed"><parent link="world"/><child link="a"/><origin xyz="3 0 0"/></joint></robot>"""
        )
        np.testing.assert_allclose(corners(quiet(tmp_path / "m.urdf"))[0].mean(axis=0), (3, 0, 0), atol=1e-6)


def test_elements_of_xacro_are_told(tmp_path):
    pytest.importorskip("yourdfpy")
    file = tmp_path / "m.urdf"
    names = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    link = '<link name="a"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
    file.write_text(f'<robot name="m" {names}>{link}</robot>')
    quiet(file)
    file.write_text(f'<robot name="m" {names}>{link}<xacro:include filename="b.xacro"/><xacro:wheel/></robot>')
    with pytest.warns(UserWarning, match=r"elements of xacro, which 'xacro m.urdf > robot.urdf' replaces \(2\)"):
        assert len(robotics.load(file).frames) == 1


CARELESS = """

<!-- a licence --><?xml version="1.0"?>
<robot><link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
<link name="limb"><visual><origin xyz="0 0 1" rpy="1.5707963267948966 0 0"/><geometry><capsule radius="0.2" length="1"/>
  </geometry><material name="skin"><color rgba="1 0.5 0.25 1"/></material></visual></link>
<link name="island"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
<joint name="hip" type="spherical"><parent link="base"/><child link="limb"/><origin xyz="0 0 2"/></joint>
<joint name="wheel" type="continuous"><parent link="limb"/><child link="foot"/><axis xyz="0 0 1"/>
  <limit drake:acceleration="2" effort="1" velocity="1"/></joint><link name="foot"/>
<transmission><type>none</type></transmission></robot>\n\0"""


def test_urdf_as_its_users_write_it(tmp_path):
    """A comment before the declaration, a prefix without one, no name, a capsule, a spherical joint, an island."""
    pytest.importorskip("yourdfpy")
    (tmp_path / "careless.urdf").write_text(CARELESS)
    with pytest.warns(UserWarning, match="the motion of spherical joints") as told:
        robot = robotics.load(tmp_path / "careless.urdf")
    assert len(told) == 1 and len(robot.left_out) == 2
    assert robot.left_out["the places of links that no joint joins to the others"] == 1
    assert set(robot.joint_limits) == {"wheel"}
    placed = dict(zip(robot.frames, corners(robot)))
    np.testing.assert_allclose(
        [placed["limb"].min(axis=0), placed["limb"].max(axis=0)], [[-0.2, -0.7, 2.8], [0.2, 0.7, 3.2]], atol=1e-3
    )
    np.testing.assert_allclose(np.abs(placed["island"]).max(axis=0), 0.1, atol=1e-3)
    assert (1, 0.5, 0.25, 1) in [tuple(material.base_color) for material in robot.scene.materials]


def test_a_lidar_sees_what_it_is_not_mounted_on(arm, tmp_path, device):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = robotics.load(arm, search=[tmp_path / "packages"], joints={"shoulder": 1.5707963267948966})
    lidar = robot.lidar(
        everywhere(5000), ignore=["tip", "upper"], effects=NONE, options=gnosphere.SimulatorOptions(device)
    )
    scan = lidar.cast(gnosphere.Shot(gnosphere.Pose((0.9, 0.6, 0.3))))
    assert set(scan.instances[~np.isnan(scan.ranges)].tolist()) == {0, 3}
    follower = np.linalg.norm(scan.points[scan.instances == 3] + [0.9, 0.6, 0.3] - [1, 0, 0], axis=1)
    assert np.abs(follower - 0.05).max() < 1.1e-3
    with pytest.raises(ValueError, match="nothing can be seen on wheel"):
        robot.lidar("top", ignore=["wheel"])


def test_what_is_not_there_is_told(arm):
    with pytest.warns(UserWarning, match=r"the mesh package://arm_description/meshes/tip.obj, which is not found"):
        robotics.load(arm)
    assert quiet(arm, collisions=True).frames == ["base"]


def test_files_of_no_robot_are_refused(tmp_path):
    for name, text, message in (
        ("a.urdf", "<html/>", "is XML of <html>"), ("b.txt", "solid", "neither USD by its ending nor XML"),
        ("c.xacro", "<robot/>", "run 'xacro c.xacro > robot.urdf' first"),
    ):  # fmt: skip
        (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match=message):
            robotics.load(tmp_path / name)


def test_every_robot_of_a_folder():
    """Whatever the folder GNOSPHERE_MODELS has is read with one warning at most, or refused with a sentence."""
    if "GNOSPHERE_MODELS" not in os.environ:
        pytest.skip("GNOSPHERE_MODELS names no folder")
    counts = {"whole": 0, "with a warning": 0, "refused": 0}
    for file in sorted(Path(os.environ["GNOSPHERE_MODELS"]).rglob("*")):
        if file.suffix not in (".urdf", ".sdf", ".world", ".usd", ".usda", ".usdc", ".usdz"):
            continue
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                robotics.load(file)
            except ValueError as error:
                assert str(file) in str(error)
                counts["refused"] += 1
                continue
        ours = [each for each in told if "leaves out" in str(each.message)]
        assert len(ours) <= 1, file
        counts["with a warning" if ours else "whole"] += 1
    print(counts)
    assert counts["whole"] and counts["refused"] <= 0.02 * sum(counts.values())


ROUND = {"sphere", "cylinder"}


def robots():
    """Public URDF robots of the packages pybullet and example-robot-data, where those are installed."""
    found = []
    try:
        import pybullet_data

        root = Path(pybullet_data.getDataPath())
        names = (
            "r2d2.urdf", "kuka_iiwa/model.urdf", "racecar/racecar.urdf", "quadruped/minitaur.urdf",
            "franka_panda/panda.urdf", "xarm/xarm6_robot.urdf", "table/table.urdf", "a1/a1.urdf",
        )  # fmt: skip
        found = [root / name for name in names]
    except ImportError:
        pass
    return [pytest.param(file, id=file.name) for file in found if file.is_file()]


@pytest.mark.parametrize("file", robots())
def test_robots_against_rays_of_trimesh_and_links_of_bullet(file, device):
    yourdfpy, trimesh = pytest.importorskip("yourdfpy"), pytest.importorskip("trimesh")
    pb = pytest.importorskip("pybullet")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = robotics.load(file)
    rng = np.random.default_rng(1)
    joints = {name: rng.uniform(max(low, -1), min(high, 1)) for name, (low, high) in robot.joint_limits.items()}
    rows = robot.move(joints)

    # Where Bullet has the links.
    client = pb.connect(pb.DIRECT)
    try:
        body = pb.loadURDF(str(file), useFixedBase=True, flags=pb.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client)
        places = {}
        for joint in range(pb.getNumJoints(body, client)):
            info = pb.getJointInfo(body, joint, client)
            if info[1].decode() in joints:
                pb.resetJointState(body, joint, joints[info[1].decode()], physicsClientId=client)
        base = pb.getDynamicsInfo(body, -1, client)[3:5]
        undone = pb.invertTransform(*base)
        origin = pb.multiplyTransforms(*pb.getBasePositionAndOrientation(body, client), *undone)
        for joint in range(pb.getNumJoints(body, client)):
            state = pb.getLinkState(body, joint, computeForwardKinematics=True, physicsClientId=client)
            name = pb.getJointInfo(body, joint, client)[12].decode()
            places[name] = pb.multiplyTransforms(*pb.invertTransform(*origin), *state[4:6])
    finally:
        pb.disconnect(client)
    followers = {joint.child for joint in yourdfpy.URDF.load(str(file), load_meshes=False).robot.joints if joint.mimic}
    for name, (position, _) in places.items():
        if name not in followers:  # Bullet moves no joint that mimics another
            np.testing.assert_allclose(robot._now[name][:3, 3], position, atol=2e-5)

    # The hits of trimesh's rays on the model that yourdfpy makes.
    finder = Resources(file, (), Parts(), 1e-3)
    model = yourdfpy.URDF.load(str(file), filename_handler=lambda fname: str(finder.find(fname)))
    model.update_cfg(joints)
    whole = model.scene.to_mesh()
    middle, size = whole.bounds.mean(axis=0), np.ptp(whole.bounds, axis=0)
    eye = middle + [1.3 * size.max(), 0.4 * size.max(), 0.7 * size.max()]
    directions = middle + rng.uniform(-0.5, 0.5, (20000, 3)) * size - eye
    sensor = gnosphere.Sensor()
    sensor.range_max = 10 * float(size.max())
    sensor.patterns = [gnosphere.BeamList(directions / np.linalg.norm(directions, axis=1, keepdims=True))]
    lidar = robot.lidar(sensor, effects=NONE, options=gnosphere.SimulatorOptions(device))
    lidar.move(rows)
    scan = lidar.cast(gnosphere.Shot(gnosphere.Pose(tuple(eye.tolist()))))
    directions = gnosphere.beams_of(sensor).directions
    places, beams, _ = whole.ray.intersects_location(
        np.tile(eye, (len(directions), 1)), directions, multiple_hits=False
    )
    theirs = np.full(len(directions), np.nan)
    theirs[beams] = np.linalg.norm(places - eye, axis=1)
    both = ~np.isnan(theirs) & ~np.isnan(scan.ranges)
    error = np.abs(scan.ranges - theirs)[both] / size.max()
    assert both.sum() > 1000
    if not ROUND & {mesh.name for mesh in robot.scene.meshes}:
        assert np.array_equal(np.isnan(theirs), np.isnan(scan.ranges)) and np.quantile(error, 0.999) < 2e-6
    else:  # round shapes have other sides there
        assert (np.isnan(theirs) == np.isnan(scan.ranges)).mean() > 0.995 and np.median(error) < 1e-3


def test_robots_of_packages_with_their_lidars():
    pytest.importorskip("yourdfpy")
    root = next((Path(path) / "cmeel.prefix/share/example-robot-data/robots" for path in sys.path
                 if (Path(path) / "cmeel.prefix/share/example-robot-data").is_dir()), None)  # fmt: skip
    if root is None:
        pytest.skip("example-robot-data is not installed")
    for file in ("xarm_description/urdf/xarm7.urdf", "finger_edu_description/robots/finger_edu.urdf"):
        assert len(quiet(root / file).frames) > 5
    with pytest.warns(UserWarning, match="noise of the lidar 'base_rear_laser'"):
        tiago = robotics.load(root / "tiago_pro_description/robots/tiago_pro.urdf")
    lidars = {mounted.name: (mounted.frame, mounted.sensor.beam_count(), mounted.rate) for mounted in tiago.sensors}
    assert lidars == {f"base_{side}_laser": (f"base_{side}_laser_link", 818, 10) for side in ("rear", "front")}
    assert all("lidar" in what or "ranges" in what for what in tiago.left_out)  # no mesh is missing


WORLD = """<sdf version="1.9"><world name="yard">
<include><uri>model://cart</uri><name>first</name><pose degrees="true">2 1 0 0 0 90</pose></include>
<include><uri>model://cart</uri><pose relative_to="mark">1 0 0 0 0 0</pose></include>
<include><uri>model://missing</uri></include>
<frame name="mark"><pose>0 5 0 0 0 0</pose></frame>
<model name="ground"><static>true</static><link name="link"><visual name="floor"><geometry><plane><normal>0 0 1</normal>
  <size>40 40</size></plane></geometry><material><diffuse>0.2 0.3 0.4 1</diffuse></material></visual></link></model>
<model name="wall"><pose>6 0 1 0 0 0</pose><link name="link"><visual name="v"><geometry><box><size>0.2 8 2</size></box>
  </geometry><transparency>0.25</transparency></visual></link></model>
<actor name="walker"/><light name="sun" type="directional"/></world></sdf>"""

CART = """<sdf version="1.9"><model name="cart">
<frame name="deck"><pose>0 0 0.5 0 0 0</pose></frame>
<link name="body"><pose relative_to="deck"/><visual name="box"><geometry><box><size>1 0.6 0.2</size></box></geometry>
  </visual>{lidar}</link>
<link name="wheel"><pose relative_to="deck">0.3 0.4 -0.3 -1.5707963267948966 0 0</pose>
  <visual name="tyre"><pose>0 0 0.1 0 0 0</pose>
  <geometry><cylinder><radius>0.2</radius><length>0.1</length></cylinder></geometry></visual></link>
<joint name="axle" type="revolute"><parent>body</parent><child>wheel</child><axis><xyz>0 0 1</xyz></axis></joint>
<model name="mast"><pose relative_to="body">0 0 0.1 0 0 0</pose><link name="pole"><visual name="cone"><geometry><cone>
  <radius>0.1</radius><length>1</length></cone></geometry></visual></link></model>
<joint name="lift" type="prismatic"><parent>body</parent><child>mast::pole</child><axis>
  <xyz expressed_in="deck">0 0 1</xyz>
  <limit><lower>0</lower><upper>1</upper></limit></axis></joint></model></sdf>"""


@pytest.fixture
def yard(tmp_path):
    cart = tmp_path / "models" / "cart"
    cart.mkdir(parents=True)
    (cart / "model.config").write_text(
        "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.9'>model.sdf</sdf>"
        "<sdf version='1.10'>none.sdf</sdf></model>"
    )
    (cart / "model.sdf").write_text(CART.format(lidar=sensor("head", pose="0 0 0.3 0 0 0")))
    (tmp_path / "yard.sdf").write_text(WORLD)
    return tmp_path / "yard.sdf"


def test_sdf_worlds_with_models_frames_and_joints(yard):
    with pytest.warns(UserWarning) as told:
        world = robotics.load(yard, search=[yard.parent / "models"], classes={"wall*": 7})
    assert world.left_out == {"the model model://missing, which is not found": 1, "<actor>": 1}
    assert len(told) == 1
    places = {frame: row[:, 3] for frame, row in zip(world.frames, world.move({}))}
    assert set(places) == {
        "ground::link", "wall::link", "first::body", "first::wheel", "first::mast::pole",
        "cart::body", "cart::wheel", "cart::mast::pole",
    }  # fmt: skip
    np.testing.assert_allclose(places["first::body"], (2, 1, 0.5), atol=1e-12)
    np.testing.assert_allclose(places["first::mast::pole"], (2, 1, 0.6), atol=1e-12)
    np.testing.assert_allclose(places["cart::body"], (1, 5, 0.5), atol=1e-12)
    # The wheel is placed 0.3 forward and 0.4 to the left, and its tyre 0.1 further along its turned z axis.
    np.testing.assert_allclose(places["first::wheel"], (2 - 0.5, 1 + 0.3, 0.2), atol=1e-12)
    assert [instance.class_id for instance in world.scene.instances].count(7) == 1
    assert world.scene.materials[world.scene.meshes[1].parts[0].material].base_color[3] == 0.75
    assert [mounted.name for mounted in world.sensors] == ["first::head", "cart::head"]
    np.testing.assert_allclose(world.pose("first::head").position, (2, 1, 0.8), atol=1e-12)
    assert set(world.joint_limits) == {"first::axle", "first::lift", "cart::axle", "cart::lift"}
    moved = dict(zip(world.frames, world.move({"first::lift": 0.4, "first::axle": np.pi / 2})))
    np.testing.assert_allclose(moved["first::mast::pole"][:, 3], (2, 1, 1.0), atol=1e-12)
    np.testing.assert_allclose(moved["first::wheel"][:, 3], places["first::wheel"], atol=1e-12)  # about its own axis
    # The wheel's x looks forward, which is y in the world; a quarter of a turn about its z, to the left, takes it down.
    np.testing.assert_allclose(moved["first::wheel"][:, 0], (0, 0, -1), atol=1e-12)
    np.testing.assert_allclose(moved["cart::mast::pole"][:, 3], places["cart::mast::pole"], atol=1e-12)


def test_a_scan_of_an_sdf_world(yard, device):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        world = robotics.load(yard, search=[yard.parent / "models"])
    lidar = world.lidar("cart::head", effects=NONE, options=gnosphere.SimulatorOptions(device))
    scan = lidar.cast(world.shot("cart::head"))
    points = scan.points[~np.isnan(scan.ranges)] + np.array(world.pose("cart::head").position)
    on_wall = np.array(world.frames)[scan.instances[~np.isnan(scan.ranges)]] == "wall::link"
    front = on_wall & (np.abs(points[:, 1]) < 3.99)  # the others are on its side
    assert front.sum() > 60 and np.abs(points[front][:, 0] - 5.9).max() < 1e-5


def test_sdf_in_a_circle_is_refused(tmp_path):
    (tmp_path / "a.sdf").write_text("<sdf><model name='a'><include><uri>a.sdf</uri></include></model></sdf>")
    with pytest.raises(ValueError, match="a.sdf includes itself"):
        robotics.load(tmp_path / "a.sdf")
    (tmp_path / "b.sdf").write_text(
        "<sdf><model name='b'><frame name='x'><pose relative_to='y'/></frame>"
        "<frame name='y'><pose relative_to='x'/></frame>"
        "<link name='l'><pose relative_to='x'/></link></model></sdf>"
    )
    with pytest.raises(ValueError, match="b.sdf: the pose of 'x' is relative to itself"):
        robotics.load(tmp_path / "b.sdf")


def test_models_of_sdf_that_double_are_refused(tmp_path):
    include = "<include><uri>m{}.sdf</uri></include>"
    for number in range(16):
        (tmp_path / f"m{number}.sdf").write_text(f"<sdf><model name='m'>{2 * include.format(number + 1)}</model></sdf>")
    (tmp_path / "m16.sdf").write_text("<sdf><model name='m'/></sdf>")
    with pytest.raises(ValueError, match="more than 10,000 models are included"):
        quiet(tmp_path / "m0.sdf")


def test_models_of_sdf_that_are_nested_too_deep_are_refused(tmp_path):
    (tmp_path / "m.sdf").write_text("<sdf>" + "<model name='m'>" * 3000 + "</model>" * 3000 + "</sdf>")
    with pytest.raises(ValueError, match="nested too deep"):
        quiet(tmp_path / "m.sdf")


@pytest.mark.parametrize("name", ["robot", "é:robot"])  # the second has a prefix that nobody declares
def test_the_time_of_comments_before_a_robot_does_not_double_with_each(tmp_path, name):
    text = "<!--a-->" * 60 + f"<{name} name='r'><link name='l'/></{name}>"
    (tmp_path / "m.urdf").write_text(text, encoding="utf-8")
    if name == "robot":
        assert parse_xml(tmp_path / "m.urdf").tag == "robot"
    else:
        with pytest.raises(ET.ParseError):
            parse_xml(tmp_path / "m.urdf")


def test_archives_are_no_meshes(tmp_path):
    (tmp_path / "bomb.zip").write_bytes(b"PK")
    (tmp_path / "m.sdf").write_text(SDF.format(pose="", shape="<mesh><uri>bomb.zip</uri></mesh>", sensor=""))
    with pytest.warns(UserWarning, match="bomb.zip is of no kind that is read"):
        assert robotics.load(tmp_path / "m.sdf").frames == []



def test_sdf_against_links_of_bullet():
    pb, data = pytest.importorskip("pybullet"), pytest.importorskip("pybullet_data")
    file = Path(data.getDataPath()) / "kuka_iiwa" / "kuka_with_gripper2.sdf"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = robotics.load(file)
    angles = {f"J{i}": 0.3 * (-1) ** i + 0.1 * i for i in range(7)}
    robot.move(angles)
    client = pb.connect(pb.DIRECT)
    try:
        body = pb.loadSDF(str(file), physicsClientId=client)[0]
        for joint in range(pb.getNumJoints(body, client)):
            name = pb.getJointInfo(body, joint, client)[1].decode()
            pb.resetJointState(body, joint, angles.get(name, 0), physicsClientId=client)
        undone = pb.invertTransform(*pb.getDynamicsInfo(body, -1, client)[3:5])
        origin = pb.multiplyTransforms(*pb.getBasePositionAndOrientation(body, client), *undone)
        base = next(iter(robot._now.values()))
        compared = 0
        for joint in range(pb.getNumJoints(body, client)):
            state = pb.getLinkState(body, joint, computeForwardKinematics=True, physicsClientId=client)
            link = pb.getJointInfo(body, joint, client)[12].decode()
            position, _ = pb.multiplyTransforms(*pb.invertTransform(*origin), *state[4:6])
            found = [place for name, place in robot._now.items() if name.endswith(f"::{link}")]
            np.testing.assert_allclose((np.linalg.inv(base) @ found[0])[:3, 3], position, atol=2e-5)
            compared += 1
        assert compared > 7
    finally:
        pb.disconnect(client)


def test_the_longest_pattern_of_a_class_counts(tmp_path):
    """As in drive files, where a lamp of a street is no street."""
    box = "<visual name='v'><geometry><box><size>1 1 1</size></box></geometry></visual>"
    links = "".join(f"<link name='{name}'>{box}</link>" for name in ("street 1", "street lamp 1"))
    file = tmp_path / "street.sdf"
    file.write_text(f"<sdf version='1.9'><model name='m'>{links}</model></sdf>")
    classes = {"*street *": 40, "*street lamp *": 80}
    for order in (classes, dict(reversed(classes.items()))):
        assert [instance.class_id for instance in quiet(file, classes=order).scene.instances] == [40, 80]


def test_tolerances_are_finite_and_above_0(tmp_path):
    file = tmp_path / "ball.sdf"
    sphere = "<sphere><radius>1</radius></sphere>"
    file.write_text(f"<sdf version='1.9'><model name='m'><link name='l'><visual name='v'><geometry>{sphere}</geometry>"
                    "</visual></link></model></sdf>")  # fmt: skip
    for tolerance in (0, -1, float("nan")):
        with pytest.raises(ValueError, match=f"the tolerance must be finite and above 0 m, not {tolerance}"):
            robotics.load(file, tolerance=tolerance)
    with pytest.warns(UserWarning, match="leaves out a shape: the tolerance 1e-17 m is finer than single precision"):
        robotics.load(file, tolerance=1e-17)


def test_mjcf_against_its_own_rays(tmp_path, device):
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "gate.xml"
    file.write_text(
        """<mujoco><worldbody><geom type="plane" size="20 20 .1"/><body name="arm" pos="1 0 1">
        <joint name="hinge" axis="0 1 0"/>
        <geom name="bar" type="box" size=".5 .1 .1" pos=".5 0 0"/><site name="eye" pos="1.1 0 0" euler="0 90 0"/></body>
        <body name="post" pos="4 0 1"><geom type="box" size=".1 2 1"/></body></worldbody>
        <sensor><rangefinder site="eye"/></sensor></mujoco>"""
    )
    robot = quiet(file, classes={"post": 3})
    assert robot.frames == ["world", "arm", "post"] and list(robot.joint_limits) == ["hinge"]
    assert [instance.class_id for instance in robot.scene.instances] == [0, 0, 3]
    lidar = robot.lidar(effects=NONE, ignore=["arm"], options=gnosphere.SimulatorOptions(device))
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    for angle in (0.0, 0.2, 0.9):
        lidar.move(robot.move({"hinge": angle}))
        data.qpos[0] = angle
        mujoco.mj_forward(model, data)
        assert abs(lidar.cast(robot.shot()).ranges[0] - data.sensordata[0]) < 1e-5


def new_stage(file, up="Z", unit=1.0):
    """An empty stage in a file, which its root layer saves."""
    from pxr import Usd, UsdGeom

    made = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(made, UsdGeom.Tokens.y if up == "Y" else UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(made, unit)
    return made


def stage(tmp_path, up="Z", unit=1.0):
    """A stage with every kind of prim that is read."""
    pxr = pytest.importorskip("pxr")
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

    assert pxr
    file = tmp_path / f"stage{up}{unit}.usda"
    made = new_stage(file, up, unit)
    root = UsdGeom.Xform.Define(made, "/World")
    root.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    mesh = UsdGeom.Mesh.Define(made, "/World/Thing/Hull")
    # A square, a triangle, and a concave polygon whose fan would be wrong.
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (3, 0, 0), (5, 0, 0), (5, 2, 0), (4, 0.5, 0), (3, 2, 0)]
    mesh.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*point) for point in points]))
    mesh.CreateFaceVertexCountsAttr([4, 3, 5])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 2, 6, 7, 8, 4, 5])
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.AddRotateZOp().Set(30)
    mesh.AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
    looks = {}
    for name, color in (("Paint", (0.1, 0.2, 0.3)), ("Glass", (0.9, 0.9, 0.9))):
        material = UsdShade.Material.Define(made, f"/Looks/{name}")
        shader = UsdShade.Shader.Define(made, f"/Looks/{name}/Shader")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
        shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.4 if name == "Glass" else 1.0)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        looks[name] = material
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(looks["Paint"])
    part = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset("glass", [1])
    UsdShade.MaterialBindingAPI.Apply(part.GetPrim()).Bind(looks["Glass"])
    thing = made.GetPrimAtPath("/World/Thing")
    thing.CreateAttribute("semantics:labels:class", Sdf.ValueTypeNames.TokenArray).Set(["hull"])
    for i, kind in enumerate(("Cube", "Sphere", "Cylinder", "Cone", "Capsule", "Plane")):
        prim = getattr(UsdGeom, kind).Define(made, f"/World/{kind}")
        prim.AddTranslateOp().Set(Gf.Vec3d(6 + 4 * i, 1, 2))
        prim.AddRotateXYZOp().Set(Gf.Vec3f(10 * i, 20, 5 * i))
        if kind in ("Cylinder", "Cone", "Capsule", "Plane"):
            prim.CreateAxisAttr("XYZX"[i % 4])
        prim.CreateDisplayColorAttr([Gf.Vec3f(0.5, 0.25, 0.125)])
    for path, hide in (("/World/Hidden", "invisible"), ("/World/Proxy", "proxy")):
        prim = UsdGeom.Cube.Define(made, path)
        if hide == "proxy":
            prim.CreatePurposeAttr("proxy")
        else:
            prim.CreateVisibilityAttr("invisible")
    UsdGeom.BasisCurves.Define(made, "/World/Hair")
    model = UsdGeom.Xform.Define(made, "/Models/Chair")
    UsdGeom.Cube.Define(made, "/Models/Chair/Seat").CreateSizeAttr(0.5)
    made.GetPrimAtPath("/Models").SetSpecifier(Sdf.SpecifierOver)  # models are there where they are referred to
    for i in range(3):
        chair = UsdGeom.Xform.Define(made, f"/World/Chair{i}")
        chair.GetPrim().GetReferences().AddInternalReference(model.GetPath())
        chair.GetPrim().SetInstanceable(True)
        chair.AddTranslateOp().Set(Gf.Vec3d(-3 * i - 3, 0, 0))
    instancer = UsdGeom.PointInstancer.Define(made, "/World/Pebbles")
    UsdGeom.Sphere.Define(made, "/World/Pebbles/Prototypes/Pebble").CreateRadiusAttr(0.1)
    instancer.CreatePrototypesRel().AddTarget("/World/Pebbles/Prototypes/Pebble")
    instancer.CreateProtoIndicesAttr([0, 0, 0, 0])
    instancer.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(i, -4, 0) for i in range(4)]))
    instancer.CreateScalesAttr(Vt.Vec3fArray([Gf.Vec3f(1 + i) for i in range(4)]))
    instancer.DeactivateId(2) if instancer.GetIdsAttr().Get() else instancer.CreateInvisibleIdsAttr([2])
    head = made.DefinePrim("/World/Mast/Head", "OmniLidar")
    UsdGeom.Xform.Define(made, "/World/Mast").AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    head.CreateAttribute("xformOp:translate", Sdf.ValueTypeNames.Double3).Set(Gf.Vec3d(0.5, 0, 0))
    head.CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray).Set(["xformOp:translate"])
    core = "omni:sensor:Core:"
    head.CreateAttribute(core + "scanType", Sdf.ValueTypeNames.Token).Set("ROTARY")
    head.CreateAttribute(core + "scanRateBaseHz", Sdf.ValueTypeNames.UInt).Set(10)
    head.CreateAttribute(core + "patternFiringRateHz", Sdf.ValueTypeNames.UInt).Set(3600)
    head.CreateAttribute(core + "farRangeM", Sdf.ValueTypeNames.Float).Set(80)
    head.CreateAttribute(core + "numberOfEmitters", Sdf.ValueTypeNames.UInt).Set(2)
    head.CreateAttribute(core + "emitterState:s001:azimuthDeg", Sdf.ValueTypeNames.FloatArray).Set([0.0, 0.0])
    head.CreateAttribute(core + "emitterState:s001:elevationDeg", Sdf.ValueTypeNames.FloatArray).Set([-5.0, 5.0])
    head.CreateAttribute(core + "emitterState:s001:fireTimeNs", Sdf.ValueTypeNames.UIntArray).Set([0, 1000])
    made.GetRootLayer().Save()
    return file


def test_usd_stages(tmp_path, device):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    file = stage(tmp_path)
    with pytest.warns(UserWarning, match=r"leaves out prims of the type BasisCurves \(1\)$"):
        found = robotics.load(file, classes={"hull": 9})
    names = [instance.name for instance in found.scene.instances]
    assert len(names) == 1 + 6 + 3 + 3 and "/World/Hidden" not in names and "/World/Proxy" not in names
    assert [name for name in names if "Pebbles" in name] == [
        f"/World/Pebbles[{i}]/World/Pebbles/Prototypes/Pebble" for i in (0, 1, 3)
    ]
    assert len({found.scene.instances[i].mesh for i, name in enumerate(names) if "Chair" in name}) == 1  # shared
    hull = found.scene.instances[names.index("/World/Thing/Hull")]
    assert (hull.class_id, hull.class_name) == (9, "hull")
    mesh = found.scene.meshes[hull.mesh]
    area = (
        np.linalg.norm(np.cross(*(np.diff(mesh.positions[mesh.indices], axis=1).transpose(1, 0, 2))), axis=1).sum() / 2
    )
    assert mesh.triangle_count() == 2 + 1 + 3 and abs(area - (1 + 1 + 2.5)) < 1e-6
    looks = [(found.scene.materials[part.material].name, part.triangle_count) for part in mesh.parts]
    assert looks == [("Paint", 2), ("Glass", 1), ("Paint", 3)]  # faces keep their order
    # Against the bounds that USD itself computes.
    made = Usd.Stage.Open(str(file))
    cache = UsdGeom.BBoxCache(Usd.TimeCode.EarliestTime(), ["default", "render"])
    for name, points in zip(names, corners(found)):
        if "[" not in name:
            prim = made.GetPrimAtPath(name)
            box = cache.ComputeWorldBound(prim)
            local, place = box.GetRange(), np.array(box.GetMatrix())
            inverse = np.linalg.inv(place)
            inside = points @ inverse[:3, :3] + inverse[3, :3]
            np.testing.assert_allclose(inside.min(axis=0), local.GetMin(), atol=2e-3, err_msg=name)
            np.testing.assert_allclose(inside.max(axis=0), local.GetMax(), atol=2e-3, err_msg=name)
    head = found.sensors[0]
    assert head.sensor.beam_count() == 720 and abs(head.rate - 10) < 1e-9
    np.testing.assert_allclose(found.pose("Head").position, (1.5, 2, 8), atol=1e-12)


def test_what_a_usd_lidar_states_in_vain_or_not_at_all_is_told(tmp_path):
    pytest.importorskip("pxr")
    from pxr import Sdf, Usd

    file = tmp_path / "lidar.usda"
    made = Usd.Stage.CreateNew(str(file))
    types, core = Sdf.ValueTypeNames, "omni:sensor:Core:"
    head = made.DefinePrim("/Head", "OmniLidar")
    for name, kind, value in (
        ("scanType", types.Token, "ROTARY"),
        ("scanRateBaseHz", types.UInt, 10),
        ("patternFiringRateHz", types.UInt, 3600),
        ("rangesMinM", types.FloatArray, [0.5, 1]),
        ("rangesMaxM", types.FloatArray, [30, 80]),
        ("minReflectance", types.Float, 0.1),
        ("minReflectionRangeM", types.Float, 60),
        ("azimuthErrorStd", types.Float, 0.025),
        ("marketName", types.String, 'a "head" # 1'),
        ("emitterState:s001:azimuthDeg", types.FloatArray, [0, 0]),
        ("emitterState:s001:elevationDeg", types.FloatArray, [-5, 5]),
        ("emitterState:s001:rangeId", types.UIntArray, [0, 1]),
    ):
        head.CreateAttribute(core + name, kind).Set(value)
    made.GetRootLayer().Save()
    with pytest.warns(UserWarning, match=r"leaves out of the lidar /Head: azimuthErrorStd, marketName \(1\)$") as told:
        found = robotics.load(file)
    assert len(told) == 1
    assert found.left_out == {"of the lidar /Head: azimuthErrorStd, marketName": 1}
    assert found.assumed == ["that the head turns clockwise (the lidar /Head)"]
    channels = found.sensors[0].sensor.channels
    assert [(channel.range_min, channel.range_max) for channel in channels] == [(0.5, 30), (1, 80)]
    assert abs(found.sensors[0].sensor.range_at_10_percent - 60) < 1e-6  # 0.1 is single in USD


@pytest.mark.parametrize("axis", "XYZ")
def test_usd_planes_that_are_not_square(tmp_path, axis):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    file = tmp_path / "plane.usda"
    made = new_stage(file)
    plane = UsdGeom.Plane.Define(made, "/Plane")
    plane.CreateAxisAttr(axis)
    plane.CreateWidthAttr(10.0)
    plane.CreateLengthAttr(2.0)
    made.GetRootLayer().Save()
    (points,) = corners(quiet(file))
    extent = np.array(plane.ComputeExtent(Usd.TimeCode.Default()))
    np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], extent, atol=1e-6)


@pytest.mark.parametrize("kind", ("Cylinder_1", "Capsule_1"))
def test_usd_radii_of_both_ends(tmp_path, kind):
    pytest.importorskip("pxr")
    for top, bottom in ((0.3, 0.3), (0.3, 0.1), (0.1, 0.3)):
        file = tmp_path / f"{top}{bottom}.usda"
        made = new_stage(file)
        prim = made.DefinePrim("/Shape", kind)
        for name, value in (("radiusTop", top), ("radiusBottom", bottom), ("height", 4.0)):
            prim.GetAttribute(name).Set(value)
        made.GetRootLayer().Save()
        if top == bottom:
            found = quiet(file)
        else:
            with pytest.warns(UserWarning, match="leaves out the smaller radius of cylinders and capsules, which"):
                found = robotics.load(file)
        (points,) = corners(found)
        half = 2 if kind == "Cylinder_1" else 2.3
        np.testing.assert_allclose(points.max(axis=0), (0.3, 0.3, half), atol=2e-3)
        np.testing.assert_allclose(points.min(axis=0), (-0.3, -0.3, -half), atol=2e-3)


def test_usd_instances_keep_the_tolerance_at_their_sizes(tmp_path):
    pytest.importorskip("pxr")
    from pxr import UsdGeom

    file = tmp_path / "balls.usda"
    made = new_stage(file)
    scatter = UsdGeom.PointInstancer.Define(made, "/Scatter")
    UsdGeom.Sphere.Define(made, "/Scatter/Ball").CreateRadiusAttr(0.05)
    scatter.CreatePrototypesRel().SetTargets(["/Scatter/Ball"])
    scales = [1, 100, 0.01, 90, 0]
    scatter.CreateProtoIndicesAttr([0] * len(scales))
    scatter.CreatePositionsAttr([(0, 0, 0)] * len(scales))
    scatter.CreateScalesAttr([(scale,) * 3 for scale in scales])
    made.GetRootLayer().Save()
    scene = quiet(file).scene
    for instance, scale in zip(scene.instances, scales):
        mesh, rows = scene.meshes[instance.mesh], instance.transform.rows
        middles = (mesh.positions + np.array(mesh.origin))[mesh.indices].mean(axis=1) @ rows[:, :3].T
        depth = 0.05 * scale - np.linalg.norm(middles, axis=1)
        assert depth.max() < 1e-3
        assert scale != 100 or depth.max() > 1e-4  # it is not much finer than asked for
    assert scene.instances[1].mesh == scene.instances[3].mesh


def test_usd_units_and_axes(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        metres, turned = (robotics.load(stage(tmp_path, *choice)) for choice in (("Z", 1.0), ("Y", 0.01)))
    for ours, theirs in zip(corners(metres), corners(turned)):
        if len(ours) == len(theirs):
            x, y, z = 0.01 * ours.T
            np.testing.assert_allclose(theirs, np.stack([x, -z, y], axis=1), atol=1e-6)
    np.testing.assert_allclose(turned.pose().position, (0.015, -0.08, 0.02), atol=1e-12)
    up = adapter.rows_of(turned.pose())[:3, :3]
    np.testing.assert_allclose(up @ [0, 0, 1], (0, -1, 0), atol=1e-9)  # the head lies as its prim does


def test_ears_of_concave_polygons():
    angles = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    star = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * np.where(np.arange(10) % 2, 0.3, 1)[:, None]
    for turn in (np.eye(3), np.eye(3)[[1, 2, 0]], np.diag([1.0, -1, 1])):
        points = star @ turn.T
        triangles = points[primitives.ears(points)]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        whole = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1).sum(), np.linalg.norm(whole), rtol=1e-12)
        np.testing.assert_allclose(normals.sum(axis=0), whole, atol=1e-12)


def test_the_command(arm, tmp_path):
    command = [sys.executable, "-m", "gnosphere.robotics"]
    options = ["--search", tmp_path / "packages", "--joint", "slide=0.5", "-o", tmp_path / "arm.glb"]
    said = subprocess.run([*command, arm, *options], check=True, capture_output=True, text=True)
    assert "joint shoulder: -1 to 1" in said.stdout and "lidar top: 270 beams" in said.stdout
    turned = "yaw_pitch_roll_deg 90.000, 0.000, 0.000"
    assert f"\n  on tip at 0.100, 0.000, 0.200, {turned}; in the world at 0.100, 0.000, 1.800\n" in said.stdout
    assert "left out: geometry that is no box, sphere, cylinder, capsule or mesh (1)" in said.stdout and not said.stderr
    scene = gnosphere.load_scene(tmp_path / "arm.glb")
    assert [instance.name for instance in scene.instances] == ["plinth", "upper", "tip", "follower"]
    for beyond, sentence in (("slide=0.7", "the joint 'slide' is at 0.7, beyond its limits 0..0.5"), ("slide=0.5", "")):
        said = subprocess.run([*command, arm, *options, "--joint", beyond], check=True, capture_output=True, text=True)
        assert sentence in said.stderr and bool(said.stderr) == bool(sentence)
    wrong = subprocess.run([*command, arm, "--joint", "knee=1"], capture_output=True, text=True)
    assert wrong.returncode == 1 and "there is no joint 'knee'" in wrong.stderr
    wrong = subprocess.run([*command, arm, "--joint", "slide"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "--joint slide states no position" in wrong.stderr


def test_the_command_without_a_reader(arm):
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([sys.executable, "-m", "gnosphere.robotics", arm], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (-signal.SIGPIPE, b"")  # so does the program `gnosphere`


def test_the_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (REPOSITORY / "docs" / "robotics.md").read_text()
    (world,) = re.findall(r"^```xml\n(.*?)^```$", page, re.M | re.S)
    (tmp_path / "yard.sdf").write_text(world)
    (block, *_) = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    exec(compile(block, "docs/robotics.md", "exec"), {})
    assert len(gnosphere.load_scene("yard.glb").instances) == 2
