# SPDX-License-Identifier: Apache-2.0
"""LiDARs in MuJoCo raced: GnoSphere, mj_multiRay(), and mujoco-lidar's back end of Warp on the CPU, if they are
installed.

    python mujoco_lidars.py [--geoms 200] [--subdivisions 5] [--frames 10] [--heads VLP-16,HDL-64E]

Every geom and the sensor move in every frame: a scene that stands still would be read from what GnoSphere keeps. Each
frame is one of each contender, in turns; the first is not counted. Times are medians: of the clock, and of all cores.
"""

import argparse
import time

import mujoco
import numpy as np

import gnosphere
import gnosphere.mujoco


def ball(subdivisions: int, seed: int) -> str:
    """Vertices and faces of an uneven ball: an octahedron divided, 8 * 4**subdivisions triangles."""
    vertices = [np.array(v, float) for v in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(subdivisions):
        middles: dict = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append((vertices[a] + vertices[b]) / np.linalg.norm(vertices[a] + vertices[b]))
            return middles[key]

        faces = [
            face
            for a, b, c in faces
            for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
            for face in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        ]
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(6, 3)) * 3
    points = np.array(vertices)
    points *= (0.6 + 0.06 * np.sin(points @ waves.T + rng.uniform(0, 6, 6)).sum(axis=1))[:, None]
    numbers = " ".join(f"{value:.5f}" for value in points.ravel())
    return f'vertex="{numbers}" face="{" ".join(str(i) for face in faces for i in face)}"'


def model_of(geoms: int, subdivisions: int) -> mujoco.MjModel:
    kinds = min(10, geoms)
    meshes = "".join(f'<mesh name="ball{i}" {ball(subdivisions, i)}/>' for i in range(kinds))
    bodies = "".join(
        f'<body name="b{i}" mocap="true"><geom type="mesh" mesh="ball{i % kinds}" contype="0" conaffinity="0"/></body>'
        for i in range(geoms)
    )
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><asset>{meshes}</asset><worldbody><geom type="plane" size="100 100 1" pos="0 0 -1.7"/>{bodies}
        <body name="mast" mocap="true"><site name="lidar"/></body></worldbody></mujoco>"""
    )


class Frames:
    """Moves all bodies and the sensor."""

    def __init__(self, model, data, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.model, self.data, self.time = model, data, 0
        count = model.nmocap - 1
        angle, far = rng.uniform(0, 2 * np.pi, count), 4 + 46 * np.sqrt(rng.uniform(0, 1, count))
        self.start = np.column_stack([far * np.cos(angle), far * np.sin(angle), rng.uniform(-1.5, 1.5, count)])
        self.speed = rng.normal(size=(count, 3)) * 0.1

    def step(self) -> None:
        self.time += 1
        data, turn = self.data, 0.05 * self.time
        data.mocap_pos[:-1] = self.start + self.time * self.speed
        data.mocap_quat[:-1] = [np.cos(turn), 0.6 * np.sin(turn), 0, 0.8 * np.sin(turn)]
        data.mocap_pos[-1] = [0.11 * self.time, 0.02 * self.time, 0.3]
        data.mocap_quat[-1] = [np.cos(turn / 2), 0, 0, np.sin(turn / 2)]
        mujoco.mj_kinematics(self.model, data)


def contenders(model, data, head: str):
    """Functions that return the range of each beam, NaN or less than 0 or the cutoff for none."""
    sensor = gnosphere.builtin_sensor(head)
    directions = np.ascontiguousarray(gnosphere.beams_of(sensor).directions)
    count, site = len(directions), data.site("lidar")
    lidar = gnosphere.mujoco.Lidar(model, sensor, site="lidar", effects=gnosphere.Effects.none())
    scan = gnosphere.Scan()

    def ours():
        return lidar.scan(data, into=scan).ranges

    geoms, distances = np.zeros(count, np.int32), np.zeros(count)

    def multi_ray():
        rays = (directions @ site.xmat.reshape(3, 3).T).reshape(-1)
        mujoco.mj_multiRay(model, data, site.xpos, rays, None, 1, -1, geoms, distances, None, count, sensor.range_max)
        return distances

    found = {"GnoSphere": ours, "mj_multiRay": multi_ray}
    try:
        import warp
        from mujoco_lidar import MjLidarWrapper

        warp.config.quiet = True
        other = MjLidarWrapper(model, "lidar", "warp", sensor.range_max, {"device": "cpu"})
        theta = np.arctan2(directions[:, 1], directions[:, 0]).astype(np.float32)
        phi = np.arcsin(directions[:, 2]).astype(np.float32)
        found["mujoco-lidar (Warp)"] = lambda: other.trace_rays(data, theta, phi)
    except ImportError as error:
        print(f"without mujoco-lidar: {error}")
    return found, count


def overhead(count: int = 1000, frames: int = 200) -> None:
    """What the bridge costs: transforms and pose, without the scan."""
    bodies = "".join(f'<body name="b{i}" mocap="true"><geom type="box" size=".1 .1 .1"/></body>' for i in range(count))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody>{bodies}<body name="mast" mocap="true"><site name="lidar"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    lidar = gnosphere.mujoco.Lidar(model, "VLP-16", site="lidar", effects=gnosphere.Effects.none())
    motion, times = Frames(model, data), []
    for _ in range(frames):
        motion.step()
        start = time.perf_counter()
        pose = lidar.pose(data)
        lidar.update(data, pose.position)
        gnosphere.Shot(pose)
        times.append(time.perf_counter() - start)
    print(f"bridge: {count} geoms, all moving: {1e3 * np.median(times):.3f} ms a frame (least {1e3 * min(times):.3f})")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--geoms", type=int, default=200)
    parser.add_argument("--subdivisions", type=int, default=5)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--heads", default="VLP-16,HDL-64E")
    options = parser.parse_args()
    overhead()
    model = model_of(options.geoms, options.subdivisions)
    data = mujoco.MjData(model)
    triangles = sum(
        int(model.mesh_facenum[model.geom_dataid[g]]) for g in range(model.ngeom) if model.geom_type[g] == 7
    )
    for head in options.heads.split(","):
        motion = Frames(model, data)
        motion.step()
        racers, beams = contenders(model, data, head)
        print(f"{head}: {beams} beams, {options.geoms} geoms of {triangles} triangles in all, {options.frames} frames")
        walls: dict = {name: [] for name in racers}
        cores: dict = {name: [] for name in racers}
        for _ in range(options.frames + 1):
            motion.step()
            answers = {}
            for name, scan in racers.items():
                start, work = time.perf_counter(), time.process_time()
                answers[name] = np.array(scan(), float)
                walls[name].append(time.perf_counter() - start)
                cores[name].append(time.process_time() - work)
        truth = answers["mj_multiRay"]
        least = gnosphere.builtin_sensor(head).range_min
        for name in racers:
            hit = (truth > least) & (truth < gnosphere.builtin_sensor(head).range_max) & (answers[name] > 0)
            far = np.abs(answers[name] - truth)[hit]
            wall, core = (1e3 * np.median(times[name][1:]) for times in (walls, cores))
            print(
                f"  {name:20} {wall:9.2f} ms, {core:9.2f} ms of cores; of {hit.sum()} common hits "
                f"{(far > 0.01).sum()} differ from mj_multiRay by more than 1 cm, the median by {np.median(far):.1e} m"
            )
        for name in racers:
            wall, core = (np.median(times[name][1:]) / np.median(times["GnoSphere"][1:]) for times in (walls, cores))
            print(f"  {name:20} takes {wall:6.1f} times as long, and {core:6.1f} times the work of cores")


if __name__ == "__main__":
    main()
