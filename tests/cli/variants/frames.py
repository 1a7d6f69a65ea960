"""Variants of landmarks, transforms, poses of trackers and sessions."""
import json
import math

POINTS = [("A", 10.0, 20.0, 30.0), ("B", 110.0, 25.0, 35.0), ("C", 15.0, 140.0, 28.0), ("D", 60.0, 70.0, 120.0)]
SHIFT = (5.0, -7.0, 11.0)
TO = [(n, x + SHIFT[0], y + SHIFT[1], z + SHIFT[2]) for n, x, y, z in POINTS]
VALUES = [["translation (-?[0-9.e-]+) ", 5, 1e-6], ["translation \\S+ (-?[0-9.e-]+) ", -7, 1e-6],
          ["translation \\S+ \\S+ (-?[0-9.e-]+)", 11, 1e-6]]


def csv(points, head="name,x_mm,y_mm,z_mm", separator=",", factor=1.0, comma=False, quote=False):
    text = head.replace(",", separator) + "\n" if head else ""
    for name, *xyz in points:
        cells = [name] + [f"{factor * c:.9g}".replace(".", "," if comma else ".") for c in xyz]
        text += separator.join(f'"{c}"' if quote else c for c in cells) + "\n"
    return text


def fcsv(points, system="LPS", quote=False, version="5.0"):
    sign = -1 if system in ("RAS", "0") else 1
    text = f"# Markups fiducial file version = {version}\n# CoordinateSystem = {system}\n"
    text += "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
    for n, (name, x, y, z) in enumerate(points):
        label = f'"{name}"' if quote else name
        text += f"{n},{sign * x},{sign * y},{z},0,0,0,1,1,1,0,{label},,\n"
    return text


def markups(points, system="LPS", unit="mm", factor=1.0, kind="Fiducial"):
    sign = -1 if system == "RAS" else 1
    return json.dumps({"markups": [{"type": kind, "coordinateSystem": system, "coordinateUnits": unit,
                                    "controlPoints": [{"id": str(n), "label": p[0], "positionStatus": "defined",
                                                       "position": [sign * factor * p[1], sign * factor * p[2],
                                                                    factor * p[3]]} for n, p in enumerate(points)]}]})


def landmark_cases(w):
    (w / "from.csv").write_text(csv(POINTS))

    def of(name, text, exits=(0,), ending=".csv", source=None, options="", **more):
        path = w / f"landmarks_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        first = w / "from.csv"
        if source:
            first = w / f"landmarks_{name}_from.csv"
            first.write_text(source)
        return {"kind": "landmarks", "name": f"landmarks_{name}", "exit": list(exits), "values": VALUES,
                "command": f"acus-register --from {first} --to '{path}' {options} -o out",
                "measure": ("transform", "out/ct_from_reference.tfm"), **more}
    yield of("plain", csv(TO))
    yield of("bom_crlf", b"\xef\xbb\xbf" + csv(TO).replace("\n", "\r\n").encode())
    yield of("utf16", csv(TO).encode("utf-16"))
    yield of("semicolon_comma", csv(TO, separator=";", comma=True))
    yield of("tabs", csv(TO, separator="\t"))
    yield of("quoted", csv(TO, quote=True))
    yield of("order", csv(TO[::-1]))
    yield of("cm", csv(TO, head="name,x_cm,y_cm,z_cm", factor=0.1))
    yield of("metres_said_mm", csv(TO, factor=1e-3), (3, 4))
    yield of("without_header", csv(TO, head=""), (0, 3))
    for system in ("LPS", "RAS", "0", "1"):
        yield of("fcsv_" + system, fcsv(TO, system), ending=".fcsv")
    yield of("fcsv_quoted", fcsv(TO, "RAS", True), ending=".fcsv")
    yield of("fcsv_old", fcsv(TO, "0", version="4.3"), ending=".fcsv")
    for system in ("LPS", "RAS"):
        yield of("markups_" + system, markups(TO, system), ending=".mrk.json")
    yield of("markups_metres", markups(TO, unit="m", factor=1e-3), ending=".mrk.json")
    yield of("markups_triple", markups(TO, unit=["cm", "cm", "cm"], factor=0.1), ending=".mrk.json")
    yield of("markups_code", markups(TO, unit=["mm", "UCUM", "millimeter"]), ending=".mrk.json")
    yield of("markups_unit_unknown", markups(TO, unit="furlong"), (3,), ending=".mrk.json")
    yield of("other_names", csv([("p" + n, *p) for n, *p in TO]), (0, 3), says=[])
    yield of("name_twice", csv(TO + TO[:1]), (3,))
    yield of("two_points", csv(TO[:2]), (3, 4), source=csv(POINTS[:2]))
    mirrored = [(n, -x, y, z) for n, x, y, z in TO]
    yield of("mirrored", csv(mirrored), (4,))
    yield of("mirrored_by_unknown_system", fcsv(mirrored, "LPS"), (4,), ending=".fcsv")
    line = [(n, 10.0 * i, 20.0 * i, 5.0 * i) for i, (n, *_) in enumerate(POINTS)]
    yield of("on_a_line", csv(line), (3, 4), source=csv(line))
    yield of("text_coordinate", csv(TO).replace("140", "high").replace("133", "high"), (3,))
    yield of("infinite", csv(TO).replace("133", "inf"), (3,))
    yield of("unknown_ending", csv(TO), (3,), ending=".pts")


def tfm(kind, parameters, fixed="0 0 0", extra=""):
    return ("#Insight Transform File V1.0\n#Transform 0\n" + extra +
            f"Transform: {kind}_double_3_3\nParameters: {parameters}\nFixedParameters: {fixed}\n")


def transform_cases(w):
    """Through the landmarks of a second registration: acus-replay reads transforms, with a patient."""
    def of(name, text, exits, ending=".tfm"):
        path = w / f"transform_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "transforms", "name": f"transform_{name}", "exit": exits, "says": [],
                "command": "acus-replay $SCENARIO $SESSION --ct $PATIENT/ct.nrrd --labels $PATIENT/labels.seg.nrrd "
                           f"--transform '{path}' --check"}
    session(w / "session_plain", (0, 3), (0, 3))
    unit = "1 0 0 0 1 0 0 0 1"
    yield of("affine", tfm("AffineTransform", unit + " 1 2 3"), [0])
    yield of("affine_crlf", tfm("AffineTransform", unit + " 1 2 3").replace("\n", "\r\n"), [0])
    yield of("float", tfm("AffineTransform", unit + " 1 2 3").replace("double", "float"), [0])
    yield of("euler", tfm("Euler3DTransform", "0 0 0.1 1 2 3"), [0])
    yield of("euler_zyx", tfm("Euler3DTransform", "0 0 0.1 1 2 3", "0 0 0 1"), [0])
    yield of("versor", tfm("VersorRigid3DTransform", "0 0 0.1 1 2 3"), [0])
    yield of("identity", tfm("IdentityTransform", "", ""), [0])
    yield of("translation", tfm("TranslationTransform", "1 2 3", ""), [0])
    yield of("matrix", "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n", [0], ".txt")
    yield of("matrix_commas", "1,0,0,1\n0,1,0,2\n0,0,1,3\n0,0,0,1\n", [0], ".csv")
    yield of("composite", tfm("TranslationTransform", "1 2 3", "",
                              "Transform: CompositeTransform_double_3_3\n#Transform 1\n"), [0])
    yield of("scaled", tfm("AffineTransform", "1.2 0 0 0 1 0 0 0 1 0 0 0"), [3])
    yield of("mirrored", tfm("AffineTransform", "-1 0 0 0 1 0 0 0 1 0 0 0"), [3])
    yield of("sheared", tfm("AffineTransform", "1 0.1 0 0 1 0 0 0 1 0 0 0"), [3])
    yield of("bspline", tfm("BSplineTransform", "0 0 0", "4 4 4"), [3])
    yield of("two", tfm("AffineTransform", unit + " 1 2 3") + tfm("AffineTransform", unit + " 1 2 3"), [3])
    yield of("two_d", tfm("AffineTransform", "1 0 0 1 0 0", "0 0").replace("3_3", "2_2"), [3])
    yield of("not_finite", tfm("AffineTransform", unit + " 1 2 nan"), [3])
    yield of("kilometres", tfm("AffineTransform", unit + " 1 2 3e9"), [3])
    yield of("empty", "", [3])
    yield of("transposed", "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n", [3], ".txt")


def columns(w, name, unit, time=1, rotation=(5, 6, 7, 8), position=(2, 3, 4), first_row=2):
    path = w / name
    path.write_text(json.dumps({"format": "acus-columns/1", "name": "n", "description": "d", "first_row": first_row,
                                "length_unit": unit, "time": {"column": time},
                                "tools": [{"tool": "needle", "position": list(position), "rotation": list(rotation)}]}))
    return path


def poses(factor=1.0, head="t,x,y,z,qw,qx,qy,qz", separator=",", comma=False, start=0.0, step=0.02, q=(1, 0, 0, 0)):
    text = head.replace(",", separator) + "\n" if head else ""
    for i in range(60):
        row = (start + step * i, factor * (100 + i), factor * (20 - 0.5 * i), factor * 700.0, *q)
        text += separator.join(f"{v:.13g}".replace(".", "," if comma else ".") for v in row) + "\n"
    return text


def tracker_cases(w):
    mm = columns(w, "mm.json", "mm")

    def of(name, text, exits=(0,), mapping=mm, ending=".csv", **more):
        path = w / f"poses_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "trackers", "name": f"poses_{name}", "exit": list(exits),
                "command": f"acus-import '{path}' --columns {mapping} -o out",
                "measure": ("poses", "out/needle.csv"),
                "values": [["first [^,]*,(-?[0-9.e-]+)", 100, 1e-6], ["first [^,]*,[^,]*,[^,]*,(-?[0-9.e-]+)", 700, 1e-6]],
                **more}
    yield of("plain", poses())
    yield of("bom_crlf", b"\xef\xbb\xbf" + poses().replace("\n", "\r\n").encode())
    yield of("utf16", poses().encode("utf-16"))
    yield of("tabs", poses(separator="\t"))
    yield of("blanks", poses(separator=" "), ending=".txt")
    yield of("semicolon_comma", poses(separator=";", comma=True))
    yield of("metres", poses(1e-3), mapping=columns(w, "m.json", "m"))
    yield of("centimetres", poses(0.1), (0, 3), mapping=columns(w, "cm.json", "cm"))
    yield of("metres_said_mm", poses(1e-3), (3,))
    yield of("mm_said_metres", poses(), (3,), mapping=columns(w, "m2.json", "m"))
    yield of("unix_time", poses(start=1714557700.0))
    yield of("quaternion_scaled", poses(q=(1.001, 0, 0, 0)), (0, 3))
    yield of("quaternion_of_two", poses(q=(2, 0, 0, 0)), (0, 3))
    yield of("quaternion_zero", poses(q=(0, 0, 0, 0)), (3, 0))
    yield of("time_back", poses() + "0.01,100,20,700,1,0,0,0\n", (3,))
    yield of("repeated_stamp", poses() + poses().splitlines()[-1] + "\n")
    yield of("empty_cells", poses().replace("0.2,110,15,700", "0.2,,,"))
    yield of("nan_cells", poses().replace("0.2,110,15,700", "0.2,NaN,NaN,NaN"))
    yield of("text", poses().replace("0.2,110", "0.2,lost"), (0, 3))
    yield of("fewer_cells", poses().replace("0.2,110,15,700,1,0,0,0", "0.2,110,15"), (0, 3))
    yield of("only_header", "t,x,y,z,qw,qx,qy,qz\n", (3,))
    yield of("empty", "", (3,))
    yield of("column_beyond", poses(), (3,), mapping=columns(w, "beyond.json", "mm", rotation=(5, 6, 7, 19)))
    yield of("tum", "\n".join(f"{1714557700 + 0.02 * i:.3f} {0.1 + 0.001 * i:.6f} 0.02 0.7 0 0 0 1" for i in range(60)) +
             "\n", mapping="columns/tum.json", ending=".txt")
    yield of("tum_comments", "# timestamp tx ty tz qx qy qz qw\n" + "\n".join(
        f"{1714557700 + 0.02 * i:.3f} {0.1 + 0.001 * i:.6f} 0.02 0.7 0 0 0 1" for i in range(60)) + "\n",
        mapping="columns/tum.json", ending=".txt")


def session(folder, needle, probe):
    folder.mkdir()
    for tool, (start, end) in (("needle", needle), ("probe", probe)):
        (folder / f"{tool}.csv").write_text("time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n" + "".join(
            f"{start + (end - start) * i / 59:.6f},{0.1 * i},-60,-10,1,0,0,0,OK\n" for i in range(60)))
    (folder / "session.json").write_text(json.dumps({"format": "acus-session/1", "name": "n", "reference_frame": "Reference",
         "streams": [{"file": f"{tool}.csv", "tool": tool} for tool in ("needle", "probe")]}))


def session_cases(w):
    """Streams of one session that meet, or do not."""
    def of(name, needle, probe, exits, **more):
        folder = w / f"session_{name}"
        session(folder, needle, probe)
        return {"kind": "streams", "name": f"session_{name}", "exit": exits,
                "command": f"acus-replay $SCENARIO {folder} --ct $PATIENT/ct.nrrd --labels $PATIENT/labels.seg.nrrd "
                           "--transform $PATIENT/ct_from_reference.tfm --check", **more}
    both = {"says": ["no common time.*acus-register temporal"]}
    yield of("same", (0, 3), (0, 3), [0])
    yield of("within", (0, 10), (4, 5), [0])
    yield of("around", (4, 5), (0, 10), [0])
    yield of("half", (0, 4), (2, 6), [0])
    yield of("touching", (0, 2), (2, 4), [0, 3])
    yield of("after", (0, 3), (4, 7), [3], **both)
    yield of("before", (14, 17), (4, 7), [3], **both)
    yield of("clock_of_day", (0, 3), (45296, 45299), [3], **both)
    yield of("unix", (1714557700, 1714557703), (0, 3), [3], **both)
    yield of("unix_both", (1714557700, 1714557703), (1714557701, 1714557704), [0])
    yield of("milliseconds", (12000, 15000), (12, 15), [3], **both)
    yield of("an_hour", (3600, 3603), (0, 3), [3], **both)
    yield of("negative", (-3, 0), (-2, 1), [0])
    yield of("just_apart", (0, 2), (2.001, 4), [3], **both)
    yield of("overlap_of_a_sample", (0, 2), (1.99, 4), [0])
    yield of("short_in_long", (0, 600), (300, 301), [0])
    yield of("same_end", (0, 3), (2.9, 3), [0])
    yield of("milliseconds_both", (12000, 15000), (12500, 14000), [0, 3])
    yield of("a_day", (0, 3), (86400, 86403), [3], **both)
    yield of("epoch_of_2000", (1714557700, 1714557703), (767872900, 767872903), [3], **both)
    yield of("nanoseconds", (1714557700e9, 1714557703e9), (1714557700, 1714557703), [3])
