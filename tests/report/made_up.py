# SPDX-License-Identifier: Apache-2.0
"""Reports in the format of tools/report from two fictitious machines: a GPU by Vulkan and by CUDA, and a CPU."""
import array
import base64
import zlib


def contender(name, stages, ratio=1):
    total = sum(stages.values())
    return {"name": name, "stages_ms": stages, "device_ms": {"median": total, "min": total},
            "total_ms": {"median": total + 1}, "ratio_to_ours": ratio, "device_ratio_to_ours": ratio}


def correctness(fingerprints):
    rows = [{"name": name, "accuracy": "exact", "beams": 100, "ties": 1, "missed": 0, "false_hits": 0, "wrong_range": 0,
             "range_error_max_m": 1e-6, "fingerprint": fingerprint} for name, fingerprint in fingerprints.items()]
    return {"rows": rows, "effects": [{"name": "fog", "fingerprint": "f0f0"}], "wrong": 0}


def case_of(label, contenders):
    return {"outcomes": [{"label": label, "sensor": {"beams": 28800}, "contenders": contenders}],
            "plot": "<svg width='200' height='50'></svg>"}


def device(spec, name, kind, fingerprints):
    ranges = base64.b64encode(zlib.compress(array.array("f", range(64)).tobytes())).decode()
    return {"spec": spec, "name": name, "type": kind, "driver": "a driver", "api_version": "1.3",
            "ranges": {"channels": 4, "columns": 16, "float32": ranges},
            "cases": {"correctness": correctness(fingerprints)}}


def report(devices):
    return {"kind": "gnosphere-report", "version": "0.1.0", "date": "2026-01-01", "left_out": [],
            "machine": {"cpu": "a cpu", "cores": 2, "system": "Linux"}, "devices": devices}


def machines():
    """Returns a machine with a GPU by Vulkan and by CUDA in both arithmetics, and one with lavapipe and the reference."""
    prints = {"sliver": "aaaa", "town": "bbbb"}
    card = device("0", "NVIDIA A", "discrete", prints)
    card["cases"]["figure7"] = case_of("VLP-16", [
        contender("standard", {"project": 0.25, "bin": 0.5}), contender("paper", {"project": 0.3, "bin": 9}),
        contender("cuda", {"project": 0.5, "bin": 0.25}, 1.25), contender("cuda-fast", {"project": 0.125, "bin": 0.25})])
    card["cases"]["effects"] = dict(case_of("all of them", [
        contender("standard", {"bin": 1, "effects": 2}), contender("cuda", {"bin": 1, "effects": 3})]), rows=[])
    card["cases"]["golden"] = {"rows": [{"name": "grid", "hash": "00aa"}, {"name": "list", "hash": "00bb"}],
                               "wrong": ["list: the hash is 00bb, not 00cc"]}
    card["cases"]["heads"] = {"rows": [{"head": "Puck", "beams": 28800, "sub_rays": 19, "ratios": {},
                                        "ms": {"clean": 0.5, "default": 1.5}}]}
    card["cases"]["batches"] = {"rows": [{"scene": "town", "views": 256, "one_by_one_ms_per_view": 0.25,
                                          "batch_ms_per_view": 0.125}]}
    card["cases"]["scaling-triangles"] = {"outcomes": [
        {"label": "30,000,000 triangles", "contenders": [contender("standard", {"bin": 3})],
         "memory": {"scene_bytes": 9e8, "sensor_bytes": 1e6, "work_bytes": 2.5e6}}]}
    card["cases"]["figure7"]["left_out"] = card["cases"]["effects"]["left_out"] = ["embree: not built in"]
    cuda = device("cuda:0", "cuda:0 NVIDIA A", "cuda", prints)
    fast = device("cuda-fast:0", "cuda:0 NVIDIA A, fast arithmetic", "cuda", dict(prints, town="cccc"))
    lavapipe = device("0", "llvmpipe", "cpu", prints)
    lavapipe["cases"]["figure7"] = case_of("VLP-16", [contender("standard", {"project": 4, "bin": 8})])
    reference = device("reference", "reference", "reference", dict(prints, sliver="dddd"))
    lent = report([card, cuda, fast])
    lent["tests"] = [{"subject": "bin_tests", "tests": 12, "skipped": 1, "failed": []},
                     {"subject": "exact_tests", "tests": 9, "skipped": 0, "failed": ["edges", "corners"]}]
    return lent, report([lavapipe, reference])
