#!/usr/bin/env python3
"""What outlier removal drops and leaves, against the truth: the table of docs/stages/clean.md.

usage: outliers.py PROGRAM FOLDER

Clouds of 100 000 points (sample.py of the quality bench) with outliers added at random within the bounding box, which are rows
of their own; an ellipsoid and the demo model with parts that are 16 times sparser; real clouds, where only what is dropped can
be told. Far outliers are those farther than four spacings from the points, the spacing there. Needs Debian's python3-open3d, numpy, scipy and the
bench (../shared/quality, or POINTBAKE_QUALITY) with its data (../shared/data, or POINTBAKE_DATA).
"""
import json
import os
import subprocess
import sys

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree

HERE = os.path.dirname(os.path.abspath(__file__))
DATA = os.environ.get("POINTBAKE_DATA", os.path.join(HERE, "../../shared/data"))
QUALITY = os.environ.get("POINTBAKE_QUALITY", os.path.join(HERE, "../../shared/quality"))
MODELS = ["spot", "bob", "clay_tablet", "tea_set", "water_bottle", "corset", "barramundi_fish", "hope_macaroni_and_cheese"]
REAL = ["scans/igea", "scans/horse_48k", "scans/dragon_stand_range_raw", "colored_points/guanyin", "colored_points/pump",
        "colored_points/o3d_livingroom_002", "colored_points/lion_takanawa", "colored_points/pond_surfels"]


def write(path, points):
    o3d.io.write_point_cloud(path, o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)))


def read(path):
    return np.asarray(o3d.io.read_point_cloud(path).points)


def sample(mesh, path, count, *options):
    if not os.path.exists(path):
        subprocess.run([sys.executable, os.path.join(QUALITY, "sample.py"), mesh, path, "--points", str(count), *options],
                       check=True, stdout=subprocess.DEVNULL)
    return read(path)


def add_outliers(points, share, rng):
    low, high = points.min(0), points.max(0)
    return rng.uniform(low, high, (int(share * len(points)), 3))


def kept_rows(program, folder, points):
    """Per point whether it is kept, and the report's counts."""
    cloud, rows = os.path.join(folder, "cloud.ply"), os.path.join(folder, "rows.ply")
    write(cloud, points)
    run = subprocess.run([program, cloud, "-o", os.path.join(folder, "out.ply"), "--stop-after", "attributes",
                          "--write-points", rows, "--report", "-"], check=True, capture_output=True)
    with open(rows, "rb") as f:
        data = f.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    kinds = {"double": "<f8", "float": "<f4", "uint": "<u4", "int": "<i4", "ushort": "<u2", "uchar": "u1"}
    fields = [(line.split()[2], kinds[line.split()[1]]) for line in data[:end].decode().split("\n") if line.startswith("property")]
    table = np.frombuffer(data, np.dtype(fields), len(points), end)
    return table["kept"] == 1, json.loads(run.stdout)["clean"]


def row(program, folder, name, true, share, rng):
    outliers = add_outliers(true, share, rng)
    kept, _ = kept_rows(program, folder, np.concatenate([true, outliers]))
    tree = cKDTree(true)
    distance, nearest = tree.query(outliers)
    distance /= tree.query(true[nearest], 13)[0][:, 12] * np.sqrt(np.pi / 12)
    far, left = distance > 4, kept[len(true):]
    print("| %s | %g %% | %d (%.3f %%) | %d of %d | %.1f |" % (
        name, 100 * share, (~kept[:len(true)]).sum(), 100 * (~kept[:len(true)]).mean(), (far & left).sum(), far.sum(),
        distance[left].max() if left.any() else 0), flush=True)


def ellipsoid(count, dense, rng):
    k = np.arange(count)
    y = 1 - (2 * k + 1) / count
    r, angle = np.sqrt(1 - y * y), np.pi * (3 - 5 ** .5) * k
    points = np.stack([r * np.cos(angle), .8 * y, .6 * r * np.sin(angle)], 1)
    return points[dense(points) | (rng.random(count) < 1 / 16)]


def painted_demo(program, folder, rng):
    """Dense where the paint is dark."""
    cloud = os.path.join(folder, "demo-points.ply")
    if not os.path.exists(cloud):
        subprocess.run([program, "demo", os.path.join(folder, "demo.glb"), "--points", "800000", "--texels", "65536", "-q"], check=True)
    points = o3d.io.read_point_cloud(cloud)
    light = np.asarray(points.colors) @ [0.3, 0.6, 0.1]
    return np.asarray(points.points)[(light < 0.5) | (rng.random(len(light)) < 1 / 16)]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, folder = sys.argv[1:]
    os.makedirs(folder, exist_ok=True)
    rng = np.random.default_rng(1)
    clouds = [(m, sample(os.path.join(DATA, "textured", m + ".obj"), os.path.join(folder, m + ".ply"), 100000)) for m in MODELS]
    spot, bob = (os.path.join(DATA, "textured", m + ".obj") for m in ("spot", "bob"))
    clouds.append(("spot, noise of 0.3 spacings", sample(spot, os.path.join(folder, "noisy.ply"), 100000, "--noise", "0.3")))
    clouds.append(("bob, `--mode random`", sample(bob, os.path.join(folder, "random.ply"), 100000, "--mode", "random")))
    stripes = lambda p: np.sin(6 * p[:, 0]) * np.sin(5 * p[:, 1] + 1) * np.sin(7 * p[:, 2]) > 0  # noqa: E731
    clouds.append(("ellipsoid, a tenth 16 times sparser", ellipsoid(400000, lambda p: p[:, 1] < 0.64, rng)))
    clouds.append(("ellipsoid, half 16 times sparser, in patches", ellipsoid(400000, stripes, rng)))
    clouds.append(("demo model, light paint 16 times sparser", painted_demo(program, folder, rng)))
    print("| cloud | outliers | true points lost | far outliers left | farthest left, in spacings |\n|---|---|---|---|---|")
    for name, points in clouds:
        for share in (0, 0.01, 0.05):
            row(program, folder, name, points, share, rng)
    print("\n| cloud | points | outliers | points of floating pieces |\n|---|---|---|---|")
    for name in REAL:
        points = read(os.path.join(DATA, name + ".ply"))
        clean = kept_rows(program, folder, points)[1]
        print("| %s | %d | %d (%.2f %%) | %d of %d |" % (os.path.basename(name), len(points), clean["outliers"], 100 * clean["outliers"]
                                                     / len(points), clean["floating_points"], clean["floating_pieces"]), flush=True)


if __name__ == "__main__":
    main()
