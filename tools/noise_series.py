#!/usr/bin/env python3
"""Surfaces from noisy clouds against screened Poisson that is given the true normals: the table of docs/stages/denoise.md.

usage: noise_series.py PROGRAM FOLDER [PATTERN] [OPTION ...]

Clouds of 100 000 points (sample.py of the quality bench) of spot and bob and of both subdivided twice, with noise in spacings
and outliers; both sides simplified to 8 000 triangles. PATTERN chooses by name (spot-0.3-0 is spot, noise 0.3, no outliers).
OPTIONs go to the program. FOLDER keeps clouds and Poisson's results. Needs Debian's python3-open3d, numpy and the bench
(../shared/quality, or POINTBAKE_QUALITY) with its data (../shared/data, or POINTBAKE_DATA).
"""
import json
import os
import re
import subprocess
import sys

import numpy as np
import open3d as o3d

HERE = os.path.dirname(os.path.abspath(__file__))
DATA = os.environ.get("POINTBAKE_DATA", os.path.join(HERE, "../../shared/data"))
QUALITY = os.environ.get("POINTBAKE_QUALITY", os.path.join(HERE, "../../shared/quality"))
sys.path.insert(0, QUALITY)
from compare import fibonacci_sphere, view_rays  # noqa: E402
from meshio import TexturedMesh, load_mesh  # noqa: E402
from raycast import Scene  # noqa: E402
from sample import at, sample_random  # noqa: E402

SERIES = [(0, 0), (0.1, 0), (0.3, 0), (0.5, 0), (1.0, 0), (0, 0.01), (0, 0.05), (0.3, 0.05)]


def loop(points, triangles):
    """Loop's subdivision of a closed mesh, once."""
    n = len(points)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    opposite = np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])
    low, high = edges.min(1), edges.max(1)
    keys, inverse = np.unique(low * n + high, return_inverse=True)
    a, b = keys // n, keys % n
    wings = np.zeros((len(keys), 3))
    np.add.at(wings, inverse, points[opposite])
    middles = 3 / 8 * (points[a] + points[b]) + 1 / 8 * wings
    valence = np.bincount(np.concatenate([a, b]), minlength=n)
    ring = np.zeros((n, 3))
    np.add.at(ring, a, points[b])
    np.add.at(ring, b, points[a])
    beta = np.where(valence == 3, 3 / 16, 3 / (8 * np.maximum(valence, 1)))
    moved = (1 - valence * beta)[:, None] * points + beta[:, None] * ring
    m = len(triangles)
    e0, e1, e2 = n + inverse[:m], n + inverse[m:2 * m], n + inverse[2 * m:]
    parts = [(triangles[:, 0], e0, e2), (triangles[:, 1], e1, e0), (triangles[:, 2], e2, e1), (e0, e1, e2)]
    return np.concatenate([moved, middles]), np.concatenate([np.stack(p, 1) for p in parts])


def subdivided(source, path):
    mesh = load_mesh(source)
    points, inverse = np.unique(mesh.positions, axis=0, return_inverse=True)
    triangles = inverse.ravel()[mesh.triangles]
    for _ in range(2):
        points, triangles = loop(points, triangles)
    with open(path, "w") as out:
        out.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in points)
        out.writelines("f %d %d %d\n" % tuple(t + 1) for t in triangles)


def bare(points, triangles):
    return TexturedMesh(points, triangles, None, np.zeros(len(triangles), int), [np.ones(3)])


def measure(truth, points, triangles):
    """Mean distance, the worse side, in 1e-4 of the diagonal; iou of the silhouettes in 12 views."""
    result = bare(points, triangles)
    corners = truth.positions[truth.triangles].reshape(-1, 3)
    center, radius = (corners.min(0) + corners.max(0)) / 2, np.linalg.norm(np.ptp(corners, axis=0)) / 2
    scenes = [Scene(m.positions, m.triangles) for m in (truth, result)]
    rng = np.random.default_rng(7)
    means = [other.distance(at(mesh, *sample_random(mesh, 100000, rng))).mean() / (2 * radius)
             for mesh, other in ((truth, scenes[1]), (result, scenes[0]))]
    both = either = 0
    for direction in fibonacci_sphere(12):
        rays = view_rays(direction, center, radius, 384)
        a, b = (np.isfinite(scene.cast(rays)[0]) for scene in scenes)
        both, either = both + (a & b).sum(), either + (a | b).sum()
    return max(means) * 1e4, both / either


def arrays(path):
    mesh = o3d.io.read_triangle_mesh(path)
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def poisson(cloud, path):
    points = o3d.io.read_point_cloud(cloud)
    mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(points, depth=9)
    o3d.io.write_triangle_mesh(path, mesh.simplify_quadric_decimation(8000))


def sample(source, out, noise, outliers, *more):
    subprocess.run(["/usr/bin/python3", os.path.join(QUALITY, "sample.py"), source, out, "--points", "100000", "--noise",
                    str(noise), "--outliers", str(outliers), *more], check=True, stdout=subprocess.DEVNULL)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, folder, pattern, options = sys.argv[1], sys.argv[2], (sys.argv + [""])[3], sys.argv[4:]
    os.makedirs(folder, exist_ok=True)
    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    print("| cloud | pointbake | Poisson | ratio | iou | Poisson's |\n|---|---|---|---|---|---|")
    for model in ("spot", "bob", "spot-loop", "bob-loop"):
        source = os.path.join(DATA, "textured", model.replace("-loop", "") + ".obj")
        for noise, outliers in SERIES:
            name = f"{model}-{noise}-{outliers}"
            if not re.search(pattern, name):
                continue
            path = os.path.join(folder, name)
            if "loop" in model:
                if not os.path.exists(f"{folder}/{model}.obj"):
                    subdivided(source, f"{folder}/{model}.obj")
                source = f"{folder}/{model}.obj"
            truth = load_mesh(source)
            if not os.path.exists(path + "-poisson.json"):
                sample(source, path + "-normals.ply", noise, outliers, "--normals")
                sample(source, path + ".ply", noise, outliers)
                poisson(path + "-normals.ply", path + "-poisson.ply")
                with open(path + "-poisson.json", "w") as out:
                    json.dump(measure(truth, *arrays(path + "-poisson.ply")), out)
            with open(path + "-poisson.json") as file:
                theirs = json.load(file)
            subprocess.run([program, path + ".ply", path + "-ours.ply", "--triangles", "8000", "--stop-after", "simplify", "-q",
                            *options], check=True)
            ours = measure(truth, *arrays(path + "-ours.ply"))
            print(f"| {name} | {ours[0]:.2f} | {theirs[0]:.2f} | {ours[0] / theirs[0]:.2f} | {ours[1]:.4f} | {theirs[1]:.4f} |",
                  flush=True)


main()
