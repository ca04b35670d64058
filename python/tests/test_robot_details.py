# SPDX-License-Identifier: Apache-2.0
"""What elements of SDF and URDF and the names of their files mean, one by one, in closed forms. URDF is skipped without
the package yourdfpy."""

import base64
import json
import warnings

import numpy as np
import pytest
from test_robotics import BOX, NONE, corners, quiet, sensor

import gnosphere
from gnosphere import robotics
from gnosphere.robotics.__main__ import main, place_of, shown
from gnosphere.robotics.resources import parse_xml


def about(axis, angle):
    """The matrix of a turn about x, y or z by radians."""
    cross = np.cross(np.eye(3), np.eye(3)["xyz".index(axis)])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def rpy(roll, pitch, yaw):
    return about("z", yaw) @ about("y", pitch) @ about("x", roll)


def sdf(folder, body, *, version="1.9", **options):
    """The robot of a model of SDF, without a warning."""
    file = folder / "m.sdf"
    file.write_text(f'<sdf version="{version}"><model name="m">{body}</model></sdf>')
    return quiet(file, **options)


def visual(geometry, inside="", name="v", kind="visual"):
    return f'<{kind} name="{name}"><geometry>{geometry}</geometry>{inside}</{kind}>'


def link(inside, name="l"):
    return f'<link name="{name}">{inside}</link>'


def colours(robot):
    """The colour and the name of the material of each instance."""
    scene = robot.scene
    materials = [scene.materials[scene.meshes[instance.mesh].parts[0].material] for instance in scene.instances]
    return [(*np.round(material.base_color, 6).tolist(), material.name) for material in materials]


def bounds(robot):
    return [[points.min(axis=0).tolist(), points.max(axis=0).tolist()] for points in corners(robot)]


TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


def write_tetrahedron(file, at=(0, 0, 0), header=""):
    """One whose three edges are along the axes from `at`."""
    lines = [f"v {x} {y} {z}" for x, y, z in TETRAHEDRON + at]
    file.write_text("\n".join([header, *lines, "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"]))


def write_gltf(file, *nodes):
    """A file of glTF with a tetrahedron for each node, which has its name, that of its mesh, and its translation."""
    positions, indices = TETRAHEDRON.astype("<f4"), np.array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], "<u2")
    data = base64.b64encode(positions.tobytes() + indices.tobytes()).decode()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": list(range(len(nodes)))}], "scene": 0,
        "nodes": [{"name": name, "mesh": i, "translation": at} for i, (name, _, at) in enumerate(nodes)],
        "meshes": [{"name": name, "primitives": [primitive]} for _, name, _ in nodes],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0] * 3, "max": [1] * 3},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64," + data}],
    }  # fmt: skip
    file.write_text(json.dumps(document))


COLLADA = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries>{}</library_geometries>
<library_nodes>{}</library_nodes><library_visual_scenes><visual_scene id="s">{}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""

COLLADA_GEOMETRY = """<geometry id="{0}" name="{0} name"><mesh><source id="{0}-p"><float_array id="{0}-a" count="12">
0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source="#{0}-a" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
</source><vertices id="{0}-v"><input semantic="POSITION" source="#{0}-p"/></vertices>{1}</mesh></geometry>"""


def collada_geometry(identifier, *primitives):
    """A geometry of a tetrahedron's corners with a primitive for each text of three corners a triangle."""
    triangles = """<triangles count="{}"><input semantic="VERTEX" source="#{}-v" offset="0"/><p>{}</p></triangles>"""
    inside = "".join(triangles.format(len(corners.split()) // 3, identifier, corners) for corners in primitives)
    return COLLADA_GEOMETRY.format(identifier, inside)


def by_height(points):
    return points[np.lexsort(np.round(points, 6).T)]


def test_a_mesh_of_sdf_is_scaled_and_then_turned_and_moved(tmp_path):
    far = (500000.3, 0, 0)  # so the file's mesh has an origin of its own
    write_tetrahedron(tmp_path / "t.obj", far)
    mesh = "<mesh><uri>t.obj</uri><scale>2 3 4</scale></mesh>"
    (points,) = corners(sdf(tmp_path, link(visual(mesh, "<pose>1 2 3 0.1 0.2 0.3</pose>"))))
    expected = (TETRAHEDRON + far) * [2, 3, 4] @ rpy(0.1, 0.2, 0.3).T + [1, 2, 3]
    np.testing.assert_allclose(by_height(points), by_height(expected), atol=0.1)


def test_the_normal_of_a_plane_of_sdf_is_in_the_frame_of_its_visual(tmp_path):
    plane = "<plane><normal>0 1 0</normal><size>4 4</size></plane>"
    (points,) = corners(sdf(tmp_path, link(visual(plane, "<pose>1 2 3 0.5 0.2 0</pose>"))))
    normal = rpy(0.5, 0.2, 0) @ [0, 1, 0]
    np.testing.assert_allclose((points - [1, 2, 3]) @ normal, 0, atol=1e-6)
    assert np.linalg.norm(points - [1, 2, 3], axis=1).max() == pytest.approx(np.sqrt(8))


@pytest.mark.parametrize("normal", ((0, 0, 2), (0, 1, 0), (3, 0, 0), (-1, 0, 0), (1, 2, -0.5), (0.3, 0.1, 1)))
def test_a_plane_of_sdf_is_turned_about_an_axis_across_z_and_its_normal(tmp_path, normal):
    """As Gazebo's From2Axes turns it, so that it is known where its longer side lies."""
    plane = f"<plane><normal>{' '.join(map(str, normal))}</normal><size>30 2</size></plane>"
    robot = sdf(tmp_path, link(visual(plane)))
    unit = np.array(normal) / np.linalg.norm(normal)
    tilt, heading = np.arccos(unit[2]), np.arctan2(unit[1], unit[0])
    turn = about("z", heading) @ about("y", tilt) @ about("z", -heading)
    np.testing.assert_allclose(robot.scene.instances[0].transform.rows[:, :3], turn, atol=1e-6)
    extent = 2 * np.abs(turn @ np.diag([15, 1, 0])).sum(axis=1)
    np.testing.assert_allclose(np.ptp(corners(robot)[0], axis=0), extent, atol=1e-4)


def test_a_plane_of_sdf_that_looks_down_is_turned_about_x(tmp_path):
    plane = "<plane><normal>0 0 -1</normal><size>30 2</size></plane>"
    robot = sdf(tmp_path, link(visual(plane)))
    assert bounds(robot) == [[[-15, -1, 0], [15, 1, 0]]]
    np.testing.assert_allclose(robot.scene.instances[0].transform.rows[:, :3], np.diag([1, -1, -1]), atol=1e-12)


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ("<box><size>1 2 3</size></box>", (0.5, 1, 1.5)),
        ("<sphere><radius>0.7</radius></sphere>", (0.7, 0.7, 0.7)),
        ("<ellipsoid><radii>0.3 0.5 0.9</radii></ellipsoid>", (0.3, 0.5, 0.9)),
        ("<cylinder><radius>0.2</radius><length>3</length></cylinder>", (0.2, 0.2, 1.5)),
        ("<capsule><radius>0.2</radius><length>3</length></capsule>", (0.2, 0.2, 1.7)),
        ("<cone><radius>0.2</radius><length>3</length></cone>", (0.2, 0.2, 1.5)),
        ("<plane><size>4 6</size></plane>", (2, 3, 0)),
        # What is not stated has the default of the specification.
        ("<box/>", (0.5, 0.5, 0.5)), ("<sphere/>", (1, 1, 1)), ("<cylinder/>", (1, 1, 0.5)),
    ],
)  # fmt: skip
def test_sizes_of_sdf(tmp_path, shape, half):
    (found,) = bounds(sdf(tmp_path, link(visual(shape))))
    np.testing.assert_allclose(found, [np.negative(half), half], atol=2e-3)


def test_the_plane_of_a_collision_of_sdf_has_no_end_and_that_of_a_visual_has(tmp_path):
    plane = "<plane><size>4 6</size></plane>"
    body = link(visual(plane) + visual(plane, kind="collision"))
    assert bounds(sdf(tmp_path, body))[0][1] == [2, 3, 0]
    assert min(bounds(sdf(tmp_path, body, collisions=True))[0][1][:2]) >= 1000


def test_colours_of_sdf(tmp_path):
    def paint(inside, transparency=""):
        return visual("<box/>", f"<material>{inside}</material>{transparency}")

    script = "<script><name>Gazebo/{}</name></script>"
    half = "<transparency>0.5</transparency>"
    body = link(
        paint("<diffuse>.2 .4 .6 .8</diffuse>") + paint("<diffuse>.2 .4 .6 .8</diffuse>", half)
        + paint("<diffuse>.2 .4 .6</diffuse>", half) + paint(script.format("Red")) + paint(script.format("Red"), half)
        + visual("<box/>", half) + visual("<box/>")
    )  # fmt: skip
    assert colours(sdf(tmp_path, body)) == [
        (0.2, 0.4, 0.6, 0.8, ""), (0.2, 0.4, 0.6, 0.4, ""), (0.2, 0.4, 0.6, 0.5, ""), (1, 0, 0, 1, "Gazebo/Red"),
        (1, 0, 0, 0.5, "Gazebo/Red"), (0.5, 0.5, 0.5, 0.5, ""), (0.5, 0.5, 0.5, 1, ""),
    ]  # fmt: skip
    # The material of a visual is that of its mesh, too; without one the mesh has its own.
    write_tetrahedron(tmp_path / "t.obj", header="mtllib t.mtl\nusemtl ink")
    (tmp_path / "t.mtl").write_text("newmtl ink\nKd 0.25 0.5 0.75\n")
    mesh = "<mesh><uri>t.obj</uri></mesh>"
    body = link(visual(mesh, "<material><diffuse>1 1 0 1</diffuse></material>") + visual(mesh))
    assert colours(sdf(tmp_path, body)) == [(1, 1, 0, 1, ""), (0.25, 0.5, 0.75, 1, "ink")]


def joint(kind, axis, name="j", parent="a", child="b", pose=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{pose}<axis>{axis}</axis>'
        "</joint>"
    )


def test_axes_of_sdf_are_in_the_frame_of_their_joint_or_in_that_which_is_named(tmp_path):
    """A link that is turned about x, a joint in it that is turned about y, and a frame that is turned about z."""
    links = link(BOX, "a") + f'<link name="b"><pose>1 2 3 0.4 0 0</pose>{BOX}</link>'
    links += '<frame name="f"><pose>9 9 9 0 0 0.7</pose></frame>'
    pose = "<pose>0.5 0 0 0 0.6 0</pose>"
    turns = {
        "": about("x", 0.4) @ about("y", 0.6),
        ' expressed_in="f"': about("z", 0.7),
        ' expressed_in="__model__"': np.eye(3),
    }
    for frame, turn in turns.items():
        axis = f"<xyz{frame}>0 3 4</xyz>"
        slid = corners(sdf(tmp_path, links + joint("prismatic", axis, pose=pose), joints={"j": 2.0}))
        np.testing.assert_allclose(slid[1].mean(axis=0), [1, 2, 3] + 2 * turn @ [0, 0.6, 0.8], atol=1e-6)
        # A turn leaves the origin of the joint where it is.
        robot = sdf(tmp_path, links + joint("revolute", axis, pose=pose), joints={"j": 1.1})
        origin = np.array([1, 2, 3]) + about("x", 0.4) @ [0.5, 0, 0]
        direction = turn @ [0, 0.6, 0.8]
        way = [1, 2, 3] - origin
        turned = (
            way * np.cos(1.1)
            + np.cross(direction, way) * np.sin(1.1)
            + direction * (direction @ way) * (1 - np.cos(1.1))
        )
        np.testing.assert_allclose(robot.move({})[1, :, 3], origin + turned, atol=1e-9)


def test_an_axis_of_sdf_without_a_direction_is_an_error(tmp_path):
    for kind in ("revolute", "prismatic"):
        with pytest.raises(ValueError, match="the axis of the joint 'j' is 0 0 0, which has no direction"):
            sdf(tmp_path, link(BOX, "a") + link(BOX, "b") + joint(kind, "<xyz>0 0 0</xyz>"))


def test_joints_of_sdf_that_hang_from_others(tmp_path):
    """Two turns about z, of which the first takes the second along."""
    links = link(BOX, "a") + "".join(
        f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose>{BOX}</link>' for name, x in (("b", 1), ("c", 2))
    )
    axis = "<xyz>0 0 1</xyz>"
    body = links + joint("revolute", axis) + joint("revolute", axis, "k", "b", "c")
    rows = sdf(tmp_path, body).move({"j": np.pi / 2, "k": np.pi / 2})
    np.testing.assert_allclose(rows[:, :, 3], [[0, 0, 0], [1, 0, 0], [1, 1, 0]], atol=1e-9)
    np.testing.assert_allclose(rows[2, :, 0], [-1, 0, 0], atol=1e-9)


def test_limits_of_joints_of_sdf(tmp_path):
    links = link(BOX, "a") + link(BOX, "b")
    limit = "<xyz>0 0 1</xyz><limit><lower>{}</lower><upper>{}</upper></limit>"
    for kind, low, high, expected in (
        ("revolute", -1, 2, (-1, 2)), ("continuous", -1, 2, (-np.inf, np.inf)),
        ("revolute", -1e16, 1e16, (-np.inf, np.inf)),
        ("prismatic", 0, 1e16, (-np.inf, np.inf)),
    ):  # fmt: skip
        robot = sdf(tmp_path, links + joint(kind, limit.format(low, high)))
        assert robot.joint_limits == {"j": expected}
    robot = sdf(tmp_path, links + joint("revolute", limit.format(-1, 2)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot.move({"j": -1})
        robot.move({"j": 2})  # limits may be reached


def test_a_mimic_of_sdf_has_a_reference(tmp_path):
    """The follower is at the multiplier times (the leader less the reference), plus the offset."""
    links = "".join(link(BOX, name) for name in "abc")
    mimic = """<xyz>0 0 1</xyz><mimic joint="j"><multiplier>3</multiplier><offset>0.5</offset><reference>0.2</reference>
        </mimic>"""
    body = links + joint("prismatic", "<xyz>0 0 1</xyz>") + joint("prismatic", mimic, "k", "a", "c")
    robot = sdf(tmp_path, body, joints={"j": 1.0})
    assert [points.mean(axis=0)[2] for points in corners(robot)] == pytest.approx([0, 1, 3 * 0.8 + 0.5])
    assert list(robot.joint_limits) == ["j"]  # what follows cannot be moved


def test_poses_of_sdf_inside_a_link_may_be_relative_to_another_frame(tmp_path):
    box = visual("<box/>", '<pose relative_to="f">1 2 3 0 0 0.5</pose>')
    links = f"""<link name="a"><pose>1 0 0 0.3 0 0</pose>{box}</link>
        <frame name="f"><pose>0 5 0 0 0.4 0</pose></frame>"""
    row = sdf(tmp_path, links).move({})[0]
    np.testing.assert_allclose(row[:, 3], [0, 5, 0] + about("y", 0.4) @ [1, 2, 3], atol=1e-9)
    np.testing.assert_allclose(row[:, :3], about("y", 0.4) @ about("z", 0.5), atol=1e-9)


@pytest.mark.parametrize(
    ("attributes", "numbers", "turn"),
    [
        ("", "1 2 3 0.1 0.2 0.3", rpy(0.1, 0.2, 0.3)),
        ('degrees="true"', "1 2 3 10 20 30", rpy(*np.radians([10, 20, 30]))),
        ('degrees="1"', "1 2 3 10 20 30", rpy(*np.radians([10, 20, 30]))),
        ('degrees="false"', "1 2 3 1 0.2 0.3", rpy(1, 0.2, 0.3)),
        ('rotation_format="quat_xyzw"', f"1 2 3 {np.sin(0.2)} 0 0 {np.cos(0.2)}", about("x", 0.4)),
        ('rotation_format="quat_xyzw"', f"1 2 3 0 0 {np.sin(0.2)} {np.cos(0.2)}", about("z", 0.4)),
        ('rotation_format="euler_rpy"', "1 2 3 0.1 0.2 0.3", rpy(0.1, 0.2, 0.3)),
    ],
)
def test_poses_of_sdf(tmp_path, attributes, numbers, turn):
    row = sdf(tmp_path, f'<link name="l"><pose {attributes}>{numbers}</pose>{BOX}</link>').move({})[0]
    np.testing.assert_allclose(row, np.column_stack([turn, [1, 2, 3]]), atol=1e-9)


def test_the_canonical_link_of_a_model_of_sdf_carries_its_frame(tmp_path):
    """A joint between the world's link and a model moves the link that the model names, and what hangs from it."""
    inner = f"""<model name="arm" {{}}><link name="x">{BOX}</link><link name="y">{BOX}</link></model>"""
    lift = joint("prismatic", "<xyz>0 0 1</xyz>", parent="base", child="arm")
    for attribute, heights in (("", [0, 2, 0]), ('canonical_link="y"', [0, 0, 2])):
        robot = sdf(tmp_path, link(BOX, "base") + inner.format(attribute) + lift, joints={"j": 2.0})
        assert robot.move({})[:, 2, 3] == pytest.approx(heights)


def test_included_models_of_sdf_have_names_places_and_files_of_their_own(tmp_path):
    """A mesh is found beside the file that names it."""
    (tmp_path / "part").mkdir()
    write_tetrahedron(tmp_path / "part" / "t.obj")
    mesh = link(visual("<mesh><uri>t.obj</uri></mesh>") + sensor("eye"))
    (tmp_path / "part" / "model.sdf").write_text(
        f'<sdf version="1.9"><model name="p"><pose>7 7 7 0 0 0</pose>{mesh}</model></sdf>'
    )
    includes = "".join(
        f"<include><uri>part/model.sdf</uri>{more}</include>"
        for more in ("<name>first</name><pose>1 0 0 0 0 0</pose>", "<name>second</name>")
    )
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9"><world name="w">{includes}</world></sdf>')
    robot = quiet(tmp_path / "m.sdf")
    assert robot.frames == ["first::l", "second::l"]
    np.testing.assert_allclose(robot.move({})[:, :, 3], [[1, 0, 0], [7, 7, 7]], atol=1e-9)
    assert [mounted.name for mounted in robot.sensors] == ["first::eye", "second::eye"]


def test_short_names_of_joints_are_for_those_that_one_joint_has(tmp_path):
    arm = "".join(link(BOX, name) for name in "ab") + joint("prismatic", "<xyz>0 0 1</xyz>")
    body = f'<model name="left">{arm}</model><model name="right">{arm}</model>' + "".join(link(BOX, n) for n in "cd")
    robot = sdf(tmp_path, body + joint("prismatic", "<xyz>0 0 1</xyz>", "k", "c", "d"))
    assert sorted(robot.joint_limits) == ["k", "m::left::j", "m::right::j"]
    heights = dict(zip(robot.frames, robot.move({"m::right::j": 2.0, "k": 3.0})[:, 2, 3]))
    assert {name: height for name, height in heights.items() if height} == {"m::right::b": 2, "m::d": 3}
    assert robot.move({"m::left::j": 4.0})[:, 2, 3].sum() == 9  # the others stay


def test_kinds_of_lidars_of_sdf(tmp_path):
    kinds = [
        ("lidar", "lidar"),
        ("ray", "ray"),
        ("gpu_lidar", "lidar"),
        ("gpu_ray", "ray"),
        ("custom", "ray"),
        ("custom", "lidar"),
    ]
    text = "".join(sensor(f"s{i}", kind, tag) for i, (kind, tag) in enumerate(kinds))
    robot = sdf(tmp_path, link(BOX + text + '<sensor name="c" type="camera"><camera/></sensor>'))
    assert [(mounted.name, mounted.rate) for mounted in robot.sensors] == [(f"m::s{i}", 10) for i in range(6)]
    lidar = robot.lidar("m::s1", effects=NONE, fields="ring")
    shot = robot.shot("m::s1", 7)
    assert shot.frame == 7 and lidar.cast(shot).has(gnosphere.Field.ring)
    for wrong in (-1, 6):
        with pytest.raises(ValueError, match=f"there is no lidar {wrong}; the file has 6"):
            robot.pose(wrong)


URDF = """<robot name="m"><material name="red"><color rgba="1 0 0 1"/></material><link name="a">{}</link></robot>"""


def urdf(folder, inside, **options):
    pytest.importorskip("yourdfpy")
    (folder / "m.urdf").write_text(URDF.format(inside))
    return quiet(folder / "m.urdf", **options)


def seen(geometry, inside="", origin='<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>', kind="visual"):
    return f"<{kind}>{origin}<geometry>{geometry}</geometry>{inside}</{kind}>"


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ('<box size="1 2 3"/>', (0.5, 1, 1.5)), ('<sphere radius="0.7"/>', (0.7, 0.7, 0.7)),
        ('<cylinder radius="0.2" length="3"/>', (0.2, 0.2, 1.5)),
        ('<capsule radius="0.2" length="3"/>', (0.2, 0.2, 1.7)),
    ],
)  # fmt: skip
def test_sizes_and_places_of_urdf(tmp_path, shape, half):
    robot = urdf(tmp_path, seen(shape))
    np.testing.assert_allclose(robot.move({})[0], np.column_stack([rpy(0.1, 0.2, 0.3), [1, 2, 3]]), atol=1e-9)
    (found,) = bounds(urdf(tmp_path, seen(shape, origin="")))
    np.testing.assert_allclose(found, [np.negative(half), half], atol=2e-3)


def test_a_mesh_of_urdf_is_scaled_and_then_turned_and_moved(tmp_path):
    write_tetrahedron(tmp_path / "t.obj")
    (points,) = corners(urdf(tmp_path, seen('<mesh filename="t.obj" scale="2 3 4"/>')))
    expected = TETRAHEDRON * [2, 3, 4] @ rpy(0.1, 0.2, 0.3).T + [1, 2, 3]
    np.testing.assert_allclose(by_height(points), by_height(expected), atol=1e-6)


def test_colours_and_names_of_urdf(tmp_path):
    write_tetrahedron(tmp_path / "t.obj", header="mtllib t.mtl\nusemtl ink")
    (tmp_path / "t.mtl").write_text("newmtl ink\nKd 0.25 0.5 0.75\n")
    mesh, box = '<mesh filename="t.obj"/>', '<box size="1 1 1"/>'
    red, own = '<material name="red"/>', '<material name="red"><color rgba="0 1 0 0.5"/></material>'
    shapes = seen(mesh) + seen(mesh, red) + seen(mesh, own) + seen(box, red) + seen(box, own) + seen(box)
    assert colours(urdf(tmp_path, shapes)) == [
        (0.25, 0.5, 0.75, 1, "ink"), (1, 0, 0, 1, "red"), (0, 1, 0, 0.5, "red"), (1, 0, 0, 1, "red"),
        (0, 1, 0, 0.5, "red"), (0.5, 0.5, 0.5, 1, ""),
    ]  # fmt: skip
    named = seen(box).replace("<visual>", '<visual name="door">') + seen(box, red)
    instances = urdf(tmp_path, named, classes={"door": 3, "red": 4}).scene.instances
    assert [(one.name, one.class_id) for one in instances] == [("door", 3), ("a", 4)]
    textured = seen(box, '<material name="wood"><texture filename="wood.png"/></material>')
    (tmp_path / "m.urdf").write_text(URDF.format(textured))
    with pytest.warns(UserWarning, match=r"leaves out textures \(1\)$"):
        robotics.load(tmp_path / "m.urdf")


def test_collisions_of_urdf_in_place_of_visuals(tmp_path):
    both = seen('<box size="1 1 1"/>', origin="") + seen('<box size="2 2 2"/>', origin="", kind="collision")
    assert bounds(urdf(tmp_path, both))[0][1] == [0.5] * 3
    assert bounds(urdf(tmp_path, both, collisions=True))[0][1] == [1] * 3


def test_limits_and_lidars_of_urdf(tmp_path):
    """A joint that turns without an end has limits of effort alone; what follows another joint cannot be moved."""
    pytest.importorskip("yourdfpy")
    joints = "".join(
        f"""<link name="{child}"/><joint name="to {child}" type="{kind}"><parent link="a"/><child link="{child}"/>
        <axis xyz="0 0 1"/><limit effort="1" velocity="1" {limits}/>{mimic}</joint>"""
        for child, kind, limits, mimic in (
            ("b", "revolute", 'lower="-1" upper="2"', ""), ("c", "continuous", 'lower="-1" upper="2"', ""),
            ("d", "prismatic", 'lower="0" upper="3"', ""), ("e", "revolute", "", '<mimic joint="to b"/>'),
        )
    )  # fmt: skip
    lidars = f'<gazebo reference="b">{sensor()}{sensor()}</gazebo><gazebo reference="z">{sensor("lost")}</gazebo>'
    text = URDF.format(seen('<box size="1 1 1"/>')).replace("</robot>", joints + lidars + "</robot>")
    (tmp_path / "m.urdf").write_text(text)
    with pytest.warns(UserWarning, match=r"leaves out the lidar lost on the link 'z', which is not there \(1\)$"):
        robot = robotics.load(tmp_path / "m.urdf")
    limits = {"to b": (-1, 2), "to c": (-np.inf, np.inf), "to d": (0, 3)}
    assert robot.joint_limits == limits
    assert [mounted.name for mounted in robot.sensors] == ["top", "top 2"]


def test_names_of_files(tmp_path, monkeypatch):
    """In folders of variables, of packages that are searched themselves, and with signs that a URI writes otherwise."""
    root = tmp_path / "robots"
    root.mkdir()
    places = {
        "package://rover/t.obj": tmp_path / "ament" / "share" / "rover",
        "package:///rover_b/meshes/t.obj": tmp_path / "ros" / "rover_b" / "meshes",
        "model://gate/t.obj": tmp_path / "models" / "gate",
        "t2.obj": tmp_path / "found",
        f"file://{tmp_path}/a%20b/t.obj": tmp_path / "a b",
    }
    for name, folder in places.items():
        folder.mkdir(parents=True)
        write_tetrahedron(folder / name.rpartition("/")[2])
    for variable, value in (
        ("AMENT_PREFIX_PATH", tmp_path / "ament"), ("ROS_PACKAGE_PATH", f"{tmp_path / 'none'}:{tmp_path / 'ros'}"),
    ):  # fmt: skip
        monkeypatch.setenv(variable, str(value))
    body = link("".join(visual(f"<mesh><uri>{name}</uri></mesh>") for name in places))
    search = [tmp_path / "models" / "gate", tmp_path / "found"]
    robot = sdf(root, body, search=search)
    assert len(robot.frames) == 5 and repr(robot) == "<RobotScene of 5 instances, 0 lidars and 0 joints>"
    body = link(visual("<mesh><uri>model://gate/t.obj</uri></mesh>"))
    for one in (str(tmp_path / "models"), tmp_path / "models"):
        assert len(sdf(root, body, search=one).frames) == 1
    body = link("".join(visual(f"<mesh><uri>{name}</uri></mesh>") for name in places))
    sdf(root, body, search=search)
    with pytest.warns(UserWarning, match=r"the mesh package://rover/T.obj, which is not found \(1\)$"):
        (root / "m.sdf").write_text((root / "m.sdf").read_text().replace("rover/t.obj", "rover/T.obj"))
        robotics.load(root / "m.sdf", search=search)


def test_colours_of_files_without_materials_are_grey(tmp_path):
    """A file of STL has none; that of PLY and OBJ may have."""
    facet = "facet normal 0 0 1\nouter loop\n{}\nendloop\nendfacet\n"
    text = facet.format("\n".join(f"vertex {x} {y} {z}" for x, y, z in TETRAHEDRON[:3]))
    (tmp_path / "t.stl").write_text(f"solid t\n{text}endsolid t\n")
    assert [colour[:4] for colour in colours(sdf(tmp_path, link(visual("<mesh><uri>t.stl</uri></mesh>"))))] == [
        (0.5, 0.5, 0.5, 1)
    ]


DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>
<unit name="inch" meter="0.5"/><up_axis>Z_UP</up_axis></asset><library_effects><effect id="e"><profile_COMMON>
<technique sid="t"><lambert><diffuse><color>0.2 0.4 0.6 1</color></diffuse></lambert></technique></profile_COMMON>
</effect></library_effects><library_materials><material id="ink" name="ink"><instance_effect url="#e"/></material>
</library_materials><library_geometries>{}</library_geometries><library_visual_scenes><visual_scene id="s">{}
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""

GEOMETRY = """<geometry id="g{0}"><mesh><source id="p{0}"><float_array id="a{0}" count="9">0 0 0 {0} 0 0 0 {0} 0
</float_array><technique_common><accessor source="#a{0}" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v{0}">
<input semantic="POSITION" source="#p{0}"/></vertices><triangles count="1" material="m"><input semantic="VERTEX"
source="#v{0}" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>"""

NODE = """<node id="n{0}"><translate>0 0 {1}</translate><instance_geometry url="#g{0}"><bind_material><technique_common>
<instance_material symbol="m" target="#ink"/></technique_common></bind_material></instance_geometry></node>"""


def test_units_colours_and_nodes_of_collada(tmp_path):
    pytest.importorskip("collada")
    pytest.importorskip("trimesh")
    nodes = NODE.format(2, 10) + NODE.format(4, 20)
    (tmp_path / "t.dae").write_text(DAE.format(GEOMETRY.format(2) + GEOMETRY.format(4), nodes))
    robot = sdf(tmp_path, link(visual("<mesh><uri>t.dae</uri></mesh>")))
    assert {colour[:4] for colour in colours(robot)} == {(0.2, 0.4, 0.6, 1)}
    (points,) = corners(robot)
    expected = np.array([[0, 0, 5], [1, 0, 5], [0, 1, 5], [0, 0, 10], [2, 0, 10], [0, 2, 10]])
    np.testing.assert_allclose(by_height(points), by_height(expected), atol=1e-6)
    scene = robot.scene
    (mesh,) = scene.meshes
    areas = np.cross(*(np.diff(mesh.positions[mesh.indices], axis=1).transpose(1, 0, 2)))[:, 2] / 2
    assert sorted(areas.tolist()) == pytest.approx([0.5, 2])  # of each triangle, with its own corners


def test_a_mesh_of_one_file_with_two_colours_is_two(tmp_path):
    write_tetrahedron(tmp_path / "t.obj")
    mesh = "<mesh><uri>t.obj</uri></mesh>"
    paint = "<material><diffuse>{} 0 0 1</diffuse></material>"
    robot = sdf(
        tmp_path, link(visual(mesh, paint.format(1)) + visual(mesh, paint.format(0.5)) + visual(mesh, paint.format(1)))
    )
    assert [colour[0] for colour in colours(robot)] == [1, 0.5, 1]
    first, second, third = (instance.mesh for instance in robot.scene.instances)
    assert first == third != second


def test_the_command_takes_what_collides(tmp_path, monkeypatch, capsys):
    body = link(visual("<box/>") + visual("<box><size>4 6 8</size></box>", kind="collision"))
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9"><model name="m">{body}</model></sdf>')
    for option, extent in (
        ([], "from -0.500 -0.500 -0.500 to 0.500"),
        (["--collisions"], "from -2.000 -3.000 -4.000 to 2"),
    ):
        monkeypatch.setattr("sys.argv", ["gnosphere.robotics", str(tmp_path / "m.sdf"), *option])
        assert main() == 0 and extent in capsys.readouterr().out


@pytest.mark.parametrize("declared", ['<?xml version="1.0" encoding="utf-16"?>\n', "<!-- é -->", ""])
@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_files_in_utf_16(tmp_path, encoding, declared):
    text = f'\ufeff{declared}<sdf version="1.9"><model name="é">{link(BOX)}</model></sdf>\n'
    (tmp_path / "m.sdf").write_bytes(text.encode(encoding))
    assert quiet(tmp_path / "m.sdf").frames == ["é::l"]


def test_prefixes_that_nobody_declares_beside_those_that_xml_has(tmp_path):
    text = '<!-- a --><robot xml:lang="en" xmlns:known="k"><link drake:x="1" known:y="2"/><other:joint/></robot>'
    (tmp_path / "m.xml").write_text(text)
    root = parse_xml(tmp_path / "m.xml")
    assert [element.tag for element in root] == ["link", "{other}joint"]
    assert root[0].attrib == {"{drake}x": "1", "{k}y": "2"}


@pytest.mark.parametrize("kind", ("sdf", "urdf"))
def test_meshes_of_gltf_stand_as_their_files_have_them(tmp_path, kind):
    """Gazebo and RViz do not turn the y axis of a file up."""
    write_gltf(tmp_path / "t.gltf", ("hull", "hull", [1, 2, 3]))
    if kind == "sdf":
        robot = sdf(tmp_path, link(visual("<mesh><uri>t.gltf</uri></mesh>")))
    else:
        pytest.importorskip("yourdfpy")
        shape = '<visual><geometry><mesh filename="t.gltf"/></geometry></visual>'
        (tmp_path / "m.urdf").write_text(f'<robot name="m"><link name="l">{shape}</link></robot>')
        robot = quiet(tmp_path / "m.urdf")
    (points,) = corners(robot)
    np.testing.assert_allclose(by_height(points), by_height(TETRAHEDRON + [1, 2, 3]), atol=1e-6)


def submesh(file, name, inside=""):
    return visual(f"<mesh><uri>{file}</uri><submesh><name>{name}</name>{inside}</submesh></mesh>")


@pytest.mark.parametrize(
    ("name", "at"), (("hull", (0, 0, 0)), ("mast", (5, 0, 0)), ("first mesh", (0, 0, 0)), ("dome", (9, 0, 0)))
)
def test_a_submesh_of_gltf_has_the_name_of_its_node_or_else_that_of_its_mesh(tmp_path, name, at):
    nodes = ("hull", "first mesh", [0, 0, 0]), ("mast", "hull", [5, 0, 0]), ("roof", "dome", [9, 0, 0])
    write_gltf(tmp_path / "t.gltf", *nodes)
    (points,) = corners(sdf(tmp_path, link(submesh("t.gltf", name))))
    np.testing.assert_allclose(by_height(points), by_height(TETRAHEDRON + at), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "expected"),
    (
        ("Hull", [TETRAHEDRON]),  # the name of the node, not the geometry's of the next one
        ("Wheel", [TETRAHEDRON + (4, 0, 0)]),  # a node of the library
        ("Roof", [TETRAHEDRON + (0, 0, 7), TETRAHEDRON + (0, 0, 9)]),  # the second is in a node without a name
        ("Cube-mesh", [TETRAHEDRON, TETRAHEDRON + (4, 0, 0)]),  # the geometry, wherever it is
    ),
)
def test_a_submesh_of_collada_has_the_name_of_its_node_or_else_that_of_its_geometry(tmp_path, name, expected):
    pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    place = '<node id="{0}-id" {1}><translate>{2}</translate>{3}</node>'
    cube, roof = '<instance_geometry url="#Cube-mesh"/>', '<instance_geometry url="#Hull"/>'
    library = place.format("wheel", 'name="Wheel"', "0 0 0", cube)
    scene = place.format("a", 'name="Hull"', "0 0 0", cube)
    scene += place.format("b", 'name="outer"', "4 0 0", '<instance_node url="#wheel-id"/>')
    scene += place.format("c", 'name="Roof"', "0 0 7", roof + place.format("d", "", "0 0 2", roof))
    whole = "0 2 1 0 1 3 0 3 2 1 2 3"
    geometries = collada_geometry("Cube-mesh", whole[:6], whole[6:]) + collada_geometry("Hull", whole)
    (tmp_path / "t.dae").write_text(COLLADA.format(geometries, library, scene))
    robot = sdf(tmp_path, link(submesh("t.dae", name)))
    (points,) = corners(robot)
    found = {tuple(point) for point in np.round(points, 5).tolist()}
    assert found == {tuple(point) for point in np.concatenate(expected).tolist()}
    assert robot.scene.placed_triangle_count() == 4 * len(expected)


def test_a_submesh_is_centred_and_then_scaled(tmp_path):
    write_gltf(tmp_path / "t.gltf", ("hull", "hull", [5, 6, 7]), ("mast", "mast", [0, 0, 0]))
    for center, middle in (("1", (0.5, 0.5, 0.5)), ("true", (0.5, 0.5, 0.5)), ("0", (-5, -6, -7))):
        shape = submesh("t.gltf", "hull", f"<center>{center}</center>")
        shape = shape.replace("</mesh>", "<scale>2 3 4</scale></mesh>")
        (points,) = corners(sdf(tmp_path, link(shape)))
        expected = (TETRAHEDRON - middle) * [2, 3, 4]
        np.testing.assert_allclose(by_height(points), by_height(expected), atol=1e-5)


def test_submeshes_of_one_file_are_meshes_of_their_own(tmp_path):
    pieces = [f"o {name}\nv 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\n" for name, z in (("low", 0), ("high", 2))]
    (tmp_path / "parts.obj").write_text("".join(pieces))
    mesh = "<mesh><uri>parts.obj</uri>{}</mesh>"
    names = [mesh.format(f"<submesh><name>{name}</name></submesh>") for name in ("low", "high")] + [mesh.format("")]
    robot = sdf(tmp_path, link("".join(map(visual, names))))
    assert [points[:, 2].tolist() for points in corners(robot)] == [[0] * 3, [2] * 3, [0] * 3 + [2] * 3]


def test_joints_of_sdf_of_other_kinds_are_told(tmp_path):
    links = "".join(link(BOX, name) for name in "abc")
    body = links + joint("ball", "") + joint("fixed", "", "k", "a", "c")
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.9"><model name="m">{body}</model></sdf>')
    with pytest.warns(UserWarning, match=r"leaves out the motion of ball joints \(1\)$"):
        assert not robotics.load(tmp_path / "m.sdf").joint_limits


@pytest.mark.parametrize("angles", ((0.3, 0.2, 0.1), (-2, 1.5, 3), (0, 0, 0), (0, -0.5, 0)))
def test_the_command_tells_a_mounting_as_a_drive_file_has_it(angles):
    yaw, pitch, roll = angles
    local = np.eye(4)
    local[:3, :3], local[:3, 3] = rpy(roll, pitch, yaw), (1, 2, 3)
    turned = f", yaw_pitch_roll_deg {', '.join(f'{value:.3f}' for value in np.degrees(angles))}" if any(angles) else ""
    assert place_of(local) == f"1.000, 2.000, 3.000{turned}"
    assert shown("a\x1b[31mb") == "a?[31mb"
