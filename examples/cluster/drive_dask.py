#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gnosphere drive in shards on the workers of a Dask cluster. Of the files only the names are sent, so DRIVE.json and
DATASET are paths of a file system that all workers share.

drive_dask.py SCHEDULER SHARDS DRIVE.json -o DATASET ...    SCHEDULER: an address, as tcp://head:8786
"""
import subprocess
import sys

from dask.distributed import Client, as_completed


def make(shard, shards, arguments):
    """Runs again on another worker if this one dies, and makes then what is not complete."""
    done = subprocess.run(["gnosphere", "drive", *arguments, "--shard", f"{shard}/{shards}"],
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"shard {shard}/{shards}: {done.stderr.strip()}")


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    scheduler, count, arguments = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    with Client(scheduler) as client:
        shards = client.map(make, range(count), shards=count, arguments=arguments, retries=2, pure=False)
        for number, shard in enumerate(as_completed(shards), 1):
            shard.result()
            print(f"{number} of {count} shards", flush=True)
