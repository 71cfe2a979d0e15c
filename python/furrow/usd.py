"""A drive for viewers of USD: `furrow usd DIR -o world.usdc`, or furrow.usd.write("out", "world.usdc").

Needs the package usd-core; shapes of vehicles need mujoco. The stage is in metres, z up: x east, y north. A second has as many time codes as vehicles.csv has rows.
"""
import pathlib
import re
import sys
from typing import Any, Union

import numpy as np

from furrow import _command, _png, _stage
from furrow.results import Drive, ResultsError

ABOUT = """Writes the ground at the end of a drive as a mesh with texture coordinates, a texture and colours, and vehicles and objects with their motion.

  furrow drive scene.yaml -o out && furrow usd out -o world.usdc
  usdchecker world.usdc"""


def _name(text: str, taken: "set[str]") -> str:
    """A name as USD takes it, that no sibling has."""
    own = re.sub(r"[^A-Za-z0-9_]", "_", text)
    own = own if own[:1].isalpha() or own[:1] == "_" else "_" + own
    name, number = own, 1
    while name in taken:
        name, number = f"{own}_{number}", number + 1
    taken.add(name)
    return name


class _Writer:
    """Puts prims into a stage."""

    def __init__(self, stage: Any, rate: float) -> None:
        self.usd = {name: _command.need(f"pxr.{name}", "usd-core") for name in ("Gf", "Sdf", "UsdGeom", "UsdShade", "Vt")}
        self.stage, self.rate = stage, rate

    def mesh(self, path: str, points: "np.ndarray", faces: "np.ndarray") -> Any:
        """A mesh of triangles or quads."""
        geom, vt = self.usd["UsdGeom"], self.usd["Vt"]
        mesh = geom.Mesh.Define(self.stage, path)
        points = np.ascontiguousarray(points, np.float32)
        mesh.CreatePointsAttr(vt.Vec3fArray.FromNumpy(points))
        mesh.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(np.full(len(faces), faces.shape[1], np.int32)))
        mesh.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(np.ascontiguousarray(faces, np.int32).reshape(-1)))
        mesh.CreateSubdivisionSchemeAttr("none")
        mesh.CreateExtentAttr([tuple(map(float, points.min(axis=0))), tuple(map(float, points.max(axis=0)))])
        return mesh

    def ground(self, own: "_stage.Ground", texture: str) -> None:
        """The ground, about a whole number of metres near it, so that floats are exact enough."""
        geom, sdf, vt, gf = (self.usd[name] for name in ("UsdGeom", "Sdf", "Vt", "Gf"))
        rows, columns = own.heights.shape
        base = float(np.floor(own.low))
        y, x = np.mgrid[0:rows, 0:columns]
        points = np.stack([x * own.spacing, y * own.spacing, own.filled() - base], axis=2).reshape(-1, 3)
        corner = (y[:-1, :-1] * columns + x[:-1, :-1]).reshape(-1)
        faces = np.stack([corner, corner + 1, corner + columns + 1, corner + columns], axis=1)
        faces = faces[~np.isnan(own.heights).reshape(-1)[faces].any(axis=1)]
        if len(faces) == 0:
            raise ResultsError("the ground has no cell without a hole; give another --window")
        mesh = self.mesh("/World/ground", points, faces)
        geom.Xformable(mesh).AddTranslateOp().Set(gf.Vec3d(own.x, own.y, base))
        primvars = geom.PrimvarsAPI(mesh)
        st = np.stack([(x + 0.5) / columns, (y + 0.5) / rows], axis=2).reshape(-1, 2)
        primvars.CreatePrimvar("st", sdf.ValueTypeNames.TexCoord2fArray, geom.Tokens.vertex).Set(vt.Vec2fArray.FromNumpy(np.ascontiguousarray(st, np.float32)))
        srgb = _stage.ground_colours(own).reshape(-1, 3)
        linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        mesh.CreateDisplayColorPrimvar(geom.Tokens.vertex).Set(vt.Vec3fArray.FromNumpy(np.ascontiguousarray(linear, np.float32)))
        self._texture(mesh, texture)

    def _texture(self, mesh: Any, texture: str) -> None:
        shade, sdf = self.usd["UsdShade"], self.usd["Sdf"]
        material = shade.Material.Define(self.stage, "/World/materials/ground")
        surface = shade.Shader.Define(self.stage, "/World/materials/ground/surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        surface.CreateInput("roughness", sdf.ValueTypeNames.Float).Set(1.0)
        reader = shade.Shader.Define(self.stage, "/World/materials/ground/st")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", sdf.ValueTypeNames.String).Set("st")
        image = shade.Shader.Define(self.stage, "/World/materials/ground/image")
        image.CreateIdAttr("UsdUVTexture")
        image.CreateInput("file", sdf.ValueTypeNames.Asset).Set(sdf.AssetPath(texture))
        image.CreateInput("sourceColorSpace", sdf.ValueTypeNames.Token).Set("sRGB")
        image.CreateInput("wrapS", sdf.ValueTypeNames.Token).Set("clamp")
        image.CreateInput("wrapT", sdf.ValueTypeNames.Token).Set("clamp")
        image.CreateInput("st", sdf.ValueTypeNames.Float2).ConnectToSource(reader.CreateOutput("result", sdf.ValueTypeNames.Float2))
        surface.CreateInput("diffuseColor", sdf.ValueTypeNames.Color3f).ConnectToSource(image.CreateOutput("rgb", sdf.ValueTypeNames.Float3))
        material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", sdf.ValueTypeNames.Token))
        shade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)

    def part(self, path: str, part: "_stage.Part") -> None:
        """A shape at its place on its body."""
        geom, gf = self.usd["UsdGeom"], self.usd["Gf"]
        size, stretch = part.size, None
        if part.kind == "mesh":
            shape = self.mesh(path, part.vertices, part.faces)
        elif part.kind in ("sphere", "ellipsoid"):
            shape = geom.Sphere.Define(self.stage, path)
            shape.CreateRadiusAttr(size[0] if part.kind == "sphere" else 1.0)
            stretch = size if part.kind == "ellipsoid" else None
        elif part.kind == "box":
            shape = geom.Cube.Define(self.stage, path)
            shape.CreateSizeAttr(2.0)
            stretch = size
        else:
            shape = (geom.Cylinder if part.kind == "cylinder" else geom.Capsule).Define(self.stage, path)
            shape.CreateRadiusAttr(size[0])
            shape.CreateHeightAttr(2 * size[1])
            shape.CreateAxisAttr("Z")
        if part.kind != "mesh":
            shape.CreateExtentAttr(geom.Boundable.ComputeExtentFromPlugins(geom.Boundable(shape.GetPrim()), self.usd_default()))
        shape.CreateDisplayColorAttr([tuple(part.colour)])
        x, y, z, w = _stage.unit_quaternion(part.turn)
        form = geom.Xformable(shape)
        form.AddTranslateOp().Set(gf.Vec3d(*map(float, part.at)))
        form.AddOrientOp(geom.XformOp.PrecisionDouble).Set(gf.Quatd(float(w), float(x), float(y), float(z)))
        if stretch is not None:
            form.AddScaleOp(geom.XformOp.PrecisionDouble).Set(gf.Vec3d(*map(float, stretch)))

    @staticmethod
    def usd_default() -> Any:
        """The time of values that have no samples."""
        return _command.need("pxr.Usd", "usd-core").TimeCode.Default()

    def mover(self, mover: "_stage.Mover", parent: str, taken: "set[str]") -> None:
        """A body with its poses in time."""
        geom, gf = self.usd["UsdGeom"], self.usd["Gf"]
        path = f"{parent}/{_name(mover.name.split('/')[-1], taken)}"
        form = geom.Xform.Define(self.stage, path)
        move, turn = form.AddTranslateOp(), form.AddOrientOp(geom.XformOp.PrecisionDouble)
        for t, at, (x, y, z, w) in zip(mover.times, mover.places, mover.turns):
            move.Set(gf.Vec3d(*map(float, at)), float(t * self.rate))
            turn.Set(gf.Quatd(float(w), float(x), float(y), float(z)), float(t * self.rate))
        parts: "set[str]" = set()
        for part in mover.parts:
            self.part(f"{path}/{_name(part.name, parts)}", part)


def _rate(movers: "list[_stage.Mover]") -> float:
    """Rows a second of what has most."""
    rates = [1 / float(np.median(np.diff(mover.times))) for mover in movers if len(mover.times) > 1]
    return max(rates, default=24.0)


def write(folder: _stage.Path, file: _stage.Path, window: "Union[list[float], None]" = None, vehicles: bool = True) -> "dict[str, Any]":
    """Writes a stage (.usdc, .usda or .usd), and beside it its texture, NAME_ground.png. window: west, south, east, north, m. Returns {posts, spacing, bodies, rate, lost}.

    Each file is there when it is whole. ResultsError: the store is gone, or the window or a model cannot be used. _command.Missing: usd-core or mujoco is not installed.
    """
    usd, geom = _command.need("pxr.Usd", "usd-core"), _command.need("pxr.UsdGeom", "usd-core")
    to = pathlib.Path(file)
    if to.suffix not in (".usdc", ".usda", ".usd"):
        raise ResultsError(f"{to}: its ending is not of USD; give .usdc, .usda or .usd")
    drive = Drive(folder)
    own = _stage.ground(drive, window)
    models = _stage.models(drive, not vehicles)
    movers = [(model.name, model.movers()) for model in models] + [("objects", _stage.objects(drive))]
    rate = _rate([mover for _, each in movers for mover in each])
    stage = usd.Stage.CreateInMemory()
    geom.SetStageUpAxis(stage, geom.Tokens.z)
    geom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    times = [t for _, each in movers for mover in each for t in (mover.times[0], mover.times[-1]) if len(mover.times)]
    if times:
        stage.SetStartTimeCode(float(min(times) * rate))
        stage.SetEndTimeCode(float(max(times) * rate))
    stage.SetDefaultPrim(geom.Xform.Define(stage, "/World").GetPrim())
    geom.Scope.Define(stage, "/World/materials")
    writer = _Writer(stage, rate)
    texture = to.with_name(to.stem + "_ground.png")
    writer.ground(own, "./" + texture.name)
    taken = {"ground", "materials"}
    for name, each in movers:
        if not each:
            continue
        parent = f"/World/{_name(name, taken)}"
        geom.Xform.Define(stage, parent)
        siblings: "set[str]" = set()
        for mover in each:
            writer.mover(mover, parent, siblings)
    with _command.Whole(texture) as whole:
        whole.write_bytes(_png.colours(np.rint(255 * _stage.ground_colours(own)[::-1])))
    with _command.Whole(to) as whole:
        aside = whole.with_name(whole.name)
        if not stage.GetRootLayer().Export(str(aside)):
            raise OSError(f"{to}: cannot be written; give a folder that can be written")
    return {"posts": list(own.heights.shape[::-1]), "spacing": own.spacing, "bodies": sum(len(each) for _, each in movers), "rate": rate,
            "lost": [f"{model.name}: {text}" for model in models for text in model.lost]}


def main(arguments: "list[str]") -> int:
    """The command. Returns its status."""
    parser = _command.parser("usd", ABOUT)
    parser.add_argument("folder", metavar="DIR", help="what furrow drive -o wrote")
    parser.add_argument("-o", "--output", metavar="FILE", required=True)
    parser.add_argument("--window", metavar="X0,Y0,X1,Y1", help="of the ground, m")
    parser.add_argument("--no-vehicles", action="store_true", help="the ground and objects alone")
    given = parser.parse_args(_command.joined(arguments, "--window"))

    def work() -> None:
        told = write(given.folder, given.output, _command.window(given.window), not given.no_vehicles)
        for text in told["lost"]:
            print(f"furrow: note: {text}", file=sys.stderr)
        print(f"{given.output}: ground of {told['posts'][0]} x {told['posts'][1]} posts at {told['spacing']:g} m, {told['bodies']} bodies at {told['rate']:g} time codes a second")

    return _command.end("usd", work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
