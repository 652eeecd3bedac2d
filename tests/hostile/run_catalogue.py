"""Every file of the catalogue through the program: run_catalogue.py PROGRAM [--any-memory] [--only PART].

For each the exit code, the number of points or what the message says, that it names the file, the time and the
peak memory. --any-memory is for sanitizers, which need memory of their own.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

MOST_SECONDS = 2.0
HANG_SECONDS = 60
MOST_BYTES, MOST_TIMES = 64 << 20, 4


def run(words):
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        process = subprocess.Popen(words, stdout=out, stderr=err)
        while True:
            done, status, usage = os.wait4(process.pid, os.WNOHANG)
            if done:
                break
            if time.monotonic() - begin > HANG_SECONDS:
                process.kill()
            time.sleep(0.001)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0), err.seek(0)
        # Other programs' turns on the processor are not this one's time.
        seconds = min(time.monotonic() - begin, usage.ru_utime + usage.ru_stime)
        return process.returncode, out.read().decode(), err.read().decode(errors="replace"), seconds, usage.ru_maxrss << 10


def problems(case, folder, program, any_memory):
    path = folder / case["name"]
    before = sorted(os.listdir(folder))
    output = folder / "out.ply"
    words = [program, "sample", path, output, "--points", "100"] if case["is_mesh"] else [program, "info", path]
    code, out, err, seconds, peak = run([str(w) for w in words])
    wanted = case["code"] or 0
    if code != wanted:
        yield f"exit code {code} instead of {wanted}"
    if wanted:
        if not any(name in err for name in (case["name"], *case["beside"])):
            yield "the message does not name the file"
        if not re.search(case["says"], err):
            yield f"the message does not say '{case['says']}'"
        if out or sorted(os.listdir(folder)) != before:
            yield "an output is there"
    elif not case["is_mesh"] and not re.search(rf"^points +{case['points']}$", out, re.M):
        yield f"not {case['points']} points"
    most = MOST_BYTES + MOST_TIMES * sum((folder / name).stat().st_size for name in before)
    if not any_memory and peak > most:
        yield f"{peak} bytes of memory, more than {most}"
    if not any_memory and seconds > MOST_SECONDS:
        yield f"{seconds:.1f} seconds"
    for word in ("runtime error", "Sanitizer", "a bug of pointbake"):
        if word in err:
            yield word
    output.unlink(missing_ok=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--any-memory", action="store_true")
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    num_bad = 0
    with tempfile.TemporaryDirectory() as top:
        # In a process of its own: a child's peak memory begins with what its parent has.
        make = pathlib.Path(__file__).with_name("catalogue.py")
        subprocess.run([sys.executable, make, top], check=True)
        cases = json.loads((pathlib.Path(top) / "cases.json").read_text())
        for case in cases:
            if arguments.only not in case["folder"]:
                continue
            found = list(problems(case, pathlib.Path(top) / case["folder"], arguments.program, arguments.any_memory))
            num_bad += bool(found)
            for problem in found:
                print(f"{case['folder']}/{case['name']}: {problem}")
    print(f"{len(cases)} files, {num_bad} with problems")
    sys.exit(num_bad > 0)


if __name__ == "__main__":
    main()
