# SPDX-License-Identifier: Apache-2.0
"""Options and effects are bound by the tables of the library."""

import copy
import gc
import json
import re
import warnings
import weakref

import pytest
from conftest import at, beams

import gnosphere as gno


def test_an_assignment_sets_an_option():
    options = gno.SimulatorOptions()
    gno.assign(options, "accuracy=exact")
    gno.assign(options, "tuning.binning=lists")
    assert options.accuracy == gno.Accuracy.exact
    assert options.tuning.binning == gno.Binning.lists
    with pytest.raises(gno.Error, match="no option is called 'binning'; there is tuning.binning"):
        gno.assign(options, "binning=lists")


def test_tuning_takes_keywords():
    tuning = gno.Tuning(binning="slabs", keep_still=False, culling=gno.Culling(rows=False, occlusion="never"))
    assert tuning.binning == gno.Binning.slabs
    assert not tuning.keep_still
    assert not tuning.culling.rows
    assert tuning.culling.occlusion == gno.Culling.Occlusion.never
    assert gno.Tuning(binning=gno.Binning.automatic).binning == gno.Binning.automatic
    assert gno.Tuning(max_buffer_bytes=1 << 40).max_buffer_bytes == 1 << 40
    assert gno.Tuning(binning="auto").binning == gno.Tuning(binning="automatic").binning == gno.Binning.automatic
    with pytest.raises(gno.Error, match="Tuning: binning must be automatic, nearest, lists or slabs, is 'list'"):
        gno.Tuning(binning="list")


def test_effects_of_a_carla_file(tmp_path):
    file = tmp_path / "objects.json"
    top, low = ({"type": "sensor.lidar.ray_cast", "id": name} for name in ("top", "low"))
    file.write_text(json.dumps([top | {"noise_stddev": "0.02"}, low | {"dropoff_general_rate": 0}]))
    assert gno.load_effects(file, mode="top").range_noise.sigma == 0.02
    assert gno.load_effects(file, "low").drop_out.general_rate == 0
    with pytest.raises(gno.Error, match="the effects of the lidars top, low differ"):
        gno.load_effects(file)


def test_effects_take_words():
    Effects = gno.Effects
    assert Effects.Intensity(scale="raw", use="off") == Effects.Intensity(
        scale=Effects.Intensity.Scale.raw, use=gno.EffectUse.off
    )
    assert Effects.AngleNoise(at="point").at == Effects.AngleNoise.At.point
    assert [Effects.Fog(use=word).use.name for word in ("on", "auto", "automatic")] == ["on", "automatic", "automatic"]
    modes = [Effects.Returns(mode=word).mode.name for word in ("second-strongest", "second_strongest")]
    assert modes == ["second_strongest"] * 2
    with pytest.raises(gno.Error, match="Fog: use must be off, on or automatic, is 'onn'"):
        Effects.Fog(use="onn")


def test_choices_are_assigned_by_words():
    effects, sensor, options = gno.Effects(), gno.Sensor(near_hits="hide"), gno.SimulatorOptions(accuracy="draft")
    assert (sensor.near_hits, options.accuracy) == (gno.NearHits.hide, gno.Accuracy.draft)
    effects.fog.use, effects.returns.mode = "on", "second-strongest"
    assert (effects.fog.use, effects.returns.mode) == (gno.EffectUse.on, gno.Effects.Returns.Mode.second_strongest)
    sensor.near_hits, options.accuracy, options.tuning.binning = "see_through", "exact", "auto"
    assert (sensor.near_hits, options.accuracy) == (gno.NearHits.see_through, gno.Accuracy.exact)
    assert options.tuning.binning == gno.Binning.automatic
    assert gno.Material(alpha_mode="mask").alpha_mode == gno.AlphaMode.mask
    assert gno.LoadOptions(up="y", scale=0.01) == gno.LoadOptions(gno.UpAxis.y, 0.01)
    with pytest.raises(gno.Error, match="Sensor: near_hits must be see_through or hide, is 'hid'"):
        sensor.near_hits = "hid"
    with pytest.raises(TypeError):
        sensor.near_hits = 1.5
    assert sensor.near_hits == gno.NearHits.see_through


def test_keywords_that_there_are_not_are_type_errors_with_the_nearest():
    for make, sentence in (
        (lambda: gno.Effects(range_nois=3), "Effects has no 'range_nois'; the nearest are range_noise, "),
        (lambda: gno.Effects.RangeNoise(sigm=3), "RangeNoise has no 'sigm'; the nearest are sigma, "),
        (lambda: gno.Effects.Fog(visiblity=80), "Fog has no 'visiblity'; there are visibility, use"),
        (lambda: gno.Tuning(bining="lists"), "Tuning has no 'bining'; the nearest are binning, "),
        (lambda: gno.Culling(row=False), "Culling has no 'row'; the nearest are rows, "),
        (lambda: gno.Sensor(range_mx=3), "Sensor has no 'range_mx'; the nearest are range_max, "),
        (lambda: gno.Material(roughnes=1), "Material has no 'roughnes'; the nearest are roughness, "),
        (lambda: gno.SimulatorOptions(acuracy=1), "SimulatorOptions has no 'acuracy'; the nearest are accuracy, "),
    ):
        with pytest.raises(TypeError, match=sentence):
            make()


def test_counts_keep_to_the_limits_of_the_table():
    divergence = gno.Effects.Divergence(sub_rays=19)
    for wrong in (2**32 + 7, 0, -1):
        with pytest.raises(gno.Error) as told:
            gno.assign(gno.Effects(), f"divergence.sub_rays={wrong}")
        sentence = re.escape(str(told.value).replace("divergence.", "Divergence: "))
        with pytest.raises(gno.Error, match=sentence):
            gno.Effects.Divergence(sub_rays=wrong)
        with pytest.raises(gno.Error, match=sentence):
            divergence.sub_rays = wrong
    assert divergence.sub_rays == 19
    with pytest.raises(gno.Error, match="Tuning: max_buffer_bytes must be a whole number, 0..18446744073709551615, is"):
        gno.Tuning(max_buffer_bytes=-1)


def test_properties_and_documentation_come_from_the_table():
    tuning = gno.Tuning()
    tuning.max_buffer_bytes = 7
    tuning.float64 = False
    assert (tuning.max_buffer_bytes, tuning.float64, tuning.keep_still) == (7, False, True)
    assert "lists with the bounds of the paper" in gno.Binning.automatic.__doc__
    assert gno.Tuning.max_buffer_bytes.__doc__.startswith("bytes; Upper limit in bytes for any one buffer on a Vulkan")
    assert gno.Effects.Fog.visibility.__doc__.startswith("m; Meteorological optical range")


@pytest.mark.parametrize("name", gno.effect_names())
def test_every_effect_is_a_property_with_its_parameters(name):
    effects = gno.Effects()
    effect = getattr(effects, name.replace("-", "_"))
    assert effect.use in gno.EffectUse
    row = json.loads(gno.to_json(effects))[name]
    for parameter, value in row.items() if isinstance(row, dict) else ():
        assert hasattr(effect, parameter), f"{name} has no {parameter}"
        if isinstance(value, float):
            setattr(effect, parameter, value)
            assert getattr(effect, parameter) == value


class Owner:
    """What has its own methods called by what it holds."""

    def __init__(self, scene, request, kind):
        self.said = []
        self.options = gno.SimulatorOptions(gno.device_by_name("reference"))
        if kind == "warn":
            self.options.warn = self.options.trace = self.say
        elif kind == "copies":
            made = gno.SimulatorOptions(self.options.device, warn=self.say, trace=self.say)
            self.copies = copy.copy(made), gno.drive.RunOptions("out", simulator=made, progress=self.say)
            self.copies[1].simulator = self.copies[0]
        elif kind == "simulator":
            self.options.warn = self.say
            self.simulator = gno.Simulator(scene, request, self.options)
            self.other = gno.Simulator(scene, request, self.options)
            self.options = None

    def say(self, *_):
        self.said.append(1)


@pytest.mark.parametrize("kind", ["warn", "copies", "simulator"])
def test_what_calls_its_owner_is_freed(town, kind):
    request = gno.SensorRequest(beams(), gno.Effects.none())
    owner = Owner(town, request, kind)
    parts = [owner.copies[1].simulator] if kind == "copies" else []
    gc.collect()
    if kind == "simulator":
        assert owner.simulator.scan(gno.Pose()).beam_count() == 9
    if kind == "copies":
        assert parts.pop().warn == owner.say
    gone = weakref.ref(owner)
    del owner
    gc.collect()
    assert gone() is None


def test_a_derived_simulator_that_calls_itself_is_freed(town):
    class Derived(gno.Simulator):
        def __init__(self):
            options = gno.SimulatorOptions(gno.device_by_name("reference"), warn=self.say)
            super().__init__(town, gno.SensorRequest(beams(), gno.Effects.none()), options)

        def say(self, sentence):
            pass

    gone = weakref.ref(Derived())
    gc.collect()
    assert gone() is None


def test_what_is_in_use_is_not_freed(town):
    """A function is kept by the simulator alone, after its options are gone."""
    request = gno.SensorRequest(gno.Sensor(range_max=100, columns=4, channels=[gno.Channel()]))
    said = []

    def say(sentence):
        said.append(sentence)

    gone = weakref.ref(say)
    options = gno.SimulatorOptions(gno.device_by_name("reference"), warn=say)
    run = gno.drive.RunOptions("out", simulator=options)
    simulator = gno.Simulator(town, request, options)
    del say, options
    gc.collect()
    assert gone() is not None
    del run
    gc.collect()
    assert gone() is not None
    shot = gno.Shot(instance_motions=[gno.InstanceMotion(0, gno.Transform())])
    simulator.scan(shot)
    assert said and "object-motion" in said[0]
    del simulator
    gc.collect()
    assert gone() is None


def motion_that_is_left_out(town, options=None):
    """Scans with a motion of an instance, which a sensor without a rotation period leaves out."""
    request = gno.SensorRequest(gno.Sensor(range_max=100, columns=4, channels=[gno.Channel()]))
    simulator = gno.Simulator(town, request, options) if options else gno.Simulator(town, request)
    simulator.scan(gno.Shot(instance_motions=[gno.InstanceMotion(0, gno.Transform())]))


def test_what_is_no_error_is_a_warning_of_python_unless_it_is_silenced(town, device):
    reference = gno.device_by_name("reference")
    every = [gno.SimulatorOptions(reference), copy.deepcopy(gno.SimulatorOptions(reference))]
    if device != reference:
        every.append(None)
    for options in every:
        with pytest.warns(UserWarning, match="object-motion is left out") as told:
            motion_that_is_left_out(town, options)
        assert {warning.filename for warning in told} == {__file__}
    quiet = gno.SimulatorOptions(reference, warn=None)
    assert quiet.warn is None
    assert gno.SimulatorOptions().warn is gno.drive.RunOptions("out").simulator.warn is warnings.warn
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        motion_that_is_left_out(town, quiet)
    assert not told


def test_motion_that_an_accuracy_leaves_out_is_a_warning(town, device):
    if device == gno.device_by_name("reference"):
        pytest.skip("the reference has motion with every accuracy")
    head = gno.Sensor(range_max=100, columns=4, channels=[gno.Channel()], rotation_period=0.1)
    with pytest.warns(UserWarning, match="sensor-motion is left out"):
        gno.Simulator(town, head, gno.SimulatorOptions(device, "exact"))


def test_light_that_ends_behind_four_panes_is_a_warning_of_the_first_scan(square):
    materials = [gno.Material("glass", transmission=0.9)]
    panes = [gno.Instance(0, at(5 + 0.02 * pane)) for pane in range(5)]
    simulator = gno.Simulator(gno.Scene(materials, [square], panes), beams(), gno.SimulatorOptions(device="reference"))
    with pytest.warns(UserWarning, match="9 echoes of 9 beams are lost, .* at most 4 surfaces") as told:
        simulator.scan(gno.Pose())
    assert [warning.filename for warning in told] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert simulator.scan(gno.Pose()).counters.lost_echoes == 9


def test_a_material_table_that_names_nothing_is_a_warning(town):
    table = gno.MaterialTable([gno.MaterialTable.Row("no such", 0.4)])
    with pytest.warns(UserWarning, match="the material table has 'no such', but the scene has no material"):
        gno.Simulator(town, beams(), gno.SimulatorOptions(gno.device_by_name("reference"), materials=table))


def test_a_sensor_is_a_request_of_it_alone(town):
    options = gno.SimulatorOptions(gno.device_by_name("reference"))
    pose = gno.Pose((0, 0, 1.8))
    expected = gno.Simulator(town, gno.SensorRequest(beams()), options).scan(pose)
    simulator = gno.Simulator(town, beams(), options)
    assert simulator.add_sensor(beams(5)) == 1
    assert simulator.scan(pose).ranges.tobytes() == expected.ranges.tobytes()
    assert simulator.scan(pose, 1).beam_count() == 5
    several = gno.Simulator(town, [beams(), gno.SensorRequest(beams(5))], options)
    assert [several.scan(pose, sensor).beam_count() for sensor in range(2)] == [9, 5]
