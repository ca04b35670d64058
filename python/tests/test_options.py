# SPDX-License-Identifier: Apache-2.0
"""Options and effects are bound by the tables of the library."""

import json

import pytest

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
    with pytest.raises(gno.Error, match="Tuning has no 'bining'"):
        gno.Tuning(bining="lists")
    with pytest.raises(gno.Error, match="must be auto, nearest, lists or slabs"):
        gno.Tuning(binning="list")


def test_properties_and_documentation_come_from_the_table():
    tuning = gno.Tuning()
    tuning.max_buffer_bytes = 7
    tuning.float64 = False
    assert (tuning.max_buffer_bytes, tuning.float64, tuning.keep_still) == (7, False, True)
    assert "lists if these pass panes" in gno.Binning.automatic.__doc__
    assert "Error(out_of_memory)" in gno.Tuning.max_buffer_bytes.__doc__
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
