#!/usr/bin/env python3
"""Reads models as programs of others do: check_models.py usd|open3d|trimesh FILE...

Prints one line a file, "NAME VERTICES TRIANGLES COLOURS" or what is wrong. Exit status: 0 all are well, 1 not,
3 the package that is asked for is not installed.
"""
import sys


def usd_problems(path, stage):
    from pxr import Sdr, UsdUtils
    if not hasattr(UsdUtils, "ComplianceChecker"):
        from pxr import UsdValidation
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        return [error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(stage)]
    checker = UsdUtils.ComplianceChecker(arkit=True, verbose=False)  # what usdchecker --arkit runs
    checker.CheckCompliance(path)
    problems = checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
    # Some wheels come without the definitions of the shaders, and then know none.
    knows_shaders = Sdr.Registry().GetShaderNodeByIdentifier("UsdPreviewSurface")
    return [problem for problem in problems if knows_shaders or "has invalid shader node" not in problem]


def usd(path):
    from pxr import Tf, Usd, UsdGeom
    try:
        from pxr import Sdr
        Sdr.Registry()
    except Tf.ErrorException:  # of such a wheel, once
        pass
    stage = Usd.Stage.Open(path)
    problems = usd_problems(path, stage)
    if problems:
        raise ValueError("; ".join(problems))
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    vertices = sum(len(mesh.GetPointsAttr().Get()) for mesh in meshes)
    return vertices, sum(len(mesh.GetFaceVertexCountsAttr().Get()) for mesh in meshes), False


def open3d(path):
    import open3d
    mesh = open3d.io.read_triangle_mesh(path)
    return len(mesh.vertices), len(mesh.triangles), mesh.has_vertex_colors()


def trimesh(path):
    import trimesh as reader
    mesh = reader.load(path, force="mesh", process=False)
    return len(mesh.vertices), len(mesh.faces), mesh.visual.kind == "vertex"


READERS = {"usd": ("pxr", usd), "open3d": ("open3d", open3d), "trimesh": ("trimesh", trimesh)}


def main(reader, *paths):
    module, read = READERS[reader]
    try:
        __import__(module)
    except ImportError as error:
        print(error)
        return 3
    failed = False
    for path in paths:
        try:
            print(path.rsplit("/", 1)[-1], *(int(v) for v in read(path)))
        except Exception as error:  # whatever a reader may throw
            print(path, error)
            failed = True
    return 1 if failed else 0


sys.exit(main(*sys.argv[1:]))
