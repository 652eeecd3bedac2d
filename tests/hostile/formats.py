"""Small sound files of every kind, as bytes, with knobs to make them lie."""
import base64
import gzip
import json
import struct
import zlib

POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0)]
XYZ = "property float x\nproperty float y\nproperty float z\n"


def ply_header(form, elements):
    return f"ply\nformat {form} 1.0\n{elements}end_header\n".encode()


def ply_binary(points=POINTS, count=None, elements=None, tail=b"", order="<"):
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    count = len(points) if count is None else count
    elements = f"element vertex {count}\n{XYZ}" if elements is None else elements
    return ply_header(form, elements) + b"".join(struct.pack(order + "3f", *p) for p in points) + tail


def ply_ascii(rows, count=None, extra=""):
    count = len(rows) if count is None else count
    return ply_header("ascii", f"element vertex {count}\n{XYZ}{extra}") + "".join(r + "\n" for r in rows).encode()


def rows(points=POINTS):
    return [" ".join(repr(v) for v in p) for p in points]


def pcd(data="ascii", points=POINTS, count=None, fields="x y z", size="4 4 4", kind="F F F", counts="1 1 1", body=None):
    count = len(points) if count is None else count
    head = (f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {size}\nTYPE {kind}\nCOUNT {counts}\n"
            f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {data}\n").encode()
    if body is None:
        if data == "ascii":
            body = "".join(r + "\n" for r in rows(points)).encode()
        elif data == "binary":
            body = b"".join(struct.pack("<3f", *p) for p in points)
        else:
            raw = b"".join(struct.pack(f"<{len(points)}f", *axis) for axis in zip(*points))
            body = lzf(raw)
    return head + body


def lzf(raw):
    """Literals only: runs of up to 32 bytes."""
    packed = b"".join(bytes([len(raw[i:i + 32]) - 1]) + raw[i:i + 32] for i in range(0, len(raw), 32))
    return struct.pack("<II", len(packed), len(raw)) + packed


def ptx(columns=2, num_rows=2, points=POINTS):
    lines = [str(columns), str(num_rows), "0 0 0", "1 0 0", "0 1 0", "0 0 1",
             "1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"]
    return "".join(l + "\n" for l in lines + [f"{x + 1} {y} {z} 0.5" for x, y, z in points]).encode()


LAS_RECORD = 20


def las(points=POINTS, count=None, version=2, form=0, record=LAS_RECORD, scale=0.01, header_size=227, at=None,
        num_vlrs=0, vlrs=b"", body=None, offset=0.0):
    body = b"".join(struct.pack("<3i", *(round(v / 0.01) for v in p)) + bytes(8) for p in points) if body is None else body
    header = bytearray(header_size if header_size >= 227 else 227)
    header[0:4] = b"LASF"
    header[24:26] = bytes([1, version])
    struct.pack_into("<HII", header, 94, header_size, len(header) + len(vlrs) if at is None else at, num_vlrs)
    struct.pack_into("<BHI", header, 104, form, record, (len(points) if count is None else count) & 0xffffffff)
    struct.pack_into("<6d", header, 131, scale, scale, scale, offset, offset, offset)
    return bytes(header) + vlrs + body


def vlr(user, number, data, claimed=None):
    return struct.pack("<H16sHH32s", 0, user, number, len(data) if claimed is None else claimed, b"") + data


def laz_vlr(compressor=2, chunk=1, item=6, item_bytes=20, version=2):
    data = struct.pack("<HHBBHIIqqH", compressor, 0, 2, 2, 0, 0, chunk, -1, -1, 1)
    return vlr(b"laszip encoded", 22204, data + struct.pack("<HHH", item, item_bytes, version))


def laz(points=POINTS, table=-1, count=None, tail=b"", **knobs):
    """Chunks of one point, which stands there uncompressed, followed by the four bytes that the decoder begins with."""
    body = struct.pack("<q", table)
    for p in points:
        body += struct.pack("<3i", *(round(v / 0.01) for v in p)) + bytes(8) + bytes(4)
    return las(points, count, form=128, num_vlrs=1, vlrs=laz_vlr(**knobs), body=body + tail)


def crc32c(data):
    crc = 0xffffffff
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82f63b78 if crc & 1 else 0)
    return crc ^ 0xffffffff


PAGE = 1024
E57_FIELDS = "".join(f'<cartesian{axis} type="Float"/>' for axis in "XYZ")


def e57_place(at):
    return at // (PAGE - 4) * PAGE + at % (PAGE - 4)


def e57(points=POINTS, count=None, fields=E57_FIELDS, streams=None, xml=None, xml_at=None, xml_bytes=None, length=None,
        page=PAGE, section=1, section_bytes=None, data_at=None, packet_bytes=None, num_streams=None, offset=None, good_crc=True):
    if streams is None:
        streams = [struct.pack(f"<{len(points)}d", *(p[k] + 1 for p in points)) for k in range(3)]
    lengths = b"".join(struct.pack("<H", len(s)) for s in streams)
    packet = struct.pack("<BBHH", 1, 0, 0, len(streams) if num_streams is None else num_streams) + lengths + b"".join(streams)
    packet += bytes(-len(packet) % 4)
    packet = packet[:2] + struct.pack("<H", (len(packet) if packet_bytes is None else packet_bytes) - 1) + packet[4:]
    head = struct.pack("<BxxxxxxxQQQ", section, 32 + len(packet) if section_bytes is None else section_bytes,
                       e57_place(48 + 32) if data_at is None else data_at, 0)
    if xml is None:
        xml = ('<?xml version="1.0"?><e57Root type="Structure"><data3D type="Vector"><vectorChild type="Structure">'
               f'<points type="CompressedVector" fileOffset="{48 if offset is None else offset}" '
               f'recordCount="{len(points) if count is None else count}"><prototype type="Structure">{fields}</prototype>'
               '</points></vectorChild></data3D></e57Root>')
    xml = xml.encode()
    content = head + packet
    total = 48 + len(content) + len(xml)
    pages = -(-total // (PAGE - 4))
    top = struct.pack("<8sIIQQQQ", b"ASTM-E57", 1, 0, pages * PAGE if length is None else length,
                      e57_place(48 + len(content)) if xml_at is None else xml_at,
                      len(xml) if xml_bytes is None else xml_bytes, page)
    content = (top + content + xml).ljust(pages * (PAGE - 4), b"\0")
    out = b""
    for at in range(0, len(content), PAGE - 4):
        part = content[at:at + PAGE - 4]
        out += part + struct.pack(">I", crc32c(part) if good_crc else 0)
    return out


OBJ = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
OFF = b"OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"
STL = (b"solid t\n" + b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       + b"endsolid t\n")


def stl_binary(count=None, tail=b""):
    facets = [(POINTS[0], POINTS[1], POINTS[2]), (POINTS[0], POINTS[1], POINTS[3])]
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *a, *b, *c, 0) for a, b, c in facets)
    return bytes(80) + struct.pack("<I", len(facets) if count is None else count) + body + tail


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width=2, height=2, pixels=None, end=True):
    raw = b"".join(b"\0" + b"\x80" * (3 * 2) for _ in range(2)) if pixels is None else pixels
    out = b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return out + png_chunk(b"IDAT", zlib.compress(raw, 9)) + (png_chunk(b"IEND", b"") if end else b"")


PNG_BOMB = png(5000, 5000, bytes(15001 * 5000))
# 9 x 7 texels
JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABQODxIPDRQSEBIXFRQYHjIhHhwcHj0sLiQySUBMS0dARkVQWnNiUFVtVkVGZIhlbXd7gYKBTmCNl4x9"
    "lnN+gXz/2wBDARUXFx4aHjshITt8U0ZTfHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHz/wAARCAAHAAkD"
    "ASIAAhEBAxEB/8QAFQABAQAAAAAAAAAAAAAAAAAAAAL/xAAYEAEBAAMAAAAAAAAAAAAAAAAAEQEhMf/EABQBAQAAAAAAAAAAAAAAAAAAAAX/xAAU"
    "EQEAAAAAAAAAAAAAAAAAAAAA/9oADAMBAAIRAxEAPwCd3uIAPKP/2Q==")


def data_uri(data):
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def gltf(image=None, **changes):
    """A textured triangle fan; changes replace members, given as dotted paths with '__' between."""
    positions = b"".join(struct.pack("<3f", *p) for p in POINTS)
    indices = struct.pack("<12H", 0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3)
    uvs = struct.pack("<8f", 0, 0, 1, 0, 0, 1, 1, 1)
    root = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": data_uri(png() if image is None else image)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
                      {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24},
                        {"buffer": 0, "byteOffset": 72, "byteLength": 32}],
        "buffers": [{"byteLength": 104, "uri": data_uri(positions + indices + uvs)}],
    }
    for path, value in changes.items():
        place = root
        *steps, last = [int(s) if s.isdigit() else s for s in path.split("__")]
        for step in steps:
            place = place[step]
        place[last] = value
    return json.dumps(root).encode()


def glb(text=None, version=2, length=None, json_bytes=None, binary=b""):
    text = gltf() if text is None else text
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text) if json_bytes is None else json_bytes, b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", version, 12 + len(chunks) if length is None else length) + chunks


def splat(points=POINTS):
    return b"".join(struct.pack("<6f8B", *p, 0.2, 0.2, 0.01, 200, 100, 50, 250, 255, 128, 128, 128) for p in points)


def spz(points=POINTS, count=None, version=2, bits=12, pack=True):
    out = b"NGSP" + struct.pack("<II4B", version, len(points) if count is None else count, 0, bits, 0, 0)
    for p in points:
        out += b"".join(struct.pack("<i", round(v * 4096))[:3] for v in p)
    out += b"\xfa" * len(points) + b"\x80" * (3 * len(points)) + b"\x86\x86\x50" * len(points) + b"\x80" * (3 * len(points))
    return gzip.compress(out, mtime=0) if pack else out


def gzip_zeros(count):
    packer = zlib.compressobj(wbits=31)
    return b"".join(packer.compress(bytes(2**20)) for _ in range(count >> 20)) + packer.flush()


def zstd(blocks):
    """A frame of raw blocks (bytes) and repeated bytes (byte, count)."""
    out = b"\x28\xb5\x2f\xfd" + b"\x00\x58"
    for i, block in enumerate(blocks):
        is_last = int(i == len(blocks) - 1)
        size, kind, data = (len(block), 0, block) if isinstance(block, bytes) else (block[1], 1, block[0])
        out += struct.pack("<I", is_last | kind << 1 | size << 3)[:3] + data
    return out
