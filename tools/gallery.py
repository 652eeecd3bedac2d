#!/usr/bin/python3
"""Draws the pictures of docs/ that the program's own demo does not draw, and prints their figures.

usage: gallery.py clouds PROGRAM FOLDER      five real clouds: points, mesh, triangles -> docs/pictures/gallery-NAME.png
       gallery.py figure7 PROGRAM FOLDER     the demo model at four budgets, both projections -> docs/pictures/figure7.png
       gallery.py lettering PROGRAM FOLDER   points, baseline, pointbake -> docs/pictures/lettering.png, tablet.png

FOLDER gets the models and stays out of the repository. The clouds lie beside the checkout (../shared/data, or
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
BACKGROUND = (244, 245, 240)  # the program's own

# name, file, direction to the viewer, up, zoom
CLOUDS = [("guanyin", "guanyin", "0.15,0.1,1", "0,1,0", "1.35"),
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


def render(program, files, picture, direction, up, zoom, width=480, height=480, *options):
    run(program, "render", *files, picture, "-q", f"--direction={direction}", f"--up={up}", "--zoom", zoom,
        "--width", width, "--height", height, *options)
    return Image.open(picture).convert("RGB")


def save(picture, name):
    """256 colours are enough for a page, and keep the repository small."""
    path = os.path.join(PICTURES, name)
    picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
    print(f"{name}: {picture.width} x {picture.height}, {os.path.getsize(path) / 1000:.0f} kB")


def clouds(program, folder):
    for name, file, *look in CLOUDS:
        cloud, model = needed(DATA, "colored_points", file + ".ply"), os.path.join(folder, name + ".glb")
        report = os.path.join(folder, name + ".json")
        run(program, cloud, model, "-q", "--report", report)
        save(render(program, [cloud, model], os.path.join(folder, name + ".png"), *look, 480, 480, "--wires"),
             f"gallery-{name}.png")
        said = json.load(open(report))
        views = run(os.path.join(HERE, "measure.py"), "views", cloud, model, program).strip()
        print(f"| {name} | {said['input']['points']} | {said['simplify']['triangles']} | {said['atlas']['texels']} | "
              f"{said['write']['bytes'] / 1e6:.1f} MB | {views} |", flush=True)


def main():
    commands = {"clouds": clouds}
    if len(sys.argv) != 4 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    os.makedirs(sys.argv[3], exist_ok=True)
    commands[sys.argv[1]](sys.argv[2], sys.argv[3])


if __name__ == "__main__":
    main()
