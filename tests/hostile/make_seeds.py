"""Writes what the fuzzers begin with: make_seeds.py FOLDER. One folder per target, small sound files in each."""
import gzip
import pathlib
import sys

import formats as f

SPLAT_PLY = ("element vertex 2\n" + f.XYZ +
             "".join(f"property float {n}\n" for n in ("f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                                       "rot_0", "rot_1", "rot_2", "rot_3")))
COLORED = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float nx\nproperty float ny\nproperty float nz\n"
FACES = f"element vertex 4\n{f.XYZ}element face 1\nproperty list uchar int vertex_indices\n"
CHUNKED = ("element chunk 1\n" + "".join(f"property float {e}_{n}\n" for n in ("x", "y", "z", "scale_x", "scale_y", "scale_z")
                                         for e in ("min", "max")) + "element vertex 1\n" +
           "".join(f"property uint packed_{n}\n" for n in ("position", "rotation", "scale", "color")))

SEEDS = {
    "ply": [f.ply_binary(), f.ply_binary(order=">"), f.ply_ascii(f.rows()), f.ply_binary(elements=FACES, tail=b"\3" + bytes(12)),
            f.ply_ascii([r + " 1 2 3 0 0 1" for r in f.rows()], extra=COLORED),
            f.ply_header("ascii", SPLAT_PLY) + b"0 0 0 1 1 1 3 -3 -3 -6 1 0 0 0\n1 1 1 1 1 1 3 -3 -3 -6 1 0 0 0\n",
            f.ply_header("binary_little_endian", CHUNKED) + bytes(64)],
    "ply_mesh": [f.ply_binary(elements=FACES, tail=b"\3" + bytes(4) + b"\1\0\0\0\2\0\0\0"),
                 f.ply_header("ascii", f"comment TextureFile t.png\n{FACES}property list uchar float texcoord\n") +
                 b"0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 6 0 0 1 0 0 1\n"],
    "pcd": [f.pcd(d) for d in ("ascii", "binary", "binary_compressed")] +
           [f.pcd("binary", fields="x y z rgb", size="4 4 4 4", kind="F F F U", counts="1 1 1 1", body=bytes(64))],
    "text": ["".join(r + "\n" for r in f.rows()).encode(), b"//X Y Z R G B\n1 2 3 255 0 0\n4 5 6 0 255 0\n",
             b"x;y;z;i\n1;2;3;0.5\n4;5;6;0.1\n", b'"x","y","z"\n1,2,3\n4,5,6\n', b"2\n1 2 3 -100 1 2 3\n4 5 6 -90 3 2 1\n"],
    "ptx": [f.ptx(), f.ptx() * 2],
    "las": [f.las(), f.las(num_vlrs=1, vlrs=f.vlr(b"LASF_Spec", 4, b"\0\0\3\0" + b"extra".ljust(188, b"\0")))],
    "laz": [f.laz()],
    "e57": [f.e57(), f.e57(fields=f.E57_FIELDS.replace('"Float"', '"ScaledInteger" minimum="0" maximum="255" scale="0.1"', 1),
                           streams=[bytes(range(4)), bytes(32), bytes(32)])],
    "obj": [f.OBJ, b"vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nusemtl m\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1/1/1 2/2/1 -1/-1/-1\n"],
    "off": [f.OFF, b"COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 1 0 0 1\n0 1 0 0.5 0 0 1\n3 0 1 2 0.1 0.2 0.3\n",
            b"NOFF 3 1 0 # c\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"],
    "stl": [f.STL, f.stl_binary()],
    "gltf": [f.gltf(), f.glb(), f.gltf(nodes=[{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1]}])],
    "splat": [f.splat()],
    "spz": [f.spz(pack=False), f.spz(version=3, pack=False) + bytes(8), f.spz(version=1, pack=False)],
    "gzip": [gzip.compress(f.ply_binary(), mtime=0), gzip.compress(b"a", mtime=0) + gzip.compress(b"b", mtime=0) + bytes(4)],
    "zstd": [f.zstd([b"raw", (b"r", 300)]), f.zstd([b"a"]) + f.zstd([b"b"])],
    "image": [f.png()],
    "options": [b"in.ply\nout.glb\n--triangles\n5000\n--geometry-error\n0.1%\n-v", b"--crop\n0,0,0,1,1,1\n--columns\nx,y,z,-,red\n-i\na.ply",
                b'{"geometry-error": "2mm", "threads": 3, "max-memory": "12G", "strict": true}', b"--surface=open\n--up\nz\n--max-memory\n500M"],
}


def main():
    for target, seeds in SEEDS.items():
        folder = pathlib.Path(sys.argv[1]) / target
        folder.mkdir(parents=True, exist_ok=True)
        for i, seed in enumerate(seeds):
            (folder / f"seed-{i}").write_bytes(seed)


if __name__ == "__main__":
    main()
