#!/usr/bin/python3
"""Draws the pictures of docs/ that the program's own demo does not draw, and prints their figures.

usage: gallery.py clouds PROGRAM FOLDER      five real clouds: points, mesh, triangles -> docs/pictures/gallery-NAME.png
       gallery.py figure7 PROGRAM FOLDER     the demo model at four budgets, both projections -> docs/pictures/figure7.png
       gallery.py splats PROGRAM FOLDER      the demo model as Gaussian splats, and its mesh -> docs/pictures/splats.png
       gallery.py lettering PROGRAM FOLDER   points, baseline, pointbake -> docs/pictures/lettering.png, tablet.png

FOLDER gets the models, which are made once, and stays out of the repository. The clouds lie beside the checkout (../shared/data, or
POINTBAKE_DATA), as does the bench with the baseline (../shared/quality, or POINTBAKE_QUALITY).
"""
import json
import os
import subprocess
import sys

from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
PICTURES = os.path.join(HERE, "../docs/pictures")
DATA = os.environ.get("POINTBAKE_DATA", os.path.join(HERE, "../../shared/data"))
BENCH = os.environ.get("POINTBAKE_QUALITY", os.path.join(HERE, "../../shared/quality"))
TEXELS = 1 << 20  # at which the lettering is shown
BACKGROUND = (244, 244, 241)  # the program's own

# name, file, direction to the viewer, up, zoom
CLOUDS = [("guanyin", "guanyin", "0.15,0.1,1", "0,1,0", "1.25"),
          ("lion", "lion_takanawa", "1,-0.15,0.3", "0,0,1", "1.35"),
          ("pump", "pump", "0.3,-1,0.3", "0,0,1", "1.35"),
          ("pond", "pond_surfels", "0.8,1,0.4", "0,1,0", "1.5"),
          ("livingroom", "o3d_livingroom_002", "0.3,-0.6,-1", "0,-1,0", "1.35")]


def needed(*parts):
    path = os.path.join(*parts)
    if not os.path.exists(path):
        sys.exit(f"gallery.py: {path} is missing: set POINTBAKE_DATA and POINTBAKE_QUALITY")
    return path


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def make(path, *words):
    if not os.path.exists(path):
        run(*words)


def render(program, files, picture, direction, up, zoom, width=480, height=480, *options):
    run(program, "render", *files, picture, "-q", f"--direction={direction}", f"--up={up}", "--zoom", zoom,
        "--width", width, "--height", height, *options)
    return Image.open(picture).convert("RGB")


def save(picture, name, dither=Image.Dither.FLOYDSTEINBERG):
    """256 colours are enough for a page, and keep the repository small."""
    path = os.path.join(PICTURES, name)
    picture.quantize(palette=picture.quantize(256), dither=dither).save(path, optimize=True)
    print(f"{name}: {picture.width} x {picture.height}, {os.path.getsize(path) / 1000:.0f} kB")


def clouds(program, folder):
    for name, file, *look in CLOUDS:
        cloud, model = needed(DATA, "colored_points", file + ".ply"), os.path.join(folder, name + ".glb")
        report = os.path.join(folder, name + ".json")
        make(model, program, cloud, model, "-q", "--report", report)
        save(render(program, [cloud, model], os.path.join(folder, name + ".png"), *look, 480, 480, "--wires"),
             f"gallery-{name}.png")
        said = json.load(open(report))
        views = run(os.path.join(HERE, "measure.py"), "views", cloud, model, program).strip()
        print(f"| {name} | {said['input']['points']} | {said['simplify']['triangles']} | {said['atlas']['texels']} | "
              f"{said['write']['bytes'] / 1e6:.1f} MB | {views} |", flush=True)


def figure7(program, folder):
    cloud = os.path.join(folder, "demo-points.ply")
    make(cloud, program, "demo", os.path.join(folder, "demo.glb"), "-q")
    look, width, height = ("0.55,0.45,1", "0,1,0", "1.38"), 300, 250
    sheet = Image.new("RGB", (5 * width, 2 * height), BACKGROUND)
    sheet.paste(render(program, [cloud], os.path.join(folder, "points.png"), *look, width, height), (0, height // 2))
    for row, projection in enumerate(["interpolated", "orthographic"]):
        for column, triangles in enumerate([11340, 3420, 446, 30]):
            model = os.path.join(folder, f"demo-{triangles}-{projection}.glb")
            make(model, program, cloud, model, "-q", "--triangles", triangles, "--projection", projection)
            both = render(program, [cloud, model], model + ".png", *look, width, height)
            sheet.paste(both.crop((width, 0, 2 * width, height)), ((1 + column) * width, row * height))
    save(sheet, "figure7.png")


def add_normals(program, cloud, out):
    """For the baseline: the normals of pointbake's dense mesh, whose vertices are the points."""
    import numpy as np
    import open3d as o3d
    from scipy.spatial import cKDTree
    run(program, "reconstruct", cloud, out, "-q")
    points, mesh = o3d.io.read_point_cloud(cloud), o3d.io.read_triangle_mesh(out)
    mesh.compute_vertex_normals()
    _, nearest = cKDTree(np.asarray(mesh.vertices)).query(np.asarray(points.points))
    points.normals = o3d.utility.Vector3dVector(np.asarray(mesh.vertex_normals)[nearest])
    o3d.io.write_point_cloud(out, points)


def demo_splats(cloud, path):
    """A .splat (y down) with what trained models have: flat splats that overlap, some faint, off the surface by noise."""
    import numpy as np
    import open3d as o3d
    from scipy.spatial import cKDTree
    points = o3d.io.read_point_cloud(cloud)
    random, x, normals = np.random.default_rng(1), np.asarray(points.points), np.asarray(points.normals)
    spacing = cKDTree(x).query(x, 7)[0][:, 6:] / 1.3
    n = len(x)
    rows = np.zeros(n, [("x", "<f4", 3), ("sigmas", "<f4", 3), ("rgba", "u1", 4), ("wxyz", "u1", 4)])
    down = np.array([1.0, -1.0, -1.0])
    rows["x"] = (x + normals * spacing * random.normal(0, 0.2, (n, 1))) * down
    rows["sigmas"] = spacing * np.array([0.7, 0.6, 0.06]) * random.uniform(0.7, 1.4, (n, 1))
    rows["rgba"][:, :3] = np.round(255 * np.asarray(points.colors))
    rows["rgba"][:, 3] = 255 * random.uniform(0.3, 1.0, n)
    # The turn that takes z to the normal: about z x normal, by half ways.
    half = normals * down + np.array([0.0, 0.0, 1.0 + 1e-9])
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    wxyz = np.column_stack([half[:, 2], -half[:, 1], half[:, 0], np.zeros(n)])
    rows["wxyz"] = np.clip(np.round(128 * wxyz + 128), 0, 255)
    rows.tofile(path)


def splats(program, folder):
    cloud, with_normals = (os.path.join(folder, "demo" + end) for end in ("-points.ply", "-normals.ply"))
    file, model = os.path.join(folder, "demo.splat"), os.path.join(folder, "splats.glb")
    make(cloud, program, "demo", os.path.join(folder, "demo.glb"), "-q")
    if not os.path.exists(file):
        add_normals(program, cloud, with_normals)
        demo_splats(with_normals, file)
    make(model, program, file, model, "-q")
    save(render(program, [file, model], os.path.join(folder, "splats.png"), "0.55,0.45,1", "0,1,0", "1.38", 480, 400,
                "--wires"), "splats.png")
    print(run(os.path.join(HERE, "measure.py"), "views", file, model, program).strip())


def three_pictures(program, folder, cloud, with_normals, texels, name, size, zoom):
    """Points, baseline and pointbake, all at 2500 triangles and the same budget of texels."""
    budget = ["--triangles", 2500, "--texels", texels]
    base, ours = (os.path.join(folder, f"{name}-{texels}-{k}") for k in ("base.obj", "pointbake.glb"))
    make(base, "/usr/bin/python3", needed(BENCH, "baseline.py"), with_normals, base, *budget)
    make(ours, program, cloud, ours, "-q", *budget)
    sheet = render(program, [cloud, base, ours], os.path.join(folder, name + ".png"), "0,0,1", "0,1,0", zoom, *size)
    return [sheet.crop((k * size[0], 0, (k + 1) * size[0], size[1])) for k in range(3)]


def lettering(program, folder):
    cloud, with_normals = (os.path.join(folder, "letters" + end) for end in ("-points.ply", "-normals.ply"))
    make(cloud, program, "demo", os.path.join(folder, "letters.glb"), "-q", "--points", 1000000)
    if not os.path.exists(with_normals):
        add_normals(program, cloud, with_normals)
    pictures = three_pictures(program, folder, cloud, with_normals, TEXELS, "letters", (2400, 1800), "1.75")
    cut = [p.crop((530, 1180, 1870, 1640)).resize((960, 330), Image.Resampling.LANCZOS) for p in pictures]
    sheet = Image.new("RGB", (960, 1010), BACKGROUND)
    for row, picture in enumerate(cut):
        sheet.paste(picture, (0, 340 * row))
    save(sheet, "lettering.png", Image.Dither.NONE)

    tablet = os.path.join(folder, "tablet.ply")
    make(tablet, program, "sample", needed(DATA, "textured/clay_tablet.obj"), tablet, "-q", "--points", 500000)
    pictures = three_pictures(program, folder, tablet, tablet, 1 << 17, "tablet", (1600, 1600), "1.3")
    sheet = Image.new("RGB", (1460, 480), BACKGROUND)
    for column, picture in enumerate(pictures):
        sheet.paste(picture.crop((360, 60, 1000, 700)).resize((480, 480), Image.Resampling.LANCZOS), (490 * column, 0))
    save(sheet, "tablet.png")


def main():
    commands = {"clouds": clouds, "figure7": figure7, "splats": splats, "lettering": lettering}
    if len(sys.argv) != 4 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    os.makedirs(sys.argv[3], exist_ok=True)
    commands[sys.argv[1]](sys.argv[2], sys.argv[3])


if __name__ == "__main__":
    main()
