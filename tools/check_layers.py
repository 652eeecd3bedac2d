#!/usr/bin/env python3
"""Fails if an #include points the wrong way: core <- {io, write, stages} <- convert <- cli."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What each folder of src/ may include besides itself, core/ and the public headers.
ALLOWED = {
    "core": set(), "io": set(), "write": set(), "clean": set(), "attributes": set(), "reconstruct": set(),
    "simplify": set(), "texture": set(), "atlas": set(), "model": set(), "sample": {"model"},
    "render": set(), "report": set(),
}
# Public headers of stages that another folder's sources may use.
PUBLIC = {"sample": {"model"}, "report": {"convert", "load", "write", "clean", "attributes", "reconstruct",
                                          "simplify", "texture", "atlas", "report", "options"}}
STAGES = {"load", "clean", "attributes", "reconstruct", "simplify", "texture", "atlas", "write", "sample",
          "model", "render", "convert", "report"}
OWN = {"io": {"load"}, "texture": {"texture", "simplify"}}


def problems():
    for path in sorted((ROOT / "src").rglob("*.[hc]*")):
        folder = path.relative_to(ROOT / "src").parts[0]
        if folder not in ALLOWED:
            continue  # convert.cpp and bake.cpp see everything
        for line, text in enumerate(path.read_text().splitlines(), 1):
            found = re.match(r'\s*#include "([^"]+)"', text)
            if not found:
                continue
            target = found.group(1)
            first, stem = target.split("/")[0], pathlib.PurePath(target).stem
            here = f"{path.relative_to(ROOT)}:{line}"
            if first == "pointbake":
                allowed = {folder} | OWN.get(folder, set()) | PUBLIC.get(folder, set())
                if stem in STAGES and stem not in allowed:
                    yield f"{here}: {folder} must not know the stage '{stem}'"
            elif first not in {folder, "core"} | ALLOWED[folder]:
                yield f"{here}: {folder} must not include {target}"
    for path in sorted((ROOT / "cli").rglob("*.[hc]*")):
        for line, text in enumerate(path.read_text().splitlines(), 1):
            if re.match(r'\s*#include "(texture|simplify|atlas|clean|attributes|reconstruct|io|write)/', text):
                yield f"{path.relative_to(ROOT)}:{line}: the command line uses public headers only"


found = list(problems())
print("\n".join(found))
sys.exit(1 if found else 0)
