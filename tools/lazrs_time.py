#!/usr/bin/env python3
"""Time that lazrs takes on one thread for LAZ files, through laspy: what build/bench/bench/load_bench is held against.

usage: build/oracle/bin/python tools/lazrs_time.py FILE.laz...     (tools/setup.sh oracle makes that environment)
"""
import sys
import time

import laspy


def least_seconds(path, runs=9):
    least = float("inf")
    for _ in range(runs):
        start = time.process_time()
        laspy.read(path, laz_backend=laspy.LazBackend.Lazrs)
        least = min(least, time.process_time() - start)
    return least


for name in sys.argv[1:]:
    print(f"{name}: {1000 * least_seconds(name):.1f} ms")
