# SPDX-License-Identifier: Apache-2.0
"""What attributes of USD prims mean, one by one, in closed forms. Skipped without the package usd-core."""

import numpy as np
import pytest
from test_robot_details import about, bounds, colours
from test_robotics import corners, quiet

import gnosphere
from gnosphere import adapter, robotics

pytest.importorskip("pxr")

HEADER = '#usda 1.0\n(\n    upAxis = "Z"\n    metersPerUnit = {}\n)\n'

SQUARE = """int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0)]
    uniform token subdivisionScheme = "none"
"""


def write(folder, *prims, unit=1.0):
    file = folder / "stage.usda"
    file.write_text(HEADER.format(unit) + "\n".join(prims))
    return file


def read(folder, *prims, unit=1.0, **options):
    """The scene of prims, without a warning."""
    return quiet(write(folder, *prims, unit=unit), **options)


def mesh(inside="", name="Mesh", points=SQUARE):
    return f'def Mesh "{name}"\n{{\n    {points}{inside}\n}}\n'


def normals(robot):
    (one,) = robot.scene.meshes
    a, b, c = one.positions[one.indices].transpose(1, 0, 2)
    return (np.cross(b - a, c - a) / 2).tolist()


def test_the_orientation_of_faces_of_usd(tmp_path):
    for orientation, up in (
        ("", 1),
        ('uniform token orientation = "rightHanded"', 1),
        ('uniform token orientation = "leftHanded"', -1),
    ):
        assert normals(read(tmp_path, mesh(orientation))) == [[0, 0, up], [0, 0, up]]


def test_files_that_are_no_usd_are_refused(tmp_path):
    for name, text in (("a.usda", ""), ("b.usda", "#usda 1.0\ndef {"), ("c.usdc", "PXR-USDC"), ("d.usdz", "PK")):
        (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match=rf"{name}: cannot be opened as USD: \S+.*") as told:
            robotics.load(tmp_path / name)
        assert "\n" not in str(told.value)
    with pytest.raises(FileNotFoundError, match="none.usda"):
        robotics.load(tmp_path / "none.usda")


def test_holes_of_usd_are_no_faces(tmp_path):
    assert normals(read(tmp_path, mesh("int[] holeIndices = [0]"))) == [[0, 0, 1]]
    (one,) = read(tmp_path, mesh("int[] holeIndices = [0]")).scene.meshes
    assert {tuple(point) for point in one.positions[one.indices].reshape(-1, 3).tolist()} == {
        (0, 0, 0),
        (1, 2, 0),
        (0, 2, 0),
    }


def test_indices_beyond_the_points_of_usd_are_told(tmp_path):
    for wrong in (4, -1):
        file = write(tmp_path, mesh(points=SQUARE.replace("[0, 1, 2, 0, 2, 3]", f"[0, 1, 2, 0, 2, {wrong}]")))
        with pytest.warns(UserWarning, match=r"leaves out meshes whose indices do not fit their points \(1\)$"):
            assert not robotics.load(file).frames


def test_purposes_and_visibility_of_usd(tmp_path):
    kinds = {"default": "", "render": "", "guide": "", "proxy": ""}
    prims = [
        f'def Cube "{kind}"\n{{\n    uniform token purpose = "{kind}"\n    double3 xformOp:translate = ({i}, 0, 0)\n'
        '    uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n' for i, kind in enumerate(kinds)
    ]  # fmt: skip
    prims.append('def Xform "Hidden"\n{\n    token visibility = "invisible"\n    def Cube "c"\n    {\n    }\n}\n')
    assert read(tmp_path, *prims).frames == ["/default", "/render"]
    assert read(tmp_path, *prims, collisions=True).frames == ["/default", "/guide"]


def test_transforms_of_usd_at_their_earliest_time(tmp_path):
    """A parent is turned about z and scaled; values are of their first time sample."""
    inner = """double3 xformOp:translate.timeSamples = {1: (1, 2, 3), 9: (7, 7, 7)}
        uniform token[] xformOpOrder = ["xformOp:translate"]"""
    text = f"""def Xform "Top"
{{
    float xformOp:rotateZ = 30
    float3 xformOp:scale = (1, 2, 3)
    double3 xformOp:translate = (5, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ", "xformOp:scale"]
    {mesh(inner)}}}
"""
    expected = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]]) + [1, 2, 3]
    expected = expected * [1, 2, 3] @ about("z", np.pi / 6).T + [5, 0, 0]
    for unit in (1.0, 0.01):
        (points,) = corners(read(tmp_path, text, unit=unit))
        np.testing.assert_allclose(points, unit * expected, atol=1e-5)


@pytest.mark.parametrize(
    ("kind", "half"),
    [("Cube", (1, 1, 1)), ("Sphere", (1, 1, 1)), ("Cylinder", (1, 1, 1)), ("Cone", (1, 1, 1)),
     ("Capsule", (0.5, 0.5, 1)), ("Plane", (1, 1, 0))],
)  # fmt: skip
def test_sizes_of_usd_that_are_not_stated(tmp_path, kind, half):
    from pxr import Usd, UsdGeom

    (found,) = bounds(read(tmp_path, f'def {kind} "Shape"\n{{\n}}\n'))
    np.testing.assert_allclose(found, [np.negative(half), half], atol=2e-3)
    stage = Usd.Stage.Open(str(tmp_path / "stage.usda"))
    theirs = UsdGeom.BBoxCache(Usd.TimeCode.EarliestTime(), ["default"]).ComputeWorldBound(
        stage.GetPrimAtPath("/Shape")
    )
    if kind != "Capsule":  # whose extent is that of its cylinder where nothing is stated
        np.testing.assert_allclose([*theirs.ComputeAlignedRange().GetMin()], found[0], atol=2e-3)


def test_a_plane_of_usd_is_divided_at_metres_whatever_the_unit(tmp_path):
    """So single precision is as fine near its middle as for a small one."""
    for unit in (1.0, 0.01):
        plane = f'def Plane "Ground"\n{{\n    double width = {50 / unit}\n    double length = {4 / unit}\n}}\n'
        (points,) = corners(read(tmp_path, plane, unit=unit))
        expected = [-25, -10, -1, 1, 10, 25], [-2, -1, 1, 2]
        for axis, values in enumerate(expected):
            np.testing.assert_allclose(np.unique(np.round(points[:, axis], 4)), values, atol=1e-4)


def scattered(extra, prototype=""):
    """Three cubes of 1 m, of a prototype that is itself moved along z."""
    return f"""def PointInstancer "Many"
{{
    rel prototypes = [</Many/Stone>]
    int[] protoIndices = [0, 0, 0]
    point3f[] positions = [(0, 0, 0), (10, 0, 0), (20, 0, 0)]
    double3 xformOp:translate = (0, 5, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {extra}
    def Xform "Stone"
    {{
        double3 xformOp:translate = (0, 0, 3)
        float xformOp:rotateZ = 90
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]
        {prototype}
        def Cube "Cube"
        {{
            double size = 1
            double3 xformOp:translate = (0, 0, 1)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }}
    }}
}}
"""


def test_what_is_scattered_in_usd(tmp_path):
    """The transform of a prototype counts; what is deactivated does not, and the others keep their places."""
    middles = [points.mean(axis=0) for points in corners(read(tmp_path, scattered("")))]
    np.testing.assert_allclose(middles, [[0, 5, 4], [10, 5, 4], [20, 5, 4]], atol=1e-6)
    assert [frame.split("/")[1] for frame in read(tmp_path, scattered("")).frames] == ["Many[0]", "Many[1]", "Many[2]"]
    hidden = "int64[] invisibleIds = [1]"
    assert [frame.split("/")[1] for frame in read(tmp_path, scattered(hidden)).frames] == ["Many[0]", "Many[2]"]
    hidden = "int64[] ids = [5, 6, 7]\n    int64[] invisibleIds = [6]"
    assert [frame.split("/")[1] for frame in read(tmp_path, scattered(hidden)).frames] == ["Many[5]", "Many[7]"]
    turned = "quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0), (0.70703125, 0.70703125, 0, 0)]"
    robot = read(tmp_path, scattered(hidden + "\n    " + turned))
    middles = [points.mean(axis=0) for points in corners(robot)]
    np.testing.assert_allclose(middles, [[0, 5, 4], [20, 1, 0]], atol=1e-3)  # turned about x by a quarter
    # Each instance shows the prototype that its index names.
    two = scattered("").replace("[</Many/Stone>]", "[</Many/Stone>, </Many/Ball>]").replace("[0, 0, 0]", "[1, 0, 1]")
    two = two.rstrip().removesuffix("}") + '    def Sphere "Ball"\n    {\n        double radius = 0.25\n    }\n}\n'
    hidden = read(tmp_path, two.replace("    def Xform", "    int64[] invisibleIds = [0]\n    def Xform", 1))
    assert [("Ball" in frame) for frame in hidden.frames] == [False, True]
    np.testing.assert_allclose(bounds(hidden)[1], [[19.75, 4.75, -0.25], [20.25, 5.25, 0.25]], atol=1e-3)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    (
        ("[0, 0, 0]", "[0, 0, 1]", "point instancers whose prototypes, indices and places do not fit"),
        ("[0, 0, 0]", "[0, -1, 0]", "point instancers whose prototypes, indices and places do not fit"),
        (", (20, 0, 0)]", "]", "point instancers whose prototypes, indices and places do not fit"),
        ("[</Many/Stone>]", "[</Many/Rock>]", "the prototype /Many/Rock, which is not there"),
    ),
)
def test_what_cannot_be_scattered_in_usd_is_told(tmp_path, old, new, told):
    file = write(tmp_path, scattered("").replace(old, new))
    with pytest.warns(UserWarning, match=rf"leaves out {told} \({3 if 'Rock' in new else 1}\)$"):
        assert not robotics.load(file).frames


def material(name, inputs, kind="UsdPreviewSurface"):
    return f"""def Material "{name}"
{{
    token outputs:surface.connect = </{name}/Shader.outputs:surface>
    def Shader "Shader"
    {{
        uniform token info:id = "{kind}"
        {inputs}
        token outputs:surface
    }}
}}
"""


def bound(name):
    return f"rel material:binding = </{name}>"


BINDS = 'prepend apiSchemas = ["MaterialBindingAPI"]'


def painted(inside, name="Mesh"):
    return mesh(inside, name).replace(f'"{name}"\n', f'"{name}" (\n    {BINDS}\n)\n')


def test_colours_of_usd(tmp_path):
    """Of the material that is bound, or else of the prim or one above it."""
    shown = "color3f[] primvars:displayColor = [(0.2, 0.4, 0.6)]\n    float[] primvars:displayOpacity = [0.5]"
    ink = material("Ink", "color3f inputs:diffuseColor = (1, 0.5, 0.25)\n        float inputs:opacity = 0.75")
    plain = material("Plain", "float inputs:opacity = 0.25")
    found = read(
        tmp_path, ink, plain, mesh(shown, "A"), painted(shown + "\n    " + bound("Ink"), "B"),
        painted(shown + "\n    " + bound("Plain"), "C"), mesh("", "D"),
        'def Xform "Top"\n{\n    color3f[] primvars:displayColor = [(1, 0, 1)] (\n'
        '        interpolation = "constant"\n    )\n    '
        + mesh("", "E") + "}\n",
    )  # fmt: skip
    assert colours(found) == [
        (0.2, 0.4, 0.6, 0.5, ""), (1, 0.5, 0.25, 0.75, "Ink"), (0.2, 0.4, 0.6, 0.25, "Plain"), (0.5, 0.5, 0.5, 1, ""),
        (1, 0, 1, 1, ""),
    ]  # fmt: skip


def test_colours_of_usd_by_their_indices(tmp_path):
    """The first value is that of the first index."""
    shown = "color3f[] primvars:displayColor = [(1, 0, 0), (0, 0, 1)]\n    int[] primvars:displayColor:indices = [1]"
    assert colours(read(tmp_path, mesh(shown))) == [(0, 0, 1, 1, "")]


def test_colours_of_usd_beyond_the_first_are_told(tmp_path):
    for kind, first in (("color3f[] primvars:displayColor", "(1, 0, 0)"), ("float[] primvars:displayOpacity", "0.5")):
        other = first.replace("0", "1")
        told = rf"leaves out values of {kind.split(':')[1]} beyond the first of a prim \(1\)$"
        file = write(tmp_path, mesh(f'{kind} = [{first}, {other}] (\n    interpolation = "uniform"\n    )'))
        with pytest.warns(UserWarning, match=told):
            found = robotics.load(file)
        assert colours(found) == [(1, 0, 0, 1, "") if "color" in kind else (0.5, 0.5, 0.5, 0.5, "")]
        read(tmp_path, mesh(f"{kind} = [{first}, {first}]"))


def only(robot):
    (one,) = robot.scene.materials
    return one


def test_metalness_roughness_and_threshold_of_usd(tmp_path):
    inputs = "float inputs:metallic = 0.75\n        float inputs:roughness = 0.125"
    for text, kind in (
        (inputs, "UsdPreviewSurface"),
        (
            inputs.replace("metallic", "metallic_constant").replace("roughness", "reflection_roughness_constant"),
            "OmniPBR",
        ),
        (inputs.replace("metallic", "metalness").replace("roughness", "specular_roughness"), "ND_standard_surface"),
    ):
        one = only(read(tmp_path, material("M", text, kind), painted(bound("M"))))
        assert (one.metallic, one.roughness, one.alpha_mode) == (0.75, 0.125, gnosphere.AlphaMode.opaque)
    # What is not stated is as the specification has it.
    one = only(read(tmp_path, material("M", ""), painted(bound("M"))))
    assert (one.metallic, one.roughness) == (0, 0.5)
    for opacity, threshold, mode in ((0.25, 0.5, "mask"), (0.75, 0.5, "mask"), (0.25, 0, "blend"), (1, 0, "opaque")):
        text = f"float inputs:opacity = {opacity}\n        float inputs:opacityThreshold = {threshold}"
        one = only(read(tmp_path, material("M", text), painted(bound("M"))))
        assert (one.base_color[3], one.alpha_mode) == (opacity, gnosphere.AlphaMode[mode])
        assert one.alpha_cutoff == 0.5
        assert gnosphere.optics_of(one).transmission == (0.75 if mode == "blend" else 0)
    text = "float inputs:opacity = 1\n        float inputs:opacityThreshold = 0.25"
    assert only(read(tmp_path, material("M", text), painted(bound("M")))).alpha_cutoff == 0.25


def test_colours_of_opacity_count_with_their_mean(tmp_path):
    text = "color3f inputs:base_color = (1, 0, 0)\n        color3f inputs:opacity = (0.25, 0.5, 0.75)"
    assert colours(read(tmp_path, material("M", text, "ND_standard_surface"), painted(bound("M")))) == [
        (1, 0, 0, 0.5, "M")
    ]


@pytest.mark.parametrize(
    ("name", "neutral", "other"),
    [("float clearcoat", "0", "1"), ("float ior", "1.5", "1.33"), ("int useSpecularWorkflow", "0", "1")],
)
def test_inputs_of_usd_that_are_not_read_are_told_where_they_have_an_effect(tmp_path, name, neutral, other):
    kind, name = name.split()
    text = f"float inputs:metallic = 0.5\n        {kind} inputs:{name} = "
    assert only(read(tmp_path, material("M", text + neutral), painted(bound("M")))).metallic == 0.5
    with pytest.warns(UserWarning, match=rf"leaves out the input {name} of materials \(1\)$"):
        robot = robotics.load(write(tmp_path, material("M", text + other), painted(bound("M"))))
    assert only(robot).metallic == (0 if "Specular" in name else 0.5)  # the specular workflow has none


@pytest.mark.parametrize(
    ("name", "kind"),
    [("diffuseColor", "color3f"), ("metallic", "float"), ("roughness", "float"), ("opacity", "float")],
)
def test_textures_of_each_input_of_usd_are_told(tmp_path, name, kind):
    text = f"""{kind} inputs:{name}.connect = </M/Image.outputs:r>
        token outputs:surface
    }}
    def Shader "Image"
    {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @a.png@
        {kind} outputs:r"""
    with pytest.warns(UserWarning, match=r"leaves out textures of materials \(1\)$"):
        robot = robotics.load(write(tmp_path, material("M", text), painted(bound("M"))))
    assert (only(robot).metallic, only(robot).roughness, only(robot).base_color[3]) == (0, 0.5, 1)


def shader(name, color, connects=""):
    return f"""def Shader "{name}"
    {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = {color}
        {connects}
        token outputs:surface
    }}
"""


def test_the_shader_of_the_surface_of_usd(tmp_path):
    """Others of the material do not count, in whatever order they stand; that for all renderers comes first."""
    red, green = shader("A", "(1, 0, 0)"), shader("B", "(0, 1, 0)")
    universal, mdl = (
        "token outputs:%ssurface.connect = </M/%s.outputs:surface>" % each for each in (("", "B"), ("mdl:", "A"))
    )
    for outputs, expected in (
        (universal, (0, 1, 0)),
        (universal + "\n" + mdl, (0, 1, 0)),
        (mdl + "\n" + universal, (0, 1, 0)),
        (mdl, (1, 0, 0)),
        ("", (0.5, 0.5, 0.5)),
    ):
        text = f'def Material "M"\n{{\n    {outputs}\n    {red}    {green}}}\n'
        assert colours(read(tmp_path, text, painted(bound("M")))) == [(*expected, 1, "M")]


def test_the_material_of_the_purpose_full_counts_in_usd(tmp_path):
    ink, wax = (
        material(name, f"color3f inputs:diffuseColor = {c}") for name, c in (("Ink", "(1, 0, 0)"), ("Wax", "(0, 1, 0)"))
    )
    for stated, name in (
        (bound("Ink"), "Ink"),
        (bound("Ink") + "\n    rel material:binding:full = </Wax>", "Wax"),
        (bound("Ink") + "\n    rel material:binding:preview = </Wax>", "Ink"),
    ):
        assert only(read(tmp_path, ink, wax, painted(stated))).name == name


def test_the_subdivision_of_usd_is_told_unless_there_is_none(tmp_path):
    for scheme in ("", 'uniform token subdivisionScheme = "catmullClark"'):
        points = SQUARE.replace('uniform token subdivisionScheme = "none"', scheme)
        with pytest.warns(
            UserWarning, match=r"leaves out the subdivision of meshes, which are as their points say \(1\)$"
        ):
            robotics.load(write(tmp_path, mesh(points=points)))
    read(tmp_path, mesh())


def test_a_shader_with_several_colours_has_its_diffuse_one(tmp_path):
    inputs = "color3f inputs:base_color = (0, 0, 1)\n        color3f inputs:diffuseColor = (1, 0.5, 0.25)"
    assert colours(read(tmp_path, material("M", inputs), painted(bound("M")))) == [(1, 0.5, 0.25, 1, "M")]


def test_opacities_of_omni_pbr_count_where_they_are_enabled(tmp_path):
    for enabled, opacity in (
        ("", 0.25),
        ("bool inputs:enable_opacity = 1", 0.25),
        ("bool inputs:enable_opacity = 0", 1),
    ):
        inputs = f"color3f inputs:diffuse_color_constant = (1, 0, 0)\n float inputs:opacity_constant = 0.25\n {enabled}"
        assert colours(read(tmp_path, material("M", inputs, "OmniPBR"), painted(bound("M")))) == [
            (1, 0, 0, opacity, "M")
        ]


def test_textures_of_usd_are_told(tmp_path):
    asset = "asset inputs:diffuse_texture = @wood.png@"
    with pytest.warns(UserWarning, match=r"leaves out textures of materials \(1\)$"):
        robotics.load(write(tmp_path, material("M", asset, "OmniPBR"), painted(bound("M"))))
    read(tmp_path, material("M", "asset inputs:diffuse_texture", "OmniPBR"), painted(bound("M")))


def test_sides_of_usd(tmp_path):
    """A mesh is seen from its front alone unless it says otherwise, and so are subsets of its faces."""
    subset = """def GeomSubset "Part" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0]
        rel material:binding = </Ink>
    }"""
    ink = material("Ink", "color3f inputs:diffuseColor = (1, 0.5, 0.25)")
    for stated, double in (("", False), ("uniform bool doubleSided = 1", True)):
        scene = read(tmp_path, ink, painted(f"{stated}\n    {subset}")).scene
        (one,) = scene.meshes
        parts = [(scene.materials[part.material], part.first_triangle) for part in one.parts]
        assert [(each.name, each.double_sided, first) for each, first in parts] == [("Ink", double, 0), ("", double, 1)]
        np.testing.assert_allclose(parts[0][0].base_color[:3], (1, 0.5, 0.25))


def test_labels_of_usd(tmp_path):
    """The nearest prim that has labels, of the type class, states the class."""

    def labels(kind, data, name="s"):
        return (
            f'string semantic:{name}:params:semanticType = "{kind}"\n'
            f'    string semantic:{name}:params:semanticData = "{data}"'
        )

    prims = [
        mesh(labels("class", "wall, grey"), "A"), mesh(labels("color", "red"), "B"),
        mesh(labels("color", "red") + "\n    " + labels("class", "door", "t"), "C"),
        'def Xform "Top"\n{\n    token[] semantics:labels:class = ["car"]\n    ' + mesh("", "D")
        + mesh('token[] semantics:labels:class = ["wheel"]', "E") + "}\n",
    ]  # fmt: skip
    instances = read(tmp_path, *prims, classes={"grey": 1, "door": 2, "car": 3, "wheel": 4, "red": 9}).scene.instances
    assert [(one.class_name, one.class_id) for one in instances] == [
        ("wall", 1),
        ("", 0),
        ("door", 2),
        ("car", 3),
        ("wheel", 4),
    ]


LIDAR = """def Xform "Mast"
{
    float3 xformOp:scale = (2, 2, 2)
    double3 xformOp:translate = (1, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
    def OmniLidar "Head"
    {
        double3 xformOp:translate = (0.5, 0, 0)
        float xformOp:rotateZ = 90
        float xformOp:rotateX:tilt = 30
        uniform token[] xformOpOrder = [%s]
        token omni:sensor:Core:scanType = "ROTARY"
        uint omni:sensor:Core:scanRateBaseHz = 20
        uint omni:sensor:Core:patternFiringRateHz = 3600
        float omni:sensor:Core:farRangeM = 80
        float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [0, 0]
        float[] omni:sensor:Core:emitterState:s001:elevationDeg = [-5, 5]
        uint[] omni:sensor:Core:emitterState:s001:fireTimeNs = [0, 1000]
    }
}
"""


def test_the_place_of_an_omni_lidar(tmp_path):
    """Its transforms are in the order that it states, some undone; a mast that is scaled moves it twice as far."""
    for order, turn in (
        (
            ("xformOp:translate", "xformOp:rotateZ", "xformOp:rotateX:tilt"),
            about("z", np.pi / 2) @ about("x", np.pi / 6),
        ),
        (
            ("xformOp:translate", "xformOp:rotateX:tilt", "xformOp:rotateZ"),
            about("x", np.pi / 6) @ about("z", np.pi / 2),
        ),
        (("xformOp:translate", "!invert!xformOp:rotateZ"), about("z", -np.pi / 2)),
        (("xformOp:translate", "xformOp:notThere", "xformOp:rotateZ"), about("z", np.pi / 2)),
    ):
        robot = robotics.load(write(tmp_path, LIDAR % ", ".join(f'"{name}"' for name in order), mesh()))
        (head,) = robot.sensors
        assert (head.name, head.frame, head.rate) == ("Head", "/Mast/Head", pytest.approx(20))
        np.testing.assert_allclose(robot.pose().position, (2, 0, 5), atol=1e-9)
        np.testing.assert_allclose(adapter.rows_of(robot.pose())[:3, :3], turn, atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(head.local[:3, :3], axis=0), 1)
    robot = robotics.load(
        write(
            tmp_path,
            LIDAR.replace("xformOp:translate = (0.5", "xformOp:translate = (50") % '"xformOp:translate"',
            unit=0.01,
        )
    )
    np.testing.assert_allclose(robot.pose().position, (1.01, 0, 0.05), atol=1e-9)
    # One that says so has no part in the transforms above it.
    alone = LIDAR % '"!resetXformStack!", "xformOp:translate", "xformOp:rotateZ"'
    robot = robotics.load(write(tmp_path, alone, mesh(), unit=0.1))
    np.testing.assert_allclose(robot.pose().position, (0.05, 0, 0), atol=1e-9)
    np.testing.assert_allclose(adapter.rows_of(robot.pose())[:3, :3], about("z", np.pi / 2), atol=1e-6)


def test_profiles_that_cameras_name(tmp_path):
    """A lidar of Isaac Sim before version 5, whose profile lies beside the stage or in a folder that is searched."""
    import json

    profile = {
        "class": "sensor", "type": "lidar", "name": "Small",
        "profile": {
            "scanType": "rotary", "scanRateBaseHz": 10.0, "reportRateBaseHz": 3600, "numberOfEmitters": 2,
            "nearRangeM": 0.5, "farRangeM": 60.0, "emitterStateCount": 1,
            "emitterStates": [{"azimuthDeg": [0.0, 0.0], "elevationDeg": [-5.0, 5.0], "fireTimeNs": [0, 1000]}],
        },
    }  # fmt: skip
    camera = 'def Camera "Lidar"\n{\n    string sensorModelConfig = "Small"\n}\n'
    with pytest.warns(UserWarning, match=r"leaves out the lidar /Lidar, whose profile Small.json is not found \(1\)$"):
        assert not robotics.load(write(tmp_path, camera, mesh())).sensors
    (tmp_path / "profiles").mkdir()
    (tmp_path / "profiles" / "Small.json").write_text(json.dumps(profile))
    own = gnosphere.read_sensor_file(tmp_path / "profiles" / "Small.json")
    robot = robotics.load(write(tmp_path, camera, mesh()), search=[tmp_path / "profiles"])
    assert robot.sensors[0].sensor == own.sensor and robot.sensors[0].sensor.range_max == 60
