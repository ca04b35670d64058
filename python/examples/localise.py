# SPDX-License-Identifier: Apache-2.0
"""Where am I? A particle filter of 500 poses in a town: localise.py town.glb. Writes localise.png.

Each step scans the town from all poses in one batch, and compares their ranges with those of the vehicle's own scan.
"""

import sys
from pathlib import Path

import numpy as np

import gnosphere
from gnosphere import Effects, SensorRequest, pictures

if len(sys.argv) != 2:
    sys.exit("usage: localise.py town.glb")
particles, steps = 500, 8
random = np.random.default_rng(4)

sensor = gnosphere.Sensor()
sensor.name = "sparse head"
sensor.columns = 120
sensor.range_max = 60
sensor.channels = [gnosphere.Channel(float(elevation)) for elevation in np.linspace(-12, 12, 8)]
simulator = gnosphere.Simulator(gnosphere.load_scene(sys.argv[1]), SensorRequest(sensor, Effects.none()))


def poses(states: np.ndarray) -> np.ndarray:
    """Poses x, y, z, quaternion of states x, y, heading."""
    result = np.zeros((len(states), 7))
    result[:, :2] = states[:, :2]
    result[:, 2] = 1.8
    result[:, 5], result[:, 6] = np.sin(states[:, 2] / 2), np.cos(states[:, 2] / 2)
    return result


def ranges(states: np.ndarray) -> np.ndarray:
    batch = simulator.scan_batch(poses(states), fields="range")
    return np.where(np.isnan(batch.ranges), sensor.range_max, batch.ranges)


truth = np.array([0.0, 0.0, 0.05])
guess = truth + random.normal(0, 1, (particles, 3)) * (6, 6, 0.3)
drawn = []
for step in range(steps):
    measured = ranges(truth[None])[0] + random.normal(0, 0.02, sensor.columns * len(sensor.channels))
    difference = np.minimum(np.abs(ranges(guess) - measured), 5.0).mean(axis=1)
    weights = np.exp(-(difference - difference.min()) / 0.15)
    weights /= weights.sum()
    mean = weights @ guess
    spread = np.sqrt(weights @ ((guess[:, :2] - mean[:2]) ** 2).sum(axis=1))
    error = np.hypot(*(mean - truth)[:2])
    print(f"step {step}: {error:.2f} m and {np.degrees(abs(mean - truth)[2]):.1f} degrees off, spread {spread:.2f} m")
    drawn.append((guess.copy(), truth.copy()))
    narrow = np.clip(2 * spread, 0.05, 1.0)
    guess = guess[random.choice(particles, particles, p=weights)]
    guess += random.normal(0, 1, guess.shape) * (0.4 * narrow, 0.4 * narrow, 0.03 * narrow)
    forward = np.array([1.5, 0.0])  # the vehicle drives on, and so do the particles
    truth[:2] += forward
    guess[:, :2] += forward

# Steps side by side, from above: the map in grey, particles in red, the truth in green; 40 x 40 m at 0.1 m.
states = drawn[0][1] + np.random.default_rng(2).normal(0, 4, (60, 3)) * (1, 1, 1.5)
points = simulator.scan_batch(poses(states))
size, shown = 400, [0, 1, 3, steps - 1]
image = np.full((size, len(shown) * (size + 4), 3), 255, np.uint8)
for panel in range(len(shown)):
    image[:, panel * (size + 4) + size : (panel + 1) * (size + 4)] = 120  # a line between two steps


def draw(panel: int, centre: np.ndarray, xy: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
    column = ((xy[:, 0] - centre[0]) * 10 + size / 2).astype(int)
    row = (size / 2 - (xy[:, 1] - centre[1]) * 10).astype(int)
    for i in range(-width, width + 1):
        for j in range(-width, width + 1):
            c, r = column + i, row + j
            inside = (c >= 0) & (c < size) & (r >= 0) & (r < size)
            image[r[inside], c[inside] + panel * (size + 4)] = colour


seen = points.points.reshape(-1, 3)
views = np.repeat(np.arange(points.views), points.beams)
heading = states[views, 2]
turned = np.stack(
    [np.cos(heading) * seen[:, 0] - np.sin(heading) * seen[:, 1], np.sin(heading) * seen[:, 0] + np.cos(heading) * seen[:, 1]],
    axis=-1,
)
walls = (turned + states[views, :2])[np.isfinite(seen[:, 2]) & (seen[:, 2] > -1.3)]
for panel, step in enumerate(shown):
    guesses, true = drawn[step]
    draw(panel, true, walls, (150, 150, 150), 0)
    draw(panel, true, guesses, (200, 30, 30), 1)
    draw(panel, true, true[None], (0, 140, 60), 3)

Path("localise.png").write_bytes(pictures.png(image))
