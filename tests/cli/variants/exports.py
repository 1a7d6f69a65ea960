"""Files as named programs export them: testing machines, spreadsheets, trackers, 3D Slicer, Mimics, archives."""
import bz2
import gzip
import json
import pathlib

from formats import *
import frames
import images
import shapes
import tables

SOURCE = pathlib.Path(__file__).absolute().parents[3]


def machine_cases(w):
    rows = tables.curve()
    table = tables.table
    s_mm_n = ("Time (s)", "Displacement (mm)", "Force (N)")
    instron = ('"Specimen label","P1"\n"Rate 1","120.00000","mm/min"\n\n')
    columns = w / "export_columns.json"
    columns.write_text(json.dumps({
        "format": "acus-force-columns/1", "name": "testXpert", "description": "d", "time": {"column": "Prüfzeit"},
        "depth": {"column": "Standardweg"}, "force": {"column": "Standardkraft"}}))
    lvm = ("LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
           "***End_of_Header***\t\n\nChannels\t2\n***End_of_Header***\n")
    gram = 1000 / 9.80665
    yield from tables.cases_of(w, "export", [
        ("excel_sep", table(names=s_mm_n, separator=";", comma=True, before="sep=;\n"), [0]),
        ("excel_sep_tab", table(names=s_mm_n, separator="\t", before="sep=\t\n"), [0, 3]),
        ("instron", table(names=("Time", "Extension", "Load"), units=("(s)", "(mm)", "(N)"), before=instron,
                          quote=True), [0]),
        ("instron_kn", table(names=("Time", "Extension", "Load"), units=("(s)", "(mm)", "(kN)"), before=instron,
                             factors=(1, 1, 1e-3), form="{:.9f}"), [0]),
        ("zwick", table(names=("Prüfzeit", "Standardweg", "Standardkraft"), units=("s", "mm", "N"), separator=";",
                        comma=True, before="Probe;1\nPrüfer;AB\n").encode("latin-1"), [0, 3], {},
         f"--columns {columns}"),
        ("zwick_utf8", table(names=("Prüfzeit", "Standardweg", "Standardkraft"), units=("s", "mm", "N"), separator=";",
                             comma=True, before="Probe;1\n"), [0], {}, f"--columns {columns}"),
        ("texture_analyser", table(names=("Time", "Distance", "Force"), units=("(sec)", "(mm)", "(g)"),
                                   factors=(1, 1, gram), separator="\t"), [3], {"says": ["[( ']g[)'.,; ]|unit"]}),
        ("gram_force", table(names=("time_s", "depth_mm", "Force (gf)"), factors=(1, 1, gram)), [0, 3]),
        ("kilogram_force", table(names=("time_s", "depth_mm", "Force [kgf]"), factors=(1, 1, gram / 1000),
                                 form="{:.9f}"), [0, 3]),
        ("dekanewton", table(names=("time_s", "depth_mm", "Force [daN]"), factors=(1, 1, 0.1), form="{:.9f}"), [0, 3]),
        ("micrometre_sign", table(names=("Time [s]", "Depth [\u00b5m]", "Force [N]"), factors=(1, 1000, 1)), [0, 3]),
        ("micrometre_greek", table(names=("Time [s]", "Depth [\u03bcm]", "Force [N]"), factors=(1, 1000, 1)), [0, 3]),
        ("micrometre_latin1", table(names=("Time [s]", "Depth [\u00b5m]", "Force [N]"),
                                    factors=(1, 1000, 1)).encode("latin-1"), [0, 3]),
        ("inches", table(names=("Time (s)", "Depth (in)", "Force (N)"), factors=(1, 1 / 25.4, 1), form="{:.9f}"), [0, 3]),
        ("speed_beside", table([(*r, 2.0) for r in rows], names=(*s_mm_n, "Speed (mm/s)"), order=(0, 1, 2, 3),
                               factors=(1, 1, 1, 1)), [0]),
        ("stress_beside", table([(*r, 9 * r[2]) for r in rows], names=(*s_mm_n, "Stress (MPa)"), order=(3, 0, 1, 2),
                                factors=(1, 1, 1, 1)), [0]),
        ("row_numbers", table([(*r, n) for n, r in enumerate(rows)], names=(*s_mm_n, "Index"), order=(3, 0, 1, 2),
                              factors=(1, 1, 1, 1)), [0]),
        ("hours_minutes", tables.replaced(table(names=("Time", "Displacement (mm)", "Force (N)")), range(1, 401),
                                          lambda line: "00:00:" + line.zfill(28)), [3]),
        ("date_and_time", tables.replaced(table(names=("Time", "Displacement (mm)", "Force (N)")), range(1, 401),
                                          lambda line: "2024-03-05 10:11:" + line.zfill(28)), [3]),
        ("units_in_cells", tables.replaced(table(names=("time", "depth", "force")), range(1, 401),
                                           lambda line: " s,".join(line.split(",")[:1]) + " s," +
                                           " mm,".join(line.split(",")[1:]) + " N"), [3]),
        ("statistics_below", table(names=s_mm_n) + "Max,20.0,0.8\nMean,10.0,0.3\n", [3]),
        ("labview_utf16", table(names=s_mm_n, separator="\t").encode("utf-16"), [0]),
        ("labview_utf16_no_mark", table(names=s_mm_n, separator="\t").encode("utf-16-le"), [0, 3]),
        ("labview_lvm", table(names=s_mm_n, separator="\t", before=lvm), [0, 3]),
        ("nul_at_end", table(names=s_mm_n).encode() + bytes(200), [0, 3]),
        ("minus_sign", table(names=s_mm_n).replace("-", "\u2212"), [0, 3]),
        ("blank_in_names", table(names=("Time\u00a0(s)", "Displacement\u00a0(mm)", "Force\u00a0(N)")), [0, 3]),
        ("apostrophes", table(names=s_mm_n, separator=";", form="{:.6f}").replace("1.", "'1.", 3), [0, 3]),
        ("matlab_writetable", table(names=("Time_s_", "Depth_mm_", "Force_N_")), [0, 3]),
        ("pandas_index", table([(*r, n) for n, r in enumerate(rows)], names=("time_s", "depth_mm", "force_n", ""),
                               order=(3, 0, 1, 2), factors=(1, 1, 1, 1)), [0]),
        ("two_blocks", table(names=s_mm_n) + "\n" + table(names=s_mm_n), [3]),
        ("force_twice", table([(*r, r[2] / 2) for r in rows], names=(*s_mm_n, "Force 2 (N)"), order=(0, 1, 2, 3),
                              factors=(1, 1, 1, 1)), [0, 3]),
    ])


def landmark_cases(w):
    source = w / "export_from.csv"
    source.write_text(frames.csv(frames.POINTS))

    def of(name, text, exits=(0,), ending=".csv", **more):
        path = w / f"export_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "landmarks", "name": f"export_{name}", "exit": list(exits), "values": frames.VALUES,
                "command": f"acus-register --from {source} --to '{path}' -o out",
                "measure": ("transform", "out/ct_from_reference.tfm"), **more}
    # A table of 3D Slicer, in RAS: never as LPS.
    ras = [(n, -x, -y, z) for n, x, y, z in frames.TO]
    yield of("slicer_table_ras", frames.csv(ras, "label,R,A,S"), (0, 3, 4))
    yield of("slicer_table_named_ras", frames.csv(ras, "name,x_ras,y_ras,z_ras"), (0, 3, 4))
    yield of("slicer_table_lps", frames.csv(frames.TO, "label,L,P,S"), (0, 3))
    document = json.loads(frames.markups(frames.TO))
    document["markups"].append(document["markups"][0])
    yield of("markups_two_lists", json.dumps(document), (3,), ".mrk.json")
    document = json.loads(frames.markups(frames.TO))
    document["markups"][0]["controlPoints"].append({"label": "E", "position": [0, 0, 0], "positionStatus": "undefined"})
    yield of("markups_undefined_point", json.dumps(document), (0,), ".mrk.json")
    document["markups"][0].pop("coordinateUnits")
    yield of("markups_no_unit", json.dumps(document), (0,), ".mrk.json")
    yield of("markups_curve", frames.markups(frames.TO, kind="Curve"), (0, 3), ".mrk.json")
    swapped = [(frames.TO[1 - n][0] if n < 2 else p[0], *p[1:]) for n, p in enumerate(frames.TO)]
    yield of("two_names_exchanged", frames.csv(swapped), (0, 3, 4), values=[], says=[])
    yield of("names_with_comma", frames.csv([(f'"{n}, left"', *p) for n, *p in frames.TO]), (0, 3), values=[])


def tracker_cases(w):
    motive = json.loads((SOURCE / "configs/columns/optitrack_motive.json").read_text())
    motive["tools"] = motive["tools"][:1]
    columns = w / "export_motive.json"
    columns.write_text(json.dumps(motive))
    ros = w / "export_ros.json"
    of_ros = "field.pose."
    ros.write_text(json.dumps({
        "format": "acus-columns/1", "name": "rostopic echo -p", "description": "d", "header_rows": [1], "first_row": 2,
        "length_unit": "m", "time": {"column": "%time"}, "tools": [{
            "tool": "needle", "position": [f"{of_ros}position.{c}" for c in "xyz"],
            "rotation": [f"{of_ros}orientation.{c}" for c in "wxyz"]}]}))

    def motive_csv(unit="Meters", factor=1e-3, rotation="Quaternion", rows=60, parent=False, lost=()):
        head = (f"Format Version,1.23,Take Name,Take 1,Capture Frame Rate,100,Rotation Type,{rotation},"
                f"Length Units,{unit},Coordinate Space,Global\n\n")
        cells = 8 if rotation == "Quaternion" else 7
        kinds = ["Rotation"] * (cells - 4) + ["Position"] * 3 + ["Mean Marker Error"]
        axes = (["X", "Y", "Z", "W"] if rotation == "Quaternion" else ["X", "Y", "Z"]) + ["X", "Y", "Z", ""]
        head += f",Type{',Rigid Body' * cells}\n,Name{',Needle' * cells}\n,ID{',1' * cells}\n"
        head += f",Parent{',' * cells}\n" if parent else ""
        head += ",," + ",".join(kinds) + "\n"
        head += "Frame,Time (Seconds)," + ",".join(axes) + "\n"
        for n in range(rows):
            turn = ["0", "0", "0", "1"] if rotation == "Quaternion" else ["0", "0", "0"]
            at = [f"{factor * v:.6f}" for v in (100 + n, 20 - 0.5 * n, 700)]
            head += f"{n},{n * 0.01:.6f}," + ",".join([""] * cells if n in lost else turn + at + ["0.0002"]) + "\n"
        return head

    def of(name, text, exits=(0,), mapping=columns, ending=".csv", **more):
        path = w / f"export_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "trackers", "name": f"export_{name}", "exit": list(exits),
                "command": f"acus-import '{path}' --columns {mapping} -o out", "measure": ("poses", "out/needle.csv"),
                "values": [["first [^,]*,(-?[0-9.e-]+)", 100, 1e-3], ["first [^,]*,[^,]*,[^,]*,(-?[0-9.e-]+)", 700, 1e-3]],
                **more}
    yield of("motive", motive_csv())
    yield of("motive_mm", motive_csv("Millimeters", 1.0))
    yield of("motive_cm", motive_csv("Centimeters", 0.1))
    yield of("motive_lost", motive_csv(lost=(10, 11)))
    yield of("motive_crlf", motive_csv().replace("\n", "\r\n"))
    yield of("motive_3_with_parents", motive_csv(parent=True), (0, 3))
    yield of("motive_euler", motive_csv(rotation="XYZ"), (3,))
    tum = lambda n, sep=" ", q="": sep.join(f"{q}{v}{q}" for v in (f"{1714557700 + 0.02 * n:.6f}", f"{0.1 + 0.001 * n:.6f}",
                                                                   "0.02", "0.7", "0", "0", "0", "1"))
    yield of("tum_quoted", "\n".join(['"timestamp" "tx" "ty" "tz" "qx" "qy" "qz" "qw"'] + [tum(n, q='"') for n in range(60)]),
             (0, 3), "columns/tum.json", ".txt")
    yield of("tum_commas", "#timestamp,tx,ty,tz,qx,qy,qz,qw\n" + "\n".join(tum(n, ",") for n in range(60)), (0, 3),
             "columns/tum.json")
    yield of("tum_nanoseconds", "\n".join(tum(n).replace(".", "", 1).replace(" ", "000 ", 1) for n in range(60)), (3,),
             "columns/tum.json", ".txt")
    head = "%time,field.header.seq,field.header.stamp,field.header.frame_id," + ",".join(
        f"{of_ros}{c}" for c in ("position.x", "position.y", "position.z", "orientation.x", "orientation.y",
                                 "orientation.z", "orientation.w")) + "\n"
    yield of("ros_echo", head + "\n".join(f"{1714557700000000000 + 20000000 * n},{n},{1714557700000000000 + 20000000 * n},"
                                          f"base,{0.1 + 0.001 * n:.6f},0.02,0.7,0,0,0,1" for n in range(60)), (0, 3), ros)
    yield of("ros_seconds", head + "\n".join(f"{1714557700 + 0.02 * n:.3f},{n},0,base,{0.1 + 0.001 * n:.6f},0.02,0.7,0,0,0,1"
                                             for n in range(60)), (0,), ros)


def volume_cases(w):
    path = w / "export_plain.nii"
    nifti(path)
    whole = path.read_bytes()

    def of(name, data, make=images.good, command=images.SEGMENT, **more):
        (w / name).write_bytes(data)
        return make("volumes", "export_" + name, command.format(w / name), **more)
    yield of("bzip2.nii.bz2", bz2.compress(whole))
    yield of("bzip2_cut.nii.bz2", bz2.compress(whole)[:-300], images.refused, may_be_cut=True)
    yield of("bzip2_of_text.nii.bz2", bz2.compress(b"no volume"), images.refused, may_be_cut=True)
    yield of("plain_called_bz2.nii.bz2", whole)
    yield of("gz_without_ending.nii", gzip.compress(whole), images.either)
    yield of("plain_called_gz.nii.gz", whole, images.either)
    yield of("gz_twice.nii.gz", gzip.compress(gzip.compress(whole)), images.refused)
    yield of("two_members.nii.gz", gzip.compress(whole[:40000]) + gzip.compress(whole[40000:]), images.either)
    yield of("zeros_behind.nii.gz", gzip.compress(whole) + bytes(512), images.either)
    yield of("longer.nii", whole + bytes(1000), images.either)
    yield of("renamed_nrrd.nii", b"NRRD0004\n" + whole[9:], images.refused)
    yield of("renamed_dicom.nii", bytes(128) + b"DICM" + bytes(600), images.refused)
    path = w / "export_pair.hdr"
    path.write_bytes(whole[:344] + b"ni1\0")
    path.with_suffix(".img").write_bytes(whole[352:])
    yield images.refused("volumes", "export_pair", images.SEGMENT.format(path))


def surface_cases(w):
    (w / "export_coarse.json").write_text('{"format": "acus-mesh/1", "surface": {"element_size_mm": 4}}')
    obj = shapes.obj

    def of(name, data, exits=(0,), ending=".obj", **more):
        path = w / f"export_{name}{ending}"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return {**shapes.case("units", name, path, list(exits), **more), "name": f"export_{name}"}
    for number, (comment, factor) in enumerate([
            ("# Units: millimeters", 1.0), ("# units: mm", 1.0), ("#Unit=mm", 1.0), ("# Model units: Millimeters", 1.0),
            ("# File units = meters", 1e-3), ("# UNITS : METERS", 1e-3), ("# Units are in centimeters", 0.1),
            ("# Unit: m", 1e-3)]):
        yield of(f"obj_comment_{number}", obj(shapes.BOX, comment + "\n", factor=factor), (0, 3))
    yield of("ply_unit_metres", shapes.ply(shapes.scaled(shapes.BOX, 1e-3)).replace(b"made by hand", b"units: m"), (0, 3),
             ".ply")
    yield of("stl_header_metres", shapes.ascii_stl(shapes.scaled(shapes.BOX, 1e-3), "part units=m"), (0, 3), ".stl")
