# SPDX-License-Identifier: Apache-2.0
"""Materials and semantic labels of USD prims."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from ..adapter import Array
from .robot_scene import Parts

COLORS = ("diffuseColor", "diffuse_color_constant", "base_color", "diffuse_tint", "diffuse_reflection_color")
"""Inputs of UsdPreviewSurface, OmniPBR and MaterialX shaders that are a colour."""
OPACITIES = ("opacity", "opacity_constant")


class Looks:
    def __init__(self, parts: Parts, time: Any) -> None:
        self._parts, self._time = parts, time
        self._bound: dict[Any, tuple[Optional[tuple[float, ...]], float, str]] = {}

    def of(self, prim: Any) -> int:
        """The number of the material of a prim: what is bound to it, or its displayColor."""
        double_sided = UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self._time) if prim.IsA(UsdGeom.Gprim) else True
        color, opacity, name = self._shader(prim)
        if color is None:
            shown = self._first(prim, "displayColor")
            color = tuple(map(float, shown)) if shown is not None else (0.5, 0.5, 0.5)
            if not name:
                veil = self._first(prim, "displayOpacity")
                opacity = float(veil) if veil is not None else opacity
        return self._parts.shapes.material((*color, opacity), name, double_sided=bool(double_sided))

    def of_subsets(self, prim: Any) -> list[tuple[Array, int]]:
        """Faces of a mesh that have materials of their own, with their numbers."""
        subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        return [
            (np.array(subset.GetIndicesAttr().Get(self._time) or (), np.int64), self._of_subset(subset.GetPrim(), prim))
            for subset in subsets
        ]

    def _of_subset(self, subset: Any, mesh: Any) -> int:
        color, opacity, name = self._shader(subset)
        double_sided = bool(UsdGeom.Gprim(mesh).GetDoubleSidedAttr().Get(self._time))
        return self._parts.shapes.material((*(color or (0.5,) * 3), opacity), name, double_sided=double_sided)

    def _shader(self, prim: Any) -> tuple[Optional[tuple[float, ...]], float, str]:
        bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if not bound:
            return None, 1.0, ""
        path = bound.GetPath()
        if path not in self._bound:
            self._bound[path] = self._read(bound)
        return self._bound[path]

    def _read(self, material: Any) -> tuple[Optional[tuple[float, ...]], float, str]:
        color: Optional[tuple[float, ...]] = None
        opacity, textures = 1.0, False
        shaders = [prim for prim in Usd.PrimRange(material.GetPrim()) if prim.IsA(UsdShade.Shader)]
        for shader in map(UsdShade.Shader, shaders):
            for name in COLORS:
                found = shader.GetInput(name)
                value = self._constant(found) if found else None
                if color is None and value is not None:
                    color = tuple(map(float, value))
                textures |= bool(found) and value is None and found.HasConnectedSource()
            for name in OPACITIES:
                found = shader.GetInput(name)
                value = self._constant(found) if found else None
                enabled = shader.GetInput("enable_opacity")
                if value is not None and (not enabled or enabled.Get()):
                    opacity = float(value)
            image = shader.GetInput("diffuse_texture")
            textures |= bool(image and getattr(image.Get(), "path", ""))
        if textures:
            self._parts.leave_out("textures of materials")
        return color, opacity, material.GetPrim().GetName()

    def _constant(self, found: Any) -> Any:
        """The value of an input that is not a texture, also through the interface of its material."""
        values = found.GetValueProducingAttributes()
        if not values or UsdShade.Utils.GetType(values[0].GetName()) == UsdShade.AttributeType.Output:
            return None
        return values[0].Get(self._time)

    def _first(self, prim: Any, name: str) -> Any:
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        values = primvar.ComputeFlattened(self._time) if primvar and primvar.HasValue() else None
        return values[0] if values is not None and len(values) else None


def classes_of(prim: Any) -> list[str]:
    """The semantic labels of the nearest prim at or above this one that has some: of UsdSemantics, and of the
    SemanticsAPI that Isaac Sim and Replicator wrote before."""
    while prim and not prim.IsPseudoRoot():
        found: list[str] = []
        for attribute in prim.GetAttributes():
            name = attribute.GetName()
            if name.startswith("semantics:labels:"):
                found += [str(label) for label in attribute.Get() or ()]
            elif name.startswith("semantic:") and name.endswith(":params:semanticData"):
                kind = prim.GetAttribute(name.replace("semanticData", "semanticType"))
                if not kind or kind.Get() in ("class", None):
                    found += [label.strip() for label in str(attribute.Get() or "").split(",") if label.strip()]
        if found:
            return found
        prim = prim.GetParent()
    return []
