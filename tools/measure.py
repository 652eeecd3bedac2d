#!/usr/bin/python3
"""Measures results with the quality bench's own readers and ray caster, for the figures in docs/.

usage: measure.py round-trip TRUTH CLOUD RESULT   colour at random points of the true surface, in dB, beside limit.py's
       measure.py bound REPORT POINTS RESULT      farthest kept point of --write-points / the bound of --report
       measure.py dense TRUTH SPACING MESH.ply    share of pixels in which the first surface hit is the true one
       measure.py flat RESULT                     neighbouring triangles with at most 8 and at least 200 texels
       measure.py seams RESULT                    seam_rms and border_rms, as compare.py measures them
       measure.py held-out CLOUD.ply PROGRAM [OPTION...]   converts nine points in ten; RMS of the texture at the others,
                                                  in 8-bit steps, beside the colour of the nearest point that was used
       measure.py views CLOUD RESULT PROGRAM [FOLDER]     24 pictures of the mesh against the same of the points as splats,
                                                  where both cover a pixel entirely; FOLDER keeps the pictures
       measure.py lettering CLOUD RESULT PROGRAM [-v]     words of the demo model's lettering that tesseract reads in pictures
                                                  of the points and of the mesh; -v: what it reads
       measure.py watertight PROGRAM CLOUD...     --surface watertight --stop-after simplify of each: closed, 2-manifold by index,
                                                  oriented, its volume, after numpy and Open3D
       measure.py walls CLOUD PROGRAM [OPTION...] RMS to the three largest planes, of the mesh over that of the points, where
                                                  nothing stands near

Needs the bench beside the checkout (../shared/quality, or POINTBAKE_QUALITY), what it needs, and python3-open3d.
"""
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter

sys.path.insert(0, os.environ.get("POINTBAKE_QUALITY", os.path.join(os.path.dirname(__file__), "../../shared/quality")))
import numpy as np
import open3d as o3d

from compare import fibonacci_sphere, psnr, seam_rms, view_rays
from limit import limits
from meshio import load_mesh, read_ply
from PIL import Image, ImageOps
from raycast import Scene
from sample import at, sample_random
from scipy.spatial import cKDTree


def color_near(mesh, where):
    """The mesh's colour at the places nearest to some points, and their distances."""
    middle = mesh.positions.mean(0)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor((mesh.positions - middle).astype(np.float32)),
                        o3d.core.Tensor(mesh.triangles.astype(np.uint32)))
    near = scene.compute_closest_points(o3d.core.Tensor((where - middle).astype(np.float32)))
    u, v = near["primitive_uvs"].numpy().T
    color = mesh.color_at(near["primitive_ids"].numpy().astype(int), np.stack([1 - u - v, u, v], 1))
    return color, np.linalg.norm(near["points"].numpy() + middle - where, axis=1)


def write_ply(path, rows):
    names = {"f": "float", "d": "double", "B": "uchar", "b": "char", "h": "short", "H": "ushort", "i": "int", "I": "uint"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    header += [f"property {names[rows.dtype[n].char]} {n}" for n in rows.dtype.names]
    with open(path, "wb") as f:
        f.write(("\n".join(header + ["end_header", ""])).encode() + rows.tobytes())


def held_out(cloud, program, *options):
    rows = read_ply(cloud)["vertex"]
    out = np.random.default_rng(5).random(len(rows)) < 0.1
    where = np.stack([rows[k] for k in "xyz"], 1).astype(float)
    channel = "red" if "red" in rows.dtype.names else "diffuse_red"
    color = np.stack([rows[channel.replace("red", k)] for k in ("red", "green", "blue")], 1) / 255.0
    with tempfile.TemporaryDirectory() as folder:
        kept, result = os.path.join(folder, "kept.ply"), os.path.join(folder, "kept.glb")
        write_ply(kept, rows[~out])
        subprocess.run([program, kept, result, "-q", *options], check=True)
        mesh = load_mesh(result)
    got, _ = color_near(mesh, where[out])
    _, nearest = cKDTree(where[~out]).query(where[out])
    rms = lambda a: 255 * float(np.sqrt(((a - color[out]) ** 2).mean()))
    print(f"{out.sum()} held out, RMS {rms(got):.2f}, nearest point {rms(color[~out][nearest]):.2f}")


def views(cloud, result, program, folder=None):
    """Pooled PSNR over all views, the worst view's, and how far the two cover the same pixels."""
    error, pixels, both, either = [], [], 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        os.makedirs(folder or scratch, exist_ok=True)
        for number, direction in enumerate(fibonacci_sphere(24)):
            up = (0, 1, 0) if abs(direction[1]) < 0.9 else (1, 0, 0)
            sheet = os.path.join(folder or scratch, f"view{number:02d}.png")
            axis = lambda v: ",".join(f"{x:.9g}" for x in v)
            subprocess.run([program, "render", cloud, result, sheet, "--transparent", "-q", "--direction=" + axis(direction),
                            "--up=" + axis(up), "--width", "512", "--height", "512"], check=True)
            points, mesh = np.split(np.asarray(Image.open(sheet), float), [512], axis=1)
            solid = (points[..., 3] == 255) & (mesh[..., 3] == 255)
            error.append((((points - mesh)[solid][:, :3] / 255) ** 2).mean(1).sum())
            pixels.append(solid.sum())
            share = np.stack([points[..., 3], mesh[..., 3]])
            both, either = both + share.min(0).sum(), either + share.max(0).sum()
    worst = int(np.argmax(np.array(error) / np.maximum(pixels, 1)))
    print(f"views {psnr(sum(error) / sum(pixels)):.2f} dB, worst {psnr(error[worst] / pixels[worst]):.2f} (view {worst}), "
          f"IoU {both / either:.4f}")


def lettering_lines():
    """Face, middle of the baseline, height and text of the demo model's lines of words, from the program's source."""
    source = open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../src/model/lettering.cpp")).read()
    line = r'\{BoxFace::k(\w+),\s*\{([\d.]+), ([\d.]+)\},\s*([\d.]+),\s*[\d.]+,\s*Ink::\w+,\s*"([^"]+)"\}'
    found = [(face, float(u), float(v), float(size), text) for face, u, v, size, text in re.findall(line, source)]
    return [f for f in found if f[2] < 0.76 and not re.search("[0-9]|(?i:abcdef)", f[4])]


def read_line(picture, height):
    """What tesseract reads in one line of text: grey, dark on bright, capitals 48 pixels high."""
    grey = ImageOps.autocontrast(picture.convert("L"))
    if np.median(np.asarray(grey)) < 128:
        grey = ImageOps.invert(grey)
    grey = grey.resize([max(1, round(n * 48 / height)) for n in grey.size], Image.Resampling.LANCZOS)
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        ImageOps.expand(grey, 24, int(np.median(np.asarray(grey)))).save(file.name)
        return subprocess.run(["tesseract", file.name, "-", "--psm", "7"], check=True, capture_output=True, text=True).stdout


def words(text):
    return Counter(w for w in re.sub("[^a-z]+", " ", text.lower()).split())


def lettering(cloud, result, program, *options):
    views = {"Front": "0,0,1", "Back": "0,0,-1", "Right": "1,0,0", "Left": "-1,0,0", "Bottom": "0,-1,0"}
    rows = read_ply(cloud)["vertex"]
    size = np.array([np.ptp(rows[k].astype(float)) for k in "xyz"])
    width, height, zoom = 2400, 1800, 1.75
    pixels = height * zoom / np.linalg.norm(size) * size.max()  # per longest side
    wanted, read = 0, [0, 0]
    with tempfile.TemporaryDirectory() as folder:
        for face, direction in views.items():
            sheet = os.path.join(folder, face + ".png")
            subprocess.run([program, "render", cloud, result, sheet, "-q", "--direction=" + direction, "--zoom", str(zoom),
                            "--up=" + ("0,0,1" if face == "Bottom" else "0,1,0"), "--width", str(width), "--height",
                            str(height)], check=True)
            image = Image.open(sheet)
            middle = 0.5 * np.array([size[2 if face in ("Left", "Right") else 0], size[2 if face == "Bottom" else 1]]) / size.max()
            for side, u, v, tall, text in lettering_lines():
                if side != face:
                    continue
                truth = words(text)
                wanted += truth.total()
                x, y = width / 2 + (u - middle[0]) * pixels, height / 2 - (v - middle[1]) * pixels
                half = tall * pixels * (0.5 + len(text) * (0.45 if text.isupper() else 0.36))
                seen = []
                for k in (0, 1):
                    box = (x - half, y - 1.15 * tall * pixels, x + half, y + 0.38 * tall * pixels)
                    seen.append(read_line(image.crop([round(b + width * k * (n % 2 == 0)) for n, b in enumerate(box)]), tall * pixels))
                    read[k] += (truth & words(seen[k])).total()
                if options:
                    print(f"{tall:.4f} {text!r}: points {seen[0].strip()!r}, mesh {seen[1].strip()!r}")
    print(f"{wanted} words: points {read[0]} ({100 * read[0] / wanted:.0f} %), mesh {read[1]} ({100 * read[1] / wanted:.0f} %)")


def round_trip(truth, cloud, result):
    true, made = load_mesh(truth), load_mesh(result)
    triangle, bary = sample_random(true, 60000, np.random.default_rng(3))
    where, wanted = at(true, triangle, bary), true.color_at(triangle, bary)
    got, _ = color_near(made, where)
    print({"pointbake": psnr(((wanted - got) ** 2).mean()), **limits(truth, cloud)})


def bound(report, points, result):
    p, mesh = read_ply(points)["vertex"], load_mesh(result)
    kept = np.stack([p["x"], p["y"], p["z"]], 1).astype(float)[p["kept"] == 1]
    middle = kept.mean(0)
    farthest = Scene(mesh.positions - middle, mesh.triangles).distance(kept - middle).max()
    print(f"{len(kept)} kept points, farthest / bound {farthest / json.load(open(report))['simplify']['bound']:.5f}")


def dense(truth, spacing, mesh):
    true, made = load_mesh(truth), o3d.io.read_triangle_mesh(mesh)
    corners = true.positions[true.triangles].reshape(-1, 3)
    middle, radius = (corners.min(0) + corners.max(0)) / 2, np.linalg.norm(np.ptp(corners, 0)) / 2
    scenes = Scene(true.positions, true.triangles), Scene(np.asarray(made.vertices), np.asarray(made.triangles))
    right = seen = 0
    for direction in fibonacci_sphere(24)[::2]:
        wanted, got = (s.cast(view_rays(direction, middle, radius, 400))[0] for s in scenes)
        hit = np.isfinite(wanted)
        seen += hit.sum()
        right += (np.abs(wanted[hit] - got[hit]) <= float(spacing)).sum()
    print(f"{100 * right / seen:.2f} %")


def flat(result):
    mesh = load_mesh(result)
    size = np.array([mesh.images[m].shape[1::-1] for m in mesh.material])
    width, height = np.round(np.ptp(mesh.uv * size[:, None], axis=1)).T
    texels = np.where(width + height == 0, 1, (width + 1) * (height + 1) / 2)
    _, weld = np.unique(np.round(mesh.positions / 1e-6).astype(np.int64), axis=0, return_inverse=True)
    by_edge = {}
    for t, corners in enumerate(weld.ravel()[mesh.triangles]):
        for k in range(3):
            by_edge.setdefault(frozenset((corners[k], corners[(k + 1) % 3])), []).append(texels[t])
    pairs = [sorted(e) for e in by_edge.values() if len(e) == 2 and min(e) <= 8 and max(e) >= 200]
    print(f"{len(pairs)} pairs")


def is_closed(points, triangles):
    """Each directed edge once, and its opposite: 2-manifold at edges, oriented."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    there, back = edges[:, 0] * len(points) + edges[:, 1], edges[:, 1] * len(points) + edges[:, 0]
    return len(np.unique(there)) == len(there) and np.array_equal(np.sort(there), np.sort(back))


def watertight(program, *clouds):
    for cloud in clouds:
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "mesh.ply")
            run = subprocess.run([program, cloud, out, "--surface", "watertight", "--stop-after", "simplify", "-q"], capture_output=True, text=True)
            if run.returncode:
                print(os.path.basename(cloud), "exit", run.returncode, run.stderr.strip(), flush=True)
                continue
            mesh = o3d.io.read_triangle_mesh(out)
        points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        a, b, c = (points[triangles[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        good = is_closed(points, triangles) and mesh.is_vertex_manifold() and mesh.is_edge_manifold(False) and volume > 0
        print(os.path.basename(cloud), "good" if good else "BAD", len(triangles), "triangles, volume %.4g" % volume, flush=True)


def plane_rms(points, normal, middle):
    return np.sqrt((((points - middle) @ normal) ** 2).mean())


def find_walls(cloud, diagonal):
    """Masks of the points on the three largest planes with no others within 1.5 % of the diagonal; centres, normals."""
    o3d.utility.random.seed(1)
    points = np.asarray(cloud.points)
    tree, left, walls = cKDTree(points), np.arange(len(points)), []
    while len(walls) < 3:
        _, found = cloud.select_by_index(left).segment_plane(0.004 * diagonal, 3, 3000)
        on_plane = np.zeros(len(points), bool)
        on_plane[left[found]] = True
        near = tree.query_ball_point(points[on_plane], 0.015 * diagonal)
        inner = np.zeros(len(points), bool)
        inner[np.nonzero(on_plane)[0][[on_plane[n].all() for n in near]]] = True
        middle = points[inner].mean(0)
        _, axes = np.linalg.eigh((points[inner] - middle).T @ (points[inner] - middle))
        walls.append((inner, axes[:, 0], middle))
        left = np.setdiff1d(left, left[found])
    return walls


def walls(path, program, *options):
    cloud = o3d.io.read_point_cloud(path)
    points = np.asarray(cloud.points)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "mesh.ply")
        subprocess.run([program, path, out, "--stop-after", "simplify", "-q", *options], check=True)
        mesh = o3d.io.read_triangle_mesh(out)
    places = np.asarray(mesh.sample_points_uniformly(400000).points)
    nearest = cKDTree(points).query(places)[1]
    for inner, normal, middle in find_walls(cloud, diagonal):
        of_points, of_mesh = (plane_rms(p, normal, middle) for p in (points[inner], places[inner[nearest]]))
        print("%d points, RMS %.2g of the diagonal; mesh %.2f of it" % (inner.sum(), of_points / diagonal, of_mesh / of_points))


def seams(result):
    print("seam_rms {:.2f}, border_rms {:.2f}".format(*seam_rms(load_mesh(result))))


if __name__ == "__main__":
    commands = {"round-trip": (round_trip, 3), "bound": (bound, 3), "dense": (dense, 3), "flat": (flat, 1), "seams": (seams, 1),
                "held-out": (held_out, 2), "views": (views, 3), "lettering": (lettering, 3),
                "watertight": (watertight, 2), "walls": (walls, 2)}
    given = len(sys.argv) - 2
    if given < 0 or sys.argv[1] not in commands or given < commands[sys.argv[1]][1]:
        sys.exit(__doc__)
    if given > commands[sys.argv[1]][1] + (sys.argv[1] in ("views", "lettering")) and sys.argv[1] not in ("held-out", "watertight", "walls"):
        sys.exit(__doc__)
    commands[sys.argv[1]][0](*sys.argv[2:])
