# SPDX-License-Identifier: Apache-2.0
"""LiDARs in other engines, a module each, on gnosphere.adapter: docs/engines.md."""
