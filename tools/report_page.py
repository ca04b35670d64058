# SPDX-License-Identifier: Apache-2.0
"""Formats a report of tools/report as one self-contained page: tables, inline SVG plots, pictures as data URIs."""
import array
import base64
import html
import math
import struct
import sys
import zlib

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 1100px; padding: 0 16px 48px; color: #222;
       overflow-wrap: anywhere; }
h1 { font-size: 1.6em; } h2 { margin-top: 2em; border-bottom: 1px solid #ccc; } h3 { margin-bottom: .3em; }
.wide { overflow-x: auto; margin-bottom: .8em; }
table { border-collapse: collapse; font-size: 13px; overflow-wrap: normal; }
th, td { border: 1px solid #ddd; padding: 3px 8px; text-align: right; white-space: nowrap; }
th { background: #f4f4f0; white-space: normal; min-width: 4em; }
td:first-child, th:first-child, .text td, .text th { text-align: left; }
.good { background: #dff3e4; } .bad { background: #f9d5c5; font-weight: bold; }
img { display: block; width: 100%; image-rendering: pixelated; border: 1px solid #ccc; }
svg { display: block; max-width: none; }
p.note { color: #555; margin-top: .3em; }
"""


def escaped(value):
    return html.escape(str(value))


def table(rows, marks=None, kind=""):
    """`marks`: (row, column) -> class of a cell; rows count from below the head. `kind`: "text" for tables of words."""
    marks = marks or {}
    head, *body = rows
    lines = ["<tr>" + "".join(f"<th>{escaped(cell)}</th>" for cell in head) + "</tr>"]
    for i, row in enumerate(body):
        cells = (f"<td class='{marks[i, j]}'>" if (i, j) in marks else "<td>" for j in range(len(row)))
        lines.append("<tr>" + "".join(f"{start}{escaped(cell)}</td>" for start, cell in zip(cells, row)) + "</tr>")
    return f"<div class='wide {kind}'><table>\n" + "\n".join(lines) + "\n</table></div>\n"


def figure(value, digits=3):
    """Formats a number with significant digits and thousands separators."""
    if value is None:
        return "-"
    if value >= 10 ** (digits - 1):
        return f"{round(value):,}"
    return f"{value:.{digits}g}"


# Pictures.

def png(width, height, rows, palette):
    """PNG with eight bits per pixel, which are indices into a palette of (red, green, blue)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    colours = b"".join(bytes(colour) for colour in palette)
    data = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 3, 0, 0, 0)) +
            chunk(b"PLTE", colours) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def ramp(anchors):
    """Interpolates 255 evenly spaced colours between the anchors."""
    colours = []
    for i in range(255):
        place = i / 254 * (len(anchors) - 1)
        first = min(int(place), len(anchors) - 2)
        colours.append(tuple(round(a + (b - a) * (place - first))
                             for a, b in zip(anchors[first], anchors[first + 1])))
    return colours


# Colour 0 is for missing values. The anchors for ranges are those of viridis (van der Walt and Smith).
RANGES = [(0, 0, 0)] + ramp([(253, 231, 37), (94, 201, 98), (33, 145, 140), (59, 82, 139), (68, 1, 84)])
DIFFERENCES = [(255, 255, 255)] + ramp([(255, 235, 160), (240, 120, 30), (120, 0, 60)])


def unpacked(ranges):
    values = array.array("f", zlib.decompress(base64.b64decode(ranges["float32"])))
    if sys.byteorder == "big":
        values.byteswap()
    return values


def image(pixels, ranges, palette, words):
    """One pixel per beam. Flips rows: a sensor's lowest channel comes first, a picture's top row."""
    columns, channels = ranges["columns"], ranges["channels"]
    rows = [pixels[row * columns:(row + 1) * columns] for row in reversed(range(channels))]
    data = base64.b64encode(png(columns, channels, rows, palette)).decode()
    return f"<img alt='{escaped(words)}' style='height: {max(96, 3 * channels)}px' src='data:image/png;base64,{data}'>\n"


def range_image(device):
    values = unpacked(device["ranges"])
    top = math.log(121)
    pixels = bytes(0 if math.isnan(v) else 1 + min(254, round(254 * math.log(1 + max(v, 0)) / top)) for v in values)
    return image(pixels, device["ranges"], RANGES, "Ranges as " + device["name"] + " gives them")


def difference(first, other):
    """Returns (beams that differ, largest difference, pixels); the colours are logarithmic from 1e-6 m to 1 m."""
    differ, most, pixels = 0, 0.0, bytearray()
    for a, b in zip(unpacked(first["ranges"]), unpacked(other["ranges"])):
        if a == b or (math.isnan(a) and math.isnan(b)):
            pixels.append(0)
            continue
        differ += 1
        apart = 1.0 if math.isnan(a) or math.isnan(b) else abs(a - b)
        if not (math.isnan(a) or math.isnan(b)):
            most = max(most, apart)
        pixels.append(1 + round(254 * min(1, max(0, 1 + math.log10(apart) / 6))))
    return differ, most, pixels


# Sections.

def judged(devices, names):
    rows = [["device", "cases", "beams", "ties", "missed", "false hits", "wrong range", "largest error, m"]]
    marks = {}
    for name, device in zip(names, devices):
        case = device["cases"].get("correctness")
        if not case:
            continue
        sums = {key: sum(row[key] for row in case["rows"])
                for key in ("beams", "ties", "missed", "false_hits", "wrong_range")}
        most = max(row["range_error_max_m"] for row in case["rows"])
        marks.update({(len(rows) - 1, column): "bad" if sums[key] else "good"
                      for column, key in ((4, "missed"), (5, "false_hits"), (6, "wrong_range"))})
        rows.append([name, len(case["rows"]), *(f"{value:,}" for value in sums.values()), figure(most, 2)])
    return table(rows, marks)


def prints_of(devices):
    """Returns the results of `exact`, by name and by index of the device."""
    prints = {}
    for column, device in enumerate(devices):
        case = device["cases"].get("correctness", {"rows": [], "effects": []})
        for row in [row for row in case["rows"] if row["accuracy"] == "exact"] + case["effects"]:
            prints.setdefault(row["name"], {})[column] = row["fingerprint"]
    return prints


def base_of(devices):
    """Returns the device to compare with: the first CPU, where the tests have run, or else the first device."""
    columns = [i for i, device in enumerate(devices) if device["type"] != "reference"]
    return next((i for i in columns if devices[i]["type"] == "cpu"), columns[0] if columns else None)


def fingerprints(devices, names):
    """Shows which devices give the same bytes: equal letters stand for equal bytes."""
    columns = [i for i, device in enumerate(devices) if device["type"] != "reference"]
    base = base_of(devices)
    rows, marks = [["exact", *(names[i] for i in columns)]], {}
    for name, found in prints_of(devices).items():
        if not set(found) & set(columns):
            continue
        order = dict.fromkeys(found[i] for i in [base, *columns] if i in found)
        letters = {fingerprint: chr(ord("A") + place) for place, fingerprint in enumerate(order)}
        for place, column in enumerate(columns):
            if column in found:
                marks[len(rows) - 1, place + 1] = "good" if letters[found[column]] == "A" else "bad"
        rows.append([name, *(letters.get(found.get(column), "-") for column in columns)])
    return table(rows, marks)


def equality(devices, names):
    """A line per device: equal, or the first difference."""
    base, prints, lines = base_of(devices), prints_of(devices), []
    for column, device in enumerate(devices):
        if device["type"] == "reference" or column == base:
            continue
        common = [name for name, found in prints.items() if base in found and column in found]
        unlike = [name for name in common if prints[name][base] != prints[name][column]]
        line = f"{names[column]} and {names[base]} have no answer in common"
        if common:
            line = f"{names[column]}: equal to {names[base]} in all of {len(common)} answers"
        if unlike:
            line = (f"{names[column]}: unlike {names[base]} in {len(unlike)} of {len(common)} answers, first in "
                    f"'{unlike[0]}'")
            line += ", as fused products may be" if device["spec"].startswith("cuda-fast") else ""
        lines.append(f"<li>{escaped(line)}</li>\n")
    return "<ul>\n" + "".join(lines) + "</ul>\n" if lines else ""


def golden(devices, names):
    """The hash of each golden cloud by device; a wrong one is marked."""
    columns = [i for i, device in enumerate(devices) if "golden" in device["cases"]]
    rows, marks = {}, {}
    for place, column in enumerate(columns):
        case = devices[column]["cases"]["golden"]
        for number, row in enumerate(case["rows"]):
            rows.setdefault(row["name"], ["-"] * len(columns))[place] = row["hash"] or "-"
            wrong = any(line.startswith(row["name"] + ": ") for line in case["wrong"])
            marks[number, place + 1] = "bad" if wrong else "good"
    rows = [["cloud", *(names[i] for i in columns)], *([name, *row] for name, row in rows.items())]
    return columns and table(rows, marks) + ("<p class='note'>Hashes of clouds of <code>exact</code>, which must be "
                                             "those in the repository.</p>\n")


def tests(reports):
    rows, marks = [["subject", "tests", "skipped", "failed"]], {}
    for report in reports:
        for row in report.get("tests", []):
            marks[len(rows) - 1, 3] = "bad" if row["failed"] else "good"
            rows.append([row["subject"], row["tests"], row["skipped"], "; ".join(row["failed"]) or "none"])
    return table(rows, marks, "text") if len(rows) > 1 else ""


def heads(case):
    rows = [["head", "beams", "sub-rays", "clean, ms", "default, ms", "moving, ms", "default / clean"]]
    for row in case.get("rows", []):
        rows.append([row["head"], f"{row['beams']:,}", row["sub_rays"] or "-",
                     *(figure(row["ms"].get(name)) for name in ("clean", "default", "default_moving")),
                     figure(row["ratios"].get("default_to_clean"))])
    return table(rows)


def batches(case):
    rows = [["scene", "views", "one by one, ms per view", "as a batch, ms per view"]]
    for row in case["rows"]:
        rows.append([row["scene"], row["views"], figure(row["one_by_one_ms_per_view"]), figure(row["batch_ms_per_view"])])
    return table(rows)


def memory(case):
    rows = [["scene", "total ms", "scene, MB", "sensor, MB", "work, MB"]]
    for outcome in case.get("outcomes", []):
        rows.append([outcome["label"], figure(outcome["contenders"][0]["total_ms"]["median"]),
                     *(figure(outcome["memory"][name + "_bytes"] / 1e6) for name in ("scene", "sensor", "work"))])
    return table(rows)


def accuracy(case):
    rows = [["setting", "ms", "times standard", "missed", "false hits", "wrong range", "largest error, m"]]
    for row in case["settings"] + case["parts"]:
        error = row["error"]
        rows.append([row["name"], figure(row["time_ms"]["median"]), f"{row['ratio_to_standard']:.2f}",
                     *(f"{error[key]:,}" for key in ("missed", "false_hits", "wrong_range")),
                     figure(error["any_owner_error_max_m"], 2)])
    return table(rows)


def effects(devices, names):
    rows = {}
    for column, device in enumerate(devices):
        for row in device["cases"].get("effects", {"rows": []})["rows"]:
            rows.setdefault(row["name"], {})[column] = row
    columns = [i for i, device in enumerate(devices) if "effects" in device["cases"]]
    cells = [["scan"] + [cell for i in columns for cell in (names[i] + ", ms", "times bare")]]
    for name, found in rows.items():
        cells.append([name] + [cell for i in columns for cell in
                               ((figure(found[i]["total_ms"]["median"]), f"{found[i]['times_bare']['median']:.2f}")
                                if i in found else ("-", "-"))])
    return table(cells)


def times(case):
    outcomes = case.get("outcomes", [])
    stages = list(outcomes[0]["contenders"][0]["stages_ms"]) if outcomes else []
    rows = [["sensor", "beams", "who", *stages, "device ms", "total ms"]]
    for outcome in outcomes:
        for who in outcome["contenders"]:
            device = who["device_ms"]
            rows.append([outcome["label"], f"{outcome['sensor']['beams']:,}", who["name"],
                         *(figure(who["stages_ms"].get(stage)) for stage in stages),
                         figure(device["median"] if device else None), figure(who["total_ms"]["median"])])
    return table(rows)


def stage_of(contender, stage):
    """Returns the median in milliseconds and as a multiple of GnoSphere's; None if it is missing."""
    if stage == "total":
        return contender["total_ms"]["median"], contender["ratio_to_ours"]
    if stage == "device":
        return (contender["device_ms"] or {}).get("median"), contender["device_ratio_to_ours"]
    return contender["stages_ms"].get(stage), None


def by_cuda(case):
    """Compares Vulkan and CUDA on the same card, step by step; empty without CUDA. Marks differences of more than
    5 %."""
    outcomes = [(outcome["label"], outcome["contenders"][0],
                 {who["name"]: who for who in outcome["contenders"] if who["name"].startswith("cuda")})
                for outcome in case.get("outcomes", [])]
    names = list(dict.fromkeys(name for _, _, cuda in outcomes for name in cuda))
    rows, marks = [], {}
    for label, vulkan, cuda in outcomes:
        stages = dict.fromkeys(stage for who in (vulkan, *cuda.values()) for stage in who["stages_ms"])
        for stage in (*stages, "device", "total"):
            ours, _ = stage_of(vulkan, stage)
            row = [label, stage, figure(ours)]
            for name in names:
                theirs, ratio = stage_of(cuda[name], stage) if name in cuda else (None, None)
                ratio = ratio or (theirs / ours if theirs and ours else None)
                if ratio and abs(ratio - 1) > 0.05:
                    marks[len(rows), len(row) + 1] = "good" if ratio > 1 else "bad"
                row += [figure(theirs), f"{ratio:.2f}" if ratio else "-"]
            rows.append(row)
    head = ["case", "stage", "Vulkan, ms"]
    for name in names:
        head += [name + ", ms", "Vulkan is times as fast"]
    return table([head, *rows], marks) if names else ""


def side_by_side(devices, names):
    parts = []
    for name, device in zip(names, devices):
        tables = "".join(by_cuda(device["cases"].get(case, {})) for case in ("figure7", "effects"))
        if tables:
            parts.append(f"<h3>{escaped(name)}</h3>\n{tables}")
    if not parts:
        return ""
    return ("<h2>Vulkan and CUDA side by side</h2>\n" + "".join(parts) +
            "<p class='note'>On one card, in turn, in one process; answers were compared beam by beam first. "
            "<code>cuda</code> has no fused products, so <code>exact</code> has the same bytes; <code>cuda-fast</code> "
            "is as nvcc makes it.</p>\n")


def pictures(devices, names):
    shown = [(name, device) for name, device in zip(names, devices) if device["ranges"]]
    parts = []
    for name, device in shown:
        parts.append(f"<h3>{escaped(name)}</h3>\n{range_image(device)}")
        base = next((other for other in shown if other[1]["ranges"]["columns"] == device["ranges"]["columns"] and
                     other[1]["ranges"]["channels"] == device["ranges"]["channels"]))
        if base[1] is device:
            continue
        differ, most, pixels = difference(base[1], device)
        beams = device["ranges"]["channels"] * device["ranges"]["columns"]
        if not differ:
            parts.append(f"<p class='note'>Every range has the bits of {escaped(base[0])}.</p>\n")
            continue
        parts.append(f"<p class='note'>{differ:,} of {beams:,} beams have another range than {escaped(base[0])} gives "
                     f"them, by {figure(most, 2)} m at the most where both hit. White: the same; dark: a metre, or a "
                     f"beam that only one of them returns.</p>\n")
        parts.append(image(pixels, device["ranges"], DIFFERENCES, f"{name} less {base[0]}"))
    return "".join(parts)


def each(devices, names, case, section):
    return "".join(f"<h3>{escaped(name)}</h3>\n{section(device['cases'][case])}"
                   for name, device in zip(names, devices) if case in device["cases"])


def titled(title, text):
    return f"<h2>{title}</h2>\n{text}" if text else ""


def plot(case):
    return f"<div class='wide'>{case['plot']}</div>\n"


def page(reports):
    devices = [device for report in reports for device in report["devices"]]
    owners = [number for number, report in enumerate(reports) for _ in report["devices"]]
    names = [device["name"] + (f" (machine {owner + 1})" if len(reports) > 1 else "")
             for device, owner in zip(devices, owners)]
    machines = [["machine", "cpu", "cores", "system", "GnoSphere", "date"]]
    for number, report in enumerate(reports):
        machine = report["machine"]
        machines.append([number + 1, machine["cpu"], machine["cores"], machine["system"], report["version"],
                         report["date"]])
    listed = [["device", "machine", "type", "driver", "Vulkan"]]
    for device, owner in zip(devices, owners):
        listed.append([device["name"], owner + 1, device["type"], device["driver"] or "-", device["api_version"] or "-"])
    left_out = [f"machine {number + 1}: {line}" for number, report in enumerate(reports) for line in report["left_out"]]
    left_out += dict.fromkeys(f"{name}: {line}" for name, device in zip(names, devices)
                              for case in device["cases"].values() for line in case.get("left_out", []))
    parts = [
        "<h1>GnoSphere on every device</h1>\n", table(machines, kind="text"), "<p></p>\n", table(listed, kind="text"),
        titled("Golden clouds", golden(devices, names)), titled("Tests on the device", tests(reports)),
        "<h2>Correctness</h2>\n", judged(devices, names),
        "<p class='note'>Against the double-precision reference, outside ties, with <code>standard</code> and "
        "<code>exact</code>.</p>\n",
        "<h2>The same bytes</h2>\n", equality(devices, names), fingerprints(devices, names),
        "<p class='note'>Where the letters of a line are the same, so are all bytes of the clouds.</p>\n",
        titled("Heads by default", each(devices, names, "heads", heads)),
        "<h2>Times</h2>\n", each(devices, names, "figure7", lambda case: times(case) + plot(case)),
        titled("Real scenes", each(devices, names, "real", times)),
        "<h2>What effects cost</h2>\n", effects(devices, names), each(devices, names, "effects", plot),
        titled("Many views at a time", each(devices, names, "batches", batches)),
        titled("Large scenes", each(devices, names, "scaling-triangles", memory)),
        "<h2>What accuracy costs</h2>\n", each(devices, names, "accuracy", accuracy),
        side_by_side(devices, names),
        "<h2>Pictures</h2>\n", pictures(devices, names),
    ]
    if left_out:
        parts += ["<h2>Left out</h2>\n<ul>\n", *(f"<li>{escaped(line)}</li>\n" for line in left_out), "</ul>\n"]
    return ("<!doctype html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
            "<meta name='viewport' content='width=device-width, initial-scale=1'>\n<link rel='icon' href='data:,'>\n"
            f"<title>GnoSphere on every device</title>\n<style>{STYLE}</style>\n</head>\n<body>\n" + "".join(parts) +
            "</body>\n</html>\n")
