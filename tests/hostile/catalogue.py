"""Files that lie, are cut off, or are merely odd, and what shall come of each."""
import gzip
import json
import pathlib
import struct
import sys

import formats as f

BIG = 2**32


class Case:
    """points: how many `info` finds; or code and what the message says, beside the name of the file.
    is_mesh: read as a mesh by `sample`."""

    def __init__(self, name, data, points=None, code=None, says="", is_mesh=False, beside=None):
        self.name, self.data, self.points, self.code, self.says = name, data, points, code, says
        self.is_mesh, self.beside = is_mesh, beside or {}


def ok(name, data, points, **more):
    return Case(name, data, points=points, **more)


def bad(name, data, says, code=3, **more):
    return Case(name, data, code=code, says=says, **more)


def cuts(name, data, places, says, code=3, **more):
    return [bad(name.replace("@", str(at)), data[:at], says, code, **more) for at in places]


def ply():
    binary, text = f.ply_binary(), f.ply_ascii(f.rows())
    body = binary.index(b"end_header\n") + 11
    xyz = f.XYZ
    listed = f"element vertex 1\n{xyz}property list int float w\n"
    point = struct.pack("<3f", 1, 2, 3)
    faces = f"element vertex 4\n{xyz}element face 1\nproperty list uchar int vertex_indices\n"

    def with_list(count):
        return f.ply_header("binary_little_endian", listed) + point + struct.pack("<i", count)

    def with_faces(tail):
        return f.ply_binary(elements=faces, tail=tail)

    yield ok("sound.ply", binary, 4)
    yield bad("empty.ply", b"", "the file is empty")
    yield from cuts("cut_in_header_@.ply", binary, [3, 4, 10, 30, 60, body - 1], "the file ends inside the header|points, but bytes are there for only")
    yield from cuts("cut_in_body_@.ply", binary, [body, body + 1, body + 12, len(binary) - 1], "points, but bytes are there for only")
    yield from cuts("cut_text_@.ply", text, [len(text) - 12, len(text) - 28], "points, but bytes are there for only")
    yield bad("count_one_more.ply", f.ply_binary(count=5), "points, but bytes are there for only")
    yield ok("count_one_less.ply", f.ply_binary(count=3), 3)
    yield bad("count_2_32_more.ply", f.ply_binary(count=4 + BIG), "points, but bytes are there for only")
    yield bad("count_2_64.ply", f.ply_binary(count=2**64), "is no number of rows")
    yield bad("count_negative.ply", f.ply_binary(count=-1), "is no number of rows")
    yield bad("count_zero.ply", f.ply_binary([]), "the file holds", 6)
    yield bad("list_negative.ply", with_list(-1), "values in row")
    yield bad("list_huge.ply", with_list(2**31 - 1), "points, but bytes are there for only")
    yield bad("list_of_float_counts.ply", f.ply_header("ascii", f"element vertex 1\n{xyz}property list float int w\n"), "a list's count must be an integer type")
    yield ok("face_beyond_points.ply", with_faces(struct.pack("<B3i", 3, 0, 1, 2**31 - 1)), 4)
    yield ok("face_of_negative_points.ply", with_faces(struct.pack("<B3i", 3, -1, -2, -3)), 4)
    yield bad("face_list_huge.ply", with_faces(struct.pack("<B3i", 255, 0, 1, 2)), "faces, but bytes are there for only")
    yield bad("mesh_without_a_good_face.ply", with_faces(struct.pack("<B3i", 3, 0, 1, 99)), "faces dropped", 6, is_mesh=True)
    yield bad("nan_everywhere.ply", f.ply_ascii(["nan nan nan"] * 4), "points has finite coordinates", 6)
    yield ok("nan_in_one_row.ply", f.ply_ascii(f.rows() + ["1 nan 1"]), 4)
    yield ok("infinite_in_one_row.ply", f.ply_ascii(f.rows() + ["inf -inf 0"]), 4)
    yield bad("denormal.ply", f.ply_binary([(1e-45, 0, 0), (0, 1e-45, 0), (0, 0, 1e-40), (1e-45, 1e-45, 0)]), "the points span")
    yield bad("at_1e38.ply", f.ply_binary([(1e38, 0, 0), (0, 1e38, 0), (0, 0, 1e38), (-1e38, 0, 0)]), "lies at")
    yield bad("at_1e300.ply", f.ply_header("ascii", "element vertex 2\n" + xyz.replace("float", "double")) +
              b"1e300 0 0\n0 1e300 0\n", "lies at")
    yield bad("number_too_large_for_any_type.ply", f.ply_ascii(["1e999 0 0", "1e999 1 0"]), "points has finite coordinates", 6)
    yield ok("all_equal.ply", f.ply_binary([(1, 2, 3)] * 50), 1)
    yield ok("crlf.ply", text.replace(b"\n", b"\r\n"), 4)
    yield ok("cr.ply", text.replace(b"\n", b"\r"), 4)
    yield ok("bom.ply", b"\xef\xbb\xbf" + text, 4)
    yield bad("utf16.ply", b"\xff\xfe" + text.decode().encode("utf-16-le"), "is text in UTF-")
    yield bad("nul_in_header.ply", binary.replace(b"property float y", b"property float y\0"), "has no scalar property")
    yield bad("nul_in_text.ply", text.replace(b"1.0", b"1\0" + b"0"), "text that is no number in row")
    yield bad("element_twice.ply", f.ply_header("ascii", f"element vertex 1\n{xyz}element vertex 1\n{xyz}") +
              b"0 0 0\n1 1 1\n", "there are several elements")
    yield bad("property_twice.ply", f.ply_ascii(["0 0 0 5"], extra="property float x\n"), "has several properties")
    yield bad("comment_of_10_MB.ply", text.replace(b"element", b"comment " + b"c" * 10**7 + b"\nelement", 1), "in the first")
    yield bad("line_of_10_MB.ply", b"ply\nformat ascii 1.0\n" + b"x" * 10**7, "in the first")
    yield bad("no_line_ends.ply", b"ply" + b" " * 10**6, "the file ends inside the header")
    yield bad("name_of_10_MB.ply", f.ply_header("ascii", "element " + "v" * 10**7 + " 1\n"), "in the first")
    yield bad("many_elements.ply", f.ply_header("ascii", "".join(f"element e{i} 0\n" for i in range(200000))), "the header has no element")
    yield bad("elements_without_properties.ply", f.ply_header("ascii", "element vertex 1000000000000\n"), "has no scalar property")
    yield ok("rows_of_no_bytes.ply", f.ply_header("binary_little_endian",
             f"element nothing 1000000000000\nelement vertex 1\n{xyz}") + point, 1)
    yield bad("big_endian_lie.ply", f.ply_header("binary_big_endian", listed) + point + struct.pack("<i", 1) + point[:4], "points, but bytes are there for only")
    yield bad("no_position.ply", f.ply_header("ascii", "element vertex 1\nproperty float red\n") + b"1\n", "has no scalar property")
    yield bad("type_unknown.ply", f.ply_header("ascii", "element vertex 1\nproperty quad x\n"), "unknown type")
    yield ok("texture_outside.ply", f.ply_header("ascii", f"comment TextureFile ../../../../etc/passwd\nelement vertex 3\n{xyz}")
             + b"0 0 0\n1 0 0\n0 1 0\n", 3)
    splats = "element chunk 1\nproperty float min_x\nelement vertex 1\nproperty uint packed_position\n"
    yield bad("splats_without_bounds.ply", f.ply_header("binary_little_endian", splats) + bytes(8), "which compressed splats need")


def pcd():
    for data in ("ascii", "binary", "binary_compressed"):
        whole = f.pcd(data)
        body = whole.index(b"DATA " + data.encode()) + 6 + len(data)
        yield ok(f"sound_{data}.pcd", whole, 4)
        yield from cuts(f"cut_{data}_@.pcd", whole, [8, 50, body - 4, body, body + 4, body + 9], "compressed bytes are promised|line with ascii, binary or binary_compressed|is no line of a PCD header|wants ascii, binary or binary_compressed, not|points, but bytes are there for only")
        yield bad(f"count_2_32_{data}.pcd", f.pcd(data, count=4 + BIG), "points, but bytes are there for only")
    yield bad("count_one_more.pcd", f.pcd("binary", count=5), "points, but bytes are there for only")
    yield ok("width_times_height_overflows.pcd", f.pcd().replace(b"WIDTH 4\nHEIGHT 1", b"WIDTH 4294967296\nHEIGHT 4294967296"), 4)
    yield bad("size_zero.pcd", f.pcd(size="0 4 4"), "has the type F and the size")
    yield bad("size_three.pcd", f.pcd(size="3 4 4"), "has the type F and the size")
    yield bad("count_zero_of_a_field.pcd", f.pcd(counts="0 1 1"), "the header has no field")
    yield bad("count_huge_of_a_field.pcd", f.pcd("binary", fields="x y z h", size="4 4 4 4", kind="F F F F",
                                                 counts="1 1 1 4611686018427387904"), "values per point")
    yield bad("count_negative.pcd", f.pcd(count=-4), "wants whole numbers, not")
    yield bad("fields_and_sizes_differ.pcd", f.pcd(size="4 4"), "the header has")
    yield bad("field_twice.pcd", f.pcd(fields="x x z"), "the header has no field")
    yield bad("packed_size_lies.pcd", f.pcd("binary_compressed", body=struct.pack("<II", 2**32 - 1, 48) + bytes(20)), "compressed bytes are promised, but only")
    yield bad("unpacked_size_lies.pcd", f.pcd("binary_compressed", body=struct.pack("<II", 20, 2**32 - 1) + bytes(20)), "bytes cannot unpack to")
    yield bad("packed_bomb.pcd", f.pcd("binary_compressed", count=2**28,
                                       body=struct.pack("<II", 300, 3 * 2**30) + b"\x00\x00" + b"\xe0\xff\x00" * 99), "compressed bytes are promised, but only")
    yield bad("repeats_before_the_start.pcd", f.pcd("binary_compressed", body=struct.pack("<II", 3, 48) + b"\x20\xff\x00"), "the compressed data behind byte")
    yield ok("words_for_numbers.pcd", f.pcd().replace(b"0.0 2.0 0.0", b"a b c"), 3)
    yield bad("line_of_10_MB.pcd", b"# .PCD v0.7\nVERSION 0.7\nFIELDS " + b"x" * 10**7, "line with ascii, binary or binary_compressed")
    yield ok("crlf.pcd", f.pcd().replace(b"\n", b"\r\n"), 4)


def text():
    plain = "".join(r + "\n" for r in f.rows()).encode()
    yield ok("sound.xyz", plain, 4)
    yield bad("empty.xyz", b"", "the file is empty")
    yield bad("blank.xyz", b"\n\n   \n", "the first lines are no table")
    yield bad("nul.xyz", b"1 2 3\n1 \0 3\n" * 5, "is zero, which text has not")
    yield ok("crlf.xyz", plain.replace(b"\n", b"\r\n"), 4)
    yield ok("bom.xyz", b"\xef\xbb\xbf" + plain, 4)
    yield bad("utf16.xyz", plain.decode().encode("utf-16"), "is text in UTF-")
    yield bad("decimal_commas.xyz", b"1,5 2,5 3,5\n" * 4, "numbers with decimal commas")
    yield ok("cut_in_a_row.xyz", plain[:-4], 3)
    yield ok("one_bad_row.xyz", plain + b"1 two 3\n", 4)
    yield bad("mostly_bad_rows.xyz", plain + b"1 two 3\n" * 40, "the first lines are no table")
    yield bad("nan.xyz", b"nan nan nan\n" * 9, "points has finite coordinates", 6)
    yield bad("at_1e308.xyz", b"1e308 0 0\n0 1e308 0\n0 0 -1e308\n", "lies at")
    yield bad("line_of_10_MB.xyz", b"1 " * 5 * 10**6, "the first lines are no table")
    yield bad("digits_10_MB.xyz", b"1" * 10**7 + b" 2 3\n", "the first lines are no table")
    yield bad("binary.xyz", bytes(range(256)) * 40, "is zero, which text has not")
    yield ok("columns_that_change.csv", b"x,y,z\n1,2,3\n2,3,4\n4,5,6\n" + b"1,2,3,4\n" * 2, 3)
    yield ok("count_lies.pts", b"4294967300\n" + plain, 4)
    yield ok("count_negative.pts", b"-4\n" + plain, 4)
    yield ok("columns_by_the_thousand.xyz", (b"1 " * 5000 + b"\n") * 9, 1)


def ptx():
    whole = f.ptx()
    lines = whole.split(b"\n")
    yield ok("sound.ptx", whole, 4)
    yield bad("empty.ptx", b"", "the file is empty")
    for n in (1, 2, 5, 9, 10, 12, 13):
        yield bad(f"cut_after_line_{n}.ptx", b"\n".join(lines[:n]) + b"\n", "no header of a scan|points, but lines are there for only")
    yield bad("count_one_more.ptx", f.ptx(5, 1), "points, but lines are there for only")
    yield bad("count_one_less.ptx", f.ptx(3, 1), "no header of a scan")
    yield bad("count_2_32.ptx", f.ptx(2 + BIG, 2), "points, but lines are there for only")
    yield bad("counts_overflow.ptx", f.ptx(BIG, BIG), "no header of a scan")
    yield bad("count_negative.ptx", f.ptx(-2, 2), "no header of a scan")
    yield bad("matrix_of_nan.ptx", whole.replace(b"0 1 0 0", b"nan nan nan nan"), "no header of a scan")
    yield bad("second_scan_cut.ptx", whole + b"\n".join(lines[:6]), "no header of a scan")
    yield bad("no_returns.ptx", b"\n".join(lines[:10]) + b"\n" + b"0 0 0 0.5\n" * 4, "none of the 4 rows is a point", 6)


def las():
    whole = f.las()
    yield ok("sound.las", whole, 4)
    yield from cuts("cut_@.las", whole, [4, 24, 100, 226, 227, 228, 247, len(whole) - 1], "the header is cut off at byte|points, but bytes are there for only")
    yield bad("count_one_more.las", f.las(count=5), "points, but bytes are there for only")
    yield ok("count_one_less.las", f.las(count=3), 3)
    yield bad("count_2_32_less_1.las", f.las(count=BIG - 1), "points, but bytes are there for only")
    yield bad("points_begin_beyond_the_end.las", f.las(at=2**31), "the points are said to begin at byte")
    yield bad("points_begin_in_the_header.las", f.las(at=4), "the points are said to begin at byte")
    yield bad("record_of_no_bytes.las", f.las(record=0), "records of")
    yield bad("record_too_short.las", f.las(record=19), "records of")
    yield bad("format_unknown.las", f.las(form=63), "point format")
    yield bad("version_9.las", f.las(version=9), "LAS of version")
    yield ok("records_by_the_billion.las", f.las(num_vlrs=2**32 - 1), 4)
    yield ok("record_longer_than_the_file.las", f.las(num_vlrs=1, vlrs=f.vlr(b"LASF_Spec", 4, b"", 65535)), 4)
    yield bad("header_of_no_size.las", f.las(header_size=0, at=227), "a header of")
    yield bad("scale_of_nan.las", f.las(scale=float("nan")), "coordinates are scaled by nan and moved by")
    yield bad("scale_of_1e300.las", f.las(scale=1e300), "lies at")
    yield bad("scale_of_zero.las", f.las(scale=0.0), "coordinates are scaled by")
    yield bad("offset_infinite.las", f.las(offset=float("inf")), "coordinates are scaled by")
    yield ok("extra_bytes_of_an_unknown_type.las",
             f.las(num_vlrs=1, vlrs=f.vlr(b"LASF_Spec", 4, b"\0\0\xff\0" + bytes(188))), 4)


def laz():
    whole = f.laz()
    begin = 227 + 54 + 40
    yield ok("sound.laz", whole, 4)
    yield from cuts("cut_@.laz", whole, [227, 260, begin, begin + 7, begin + 8, begin + 20, begin + 32], "the points are said to begin at byte|bytes that hold them do not unpack to as many")
    yield bad("count_one_more.laz", f.laz(count=5), "bytes that hold them do not unpack to as many")
    yield bad("count_2_31.laz", f.laz(count=2**31), "bytes, but the file has", 5)
    yield bad("count_a_million.laz", f.laz(count=10**6), "bytes, but the file has", 5)
    table = begin + 8 + 24 * 4
    yield ok("table_in_the_points.laz", f.laz(table=begin + 8), 4)
    yield ok("table_is_its_own_place.laz", f.laz(table=begin), 4)
    yield ok("table_beyond_the_end.laz", f.laz(table=2**40), 4)
    yield ok("table_of_a_billion_chunks.laz", f.laz(table=table, tail=struct.pack("<II", 0, 2**30) + bytes(16)), 4)
    yield bad("table_of_chunks_of_no_bytes.laz", f.laz(table=table, tail=struct.pack("<II", 0, 4) + bytes(16)), "bytes that hold them do not unpack to as many")
    yield ok("table_cut.laz", f.laz(table=table, tail=struct.pack("<II", 0, 4)), 4)
    yield bad("chunks_of_no_points.laz", f.laz(chunk=0), "chunks of")
    yield bad("chunks_of_2_32_points.laz", f.laz(f.POINTS[:1], count=99, chunk=2**32 - 2), "bytes that hold them do not unpack to as many")
    yield bad("compressor_unknown.laz", f.laz(compressor=9), "LAZ compressor")
    yield bad("item_unknown.laz", f.laz(item=99), "of version")
    yield bad("item_of_no_bytes.laz", f.laz(item_bytes=0), "LAZ item")
    yield bad("without_its_record.laz", f.las(form=128), "the points are compressed, but there is no record")


def e57():
    whole = f.e57()
    yield ok("sound.e57", whole, 4)
    yield from cuts("cut_@.e57", whole, [8, 47, 48, 600, 1023], "the header is cut off at byte|bytes, but the file ends at byte")
    yield bad("checksum_wrong.e57", f.e57(good_crc=False), "does not match its checksum")
    yield bad("count_one_more.e57", f.e57(count=5), "points is promised, but bytes are there for only")
    yield bad("count_2_32.e57", f.e57(count=BIG), "points", 5)
    yield bad("count_2_64.e57", f.e57(count=2**64), "recordCount is")
    yield bad("count_negative.e57", f.e57(count=-1), "recordCount is")
    yield bad("length_lies.e57", f.e57(length=2**40), "bytes, but the file ends at byte")
    yield bad("pages_of_no_bytes.e57", f.e57(page=0), "pages of")
    yield bad("pages_of_a_terabyte.e57", f.e57(page=2**40), "pages of")
    yield bad("xml_beyond_the_end.e57", f.e57(xml_at=2**40), "the XML is said to be at byte")
    yield bad("xml_of_2_63_bytes.e57", f.e57(xml_bytes=2**63), "the XML is said to be at byte")
    yield bad("xml_of_no_bytes.e57", f.e57(xml_bytes=0), "the XML is said to be at byte")
    yield bad("xml_cut.e57", f.e57(xml_bytes=100), "the XML is damaged at its byte")
    yield bad("points_beyond_the_end.e57", f.e57(offset=2**40), "the file ends")
    yield bad("points_in_themselves.e57", f.e57(offset=0), "another kind of section")
    yield bad("section_of_another_kind.e57", f.e57(section=7), "another kind of section")
    yield bad("section_of_2_63_bytes.e57", f.e57(section_bytes=2**63), "its length is impossible")
    yield bad("data_before_their_section.e57", f.e57(data_at=0), "its data lie elsewhere")
    yield bad("packet_beyond_its_section.e57", f.e57(packet_bytes=60000), "a packet of kind")
    yield bad("packet_of_many_streams.e57", f.e57(num_streams=65535), "bytes does not hold the")
    yield bad("range_upside_down.e57", f.e57(fields=f.E57_FIELDS.replace(
        '"Float"', '"Integer" minimum="9" maximum="-9"', 1)), "scan")
    yield bad("points_of_no_bits.e57", f.e57(fields=f.E57_FIELDS.replace(
        '"Float"', '"Integer" minimum="7" maximum="7"'), count=2**40), "points", 5)
    yield bad("a_million_points_of_no_bits.e57", f.e57(fields=f.E57_FIELDS.replace(
        '"Float"', '"Integer" minimum="7" maximum="7"'), count=10**6), "a scan of 1000000 points is promised, but bytes are there for only")
    yield bad("xml_with_entities.e57", f.e57(xml='<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "' + "c" * 500 +
              '"><!ENTITY d "&b;&b;&b;&b;">]><e57Root>&d;</e57Root>'), "the file holds", 6)
    yield bad("xml_nested.e57", f.e57(xml="<e57Root>" + "<a>" * 20000), "the XML is damaged at its byte")


def obj():
    yield ok("sound.obj", f.OBJ, 4)
    yield ok("sound_mesh.obj", f.OBJ, None, is_mesh=True)
    yield bad("empty.obj", b"", "the file is empty")
    for face in ("1 2 99", "0 1 2", "-9 1 2", "1 2 18446744073709551617", "1 x 3", "1/2/3/4 2 3"):
        yield bad(f"face_{face.replace(' ', '_').replace('/', 's')}.obj", f.OBJ + f"f {face}\n".encode(), "names no vertex|names no texture coordinate")
    yield bad("vertex_of_words.obj", b"v 0 0 zero\n", "a vertex needs three numbers")
    yield bad("vertex_cut.obj", b"v 0 0 0\nv 1 0", "a vertex needs three numbers")
    yield bad("vertex_of_nan.obj", f.OBJ + b"v nan nan nan\n", "the coordinates of vertex")
    yield ok("crlf.obj", f.OBJ.replace(b"\n", b"\r\n"), 4)
    yield bad("nul.obj", f.OBJ.replace(b"v 1 0 0", b"v 1\0 0 0"), "a vertex needs three numbers")
    yield ok("line_of_10_MB.obj", f.OBJ + b"# " + b"x" * 10**7 + b"\n", 4)
    yield bad("line_of_10_MB_first.obj", b"# " + b"x" * 10**7 + b"\n" + f.OBJ, "words among the first three of")
    yield ok("face_of_100_000_corners.obj", f.OBJ + b"f" + b" 1 2 3" * 33333 + b"\n", 4)
    yield ok("line_continued_forever.obj", f.OBJ + b"# \\\n" * 100000, 4)
    yield ok("material_outside.obj", b"mtllib ../../../../etc/passwd\n" + f.OBJ, None, is_mesh=True)
    yield ok("material_is_itself.obj", b"mtllib material_is_itself.obj\n" + f.OBJ, None, is_mesh=True)
    textured = b"mtllib m.mtl\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n"
    material = {"m.mtl": b"newmtl m\nmap_Kd t.png\n"}

    def with_texture(name, image, says, code=3):
        return bad(name, textured, says, code, is_mesh=True, beside={**material, "t.png": image})

    yield ok("texture_sound.obj", textured, None, is_mesh=True, beside={**material, "t.png": f.png()})
    yield with_texture("texture_empty.obj", b"", "neither PNG nor JPEG nor WebP, which are the images that are read")
    yield with_texture("texture_cut.obj", f.png()[:50], "damaged PNG")
    yield with_texture("texture_without_pixels.obj", f.png(pixels=b""), "damaged PNG")
    yield with_texture("texture_of_2_31_columns.obj", f.png(2**31 - 1, 1), "damaged PNG")
    yield with_texture("texture_too_large.obj", f.png(40000, 40000), "texels", 5)
    yield with_texture("texture_of_no_size.obj", f.png(0, 0), "damaged PNG")
    yield with_texture("texture_bomb.obj", f.PNG_BOMB, "texels from", 5)
    yield with_texture("texture_jpeg_bomb.obj", f.JPEG[:163] + struct.pack(">HH", 16000, 16000) + f.JPEG[167:], "texels from", 5)
    yield with_texture("texture_of_another_kind.obj", b"GIF89a" + bytes(50), "neither PNG nor JPEG nor WebP, which are the images that are read")
    yield with_texture("texture_jpeg_cut.obj", b"\xff\xd8\xff\xe0\x00\x10JFIF\0\1\1\0\0\1\0\1\0\0", "damaged JPEG")


def off():
    yield ok("sound.off", f.OFF, 4)
    yield bad("empty.off", b"", "the file is empty")
    yield bad("only_its_name.off", b"OFF", "the numbers of vertices and faces are wanted behind the keyword")
    yield bad("count_2_32.off", f.OFF.replace(b"4 4 6", b"4294967300 4 6"), "vertices, but lines are there for only")
    yield bad("count_one_more.off", f.OFF.replace(b"4 4 6", b"5 4 6"), "faces, but lines are there for only")
    yield bad("faces_2_32.off", f.OFF.replace(b"4 4 6", b"4 4294967300 6"), "faces, but lines are there for only")
    yield bad("count_negative.off", f.OFF.replace(b"4 4 6", b"-4 4 6"), "the numbers of vertices and faces are wanted behind the keyword")
    yield ok("face_of_2_31_corners.off", f.OFF.replace(b"3 0 1 2", b"2147483647 0 1 2"), 4)
    yield ok("face_negative.off", f.OFF.replace(b"3 0 1 2", b"-3 0 1 2"), 4)
    yield ok("face_beyond_points.off", f.OFF.replace(b"3 0 1 2", b"3 0 1 4000000000"), 4)
    yield bad("binary.off", b"OFF BINARY\n" + bytes(60), "binary OFF is not read")
    yield from cuts("cut_@.off", f.OFF, [6, 12, 20, 45], "the numbers of vertices and faces are wanted behind the keyword|vertices, but lines are there for only|faces, but lines are there for only")
    yield ok("line_of_10_MB.off", f.OFF.replace(b"\n", b"\n#" + b"x" * 10**7 + b"\n", 1), 4)


def stl():
    binary = f.stl_binary()
    yield ok("sound.stl", binary, 4)
    yield ok("sound_text.stl", f.STL, 3)
    yield bad("empty.stl", b"", "the file is empty")
    yield from cuts("cut_@.stl", binary, [50, 84, 100, 134, len(binary) - 1], "bytes are no STL file|triangles, but bytes are there for only")
    yield from cuts("cut_text_@.stl", f.STL, [9, 70], "bytes are no STL file|wants three numbers")
    yield bad("count_one_more.stl", f.stl_binary(3), "triangles, but bytes are there for only")
    yield bad("count_2_32_less_1.stl", f.stl_binary(2**32 - 1), "triangles, but bytes are there for only")
    yield bad("count_zero.stl", f.stl_binary(0)[:84], "the file holds no triangles", 6)
    yield bad("words_for_numbers.stl", f.STL.replace(b"vertex 1 0 0", b"vertex one 0 0"), "wants three numbers")
    yield bad("nan.stl", f.STL.replace(b"vertex 1 0 0", b"vertex nan 0 0"), "the file holds no triangles", 6)
    yield ok("solid_but_binary.stl", b"solid" + binary[5:], 4)


def gltf():
    yield ok("sound.gltf", f.gltf(), 4)
    yield ok("sound.glb", f.glb(), 4)
    yield from cuts("cut_@.glb", f.glb(), [4, 11, 12, 19, 20, 200], "not valid JSON|the JSON text is no object|bytes, but only")
    yield bad("chunk_2_32_less_1.glb", f.glb(json_bytes=2**32 - 1), "bytes, but only")
    yield bad("version_3.glb", f.glb(version=3), "GLB version")
    yield bad("no_json.glb", struct.pack("<4sII", b"glTF", 2, 12), "the JSON text is no object")
    yield bad("empty_object.gltf", b"{}", "the file holds no triangles", 6)
    yield bad("nested_arrays.gltf", b'{"a":' + b"[" * 200000, "not valid JSON")
    yield ok("nested_nodes.gltf", f.gltf(nodes=[{"children": [i + 1]} for i in range(200000)] + [{"mesh": 0}]), 4)
    yield bad("nodes_in_a_circle.gltf", f.gltf(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]), "a node has two parents")
    yield bad("node_is_its_own_child.gltf", f.gltf(nodes=[{"mesh": 0, "children": [0]}]), "a node has two parents")
    yield bad("nodes_that_double.gltf", f.gltf(nodes=[{"children": [i + 1, i + 1]} for i in range(40)] + [{"mesh": 0}]), "a node has two parents")
    yield bad("mesh_missing.gltf", f.gltf(nodes=[{"mesh": 7}]), "there is no meshes")
    yield bad("indices_beyond_points.gltf", f.gltf(accessors__0__count=2), "TEXCOORD does not fit POSITION")
    yield bad("count_2_32.gltf", f.gltf(accessors__0__count=BIG), "accessors")
    yield bad("count_2_63.gltf", f.gltf(accessors__1__count=2**63), "accessors")
    yield bad("count_negative.gltf", f.gltf(accessors__0__count=-1), "is no non-negative integer")
    yield bad("count_fraction.gltf", f.gltf(accessors__0__count=1.5), "is no non-negative integer")
    yield bad("view_offset_2_63.gltf", f.gltf(bufferViews__0__byteOffset=2**63), "bufferViews")
    yield bad("view_length_2_64.gltf", f.gltf(bufferViews__0__byteLength=2**64 - 1), "bufferViews")
    yield bad("stride_of_zero.gltf", f.gltf(bufferViews__0__byteStride=0), "accessors")
    yield bad("type_unknown.gltf", f.gltf(accessors__0__type="MAT9"), "has an unknown type")
    yield bad("buffer_missing.gltf", f.gltf(bufferViews__0__buffer=5), "there is no buffers")
    yield bad("buffer_outside.gltf", f.gltf(buffers__0__uri="../../../../../../etc/passwd"), "in the same folder or below is wanted")
    yield bad("buffer_percent_outside.gltf", f.gltf(buffers__0__uri="%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd"), "in the same folder or below is wanted")
    yield bad("buffer_absolute.gltf", f.gltf(buffers__0__uri="/etc/passwd"), "in the same folder or below is wanted")
    yield bad("buffer_is_a_device.gltf", f.gltf(buffers__0__uri="/dev/zero"), "buffers")
    yield bad("buffer_not_base64.gltf", f.gltf(buffers__0__uri="data:;base64,???"), "a data URI that is not base")
    yield bad("image_bomb.gltf", f.gltf(image=f.PNG_BOMB), "images", 5, is_mesh=True)
    yield bad("image_cut.gltf", f.gltf(image=f.png()[:40]), "damaged PNG", is_mesh=True)
    yield bad("image_missing.gltf", f.gltf(textures__0__source=9), "there is no images", is_mesh=True)
    yield bad("matrix_of_words.gltf", f.gltf(nodes=[{"mesh": 0, "matrix": ["a"] * 16}]), "does not hold")
    yield bad("utf8_broken.gltf", f.gltf().replace(b"POSITION", b"POSI\xff\xfeON"), "not valid JSON")


def splats():
    yield ok("sound.splat", f.splat(), 4)
    yield bad("empty.splat", b"", "the file is empty")
    yield from cuts("cut_@.splat", f.splat(), [1, 31, 33, 127], "bytes are not a whole number of splats of")
    yield bad("nan.splat", f.splat([(float("nan"), 0, 0)] * 4), "points has finite coordinates", 6)
    yield bad("zeros.splat", bytes(320), "rows is a point", 6)
    yield ok("sound.spz", f.spz(), 4)
    plain = f.spz(pack=False)
    yield from cuts("cut_@.spz", plain, [4, 15, 16, 20, len(plain) - 1], "the SPZ header is cut off at byte|splats, but their data end at byte")
    packed = f.spz()
    yield from cuts("cut_packed_@.spz", packed, [5, 12, 30, len(packed) - 4], "the gzip data are cut off at byte")
    yield bad("count_one_more.spz", f.spz(count=5), "splats, but their data end at byte")
    yield bad("count_2_32_less_1.spz", f.spz(count=2**32 - 1), "splats, but their data end at byte")
    yield bad("count_zero.spz", f.spz(count=0), "the file holds", 6)
    yield bad("version_99.spz", f.spz(version=99), "SPZ of version")
    yield bad("fraction_of_255_bits.spz", f.spz(bits=255), "fractional bits")
    streams = b"NGSP" + struct.pack("<II4BI", 4, 4, 0, 12, 0, 5, 32) + bytes(12)
    yield bad("table_of_streams_lies.spz", streams + struct.pack("<QQ", 2**63, 2**63) * 5, "the table of streams is cut off or wrong")
    bomb = f.zstd([(b"\0", 2**17)] * 2000)
    yield bad("stream_bomb.spz", streams + struct.pack("<QQ", len(bomb), 36) * 5 + bomb * 5, "bytes unpack to", 5)


def packed():
    sound = f.ply_binary()
    whole = gzip.compress(sound, mtime=0)
    yield ok("sound.ply.gz", whole, 4)
    yield from cuts("cut_@.ply.gz", whole, [3, 9, 11, 40, len(whole) - 8, len(whole) - 1], "the gzip data are cut off at byte")
    yield bad("checksum_wrong.ply.gz", whole[:-8] + bytes(4) + whole[-4:], "the gzip data are damaged")
    yield bad("damaged.ply.gz", whole[:20] + b"\xff\xff\xff\xff" + whole[24:], "the gzip data are damaged")
    yield bad("method_unknown.ply.gz", whole[:2] + b"\x09" + whole[3:], "is of an unknown kind")
    yield ok("zeros_behind.ply.gz", whole + bytes(1000), 4)
    yield ok("in_two_parts.ply.gz", gzip.compress(sound[:50], mtime=0) + gzip.compress(sound[50:], mtime=0), 4)
    yield bad("packed_twice.ply.gz", gzip.compress(whole, mtime=0), "is packed twice")
    yield bad("bomb.ply.gz", f.gzip_zeros(2**27), "bytes unpack to", 5)
    yield bad("bomb_of_parts.ply.gz", gzip.compress(bytes(2**20), mtime=0) * 1000, "bytes unpack to", 5)
    yield ok("sound.ply.zst", f.zstd([sound]), 4)
    frame = f.zstd([sound])
    yield from cuts("cut_@.ply.zst", frame, [4, 5, 8, 40, len(frame) - 1], "the zstd data are cut off at byte")
    yield bad("window_of_a_terabyte.ply.zst", b"\x28\xb5\x2f\xfd\x00\xf8" + frame[6:], "the zstd data are damaged")
    yield bad("block_of_the_fourth_kind.ply.zst", b"\x28\xb5\x2f\xfd\x00\x58\x07\x00\x00", "the zstd data are damaged")
    yield bad("bomb_of_1_GB.ply.zst", f.zstd([(b"\0", 2**17)] * 2**13), "bytes unpack to", 5)
    yield bad("bomb_in_a_header.ply.zst", f.zstd([b"ply\nformat ascii 1.0\ncomment "] + [(b"c", 2**17)] * 2**13), "bytes unpack to", 5)


GROUPS = (ply, pcd, text, ptx, las, laz, e57, obj, off, stl, gltf, splats, packed)


def write_case(case, folder):
    folder.mkdir(parents=True)
    for name, data in {case.name: case.data, **case.beside}.items():
        (folder / name).write_bytes(data)


def main():
    """catalogue.py FOLDER: writes each file into a folder of its own, and cases.json about all of them."""
    top, told = pathlib.Path(sys.argv[1]), []
    for group in GROUPS:
        for case in group():
            folder = f"{group.__name__}/{case.name.replace('.', '_')}"
            write_case(case, top / folder)
            told.append({"folder": folder, "name": case.name, "points": case.points, "code": case.code, "says": case.says,
                         "is_mesh": case.is_mesh, "beside": list(case.beside)})
    (top / "cases.json").write_text(json.dumps(told, indent=1))


if __name__ == "__main__":
    main()
