# SPDX-License-Identifier: Apache-2.0
"""Vulkan's loader and Mesa's lavapipe, a Vulkan driver for CPUs, for machines that have no driver of their own.

`import gnosphere` imports this package where it is installed. The loader then finds lavapipe beside the machine's own
drivers, of which GnoSphere takes the fastest. VK_DRIVER_FILES still names the only drivers that a process sees.
"""

import ctypes
import os
import pathlib

_folder = pathlib.Path(__file__).resolve().parent
_manifests = [entry for entry in os.environ.get("VK_ADD_DRIVER_FILES", "").split(os.pathsep) if entry]
if str(_folder / "lvp_icd.json") not in _manifests:
    os.environ["VK_ADD_DRIVER_FILES"] = os.pathsep.join([*_manifests, str(_folder / "lvp_icd.json")])
# A library that is loaded already is found by its name. Loaders before 1.3.207 do not know VK_ADD_DRIVER_FILES, hence
# the one of this package.
_loader = ctypes.CDLL(str(_folder / "libvulkan.so.1"))
