# SPDX-License-Identifier: Apache-2.0
"""Makes the data set of a drive file: dataset.py drive.json FOLDER [FRAMES]. It goes on where it was.

`gnosphere town -o town.glb --drive drive.json` writes an example.
"""

import sys

from gnosphere import drive

if len(sys.argv) not in (3, 4):
    sys.exit("usage: dataset.py drive.json FOLDER [FRAMES]")
ride = drive.read_drive(sys.argv[1])
for warning in ride.warnings:
    print(f"warning: {warning}")
options = drive.RunOptions(sys.argv[2], progress=lambda done, total: print(f"{done} of {total} frames"))
if len(sys.argv) > 3:
    options.end_frame = int(sys.argv[3])
report = drive.run(ride, options)
print(f"{ride.name}: {report.kept} of {report.chosen} frames were there, {report.files} files were made")
