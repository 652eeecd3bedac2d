#!/usr/bin/env python3
"""Reads models as programs of others do: check_models.py usd|open3d|trimesh FILE...

Prints one line a file, "NAME VERTICES TRIANGLES COLOURS" or what is wrong. Exit status: 0 all are well, 1 not,
3 the package that is asked for is not installed.
"""
import sys


def usd(path):
    from pxr import Usd, UsdGeom, UsdUtils
    problems = []
    if hasattr(UsdUtils, "ComplianceChecker"):  # what usdchecker --arkit runs
        checker = UsdUtils.ComplianceChecker(arkit=True, verbose=False)
        checker.CheckCompliance(path)
        problems = checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
    else:
        from pxr import UsdValidation
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(path))
        problems = [error.GetMessage() for error in found]
    if problems:
        raise ValueError("; ".join(problems))
    vertices = triangles = 0
    for prim in Usd.Stage.Open(path).Traverse():
        if prim.IsA(UsdGeom.Mesh):
            vertices += len(UsdGeom.Mesh(prim).GetPointsAttr().Get())
            triangles += len(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get())
    return vertices, triangles, False


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
