#!/bin/sh
# Two public cases of the quality bench, without its baseline: make quick-bench.
# Needs the bench beside the checkout (../shared/quality, or POINTBAKE_QUALITY) and what it needs itself.
set -eu
cd "$(dirname "$0")/.."
quality=${POINTBAKE_QUALITY:-../shared/quality}
if [ ! -f "$quality/run.py" ]; then
    echo "quick-bench: no quality bench at $quality (set POINTBAKE_QUALITY)" >&2
    exit 1
fi
mkdir -p build/quick-bench
python=/usr/bin/python3
"$python" - "$quality/cases.json" build/quick-bench/cases.json <<'PY'
import json, sys
cases = [c for c in json.load(open(sys.argv[1])) if c["name"] in ("spot", "bob")]
for case in cases:
    case["texels"] = case["texels"][-1:]
json.dump(cases, open(sys.argv[2], "w"))
PY
"$python" "$quality/run.py" build/quick-bench/cases.json --converter build/release/pointbake \
    --out build/quick-bench --no-baseline
