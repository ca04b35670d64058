# SPDX-License-Identifier: Apache-2.0
"""Where models of SDF are that are placed by one of their frames, and what becomes of included models that are merged
into the model around them."""

import numpy as np
import pytest
from test_robot_details import TETRAHEDRON, link, rpy, visual, write_tetrahedron
from test_robotics import BOX, corners, quiet, sensor

from gnosphere import robotics


def pose(*values, relative_to=""):
    relative = f' relative_to="{relative_to}"' if relative_to else ""
    return f"<pose{relative}>{' '.join(map(str, values))}</pose>"


def rigid(x, y, z, *angles):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rpy(*angles), (x, y, z)
    return result


def places(robot):
    """Where the things on each link are, maps of shape (3, 4)."""
    return {frame: instance.transform.rows for frame, instance in zip(robot.frames, robot.scene.instances)}


LINK, TOP, AT = (0.1, 0.2, 0.3, 0.1, 0, 0), (1, 2, 3, 0.4, 0.5, 0.6), (4, 5, 6, -0.3, 0.2, 0.1)


def placed(attribute, at=pose(*AT)):
    """A model with a frame `top`, which is relative to its link."""
    top = f'<frame name="top" attached_to="l">{pose(*TOP)}</frame>'
    return f'<model name="m"{attribute}>{at}{top}<link name="l">{pose(*LINK)}{BOX}{sensor()}</link></model>'


@pytest.mark.parametrize("around", ("{}", '<world name="w">{}</world>', '<model name="n">{}</model>'))
def test_a_model_is_placed_by_one_of_its_frames(tmp_path, around):
    body = around.format(placed(' placement_frame="top"'))
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9">{body}</sdf>')
    robot = quiet(tmp_path / "m.sdf")
    (found,) = places(robot).values()
    expected = rigid(*AT) @ np.linalg.inv(rigid(*TOP))  # of the link, since the frame is attached to it
    np.testing.assert_allclose(found, expected[:3], atol=1e-6)
    np.testing.assert_allclose(robot.pose().position, expected[:3, 3], atol=1e-6)


@pytest.mark.parametrize(
    ("attribute", "element", "frame"),
    (
        ("", "<placement_frame>top</placement_frame>", rigid(*LINK) @ rigid(*TOP)),
        (' placement_frame="top"', "<placement_frame>l</placement_frame>", rigid(*LINK)),
        (' placement_frame="top"', "", rigid(*LINK) @ rigid(*TOP)),
        (' placement_frame="top"', "<placement_frame>__model__</placement_frame>", np.eye(4)),
    ),
)
@pytest.mark.parametrize("merge", ("", ' merge="true"'))
def test_an_included_model_is_placed_by_one_of_its_frames(tmp_path, attribute, element, frame, merge):
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9">{placed(attribute, pose(9, 9, 9, 0, 0, 0))}</sdf>')
    mark = f'<frame name="mark">{pose(0, 0, 2, 0, 0, 1)}</frame>'
    include = f"<include{merge}><uri>part.sdf</uri>{element}{pose(*AT, relative_to='mark')}</include>"
    (tmp_path / "w.sdf").write_text(f'<sdf version="1.9"><model name="n">{mark}{include}</model></sdf>')
    (found,) = places(quiet(tmp_path / "w.sdf")).values()
    expected = rigid(0, 0, 2, 0, 0, 1) @ rigid(*AT) @ np.linalg.inv(frame) @ rigid(*LINK)
    np.testing.assert_allclose(found, expected[:3], atol=1e-6)


def test_a_model_is_placed_by_a_frame_of_a_model_in_it(tmp_path):
    inner = f'<model name="arm">{pose(0, 0, 1, 0, 0, 0)}<link name="tip">{pose(0, 2, 0, 0, 0, 0)}{BOX}</link></model>'
    body = f'<model name="m" placement_frame="arm::tip">{pose(*AT)}{inner}</model>'
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9">{body}</sdf>')
    np.testing.assert_allclose(places(quiet(tmp_path / "m.sdf"))["m::arm::tip"], rigid(*AT)[:3], atol=1e-6)


@pytest.mark.parametrize("frame", ("roof", "roof::top"))
def test_a_frame_that_places_a_model_must_be_there(tmp_path, frame):
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9">{placed(f""" placement_frame="{frame}" """)}</sdf>')
    with pytest.raises(ValueError, match=f"the model 'm' is placed by its frame '{frame}', which is not there"):
        robotics.load(tmp_path / "m.sdf")


AXES = {
    "1.4": "<xyz>0 1 0</xyz>",
    "1.6": "<xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame>",
    "1.8": '<xyz expressed_in="__model__">0 1 0</xyz>',
    "1.9": "<xyz>0 1 0</xyz>",
}
"""The axis of the joint of a model by the version of its file: in the frame of the model, but that of the last one."""


def write_rig(folder, version):
    """A model with a mesh in a link, a sliding link, a model inside, and frames of which some are its own."""
    folder.mkdir(parents=True)
    write_tetrahedron(folder / "t.obj")
    mesh = visual("<mesh><uri>t.obj</uri></mesh>")
    base = f'<link name="base">{pose(0.2, 0.1, 0, 0, 0, 0.1)}{mesh}</link>'
    head = f'<link name="head">{pose(1, 0, 2, 0.3, 0.2, 0.1)}{BOX}{sensor()}</link>'
    cap = f'<model name="cap">{pose(0, 0, 3, 0, 0.5, 0)}<link name="l">{BOX}</link></model>'
    slide = f"""<joint name="slide" type="prismatic"><parent>base</parent><child>head</child>
        <axis>{AXES[version]}</axis></joint>"""
    lid = '<joint name="lid" type="fixed"><parent>head</parent><child>cap::l</child></joint>'
    frames = ""
    if version >= "1.7":
        frames = f'<frame name="own">{pose(0, 1, 0, 0, 0, 0.7)}</frame>'
        frames += f'<frame name="eye" attached_to="head">{pose(0, 0, 1, 0, 0, 0, relative_to="__model__")}</frame>'
        near = BOX.replace('name="v">', f'name="near">{pose(0, 0, 0, 0, 0, 0, relative_to="__model__")}')
        frames += f'<link name="arm">{pose(1, 1, 1, 0, 0, 0, relative_to="own")}{near}</link>'
        frames += '<joint name="bolt" type="fixed"><parent>__model__</parent><child>arm</child></joint>'
    body = f'<model name="rig">{pose(9, 9, 9, 0, 0, 0)}{base}{head}{cap}{slide}{lid}{frames}</model>'
    (folder / "model.sdf").write_text(f'<sdf version="{version}">{body}</sdf>')


@pytest.mark.parametrize("version", AXES)
def test_a_merged_model_is_where_it_would_be_as_a_model_of_its_own(tmp_path, version):
    write_rig(tmp_path / "rig", version)
    robots = {}
    for merge, model in (("", "rig::"), (' merge="true"', "")):
        include = f"<include{merge}><uri>model://rig</uri>{pose(1, 2, 0, 0, 0.1, 0.4, relative_to='chassis')}</include>"
        wheel = f"""<joint name="turn" type="revolute"><parent>chassis</parent><child>{model}base</child>
            <axis><xyz>0 0 1</xyz></axis></joint>"""
        optic = f'<frame name="optic" attached_to="{model}head"/>' if version >= "1.7" else ""
        extra = link(pose(0, 0, 1, 0, 0, 0, relative_to="optic" if optic else f"{model}head") + BOX, "extra")
        extra += f'<joint name="e" type="fixed"><parent>{"optic" if optic else model + "head"}</parent>'
        extra += "<child>extra</child></joint>"
        chassis = link(pose(0, 0, 0.5, 0, 0, 0.2) + BOX, "chassis")
        text = f'<sdf version="1.9"><model name="m">{chassis}{include}{optic}{extra}{wheel}</model></sdf>'
        (tmp_path / "m.sdf").write_text(text)
        robots[model] = quiet(tmp_path / "m.sdf")
    own, merged = robots.values()
    assert set(own.joint_limits) == set(merged.joint_limits) == {"turn", "slide"}
    for positions in ({}, {"turn": 0.7}, {"turn": -0.4, "slide": 0.5}):
        own.move(positions)
        merged.move(positions)
        found, expected = places(merged), places(own)
        assert found.keys() == {frame.replace("m::rig::", "m::") for frame in expected}
        for frame, rows in expected.items():
            np.testing.assert_allclose(found[frame.replace("m::rig::", "m::")], rows, atol=1e-6)
        np.testing.assert_allclose(merged.pose("m::top").position, own.pose("m::rig::top").position, atol=1e-9)
    (mesh,) = [points for frame, points in zip(merged.frames, corners(merged)) if frame == "m::base"]
    assert len(mesh) == len(TETRAHEDRON)


def test_a_merged_model_has_its_own_place_if_its_include_has_none(tmp_path):
    write_rig(tmp_path / "rig", "1.9")
    text = '<sdf version="1.9"><model name="m"><include merge="1"><uri>model://rig</uri></include></model></sdf>'
    (tmp_path / "m.sdf").write_text(text)
    expected = rigid(9, 9, 9, 0, 0, 0) @ rigid(1, 0, 2, 0.3, 0.2, 0.1)
    np.testing.assert_allclose(places(quiet(tmp_path / "m.sdf"))["m::head"], expected[:3], atol=1e-6)


def test_a_merged_model_stands_where_its_include_does(tmp_path):
    """So the first link of the model around it, to which its frame is attached, is the merged one."""
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9"><model name="p">{link(BOX, "a")}</model></sdf>')
    body = f"""<include merge="true"><uri>part.sdf</uri></include>{link(BOX, "b")}<joint name="j" type="prismatic">
        <parent>b</parent><child>__model__</child><axis><xyz>0 0 1</xyz></axis></joint>"""
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9"><model name="m">{body}</model></sdf>')
    found = places(quiet(tmp_path / "m.sdf", joints={"j": 2.0}))
    assert [found[frame][2, 3] for frame in ("m::a", "m::b")] == [2, 0]


def test_models_of_a_model_that_is_merged_into_a_world(tmp_path):
    inner = f'<model name="box">{pose(0, 0, 1, 0, 0, 0)}{link(BOX)}</model>'
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9"><model name="p">{inner}{link(BOX)}</model></sdf>')
    include = f'<include merge="true"><uri>part.sdf</uri>{pose(5, 0, 0, 0, 0, 0)}</include>'
    (tmp_path / "w.sdf").write_text(f'<sdf version="1.9"><world name="w">{include}</world></sdf>')
    with pytest.warns(UserWarning, match=r"leaves out links of a model that is merged into a world \(1\)$"):
        robot = robotics.load(tmp_path / "w.sdf")
    ((frame, rows),) = places(robot).items()
    assert frame == "box::l" and rows[:, 3].tolist() == [5, 0, 1]


def test_one_model_that_is_merged_twice(tmp_path):
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9"><model name="p">{link(BOX)}</model></sdf>')
    include = '<include merge="true"><uri>part.sdf</uri>{}</include>'
    includes = "".join(include.format(pose(x, 0, 0, 0, 0, 0)) for x in (1, 2))
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9"><model name="m">{includes}</model></sdf>')
    with pytest.warns(UserWarning, match=r"leaves out the name 'l' of another link, which is 'l 2' here \(1\)$"):
        found = places(robotics.load(tmp_path / "m.sdf"))
    assert {frame: rows[0, 3] for frame, rows in found.items()} == {"m::l": 1, "m::l 2": 2}
