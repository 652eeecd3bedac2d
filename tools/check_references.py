#!/usr/bin/env python3
"""Fails if a [Key] cited in sources or docs is not in docs/references.bib."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
known = set(re.findall(r"^@\w+\{(\w+),", (ROOT / "docs/references.bib").read_text(), re.M))
missing = []
for folder in ("include", "src", "cli", "tests", "bench", "docs"):
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix not in {".h", ".cpp", ".md"} or "node_modules" in path.parts:
            continue
        for line, text in enumerate(path.read_text().splitlines(), 1):
            for group in re.findall(r"\[((?:[A-Z][A-Za-z]+\d\d(?:, )?)+)\]", text):
                missing += [f"{path.relative_to(ROOT)}:{line}: [{key}] is not in docs/references.bib"
                            for key in group.split(", ") if key not in known]
print("\n".join(missing))
sys.exit(1 if missing else 0)
