"""Conversions in which the system fails: run_faults.py PROGRAM SHIM [--kills N].

With --max-memory, too little of it. Every call that opens, writes, closes or renames an output fails in turn; the input cannot be read; the folder vanishes;
the program is killed. What was there before stays, or what is new is there whole; nothing temporary is left.
"""
import argparse
import errno
import gzip
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

OLD = b"the old one"
FAULTS = {"open": errno.EACCES, "write": errno.ENOSPC, "close": errno.EIO, "rename": errno.EROFS}
SETS = {"out.glb": ["out.glb"], "out.gltf": ["out.gltf", "out.bin", "out.png"], "out.obj": ["out.obj", "out.mtl", "out.png"],
        "out.ply": ["out.ply", "out.png"]}
MORE = ["--report", "report.json", "--write-points", "rows.ply", "--work-dir", "work", "--debug-maps", "maps"]


def cloud(num_points=120):
    lines = ["ply\nformat ascii 1.0", f"element vertex {num_points}", *(f"property float {axis}" for axis in "xyz"),
             *(f"property uchar {name}" for name in ("red", "green", "blue")), "end_header"]
    for i in range(num_points):
        z = 1 - (2 * i + 1) / num_points
        r, turn = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
        lines.append(f"{r * math.cos(turn):.6f} {0.8 * r * math.sin(turn):.6f} {0.6 * z:.6f} {2 * i % 256} 100 {255 - i % 256}")
    return "\n".join(lines).encode() + b"\n"


class Scene:
    """A folder with an input and what an earlier run left."""

    def __init__(self, top, number, old):
        self.folder = top / str(number) / "place"
        self.log = top / str(number) / "struck"
        self.folder.mkdir(parents=True)
        (self.folder / "in.ply").write_bytes(cloud())
        for name in old:
            (self.folder / name).write_bytes(OLD)

    def start(self, program, words, shim=None, fault=""):
        environment = dict(os.environ, FAULT=fault, FAULT_LOG=str(self.log), FAULT_FOLDER=str(self.folder))
        if shim:
            environment["LD_PRELOAD"] = shim
        return subprocess.Popen([program, "in.ply", *words, "-q"], cwd=self.folder, env=environment, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def run(self, *how):
        process = self.start(*how)
        err = process.communicate(timeout=60)[1]
        return process.returncode, err

    def files(self):
        return {str(p.relative_to(self.folder)): p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}


def without_times(report):
    return {key: value for key, value in json.loads(report).items() if key != "timings"}


def is_new(name, data, wanted):
    if name.endswith("report.json") and name in wanted:
        return without_times(data) == without_times(wanted[name])
    return data == wanted.get(name)


def judge(files, wanted, main_set):
    """What is wrong with the files that are there."""
    for name, data in files.items():
        if ".tmp" in name:
            yield f"{name} is left"
        elif name != "in.ply" and data != OLD and not is_new(name, data, wanted):
            yield f"{name} is neither the old nor the new one"
    states = {files.get(name) == wanted[name] for name in main_set}
    if len(states) > 1:
        yield "some files of the model are new, others are not"
    for name in main_set:
        if name not in files:
            yield f"{name} is gone"


class Faults:
    def __init__(self, arguments, top):
        self.program, self.shim = os.path.abspath(arguments.program), os.path.abspath(arguments.shim)
        self.top = top
        self.num_runs, self.num_scenes, self.problems = 0, 0, []

    def scene(self, old):
        self.num_scenes += 1
        return Scene(self.top, self.num_scenes, old)

    def reference(self, words):
        scene = self.scene([])
        code, err = scene.run(self.program, words)
        if code != 0:
            sys.exit(f"the undisturbed run failed: {err}")
        return scene.files()

    def report(self, what, problems):
        self.num_runs += 1
        self.problems += [f"{what}: {p}" for p in problems]

    def each_call(self, output, more):
        words = [output, *more]
        wanted = self.reference(words)
        for call, error in FAULTS.items():
            number = 0
            while True:
                number += 1
                scene = self.scene(SETS[output])
                code, err = scene.run(self.program, words, self.shim, f"{call} {number} {error}")
                if not scene.log.exists():
                    break
                found = list(judge(scene.files(), wanted, SETS[output]))
                if code != 4:
                    found.append(f"exit code {code}: {err}")
                if os.strerror(error) not in err or "pointbake: error: " not in err:
                    found.append(f"the message is: {err}")
                if not any(name in err for name in (*wanted, "work", "maps")):
                    found.append(f"the message names no file: {err}")
                self.report(f"{' '.join(words)}, {call} {number}", found)
            if number == 1:
                self.problems.append(f"{output}: no {call} was seen")

    def vanishing_folder(self):
        number = 0
        while True:
            number += 1
            scene = self.scene(["out.glb"])
            code, err = scene.run(self.program, [str(scene.folder / "out.glb")], self.shim, f"vanish {number} 0")
            if not scene.log.exists():
                break
            self.report(f"vanish {number}", [] if code == 4 and "out.glb" in err else [f"exit code {code}: {err}"])

    def lost_input(self):
        for fault in ("read", "map", "truncate"):
            scene = self.scene(["out.glb"])
            code, err = scene.run(self.program, ["out.glb"], self.shim, f"{fault} 1 {errno.EIO}")
            found = list(judge(scene.files(), {"out.glb": b""}, ["out.glb"]))
            if code != 3 or "in.ply: cannot be read" not in err:
                found.append(f"exit code {code}: {err}")
            self.report(fault, found)

    def little_memory(self):
        """Refused at once where the header tells; packed, nothing tells before it is too much."""
        header = b"ply\nformat binary_little_endian 1.0\nelement vertex 2000000\n" + b"".join(
            b"property float %c\n" % axis for axis in b"xyz") + b"end_header\n"
        body = random.Random(1).randbytes(24_000_000)
        for what, says, data, most in (("told by the header", "are expected to need", header + body, "2G"),
                                       ("packed", "more memory is needed", gzip.compress(header + body, 1), "20M")):
            scene = self.scene(["out.glb"])
            (scene.folder / "in.ply").write_bytes(data)
            code, err = scene.run(self.program, ["out.glb", "--max-memory", most])
            found = list(judge(scene.files(), {"out.glb": b""}, ["out.glb"]))
            if code != 5 or says not in err:
                found.append(f"exit code {code}: {err}")
            self.report(what, found)

    def kills(self, count):
        wanted = self.reference(["out.glb"])
        begin = time.monotonic()
        self.reference(["out.glb"])
        whole = time.monotonic() - begin
        random.seed(1)
        num_killed = 0
        for i in range(count):
            scene = self.scene(["out.glb"])
            process = scene.start(self.program, ["out.glb"])
            time.sleep(random.random() * whole)
            process.kill()
            process.communicate()
            num_killed += process.returncode < 0
            files = {name: data for name, data in scene.files().items() if not name.endswith(".tmp")}
            self.report(f"kill {i}", judge(files, wanted, ["out.glb"]))
        if num_killed < count // 2:
            self.problems.append(f"only {num_killed} of {count} runs were killed before their end")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("shim")
    parser.add_argument("--kills", type=int, default=30)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as top:
        faults = Faults(arguments, pathlib.Path(top))
        faults.lost_input()
        faults.little_memory()
        faults.vanishing_folder()
        faults.each_call("out.glb", MORE)
        for output in ("out.gltf", "out.obj", "out.ply"):
            faults.each_call(output, [])
        faults.kills(arguments.kills)
    for problem in faults.problems:
        print(problem)
    print(f"{faults.num_runs} runs, {len(faults.problems)} problems")
    sys.exit(len(faults.problems) > 0)


if __name__ == "__main__":
    main()
