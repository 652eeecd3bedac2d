#!/usr/bin/env python3
"""Holds what pointbake reads against independent readers: counts, places, extents and mean colours of every test file.

usage: readers_test.py PROGRAM DATA [--table]      DATA: the folder of colored_points, scans, gaussians and loaders;
                                                   --table prints what docs/formats.md shows

LAS and LAZ: laspy with lazrs. E57: pye57. PLY: plyfile. PCD: Open3D. Tables of text, PTX, OBJ and .splat have no reader on PyPI
that says what the file says; numpy reads them here. Exit code 77: a module or the data lacks.
"""
import json
import os
import subprocess
import sys
import tempfile

SKIPPED = 77
try:
    import laspy
    import lazrs  # noqa: F401  laspy finds it
    import numpy as np
    import open3d
    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    import pye57
    from plyfile import PlyData
except ImportError as missing:
    print(f"SKIPPED: {missing}; `make oracle-test` installs what the independent readers need")
    sys.exit(SKIPPED)

FOLDERS = ["colored_points", "scans", "gaussians", "loaders"]
LEAST_COLOR_STEP = 0.02  # of 8-bit steps, in means: what rounding leaves

# Files whose independent reader cannot be the judge, and why.
NO_JUDGE = {
    "loadersgl_pdrf10-1.5.laz": "LAZ items of version 4", "loadersgl_pdrf9-1.5.laz": "LAZ items of version 4",
    "loadersgl_pdrf7-v4-1.4.laz": "LAZ items of version 4",
    "pdal_garbage_nVariableLength.las": "laspy reads records without end",
}


class NotRead(Exception):
    pass


def eight_bit(colors):
    """Integers are 8-bit values if none exceeds 255, else 16 bit; floats up to 1 are shares."""
    colors = np.asarray(colors)
    if colors.dtype.kind == "f":
        return colors * 255.0 if len(colors) == 0 or np.nanmax(colors) <= 1.5 else colors.astype(float)
    return colors.astype(float) / (1 if colors.max(initial=0) <= 255 else 257)


def find(names, *choices):
    lower = {n.lower(): n for n in names}
    for choice in choices:
        if all(c in lower for c in choice):
            return [lower[c] for c in choice]
    return None


COLORS = [("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")]


def read_las(path):
    las = laspy.read(path)
    names = list(las.point_format.dimension_names)
    colors = None
    if "red" in names:
        colors = np.stack([las.red, las.green, las.blue], 1)
        colors = eight_bit(colors) if colors.any() else None
    return np.array(las.xyz), colors


def read_e57(path):
    file = pye57.E57(path)
    places, colors = [], []
    for k in range(file.scan_count):
        scan = file.read_scan(k, intensity=False, colors=True, ignore_missing_fields=True)
        places.append(np.stack([scan["cartesian" + a] for a in "XYZ"], 1))
        if "colorRed" in scan:
            colors.append(np.stack([scan["color" + c] for c in ("Red", "Green", "Blue")], 1))
    if not places:
        raise NotRead("no scans")
    whole = len(colors) == len(places) and all(len(c) == len(p) for c, p in zip(colors, places))
    return np.concatenate(places), eight_bit(np.concatenate(colors)) if whole else None


def unpacked_splats(vertex, chunk):
    """Places in SuperSplat's compressed PLY."""
    box = chunk[np.arange(len(vertex)) // 256]
    bits = vertex["packed_position"]
    share = [(bits >> 21) / 2047, (bits >> 11 & 1023) / 1023, (bits & 2047) / 2047]
    return np.stack([(1 - s) * box["min_" + a] + s * box["max_" + a] for a, s in zip("xyz", share)], 1)


def read_ply(path):
    ply = PlyData.read(path)
    vertex = ply["vertex"]
    if any(e.name == "chunk" for e in ply.elements):
        return unpacked_splats(vertex.data, ply["chunk"].data), None
    names = vertex.data.dtype.names
    xyz = find(names, ("x", "y", "z"))
    places = np.stack([vertex[n].astype(float) for n in xyz], 1)
    rgb = find(names, *COLORS)
    if rgb:
        return places, eight_bit(np.stack([vertex[n] for n in rgb], 1))
    if "f_dc_0" in names:
        harmonic = np.stack([vertex[f"f_dc_{k}"].astype(float) for k in range(3)], 1)
        return places, 255 * np.clip(0.5 + 0.28209479177387814 * harmonic, 0, 1)
    return places, None


def read_pcd(path):
    cloud = open3d.t.io.read_point_cloud(path)
    places = cloud.point.positions.numpy().astype(float)
    colors = eight_bit(cloud.point.colors.numpy()) if "colors" in cloud.point else None
    return places, colors


def read_splat(path):
    rows = np.fromfile(path, [("place", "<f4", 3), ("size", "<f4", 3), ("color", "u1", 4), ("turn", "u1", 4)])
    return rows["place"].astype(float), rows["color"][:, :3].astype(float)


def read_obj(path):
    with open(path, encoding="utf-8", errors="replace") as f:
        rows = [[float(w) for w in line.split()[1:]] for line in f if line.startswith("v ")]
    rows = np.array(rows)
    return rows[:, :3], eight_bit(rows[:, 3:6]) if rows.shape[1] >= 6 else None


def read_ptx(path):
    """Scans of a header of ten lines: columns, rows, scanner, its axes, and a matrix that moves row vectors."""
    places, colors = [], []
    with open(path) as f:
        lines = [line.split() for line in f if line.strip()]
    at = 0
    while at < len(lines):
        count = int(lines[at][0]) * int(lines[at + 1][0])
        matrix = np.array(lines[at + 6:at + 10], float)
        rows = np.array(lines[at + 10:at + 10 + count], float)
        moved = rows[:, :3] @ matrix[:3, :3] + matrix[3, :3]
        moved[~rows[:, :3].any(1)] = np.nan  # no return
        places.append(moved)
        colors.append(rows[:, 4:7] if rows.shape[1] >= 7 else None)
        at += 10 + count
    whole = all(c is not None for c in colors)
    return np.concatenate(places), np.concatenate(colors) if whole else None


def read_text(path):
    """Lines of at least three numbers; colours where the header names them, or three whole columns behind x y z [i]."""
    rows, names = [], []
    with open(path, encoding="utf-8", errors="replace") as f:
        for line in f:
            words = line.replace(",", " ").replace(";", " ").replace('"', " ").split()
            try:
                numbers = [float(w) for w in words]
            except ValueError:
                names = names or [w.lower().lstrip("/") for w in words]
                continue
            if len(numbers) >= 3:
                rows.append(numbers)
    if not rows or len({len(r) for r in rows}) != 1:
        raise NotRead("no table")
    rows = np.array(rows)
    columns = names if len(names) == rows.shape[1] else []
    xyz = find(columns, ("x", "y", "z"))
    places = rows[:, [columns.index(n) for n in xyz]] if xyz else rows[:, :3]
    rgb = find(columns, *COLORS)
    if rgb:
        return places, rows[:, [columns.index(n) for n in rgb]]
    # Seven columns: an intensity before the colours, or a constant alpha behind them.
    begin = 4 if rows.shape[1] == 7 and np.ptp(rows[:, 6]) > 0 else 3
    rest = rows[:, begin:begin + 3]
    is_color = rest.shape[1] == 3 and (rest == rest.round()).all() and rest.min() >= 0 and 1 < rest.max() <= 255
    return places, rest if is_color else None


READERS = {".las": (read_las, "laspy"), ".laz": (read_las, "laspy"), ".e57": (read_e57, "pye57"), ".ply": (read_ply, "plyfile"),
           ".pcd": (read_pcd, "Open3D"), ".splat": (read_splat, "numpy"), ".obj": (read_obj, "numpy"), ".ptx": (read_ptx, "numpy"),
           ".xyz": (read_text, "numpy"), ".pts": (read_text, "numpy"), ".pwn": (read_text, "numpy"), ".txt": (read_text, "numpy")}


def read_with_pointbake(program, path, folder):
    """The report and the points with their rows; or the message."""
    out, report = os.path.join(folder, "points.ply"), os.path.join(folder, "report.json")
    run = subprocess.run([program, path, "-o", out, "--stop-after", "load", "--report", report, "-q"], capture_output=True, text=True)
    if run.returncode:
        return None, (run.returncode, run.stderr.strip().replace("pointbake: error: ", "").replace(path + ": ", "").replace(os.path.dirname(path) + "/", ""))
    vertex = PlyData.read(out)["vertex"].data
    names = vertex.dtype.names
    places = np.stack([vertex[a].astype(float) for a in "xyz"], 1)
    colors = eight_bit(np.stack([vertex[c] for c in COLORS[0]], 1)) if "red" in names else None
    return json.load(open(report))["input"], (places, colors, vertex["row"].astype(np.int64))


def read_independently(path):
    extension = os.path.splitext(path)[1]
    if os.path.basename(path) in NO_JUDGE:
        return None, NO_JUDGE[os.path.basename(path)]
    if extension not in READERS:
        return None, "no independent reader"
    reader, name = READERS[extension]
    try:
        return reader(path), name
    except Exception:  # noqa: BLE001  whatever a foreign reader throws
        return None, f"{name} does not read it"


def num_added(report):
    for note in report["notes"]:
        if "added to the" in note:
            return int(note.split()[0])
    return 0


def compare(report, ours, theirs, is_ordered):
    """What differs; an empty list if nothing does that the report does not tell."""
    places, colors, rows = ours
    their_places, their_colors = theirs
    wrong, defects = [], report["defects"]
    finite = np.isfinite(their_places).all(1)
    in_file = rows < len(their_places)
    if is_ordered:
        if report["rows"] - num_added(report) != len(their_places):
            wrong.append(f"{report['rows']} rows, {len(their_places)} there")
            return wrong
        if len(places) + defects["merged"] + defects["non_finite"] + defects["left_out"] != report["rows"]:
            wrong.append("rows do not add up")
        kept = rows[in_file]
        mine, other = places[in_file], their_places[kept]
        tolerance = 1e-6 * np.abs(other).max(initial=1e-30)
        far = np.abs(mine - other).max(initial=0)
        if not far <= tolerance:
            wrong.append(f"a place is {far:.3g} off")
        away = np.setdiff1d(np.nonzero(finite)[0], kept)
        if len(away) > defects["merged"] + defects["left_out"]:
            wrong.append(f"{len(away)} rows are missing, {defects['merged']} merged and {defects['left_out']} left out")
        if colors is not None and their_colors is not None:
            # Rows that have their place for themselves: merged ones carry means.
            all_places = np.concatenate([other, their_places[away]])
            _, group, size = np.unique(all_places, axis=0, return_inverse=True, return_counts=True)
            alone = size[group.ravel()[:len(kept)]] == 1
            mean, wanted = colors[in_file][alone], their_colors[kept][alone]
            if len(mean) and not np.abs(mean.mean(0) - wanted.mean(0)).max() <= LEAST_COLOR_STEP:
                wrong.append(f"mean colour {mean.mean(0).round(2)}, {wanted.mean(0).round(2)} there")
    else:
        their = their_places[finite]
        unique = np.unique(their, axis=0)
        # pye57 keeps points at the scanner, which are no returns, and leaves out invalid ones.
        if not 0 <= len(unique) - len(places) <= defects["left_out"]:
            wrong.append(f"{len(places)} points, {len(unique)} there")
        far = max(np.abs(places.min(0) - their.min(0)).max(), np.abs(places.max(0) - their.max(0)).max())
        if not far <= 1e-6 * np.abs(their).max(initial=1e-30) and len(unique) == len(places):
            wrong.append(f"extents are {far:.3g} off")
        if colors is not None and their_colors is not None and len(unique) == len(their_places):
            if not np.abs(colors.mean(0) - their_colors[finite].mean(0)).max() <= LEAST_COLOR_STEP:
                wrong.append(f"mean colour {colors.mean(0).round(2)}, {their_colors.mean(0).round(2)} there")
    if their_colors is not None and colors is None and their_colors.any():
        wrong.append("no colours")
    return wrong


def row_of_table(name, report, ours, judge):
    places, colors, _ = ours
    defects = report["defects"]
    gone = ", ".join(f"{defects[k]} {k.replace('_', ' ')}" for k in ("non_finite", "left_out", "merged") if defects[k])
    extent = " x ".join(f"{e:.5g}" for e in np.ptp(places, axis=0))
    mean = "" if colors is None else " ".join(f"{c:.1f}" for c in colors.mean(0))
    return f"| {name} | {report['rows']} | {len(places)} | {gone} | {extent} | {mean} | {judge} |"


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    program, data = sys.argv[1:3]
    if not all(os.path.isdir(os.path.join(data, f)) for f in FOLDERS):
        print(f"SKIPPED: {data} has no {', '.join(FOLDERS)}")
        return SKIPPED
    failures, counts, table, refused = [], {"equal": 0, "unjudged": 0, "refused": 0}, [], []
    with tempfile.TemporaryDirectory() as scratch:
        for folder in FOLDERS:
            for name in sorted(os.listdir(os.path.join(data, folder))):
                path = os.path.join(data, folder, name)
                report, ours = read_with_pointbake(program, path, scratch)
                theirs, judge = read_independently(path)
                if report is None:
                    code, message = ours
                    counts["refused"] += 1
                    refused.append(f"| {name} | {message} | {'' if theirs is None else f'{len(theirs[0])} rows by ' }{judge} |")
                    if code not in (3, 5, 6) or not message:
                        failures.append(f"{name}: exit code {code}: {message}")
                    continue
                wrong = compare(report, ours, theirs, not name.endswith(".e57")) if theirs else []
                counts["equal" if theirs and not wrong else "unjudged"] += not wrong
                failures += [f"{name}: {w} ({judge})" for w in wrong]
                table.append(row_of_table(name, report, ours, judge if theirs else f"none: {judge}"))
    if len(sys.argv) == 4:
        print("| file | rows | points | not kept | extent | mean colour | equal to |\n|---|---|---|---|---|---|---|")
        print("\n".join(table))
        print("\n| refused | message | independent reader |\n|---|---|---|\n" + "\n".join(refused))
    for failure in failures:
        print("FAILED", failure)
    print(f"{counts['equal']} files are equal, {counts['unjudged']} have no independent reader, {counts['refused']} are refused, "
          f"{len(failures)} differences")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
