# SPDX-License-Identifier: Apache-2.0
"""Traffic of SUMO and OpenSCENARIO becomes actors that a drive takes."""

import json
import math
import re

import numpy as np
import pytest
from conftest import REPOSITORY

from gnosphere import drive as drives
from gnosphere import robotics

FCD = """<fcd-export><timestep time="0.00"><vehicle id="a" x="10" y="0" angle="90" type="passenger" speed="5"/></timestep>
<timestep time="1.00"><vehicle id="a" x="15" y="0" angle="90" type="passenger"/><vehicle id="tram" x="0" y="0" angle="0"
type="rail"/><person id="p" x="3" y="4" angle="0" type="DEFAULT_PEDTYPE"/></timestep></fcd-export>"""

XOSC = """<OpenSCENARIO><Entities><ScenarioObject name="Ego"><Vehicle vehicleCategory="car"/></ScenarioObject>
<ScenarioObject name="Walker"><Pedestrian pedestrianCategory="pedestrian"/></ScenarioObject></Entities>
<Storyboard><Story><Act><ManeuverGroup><Actors><EntityRef entityRef="Walker"/></Actors><Maneuver><Event><Action>
<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name="t"><Shape><Polyline>
<Vertex time="2"><Position><WorldPosition x="1" y="2" z="0.5" h="1.5707963"/></Position></Vertex>
<Vertex time="0"><Position><WorldPosition x="1" y="0"/></Position></Vertex>
<Vertex time="3"><Position><LanePosition/></Position></Vertex>
</Polyline></Shape></Trajectory></TrajectoryRef></FollowTrajectoryAction></RoutingAction></PrivateAction></Action></Event>
</Maneuver></ManeuverGroup></Act></Story></Storyboard></OpenSCENARIO>"""


def test_sumo(tmp_path, folder):
    (tmp_path / "fcd.xml").write_text(FCD)
    with pytest.warns(UserWarning, match=r"leaves out the type 'rail' \(1\)"):
        actors = robotics.read_traffic(
            tmp_path / "fcd.xml",
            {"p*": "truck", "passenger": "car", "*PED*": "person"},
            {"*PED*": "pedestrian"},
            {"pass*": 9.0, "passenger": 4.0},
        )
    assert [(actor["name"], actor["model"], actor["class"]) for actor in actors] == [
        ("a", "car", "car"), ("p", "person", "pedestrian"),
    ]  # fmt: skip
    assert actors[0]["trajectory"]["waypoints"] == [
        {"time": 0.0, "position": [8.0, 0.0, 0.0], "yaw_deg": 0.0},
        {"time": 1.0, "position": [13.0, 0.0, 0.0], "yaw_deg": 0.0},
    ]
    assert actors[1]["trajectory"]["waypoints"] == [{"time": 1.0, "position": [3.0, 4.0, 0.0], "yaw_deg": 90.0}]
    # A drive takes them.
    given = json.loads((folder / "drive.json").read_text())
    known = given["actors"][0]
    given["actors"] = [{**actor, "model": known["model"], "class": known["class"]} for actor in actors]
    (folder / "traffic.json").write_text(json.dumps(given))
    assert drives.read_drive(folder / "traffic.json") is not None


def test_the_page(tmp_path, folder, monkeypatch):
    """The block of docs/robotics.md adds a car and a person to the town's drive, which takes them."""
    monkeypatch.chdir(tmp_path)
    text = FCD.replace("passenger", "DEFAULT_VEHTYPE").replace('"tram"', '"t"').replace("rail", "DEFAULT_VEHTYPE")
    (tmp_path / "fcd.xml").write_text(text)
    page = (REPOSITORY / "docs" / "robotics.md").read_text()
    (block,) = (one for one in re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S) if "fcd.xml" in one)
    drive = json.loads((folder / "drive.json").read_text())
    count = len(drive["actors"])
    exec(compile(block, "docs/robotics.md", "exec"), {"drive": drive, "robotics": robotics})
    added = {actor["name"]: actor for actor in drive["actors"][count:]}
    assert {name: actor["model"] for name, actor in added.items()} == {"a": "car", "t": "car", "p": "person"}
    assert added["a"]["trajectory"]["waypoints"][0]["position"] == [10 - 4.5 / 2, 0, 0]  # SUMO's 10 is its front
    (folder / "traffic.json").write_text(json.dumps(drive))
    assert drives.read_drive(folder / "traffic.json") is not None


def test_the_timing_of_open_scenario(tmp_path):
    def times(timing):
        reference = f"</TrajectoryRef><TimeReference>{timing}</TimeReference>"
        (tmp_path / "a.xosc").write_text(XOSC.replace("</TrajectoryRef>", reference))
        with pytest.warns(UserWarning) as told:
            (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
        starts = "the starts of trajectories with relative times, which are taken as 0 (1)" in str(told[0].message)
        return [point["time"] for point in walker["trajectory"]["waypoints"]], starts

    assert times("<None/>") == ([0, 2], False)
    timing = '<Timing domainAbsoluteRelative="{}" offset="5" scale="2"/>'
    assert times(timing.format("absolute")) == ([5, 9], False)
    assert times(timing.format("relative")) == ([5, 9], True)


def fcd(path, *steps, step=0.5):
    """Writes an FCD file, whose time steps have the given elements, and returns its name."""
    elements = "".join(f'<timestep time="{i * step:.2f}">{things}</timestep>' for i, things in enumerate(steps))
    path.write_text(f"<fcd-export>{elements}</fcd-export>")
    return path


def test_sumo_without_lengths(tmp_path):
    (tmp_path / "fcd.xml").write_text(FCD)
    ahead = "the lengths of vehicles of the type '{}', which are half of it too far ahead (1)"
    with pytest.warns(UserWarning) as told:
        robotics.read_traffic(tmp_path / "fcd.xml", {"*": "car"})
    assert ahead.format("passenger") in str(told[0].message) and ahead.format("rail") in str(told[0].message)
    # Patterns of lengths that fit some types do not silence the warning of the others, nor do types that are left out
    # have one.
    with pytest.warns(UserWarning) as told:
        robotics.read_traffic(tmp_path / "fcd.xml", {"*": "car"}, lengths={"pass*": 4.0})
    assert str(told[0].message).endswith("fcd.xml leaves out " + ahead.format("rail"))
    with pytest.warns(UserWarning) as told:
        robotics.read_traffic(tmp_path / "fcd.xml", {"pass*": "car", "*PED*": "person"}, lengths={"pass*": 4.0})
    assert str(told[0].message).endswith("fcd.xml leaves out the type 'rail' (1)")


def test_a_vehicle_and_a_person_with_one_id_of_sumo_are_two_actors(tmp_path):
    step = """<vehicle id="0" x="{}" y="0" angle="90" type="car"/><person id="0" x="3" y="{}" angle="0" type="ped"/>
<person id="1" x="9" y="9" angle="0" type="ped"/>"""
    file = fcd(tmp_path / "fcd.xml", step.format(10, 4), step.format(15, 5))
    actors = robotics.read_traffic(file, {"car": "car", "ped": "person"}, lengths={"car": 4.0})
    assert [(actor["name"], actor["model"]) for actor in actors] == [
        ("0", "car"), ("person 0", "person"), ("1", "person"),
    ]  # fmt: skip
    assert [point["position"] for point in actors[0]["trajectory"]["waypoints"]] == [[8, 0, 0], [13, 0, 0]]
    assert [point["position"] for point in actors[1]["trajectory"]["waypoints"]] == [[3, 4, 0], [3, 5, 0]]


def test_persons_of_sumo_are_left_out_while_they_ride(tmp_path):
    car = '<vehicle id="c" x="{0}" y="0" angle="90" type="car" speed="10"/>'
    person = '<person id="p" x="{}" y="{}" angle="0" type="ped" speed="1" {}/>'
    told_by_place = (person.format(10, 0, ""), person.format(15, 0, ""))
    told_by_attribute = (person.format(9, 1, 'vehicle="c"'), person.format(14, 1, 'vehicle="c"'))
    for riding in (told_by_place, told_by_attribute):
        file = fcd(
            tmp_path / "fcd.xml",
            car.format(5) + person.format(10, 1, 'vehicle=""'),
            car.format(10) + riding[0],
            car.format(15) + riding[1],
            car.format(20) + person.format(15, 1, ""),
        )
        with pytest.warns(UserWarning, match=r"leaves out persons while they ride \(1\), .* absent .* \(1\)$"):
            actors = robotics.read_traffic(file, {"car": "car", "ped": "person"}, lengths={"car": 4.0})
        assert [actor["name"] for actor in actors] == ["c", "p", "p part 2"]
        before, after = (actor["trajectory"]["waypoints"] for actor in actors[1:])
        assert [(point["time"], point["position"]) for point in before] == [(0.0, [10, 1, 0])]
        assert [(point["time"], point["position"]) for point in after] == [(1.5, [15, 1, 0])]


def test_containers_of_sumo_are_left_out_with_a_warning(tmp_path):
    file = fcd(tmp_path / "fcd.xml", '<container id="b" x="1" y="2" angle="0"/>')
    with pytest.warns(UserWarning, match=r"fcd.xml leaves out <container> \(1\)$"):
        assert robotics.read_traffic(file, {"*": "box"}) == []


def test_a_vehicle_of_sumo_is_gone_while_it_is_absent(tmp_path):
    def step(x):
        return f'<vehicle id="stays" x="{x}" y="9" angle="90" type="car"/>'

    def both(x):
        return step(x) + f'<vehicle id="tele" x="{10 * x}" y="0" angle="90" type="car"/>'

    file = fcd(tmp_path / "fcd.xml", both(0), both(1), step(2), step(3), both(4), both(5), step(6), both(7))
    absent = r"leaves out the ways of vehicles and persons while they are absent or teleport, .* \(2\)$"
    with pytest.warns(UserWarning, match=absent):
        actors = robotics.read_traffic(file, {"car": "car"}, lengths={"car": 0.0})
    assert [(actor["name"], actor["outside"]) for actor in actors] == [
        ("stays", "gone"), ("tele", "gone"), ("tele part 2", "gone"), ("tele part 3", "gone"),
    ]  # fmt: skip
    times = [[point["time"] for point in actor["trajectory"]["waypoints"]] for actor in actors]
    assert times == [[i / 2 for i in range(8)], [0.0, 0.5], [2.0, 2.5], [3.5]]


def test_a_vehicle_of_sumo_that_is_seen_less_often_than_others_is_one_actor(tmp_path):
    steps = [f'<vehicle id="often" x="{i}" y="9" angle="90"/>' for i in range(13)]
    for i in range(0, 13, 4):
        steps[i] += f'<vehicle id="seldom" x="{i}" y="0" angle="90"/>'
    actors = robotics.read_traffic(fcd(tmp_path / "fcd.xml", *steps), {"*": "car"}, lengths={"*": 0.0})
    assert [(actor["name"], len(actor["trajectory"]["waypoints"])) for actor in actors] == [
        ("often", 13),
        ("seldom", 4),
    ]


def test_time_steps_of_sumo_ascend(tmp_path):
    file = tmp_path / "fcd.xml"
    file.write_text('<fcd-export><timestep time="1"/><timestep time="1"/></fcd-export>')
    with pytest.raises(ValueError, match=r"fcd.xml: <timestep time='1'> does not come after the one before, 1$"):
        robotics.read_traffic(file, {"*": "car"})
    file.write_text("<fcd-export><timestep/></fcd-export>")
    with pytest.raises(ValueError, match="fcd.xml: a <timestep> has no time$"):
        robotics.read_traffic(file, {"*": "car"})
    file = fcd(tmp_path / "fcd.xml", '<vehicle id="a" x="nan" y="0" angle="90"/>')
    with pytest.raises(ValueError, match="fcd.xml: <vehicle x='nan'> is not finite$"):
        robotics.read_traffic(file, {"*": "car"})


def test_a_vehicle_of_sumo_does_not_slide_where_it_teleports(tmp_path):
    places = [(0, 10), (5, 10), (8, 6), (8, 0), (8, 0), (120, 9), (124.5, 9), (129, 12.2)]
    file = fcd(tmp_path / "fcd.xml", *(f'<vehicle id="a" x="{x}" y="0" angle="90" speed="{v}"/>' for x, v in places))
    with pytest.warns(UserWarning, match=r"while they are absent or teleport, who go on as further actors \(1\)$"):
        actors = robotics.read_traffic(file, {"*": "car"}, lengths={"*": 0.0})
    times = [[point["time"] for point in actor["trajectory"]["waypoints"]] for actor in actors]
    assert times == [[0.0, 0.5, 1.0, 1.5, 2.0], [2.5, 3.0, 3.5]]
    # Between the time steps of a long period a vehicle may start and stop again.
    stops = (f'<vehicle id="a" x="{x}" y="0" angle="90" speed="0"/>' for x in (0, 90, 180))
    (actor,) = robotics.read_traffic(fcd(tmp_path / "b.xml", *stops, step=10), {"*": "car"}, lengths={"*": 0.0})
    assert len(actor["trajectory"]["waypoints"]) == 3


def test_yaws_of_sumo_do_not_jump_at_north_or_west(tmp_path):
    angles = [350, 358, 4, 356, 280, 271, 260, 180, 90, 0]
    file = fcd(tmp_path / "fcd.xml", *(f'<vehicle id="a" x="{i}" y="0" angle="{a}"/>' for i, a in enumerate(angles)))
    (actor,) = robotics.read_traffic(file, {"*": "car"}, lengths={"*": 4.0})
    yaws = [point["yaw_deg"] for point in actor["trajectory"]["waypoints"]]
    assert yaws == [100, 92, 86, 94, 170, 179, 190, 270, 360, 450]


def test_the_slope_of_sumo_is_a_pitch(tmp_path):
    step = '<vehicle id="a" x="{0}" y="0" z="7" angle="0" type="car" slope="30"/>'
    step += '<person id="p" x="{0}" y="5" z="7" angle="0" type="ped" slope="30"/>'
    file = fcd(tmp_path / "fcd.xml", step.format(0), step.format(1))
    car, person = robotics.read_traffic(file, {"*": "car"}, lengths={"car": 4.0})
    waypoint = car["trajectory"]["waypoints"][0]
    # Uphill to the north: the middle is 2 m back along the slope, and the front looks up.
    np.testing.assert_allclose(waypoint["position"], [0, -2 * math.cos(math.pi / 6), 6], atol=1e-4)
    x, y, z, w = waypoint["orientation"]
    forward = [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)]
    np.testing.assert_allclose(forward, [0, math.cos(math.pi / 6), 0.5], atol=1e-8)
    assert "yaw_deg" not in waypoint
    # Persons walk upright.
    assert person["trajectory"]["waypoints"][0] == {"time": 0.0, "position": [0, 5, 7], "yaw_deg": 90}


def test_longitudes_and_latitudes_of_sumo_are_refused(tmp_path):
    def drive(per_metre, place, attributes):
        x = [place + 5 * i * per_metre for i in range(4)]
        things = (f'<vehicle id="a" x="{value:.6f}" y="48.139700" angle="90" {attributes}/>' for value in x)
        return robotics.read_traffic(fcd(tmp_path / "fcd.xml", *things), {"*": "car"}, lengths={"*": 4.0})

    degrees = 1 / 111195 / math.cos(math.radians(48))
    for attributes in ('speed="10"', ""):
        with pytest.raises(ValueError, match=r"fcd.xml: x and y .* degrees, .* without --fcd-output.geo"):
            drive(degrees, 11.5661, attributes)
        assert len(drive(1, 11.5661, attributes)) == 1  # metres
        assert len(drive(0, 11.5661, attributes)) == 1  # nothing moves


def test_numbers_that_sumo_does_not_state_are_named(tmp_path):
    file = fcd(tmp_path / "fcd.xml", '<vehicle id="a" y="0" angle="90"/>')
    with pytest.raises(ValueError, match=r"fcd.xml: <vehicle> has no x; SUMO writes it if"):
        robotics.read_traffic(file, {"*": "car"})
    file = fcd(tmp_path / "fcd.xml", '<vehicle id="a" x="east" y="0" angle="90"/>')
    with pytest.raises(ValueError, match=r"fcd.xml: <vehicle x='east'> is no number$"):
        robotics.read_traffic(file, {"*": "car"})


def test_entities_of_open_scenario_stand_where_init_puts_them(tmp_path):
    init = """<Init><Actions><Private entityRef="{}"><PrivateAction><TeleportAction><Position>{}</Position>
</TeleportAction></PrivateAction></Private></Actions></Init>"""
    place = '<WorldPosition x="$Dist" y="-2" h="3.1415927"/>'
    text = XOSC.replace(
        "<Entities>",
        """<ParameterDeclarations><ParameterDeclaration name="Dist" parameterType="double" value="40"/>
</ParameterDeclarations><Entities>""",
    ).replace('<Vehicle vehicleCategory="car"/>', '<CatalogReference catalogName="v" entryName="hatchback_red"/>')
    (tmp_path / "a.xosc").write_text(text.replace("<Storyboard>", "<Storyboard>" + init.format("Ego", place)))
    with pytest.warns(UserWarning, match="vertices without"):
        ego, walker = robotics.read_traffic(tmp_path / "a.xosc", {"hatchback*": "car", "pedestrian": "person"})
    assert ego["model"] == "car" and ego["outside"] == walker["outside"] == "hold"
    assert ego["trajectory"]["waypoints"] == [{"time": 0.0, "position": [40.0, -2.0, 0.0], "yaw_deg": 180.0}]
    (tmp_path / "a.xosc").write_text(
        text.replace("<Storyboard>", "<Storyboard>" + init.format("Ego", "<LanePosition/>"))
    )
    with pytest.warns(UserWarning, match=r"places of Init that are no WorldPosition \(1\)"):
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"*": "person"})
    (tmp_path / "a.xosc").write_text(XOSC.replace('x="1" y="2"', 'x="$Far" y="2"'))
    with pytest.raises(ValueError, match=r"a.xosc: <WorldPosition x='\$Far'> is no number, and no parameter with one"):
        robotics.read_traffic(tmp_path / "a.xosc", {"*": "person"})


def test_an_entity_stands_where_init_puts_it_until_its_trajectory_begins(tmp_path):
    init = """<Storyboard><Init><Actions><Private entityRef="Walker"><PrivateAction><TeleportAction><Position>
<WorldPosition x="$there" y="7"/></Position></TeleportAction></PrivateAction></Private></Actions></Init>"""
    text = XOSC.replace("<Storyboard>", init).replace('<Vertex time="0">', '<Vertex time="1.5">')
    story = """<ParameterDeclarations><ParameterDeclaration name="there" value="$far"/>
<ParameterDeclaration name="far" value="-9"/></ParameterDeclarations><Act delay="${2 * $unknown}">"""
    (tmp_path / "a.xosc").write_text(text.replace("<Act>", story))
    with pytest.warns(UserWarning, match="vertices without"):
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
    waypoints = walker["trajectory"]["waypoints"]
    assert [point["time"] for point in waypoints] == [0.0, 1.499, 1.5, 2.0]
    assert waypoints[0]["position"] == waypoints[1]["position"] == [-9.0, 7.0, 0.0]
    assert waypoints[2]["position"] == [1.0, 0.0, 0.0]
    # A trajectory that begins at once leaves no time for that.
    at_once = text.replace('<Vertex time="1.5">', '<Vertex time="0">').replace("$there", "4")
    (tmp_path / "a.xosc").write_text(at_once)
    with pytest.warns(UserWarning, match="vertices without"):
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
    assert [point["time"] for point in walker["trajectory"]["waypoints"]] == [0.0, 2.0]


def test_trajectories_of_open_scenario_follow_each_other(tmp_path):
    action = XOSC[XOSC.index("<FollowTrajectoryAction>") : XOSC.index("</RoutingAction>")]
    last = '<Vertex time="3"><Position><LanePosition/></Position></Vertex>'
    follow = '<TrajectoryFollowingMode followingMode="follow"/></FollowTrajectoryAction>'
    then = (
        action.replace(last, "")
        .replace('time="2"', 'time="5"').replace('x="1" y="2" z="0.5" h="1.5707963"', 'x="4" y="2" z="0.5"')
        .replace('time="0"', 'time="2"').replace('x="1" y="0"', 'x="{}" y="2" z="0.5"')
        .replace("</FollowTrajectoryAction>", follow)
    )  # fmt: skip
    text = XOSC.replace(last, "")

    def waypoints(start):
        both = text.replace("</RoutingAction>", then.format(start) + "</RoutingAction>")
        (tmp_path / "a.xosc").write_text(both)
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
        return walker["trajectory"]["waypoints"]

    assert waypoints("1") == [
        {"time": 0.0, "position": [1.0, 0.0, 0.0], "yaw_deg": 0.0},
        {"time": 2.0, "position": [1.0, 2.0, 0.5], "yaw_deg": 90.0},
        {"time": 5.0, "position": [4.0, 2.0, 0.5]},  # looks along its way
    ]
    with pytest.warns(UserWarning, match=r"places at times at which an entity is elsewhere, too \(1\)"):
        assert len(waypoints("3")) == 3


def test_pitch_and_roll_of_open_scenario(tmp_path):
    follow = '</TrajectoryRef><TrajectoryFollowingMode followingMode="follow"/>'
    text = XOSC.replace('h="1.5707963"', 'p="-0.2"').replace("</TrajectoryRef>", follow)
    (tmp_path / "a.xosc").write_text(text)
    with pytest.warns(UserWarning, match=r"the pitch and the roll of vertices without a heading \(1\)"):
        robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
    (tmp_path / "a.xosc").write_text(XOSC.replace('h="1.5707963"', 'h="0.3" p="-0.2" r="0.1"'))
    with pytest.warns(UserWarning, match="vertices without"):
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
    about = [([0, 0, 1], 0.3), ([0, 1, 0], -0.2), ([1, 0, 0], 0.1)]
    turn = np.eye(3)
    for axis, angle in about:  # Rodrigues
        cross = np.cross(np.eye(3), axis)
        turn = turn @ (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
    x, y, z, w = walker["trajectory"]["waypoints"][1]["orientation"]
    forward = [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)]
    np.testing.assert_allclose(forward, turn[:, 0], atol=1e-8)
    np.testing.assert_allclose(2 * (y * z + x * w), turn[2, 1], atol=1e-8)


def test_open_scenario(tmp_path):
    (tmp_path / "a.xosc").write_text(XOSC)
    with pytest.warns(UserWarning, match=r"leaves out vertices without a time or a WorldPosition \(1\)"):
        (walker,) = robotics.read_traffic(tmp_path / "a.xosc", {"pedestrian": "person"})
    assert walker["name"] == "Walker" and walker["model"] == "person"
    first, last = walker["trajectory"]["waypoints"]
    assert first == {"time": 0.0, "position": [1.0, 0.0, 0.0], "yaw_deg": 0.0}
    assert last == {"time": 2.0, "position": [1.0, 2.0, 0.5], "yaw_deg": 90.0}
    (tmp_path / "b.xml").write_text("<net/>")
    with pytest.raises(ValueError, match="is XML of <net>"):
        robotics.read_traffic(tmp_path / "b.xml", {})


def test_the_faster_of_two_speeds_says_how_far_a_vehicle_of_sumo_comes(tmp_path):
    """It starts or stops within a time step, in which it comes 24 m, and 10 m beyond is what it may."""
    for speeds in ((30, 0), (0, 30)):
        both = [f'<vehicle id="a" x="{24 * i}" y="0" angle="90" speed="{v}"/>' for i, v in enumerate(speeds)]
        (actor,) = robotics.read_traffic(fcd(tmp_path / "fcd.xml", *both), {"*": "car"}, lengths={"*": 0.0})
        assert len(actor["trajectory"]["waypoints"]) == 2
    both = [f'<vehicle id="a" x="{28 * i}" y="0" angle="90" speed="30"/>' for i in range(2)]
    with pytest.warns(UserWarning, match="while they are absent or teleport"):
        assert len(robotics.read_traffic(fcd(tmp_path / "fcd.xml", *both), {"*": "car"}, lengths={"*": 0.0})) == 2


def test_detours_of_sumo_within_a_time_step_are_no_degrees(tmp_path):
    """A bus that drives a loop of 200 m is 5 m further after it."""
    steps = (f'<vehicle id="a" x="{5 * i}" y="0" angle="90" speed="20"/>' for i in range(3))
    (actor,) = robotics.read_traffic(fcd(tmp_path / "fcd.xml", *steps, step=10), {"*": "car"}, lengths={"*": 0.0})
    assert len(actor["trajectory"]["waypoints"]) == 3


def test_kinds_of_entities_of_open_scenario(tmp_path):
    """The category of a vehicle, a pedestrian or a thing, or what each of them is where none is stated."""
    place = """<Private entityRef="{0}"><PrivateAction><TeleportAction><Position><WorldPosition x="{1}" y="0"/>
</Position></TeleportAction></PrivateAction></Private>"""
    things = [
        ('<Vehicle vehicleCategory="truck"/>', "truck"), ('<Pedestrian pedestrianCategory="animal"/>', "animal"),
        ('<MiscObject miscObjectCategory="barrier"/>', "barrier"), ("<Vehicle/>", "vehicle"),
        ("<MiscObject/>", "miscobject"),        ('<CatalogReference catalogName="c" entryName="van"/>', "van"),
    ]  # fmt: skip
    entities = "".join(f'<ScenarioObject name="{i}">{text}</ScenarioObject>' for i, (text, _) in enumerate(things))
    places = "".join(place.format(i, i) for i in range(len(things)))
    (tmp_path / "a.xosc").write_text(
        f"<OpenSCENARIO><Entities>{entities}</Entities><Storyboard><Init><Actions>{places}</Actions></Init>"
        "</Storyboard></OpenSCENARIO>"
    )
    models = {kind: f"model of {kind}" for _, kind in things}
    actors = robotics.read_traffic(tmp_path / "a.xosc", models, centred=False)
    assert [actor["model"] for actor in actors] == [f"model of {kind}" for _, kind in things]
    assert [actor["trajectory"]["waypoints"][0]["position"] for actor in actors] == [[i, 0, 0] for i in range(6)]


def test_the_actors_of_a_group_of_open_scenario_go_one_way(tmp_path):
    both = '<EntityRef entityRef="Walker"/><EntityRef entityRef="Ego"/>'
    text = XOSC.replace('<EntityRef entityRef="Walker"/>', both).replace(
        '<Vertex time="3"><Position><LanePosition/></Position></Vertex>', ""
    )
    (tmp_path / "a.xosc").write_text(text)
    ego, walker = robotics.read_traffic(tmp_path / "a.xosc", {"car": "car", "pedestrian": "person"})
    assert (ego["name"], walker["name"]) == ("Ego", "Walker")
    assert ego["trajectory"] == walker["trajectory"] and len(ego["trajectory"]["waypoints"]) == 2
    clothoid = text.replace("<Polyline>", "<Clothoid>").replace("</Polyline>", "</Clothoid>")
    (tmp_path / "a.xosc").write_text(clothoid)
    with pytest.warns(UserWarning, match=r"leaves out trajectories that are no polylines \(1\)"):
        robotics.read_traffic(tmp_path / "a.xosc", {"*": "car"})


def test_the_offset_of_a_network_moves_traffic_as_it_moves_a_town(tmp_path):
    file = fcd(tmp_path / "fcd.xml", *(f'<vehicle id="a" x="{10 + i}" y="20" z="1" angle="90"/>' for i in range(2)))

    def way(network, name="map.xodr", source=file):
        (tmp_path / name).write_text(network)
        (actor,) = robotics.read_traffic(source, {"*": "car"}, lengths={"*": 0.0}, network=tmp_path / name)
        return actor["trajectory"]["waypoints"]

    plain = "<OpenDRIVE{}><header>{}</header></OpenDRIVE>"
    assert way(plain.format("", ""))[0] == {"time": 0.0, "position": [10, 20, 1], "yaw_deg": 0}
    far = '<offset x="649187.87" y="5318235.61" z="500" hdg="0"/>'
    for xmlns in ("", ' xmlns="http://code.asam.net/simulation/standard/opendrive_schema"'):
        assert way(plain.format(xmlns, far))[1]["position"] == [649198.87, 5318255.61, 501]
    # netconvert adds the netOffset of a network to what the projection gives, and its OpenDRIVE files take it back.
    location = '<net><location netOffset="-649187.87,-5318235.61"/></net>'
    assert way(location, "map.net.xml")[1]["position"] == [649198.87, 5318255.61, 1]
    assert way("<net/>", "map.net.xml")[1]["position"] == [11, 20, 1]
    # A header first moves, and then turns about the new origin.
    turned = way(plain.format("", f'<offset x="5" y="-20" z="0" hdg="{math.pi / 2}"/>'))
    assert turned[1] == {"time": 0.5, "position": [0, 16, 1], "yaw_deg": 90}
    file.write_text(file.read_text().replace('angle="90"', 'angle="90" slope="30"'))
    x, y, z, w = way(plain.format("", f'<offset hdg="{math.pi / 2}"/>'))[0]["orientation"]
    forward = [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)]
    np.testing.assert_allclose(forward, [0, math.cos(math.pi / 6), 0.5], atol=1e-8)
    for bad, message in (
        ("<osm/>", "map.xodr is XML of <osm>"), ("<net", "map.xodr is not XML"),
        ('<net><location netOffset="far"/></net>', "map.xodr: "),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            way(bad)


BOX = """<Vehicle vehicleCategory="car"><BoundingBox><Center x="1.4" y="0.2" z="0.75"/><Dimensions width="2" length="4.6"
height="1.5"/></BoundingBox></Vehicle>"""


def test_the_middle_of_the_box_of_open_scenario_is_the_middle_of_the_model(tmp_path):
    init = """<Storyboard><Init><Actions><Private entityRef="Ego"><PrivateAction><TeleportAction><Position>
<WorldPosition x="7" y="3" h="3.14159265"/></Position></TeleportAction></PrivateAction></Private></Actions></Init>"""
    text = XOSC.replace('<Pedestrian pedestrianCategory="pedestrian"/>', BOX).replace(
        '<Vehicle vehicleCategory="car"/>', BOX
    )
    text = text.replace("<Storyboard>", init).replace(
        '<Vertex time="3"><Position><LanePosition/></Position></Vertex>', ""
    )
    file = tmp_path / "a.xosc"

    def places(text, **settings):
        file.write_text(text)
        actors = robotics.read_traffic(file, {"*": "car"}, **settings)
        return [[point["position"] for point in actor["trajectory"]["waypoints"]] for actor in actors]

    # The ego looks along -x; the other one at first along x, and then along y.
    assert places(text) == [[[5.6, 2.8, 0]], [[2.4, 0.2, 0], [0.8, 3.4, 0.5]]]
    assert places(text, centred=False) == [[[7, 3, 0]], [[1, 0, 0], [1, 2, 0.5]]]
    # Uphill the middle is higher.
    climbing = places(text.replace('h="1.5707963"', f'h="0" p="{-math.pi / 6}"'))[1][1]
    np.testing.assert_allclose(climbing, [1 + 1.4 * math.cos(math.pi / 6), 2.2, 0.5 + 0.7], atol=1e-4)
    # Without headings the entity looks along its way, and at a bend half-way between the two.
    follow = '</TrajectoryRef><TrajectoryFollowingMode followingMode="follow"/>'
    bend = '<Vertex time="4"><Position><WorldPosition x="5" y="2"/></Position></Vertex></Polyline>'
    along = text.replace('h="1.5707963"', "").replace("</TrajectoryRef>", follow).replace("</Polyline>", bend)
    half = math.sqrt(0.5)
    expected = [[0.8, 1.4, 0], [1 + 1.2 * half, 2 + 1.6 * half, 0.5], [6.4, 2.2, 0]]
    np.testing.assert_allclose(places(along)[1], expected, atol=2e-4)
    # Boxes of catalogues are not read.
    with pytest.warns(UserWarning, match=r"the centres of the boxes of entries in catalogues \(1\)$"):
        places(text.replace(BOX, '<CatalogReference catalogName="c" entryName="van"/>', 1))


def test_actions_of_open_scenario_that_are_not_followed_are_counted(tmp_path):
    speed = "<SpeedAction><SpeedActionTarget><AbsoluteTargetSpeed value='{}'/></SpeedActionTarget></SpeedAction>"

    def told(text):
        (tmp_path / "a.xosc").write_text(text)
        with pytest.warns(UserWarning) as warned:
            robotics.read_traffic(tmp_path / "a.xosc", {"*": "car"})
        return str(warned[0].message).partition(" leaves out ")[2]

    text = XOSC.replace('<Vertex time="3"><Position><LanePosition/></Position></Vertex>', "")
    story = speed.format(9) + "<LaneChangeAction/><LaneChangeAction/><AssignRouteAction/><TeleportAction/>"
    others = text.replace("</RoutingAction>", f"</RoutingAction>{story}")
    assert told(others) == "<SpeedAction> (1), <LaneChangeAction> (2), <AssignRouteAction> (1), <TeleportAction> (1)"
    start, end = text.index("<Trajectory name"), text.index("</TrajectoryRef>")
    catalogue = text[:start] + '<CatalogReference catalogName="c" entryName="t"/>' + text[end:]
    assert told(catalogue) == "trajectories of catalogues (1)"
    # Init gives the ego, which has no trajectory, a speed. That of the walker is the trajectory's.
    init = "<Storyboard><Init><Actions>" + "".join(
        f'<Private entityRef="{name}"><PrivateAction>{speed.format(value)}</PrivateAction></Private>'
        for name, value in (("Ego", 10), ("Ego", 0), ("Walker", 1))
    )
    assert told(text.replace("<Storyboard>", init + "</Actions></Init>")) == "<SpeedAction> (1)"
