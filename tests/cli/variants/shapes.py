"""Variants of surfaces: formats, units, and what is wrong with them."""
import json
import math
import struct

from formats import *

BOX = box((-20, -15, -10), (20, 15, 10))
BOX_ML = 24.0


def case(kind, name, path, exits, ml=BOX_ML, options="", within=0.03, **more):
    return {"kind": kind, "name": f"surface_{name}", "command": f"acus-mesh --surface '{path}' {options} -o out",
            "exit": exits, "values": [["mesh_ml ([-0-9.e]+)", ml, within * ml]], "measure": ("mesh", "out"), **more}


def obj(triangles, before="", relative=False, quads=False, slashes=False, factor=1.0):
    nodes, faces = indexed(triangles)
    text = before + "".join("v " + " ".join(f"{factor * c:.9g}" for c in n) + "\n" for n in nodes)
    if slashes:
        text += "vt 0 0\nvn 0 0 1\ng box\nusemtl skin\ns off\n"
    for face in faces:
        numbers = [n - len(nodes) if relative else n + 1 for n in face]
        text += "f " + " ".join(f"{n}/1/1" if slashes else str(n) for n in numbers) + "\n"
    return text


def ply(triangles, kind="ascii", extra=False, count_type="uchar"):
    nodes, faces = indexed(triangles)
    head = f"ply\nformat {kind} 1.0\ncomment made by hand\nelement vertex {len(nodes)}\n"
    head += "".join(f"property float {c}\n" for c in "xyz") + ("property uchar red\n" if extra else "")
    head += f"element face {len(faces)}\nproperty list {count_type} int vertex_indices\nend_header\n"
    if kind == "ascii":
        body = "".join(" ".join(map(str, n)) + (" 255" if extra else "") + "\n" for n in nodes)
        return (head + body + "".join("3 %d %d %d\n" % f for f in faces)).encode()
    e = "<" if "little" in kind else ">"
    body = b"".join(struct.pack(e + "3f", *n) + (b"\xff" if extra else b"") for n in nodes)
    count = "B" if count_type == "uchar" else "i"
    return head.encode() + body + b"".join(struct.pack(e + count + "3i", 3, *f) for f in faces)


def vtk(triangles, binary=False, title="surface", version="3.0"):
    nodes, faces = indexed(triangles)
    head = f"# vtk DataFile Version {version}\n{title}\n{'BINARY' if binary else 'ASCII'}\nDATASET POLYDATA\n"
    if binary:
        return (head + f"POINTS {len(nodes)} float\n").encode() + b"".join(struct.pack(">3f", *n) for n in nodes) + (
            f"\nPOLYGONS {len(faces)} {4 * len(faces)}\n").encode() + b"".join(
            struct.pack(">4i", 3, *f) for f in faces) + b"\n"
    return (head + f"POINTS {len(nodes)} float\n" + "".join("%g %g %g\n" % n for n in nodes) +
            f"POLYGONS {len(faces)} {4 * len(faces)}\n" + "".join("3 %d %d %d\n" % f for f in faces)).encode()


def ascii_stl(triangles, name="part"):
    text = f"solid {name}\n"
    for t in triangles:
        text += "  facet normal 0 0 0\n    outer loop\n" + "".join("      vertex %g %g %g\n" % p for p in t)
        text += "    endloop\n  endfacet\n"
    return text + f"endsolid {name}\n"


def scaled(triangles, factor):
    return [tuple(tuple(factor * c for c in p) for p in t) for t in triangles]


def surface_cases(w):
    (w / "coarse.json").write_text('{"format": "acus-mesh/1", "surface": {"element_size_mm": 4}}')
    coarse = f"--config {w}/coarse.json"
    def of(name, data, exits=(0,), ending=".stl", **more):
        path = w / f"surface_{name}{ending}"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return case("surfaces", name, path, list(exits), **more)
    path = w / "surface_binary.stl"
    stl(path, BOX)
    yield case("surfaces", "stl_binary", path, [0])
    path = w / "surface_solid.stl"
    stl(path, BOX, b"solid made by a program")
    yield case("surfaces", "stl_binary_called_solid", path, [0])
    yield of("stl_text", ascii_stl(BOX))
    yield of("stl_text_crlf", ascii_stl(BOX).replace("\n", "\r\n"))
    yield of("stl_upper", ascii_stl(BOX).upper(), ending=".STL")
    yield of("stl_two_solids", ascii_stl(BOX) + ascii_stl(box((30, 0, 0), (40, 10, 10)), "b"), ml=25.0)
    yield of("obj", obj(BOX), ending=".obj")
    yield of("obj_relative", obj(BOX, relative=True), ending=".obj")
    yield of("obj_slashes", obj(BOX, slashes=True), ending=".obj")
    yield of("obj_crlf", obj(BOX).replace("\n", "\r\n"), ending=".obj")
    yield of("ply_text", ply(BOX), ending=".ply")
    yield of("ply_little", ply(BOX, "binary_little_endian", True), ending=".ply")
    yield of("ply_big", ply(BOX, "binary_big_endian", False, "int"), ending=".ply")
    yield of("vtk_text", vtk(BOX), ending=".vtk")
    yield of("vtk_binary", vtk(BOX, True), ending=".vtk")
    yield of("vtk_ras", vtk(BOX, title="3D Slicer output. SPACE=RAS"), ending=".vtk")
    yield of("inwards", ascii_stl([(a, c, b) for a, b, c in BOX]))
    yield of("one_turned", ascii_stl([(a, c, b) if n == 3 else (a, b, c) for n, (a, b, c) in enumerate(BOX)]))
    yield of("twice", ascii_stl(BOX + BOX))
    yield of("without_a_triangle", ascii_stl(BOX[1:]))
    yield of("without_half", ascii_stl(BOX[:6]), (0, 3), ml=12.0, says=["hole"])
    yield of("flat_triangle", ascii_stl(BOX + [(BOX[0][0], BOX[0][0], BOX[0][1])]))
    yield of("single_triangle", ascii_stl(BOX[:1]), (3,))
    yield of("not_finite", ascii_stl(BOX).replace("20", "nan", 1), (3,))
    yield of("cut_off", ascii_stl(BOX)[:-200], (3, 0), may_be_cut=True)
    yield of("empty", "", (3,), may_be_cut=True)
    yield of("no_surface", "solid a\nendsolid a\n", (3,))
    other = box((10, 5, 0), (40, 30, 25))
    union = 24 + 30 * 25 * 25 / 1000 - 10 * 10 * 10 / 1000
    yield of("overlapping", ascii_stl(BOX + other), (3,), says=["--repair"])
    yield of("overlapping_repaired", ascii_stl(BOX + other), ml=union, options="--repair " + coarse)
    yield of("overlapping_turned_repaired", ascii_stl(BOX + [(a, c, b) for a, b, c in other]), ml=union,
             options="--repair " + coarse)
    third = box((-40, -5, -5), (-10, 5, 5))
    yield of("three_overlapping_repaired", ascii_stl(BOX + other + third), ml=union + 2.0, options="--repair " + coarse)
    yield of("nested_repaired", ascii_stl(BOX + box((-5, -5, -5), (5, 5, 5)) + other), ml=union,
             options="--repair " + coarse)
    cavity = [(a, c, b) for a, b, c in box((-15, -10, -5), (-2, 3, 5))]
    yield of("cavity_repaired", ascii_stl(BOX + cavity + other), ml=union - 13 * 13 * 10 / 1000,
             options="--repair " + coarse)
    yield of("cavity", ascii_stl(BOX + cavity), ml=24 - 13 * 13 * 10 / 1000, options=coarse)
    yield of("nested", ascii_stl(BOX + box((-5, -5, -5), (5, 5, 5))), (0, 3), options=coarse)
    lid = [tuple((p[0], p[1], p[2] + (0.004 if n in (2, 3) else 0)) for p in t) for n, t in enumerate(BOX)]
    yield of("crack_repaired", ascii_stl(lid), options="--repair")
    yield of("sound_repaired", ascii_stl(BOX), options="--repair", within=1e-6)
    yield of("hole_repaired", ascii_stl(BOX[1:]), options="--repair")


def unit_cases(w):
    def of(name, data, exits, ending, ml=BOX_ML, options=""):
        path = w / f"unit_{name}{ending}"
        path.write_text(data)
        return case("units", name, path, exits, ml, options)
    for unit, factor in (("m", 1e-3), ("meters", 1e-3), ("cm", 0.1), ("inches", 1 / 25.4), ("mm", 1.0)):
        yield of("obj_" + unit, obj(BOX, f"# Exported\n# Units: {unit}\n", factor=factor), [0], ".obj")
    yield of("obj_unit_unknown", obj(BOX, "# Units: parsec\n"), [3, 0], ".obj")
    yield of("stl_metres", ascii_stl(scaled(BOX, 1e-3)), [3], ".stl")
    yield of("stl_micrometres", ascii_stl(scaled(BOX, 1e3)), [3], ".stl")
    yield of("stl_metres_taken", ascii_stl(scaled(BOX, 1e-3)), [0], ".stl", BOX_ML * 1e-9, "--as-it-is")
