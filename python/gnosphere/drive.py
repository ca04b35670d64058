# SPDX-License-Identifier: Apache-2.0
"""Makes data sets of drive files, as `gnosphere drive` does: docs/drives.md."""

from ._gnosphere.drive import *
