# SPDX-License-Identifier: Apache-2.0
"""Traffic of SUMO and OpenSCENARIO becomes actors that a drive takes."""

import json

import pytest

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
