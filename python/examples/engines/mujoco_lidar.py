# SPDX-License-Identifier: Apache-2.0
"""A LiDAR on a car in MuJoCo, among things that fall: mujoco_lidar.py. Needs the package mujoco; writes
mujoco_lidar.png.

The car drives while the head turns, so each scan is made of what ten steps of the simulation have recorded.
"""

import mujoco
import numpy as np

import gnosphere
import gnosphere.mujoco

rng = np.random.default_rng(5)
kinds = ['type="sphere" size=".5"', 'type="box" size=".4 .5 .6"', 'type="capsule" size=".3 .5"',
         'type="cylinder" size=".4 .6"', 'type="ellipsoid" size=".4 .6 .8"']  # fmt: skip
things = "".join(
    f'<body name="thing{i}" pos="{5 + 0.8 * i} {rng.uniform(-6, 6):.2f} {rng.uniform(1, 3):.2f}" euler="{40 * i} 10 0">'
    f'<freejoint/><geom {kinds[i % 5]} rgba="{rng.uniform(0.2, 0.9):.2f} .5 .4 1"/></body>'
    for i in range(25)
)
model = mujoco.MjModel.from_xml_string(
    f"""<mujoco><option timestep="0.01"/>
    <asset><hfield name="hills" nrow="40" ncol="40" size="14 14 2.5 .1"/></asset>
    <worldbody><geom name="ground" type="plane" size="0 0 1"/>
    <geom name="hills" type="hfield" hfield="hills" pos="14 22 -.3" rgba=".3 .5 .2 1"/>
    <geom name="wall" type="box" size="16 .1 1.5" pos="12 -8 1.5" rgba=".7 .7 .7 1"/>{things}
    <body name="car" pos="0 0 .6"><joint name="drive" type="slide" axis="1 0 0"/>
      <geom type="box" size="1 .5 .3" contype="0" conaffinity="0"/>
      <body name="mast" pos="0 0 .3"><geom type="cylinder" size=".05 .3" pos="0 0 .3"/>
      <site name="lidar" pos="0 0 .7"/></body></body></worldbody></mujoco>"""
)
waves = np.linspace(0, 7, 40)
model.hfield_data[:] = (0.5 + 0.25 * np.sin(waves)[:, None] + 0.25 * np.cos(1.3 * waves)[None]).ravel()
data = mujoco.MjData(model)
data.joint("drive").qvel = 5

lidar = gnosphere.mujoco.Lidar(
    model, "OS1-64", site="lidar", treeexclude="car", fields="intensity,class",
    classes={"ground": 1, "hills": 2, "wall": 3, "thing*": 4},
)  # fmt: skip
mujoco.mj_forward(model, data)
for frame in range(8):  # 0.8 s; a turn of the head is 0.1 s, ten steps
    lidar.record(data)
    for _ in range(10):
        mujoco.mj_step(model, data)
        lidar.record(data)
    scan = lidar.scan(data)
    classes = scan["class"][~np.isnan(scan.ranges)]
    counts = np.bincount(classes, minlength=5)
    print(f"{data.time:.1f} s: {counts[1]} points on the ground, {counts[2]} on hills, {counts[3]} on the wall, "
          f"{counts[4]} on things")  # fmt: skip
gnosphere.write_picture(scan, "mujoco_lidar.png")

cloud = gnosphere.adapter.point_cloud2(scan, "x,y,z,intensity,class", stamp=data.time)
print(cloud["width"], "points of", cloud["point_step"], "bytes in a PointCloud2")
