#!/usr/bin/python3
"""Draws Gaussian splats as they are meant to be drawn, and holds a mesh made of them against that.

usage: splat_views.py SPLATS RESULT PROGRAM [FOLDER]    24 pictures of the mesh against the same of the splats; FOLDER keeps them

The splats are read and drawn here with numpy alone: every Gaussian of the file, projected [Zwicker01], blended from front to
back by its opacity [Kerbl23], along the same orthographic cameras as `pointbake render`. Read are PLY of the 2023 layout (degree 0
of the harmonics only), SuperSplat's compressed PLY and .splat. PSNR is taken where either covers a pixel, over the program's
background: what lacks and what sticks out counts.
"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

SIZE = 512
TILE = 16
BACKGROUND = np.array([244, 244, 241]) / 255  # the program's own
LOW_PASS = 0.3  # variance added in squared pixels, [Kerbl23]'s
MOST_ALPHA = 0.99
LEAST_ALPHA = 1 / 255
CUT = 3.3  # sigmas, where an opaque splat's alpha falls below the least
LEAST_LIGHT = 1e-4  # behind that nothing shows


def read_ply_elements(path):
    types = {"float": "<f4", "uint": "<u4", "uchar": "u1", "double": "<f8", "int": "<i4"}
    with open(path, "rb") as f:
        elements = []
        while (line := f.readline().decode("ascii").split()) != ["end_header"]:
            if line[0] == "element":
                elements.append((line[1], int(line[2]), []))
            elif line[0] == "property":
                elements[-1][2].append((line[2], types[line[1]]))
        return {name: np.frombuffer(f.read(n * np.dtype(t).itemsize), t) for name, n, t in elements}


def columns(rows, *names):
    return np.stack([rows[n].astype(float) for n in names], 1)


def unit(bits, shift, width):
    return (bits >> shift & (2 ** width - 1)) / (2 ** width - 1)


def unpack(rows, chunks):
    """SuperSplat: values between a chunk's least and most, 256 rows a chunk."""
    chunk = chunks[np.arange(len(rows)) // 256]
    between = lambda share, name, axes: (columns(chunk, *(f"min_{name}{a}" for a in axes)) * (1 - share) +
                                         columns(chunk, *(f"max_{name}{a}" for a in axes)) * share)
    three = lambda bits: np.stack([unit(bits, 21, 11), unit(bits, 11, 10), unit(bits, 0, 11)], 1)
    packed = rows["packed_rotation"]
    rest = (np.stack([unit(packed, s, 10) for s in (20, 10, 0)], 1) - 0.5) * np.sqrt(2)
    rotation = np.empty((len(rows), 4))
    largest = (packed >> 30).astype(int)
    others = np.array([[k for k in range(4) if k != m] for m in range(4)])[largest]
    np.put_along_axis(rotation, others, rest, 1)
    np.put_along_axis(rotation, largest[:, None], np.sqrt(np.maximum(0, 1 - (rest ** 2).sum(1)))[:, None], 1)
    color = np.stack([unit(rows["packed_color"], s, 8) for s in (24, 16, 8)], 1)
    if "min_r" in chunks.dtype.names:
        color = between(color, "", "rgb")
    return (between(three(rows["packed_position"]), "", "xyz"), np.exp(between(three(rows["packed_scale"]), "scale_", "xyz")),
            rotation, color, unit(rows["packed_color"], 0, 8))


def read_splats(path):
    """Positions, standard deviations, quaternions (w first), colours and opacities."""
    if path.endswith(".splat"):
        rows = np.fromfile(path, [("p", "<f4", 3), ("s", "<f4", 3), ("c", "u1", 4), ("q", "u1", 4)])
        return (rows["p"].astype(float), rows["s"].astype(float), rows["q"] / 128.0 - 1, rows["c"][:, :3] / 255, rows["c"][:, 3] / 255)
    ply = read_ply_elements(path)
    rows = ply["vertex"]
    if "chunk" in ply:
        return unpack(rows, ply["chunk"])
    return (columns(rows, "x", "y", "z"), np.exp(columns(rows, "scale_0", "scale_1", "scale_2")),
            columns(rows, "rot_0", "rot_1", "rot_2", "rot_3"), 0.5 + 0.28209479177387814 * columns(rows, "f_dc_0", "f_dc_1", "f_dc_2"),
            1 / (1 + np.exp(-rows["opacity"].astype(float))))


def rotations(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1).reshape(-1, 3, 3)


def blend_tile(x, y, splats):
    """Front to back over one tile's pixels: light that gets through so far times alpha."""
    place, inverse, color, opacity = splats
    through, out = np.ones(x.shape), np.zeros((x.size, 3))
    for k in range(0, len(place), 256):
        part = slice(k, k + 256)
        dx, dy = x - place[part, 0, None], y - place[part, 1, None]
        q = inverse[part, 0, None] * dx * dx + 2 * inverse[part, 1, None] * dx * dy + inverse[part, 2, None] * dy * dy
        alpha = np.minimum(MOST_ALPHA, opacity[part, None] * np.exp(-0.5 * q))
        alpha[alpha < LEAST_ALPHA] = 0
        left = through * np.cumprod(1 - alpha, 0)
        weight = np.concatenate([through[None], left[:-1]]) * alpha
        out += weight.T @ color[part]
        through = left[-1]
        if through.max() < LEAST_LIGHT:
            break
    return out, 1 - through


def draw(splats, direction, up, middle, pixels_per_unit):
    """Colours already times alpha, and alpha; SIZE x SIZE."""
    position, sigma, rotation, color, opacity = splats
    toward = direction / np.linalg.norm(direction)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    axes = np.stack([right, -np.cross(toward, right), toward]) * pixels_per_unit
    seen = (position - middle) @ axes.T
    place = seen[:, :2] + SIZE / 2
    spread = axes[:2] @ rotations(rotation) * sigma[:, None]
    cov = spread @ spread.transpose(0, 2, 1) + LOW_PASS * np.eye(2)
    det = cov[:, 0, 0] * cov[:, 1, 1] - cov[:, 0, 1] ** 2
    inverse = np.stack([cov[:, 1, 1], -cov[:, 0, 1], cov[:, 0, 0]], 1) / det[:, None]
    reach = CUT * np.sqrt(np.stack([cov[:, 0, 0], cov[:, 1, 1]], 1))
    first = np.clip((place - reach) // TILE, 0, SIZE // TILE).astype(int)
    last = np.clip((place + reach) // TILE + 1, 0, SIZE // TILE).astype(int)
    order = np.argsort(-seen[:, 2], kind="stable")
    picture, alpha = np.zeros((SIZE, SIZE, 3)), np.zeros((SIZE, SIZE))
    for row in range(SIZE // TILE):
        in_row = order[(first[order, 1] <= row) & (row < last[order, 1])]
        for column in range(SIZE // TILE):
            here = in_row[(first[in_row, 0] <= column) & (column < last[in_row, 0])]
            if len(here) == 0:
                continue
            y, x = np.mgrid[row * TILE:(row + 1) * TILE, column * TILE:(column + 1) * TILE] + 0.5
            out, a = blend_tile(x.ravel(), y.ravel(), (place[here], inverse[here], color[here], opacity[here]))
            tile = np.s_[row * TILE:(row + 1) * TILE, column * TILE:(column + 1) * TILE]
            picture[tile], alpha[tile] = out.reshape(TILE, TILE, 3), a.reshape(TILE, TILE)
    return np.clip(picture, 0, 1), alpha


def directions(count=24):
    """Spread over the sphere, as in the other views."""
    k = np.arange(count) + 0.5
    phi, y = np.pi * (1 + 5 ** 0.5) * k, 1 - 2 * k / count
    r = np.sqrt(1 - y * y)
    return np.stack([np.cos(phi) * r, y, np.sin(phi) * r], 1)


def up_of(direction):
    return np.array((0, 1, 0) if abs(direction[1]) < 0.9 else (1, 0, 0), float)


def camera_of(program, path):
    """Centre and scale of `pointbake render PATH`: the bounding sphere of the points it reads fills the picture."""
    box = json.loads(subprocess.run([program, "info", "--json", path], check=True, capture_output=True, text=True).stdout)["box"]
    low, high = np.array(box["low"]), np.array(box["high"])
    return (low + high) / 2, SIZE / np.linalg.norm(high - low)


def mesh_picture(program, path, result, direction, up):
    """Of the mesh as the splats' points are looked at: colours times alpha, and alpha."""
    axis = lambda v: ",".join(f"{x:.9g}" for x in v)
    with tempfile.TemporaryDirectory() as folder:
        sheet = os.path.join(folder, "sheet.png")
        subprocess.run([program, "render", path, result, sheet, "--transparent", "-q", "--direction=" + axis(direction),
                        "--up=" + axis(up), "--width", str(SIZE), "--height", str(SIZE)], check=True)
        rgba = np.asarray(Image.open(sheet), float)[:, SIZE:] / 255
    return rgba[..., :3] * rgba[..., 3:], rgba[..., 3]


def on_background(picture, alpha):
    return picture + (1 - alpha[..., None]) * BACKGROUND


def views(path, result, program, folder=None):
    splats = read_splats(path)
    middle, scale = camera_of(program, path)
    error, pixels, solid_error, solid_pixels, both, either = np.zeros(24), np.zeros(24), 0, 0, 0, 0
    for number, direction in enumerate(directions()):
        up = up_of(direction)
        wanted, cover = draw(splats, direction, up, middle, scale)
        got, mask = mesh_picture(program, path, result, direction, up)
        square = ((on_background(wanted, cover) - on_background(got, mask)) ** 2).mean(2)
        seen, solid = (cover > 0.5) | (mask > 0.5), (cover > 0.95) & (mask == 1)
        error[number], pixels[number] = square[seen].sum(), seen.sum()
        solid_error, solid_pixels = solid_error + square[solid].sum(), solid_pixels + solid.sum()
        both, either = both + np.minimum(cover, mask).sum(), either + np.maximum(cover, mask).sum()
        if folder:
            os.makedirs(folder, exist_ok=True)
            pair = np.concatenate([on_background(wanted, cover), on_background(got, mask)], 1)
            Image.fromarray((255 * pair + 0.5).astype(np.uint8)).save(os.path.join(folder, f"view{number:02d}.png"))
    psnr = lambda e: -10 * np.log10(e)
    worst = int(np.argmax(error / pixels))
    print(f"views {psnr(error.sum() / pixels.sum()):.2f} dB, worst {psnr(error[worst] / pixels[worst]):.2f} (view {worst}), "
          f"where both cover {psnr(solid_error / solid_pixels):.2f} dB, IoU {both / either:.3f}")


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    views(*sys.argv[1:])
