# SPDX-License-Identifier: Apache-2.0
"""Materials and semantic labels of USD prims."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
from pxr import UsdGeom, UsdShade

from ..adapter import Array
from .robot_scene import Parts

COLORS = ("diffuseColor", "diffuse_color_constant", "base_color", "diffuse_tint", "diffuse_reflection_color")
"""Inputs of UsdPreviewSurface, OmniPBR and MaterialX shaders that are a colour."""
METALNESSES = ("metallic", "metallic_constant", "metalness")
ROUGHNESSES = ("roughness", "reflection_roughness_constant", "specular_roughness")
OPACITIES = ("opacity", "opacity_constant")
THRESHOLDS = ("opacityThreshold", "opacity_threshold")
NOT_READ = {"clearcoat": 0.0, "ior": 1.5, "useSpecularWorkflow": 0.0}
"""Inputs of UsdPreviewSurface that change reflectances, with the values that change nothing."""


class Look(NamedTuple):
    """What a material states."""

    color: Optional[tuple[float, ...]] = None
    opacity: float = 1.0
    name: str = ""
    metallic: float = 0.0
    roughness: float = 1.0
    cutoff: Optional[float] = None
    """Opacities below it are holes, and others are 1."""


class Looks:
    def __init__(self, parts: Parts, time: Any) -> None:
        self._parts, self._time = parts, time
        self._bound: dict[Any, Look] = {}

    def of(self, prim: Any) -> int:
        """The number of the material of a prim: what is bound to it, or its displayColor."""
        double_sided = UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self._time) if prim.IsA(UsdGeom.Gprim) else True
        look = self._look(prim)
        if look.color is None:
            shown = self._first(prim, "displayColor")
            if shown is not None:
                look = look._replace(color=tuple(map(float, shown)))
            veil = None if look.name else self._first(prim, "displayOpacity")
            if veil is not None:
                look = look._replace(opacity=float(veil))
        return self._number(look, bool(double_sided))

    def of_subsets(self, prim: Any) -> list[tuple[Array, int]]:
        """Faces of a mesh that have materials of their own, with their numbers."""
        subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        double_sided = bool(UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self._time))
        return [
            (
                np.array(subset.GetIndicesAttr().Get(self._time) or (), np.int64),
                self._number(self._look(subset.GetPrim()), double_sided),
            )
            for subset in subsets
        ]

    def _number(self, look: Look, double_sided: bool) -> int:
        return self._parts.shapes.material(
            (*(look.color or (0.5, 0.5, 0.5)), look.opacity),
            look.name,
            double_sided=double_sided,
            metallic=look.metallic,
            roughness=look.roughness,
            alpha_cutoff=look.cutoff,
        )

    def _look(self, prim: Any) -> Look:
        bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)
        if not bound:
            return Look()
        path = bound.GetPath()
        if path not in self._bound:
            self._bound[path] = self._read(bound)
        return self._bound[path]

    def _read(self, material: Any) -> Look:
        name = material.GetPrim().GetName()
        shader = self._surface(material)
        if not shader:
            return Look(name=name)
        stated = [self._stated(shader, names) for names in (COLORS, METALNESSES, ROUGHNESSES, OPACITIES, THRESHOLDS)]
        image = shader.GetInput("diffuse_texture")
        if any(textured for _, textured in stated) or (image and getattr(image.Get(), "path", "")):
            self._parts.leave_out("textures of materials")
        color, metallic, roughness, opacity, threshold = (value for value, _ in stated)
        enabled = shader.GetInput("enable_opacity")
        if enabled and not enabled.Get():
            opacity = threshold = None
        if shader.GetShaderId() == "UsdPreviewSurface":
            roughness = 0.5 if roughness is None else roughness  # as its specification has it
            unread = [each for each, neutral in NOT_READ.items() if self._differs(shader, each, neutral)]
            for each in unread:
                self._parts.leave_out(f"the input {each} of materials")
            if "useSpecularWorkflow" in unread:
                metallic = None  # the specular workflow has no metalness
        return Look(
            None if color is None else tuple(map(float, color)),
            1.0 if opacity is None else float(np.mean(opacity)),  # a colour in MaterialX
            name,
            0.0 if metallic is None else float(metallic),
            1.0 if roughness is None else float(roughness),
            float(threshold) if threshold is not None and threshold > 0 else None,
        )

    def _differs(self, shader: Any, name: str, neutral: float) -> bool:
        """Whether an input states another value than this one."""
        value, _ = self._stated(shader, (name,))
        return value is not None and not np.isclose(float(value), neutral)

    def _surface(self, material: Any) -> Any:
        """The shader of the surface for all renderers, or else the first one for some of them, such as those of MDL."""
        contexts = [output.GetBaseName().rpartition(":")[0] for output in material.GetSurfaceOutputs()]
        shaders = (material.ComputeSurfaceSource(context)[0] for context in ["", *contexts])
        return next(filter(None, shaders), None)

    def _stated(self, shader: Any, names: tuple[str, ...]) -> tuple[Any, bool]:
        """The first of these inputs that is a value, and whether one of them is a texture."""
        inputs = [found for found in map(shader.GetInput, names) if found]
        values = [self._constant(found) for found in inputs]
        textured = any(value is None and found.HasConnectedSource() for found, value in zip(inputs, values))
        return next((value for value in values if value is not None), None), textured

    def _constant(self, found: Any) -> Any:
        """The value of an input that is not a texture, also through the interface of its material."""
        values = found.GetValueProducingAttributes()
        if not values or UsdShade.Utils.GetType(values[0].GetName()) == UsdShade.AttributeType.Output:
            return None
        return values[0].Get(self._time)

    def _first(self, prim: Any, name: str) -> Any:
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        values = primvar.ComputeFlattened(self._time) if primvar and primvar.HasValue() else None
        if values is None or not len(values):
            return None
        if np.any(np.asarray(values) != values[0]):
            self._parts.leave_out(f"values of {name} beyond the first of a prim")
        return values[0]


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
