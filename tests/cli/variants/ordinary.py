"""Ordinary files that the other modules do not have: frames of reference, names of labels, odd but valid headers."""
import gzip
import json
import math
import struct
import zipfile

from formats import *
import frames
import images
import labels
import shapes
import tables

FRAME, SERIES = "1.2.826.7", "1.2.826.1"


def frame_cases(w):
    """Labels in DICOM, and the frame of reference of the CT."""
    folder = w / "ordinary_ct"
    ct_series(folder, series=SERIES, extra=((0x20, 0x52, "UI", FRAME),))
    liver = [("Liver", "ORGAN", [labels.ellipse(z) for z in labels.PLANES])]

    def of(name, exits=(0,), says=(), rois=liver, ct=folder, more="", seg=False, never=(), **options):
        path = w / f"ordinary_{name}.dcm"
        if seg:
            labels.segmentation(path, list(range(2, 7)), **options)
        else:
            labels.structure_set(path, rois, **options)
        return {"kind": "structures", "name": "ordinary_" + name, "exit": list(exits), "says": list(says),
                "values": labels.LIVER, "measure": ("label", "out", "liver"), "never": list(never),
                "command": f"acus-segment {ct} --import {path} --accept-implausible -o out".replace(
                    "--accept-implausible", more)}
    # The liver of these variants is no plausible one, so that a map that is taken needs the option.
    taken = "--accept-implausible"
    silent = ["frame of reference", "drawn on series"]
    yield of("same_frame", frame=FRAME, series=SERIES, more=taken, never=silent)
    yield of("same_frame_of_roi", frame=FRAME, series=SERIES, roi_frames=[FRAME], more=taken, never=silent)
    yield of("no_frame", more=taken, never=silent)
    yield of("other_frame", (3,), ["1.2.826.8, that of the CT 1.2.826.7", "--accept-implausible"], frame="1.2.826.8",
             series="1.2.826.2")
    yield of("other_frame_of_roi", (3,), ["1.2.826.8, that of the CT 1.2.826.7"], roi_frames=["1.2.826.8"])
    yield of("other_frame_taken", (0,), ["1.2.826.8, that of the CT 1.2.826.7"], frame="1.2.826.8", more=taken)
    yield of("other_frame_of_this_series", (0,), ["drawn on the series of the CT"], frame="1.2.826.8", series=SERIES,
             more=taken)
    yield of("other_series", (0,), ["drawn on series 1.2.826.2, the CT is 1.2.826.1"], frame=FRAME, series="1.2.826.2",
             more=taken)
    yield of("roi_of_mr", (0,), ["omitted: Spleen .another frame of reference."], roi_frames=[FRAME, "1.2.826.8"],
             rois=liver + [("Spleen", "ORGAN", liver[0][2])], more=taken)
    yield of("seg_same_frame", frame=FRAME, series=SERIES, seg=True, more=taken, never=silent)
    yield of("seg_other_frame", (3,), ["1.2.826.8, that of the CT 1.2.826.7"], frame="1.2.826.8", seg=True)
    yield of("frame_beside_nifti", frame=FRAME, series=SERIES, ct="$CT", more=taken)


def name_cases(w):
    """Names of the values, in files of other programs: 3 is the liver, 7 an unlabelled spleen."""
    def two(x, y, z):
        return 3 * labels.in_liver(x, y, z) or (7 if (x + 60) ** 2 + y ** 2 + (z - 90) ** 2 < 900 else 0)

    def of(name, files, exits=(0,), mapping=None, ending=".nii.gz", make=nifti, **more):
        folder = w / f"ordinary_{name}"
        folder.mkdir()
        options = more.pop("options", {})
        make(folder / ("map" + ending), **{"code": "B", "value": two, **options})
        for file, text in files.items():
            (folder / file).write_bytes(text if isinstance(text, bytes) else text.encode())
        case = labels.imported("labels", "ordinary_" + name, folder / ("map" + ending), exits, **more)
        if mapping:
            case["command"] += f" --mapping {folder / mapping}"
        return case
    snap = ("################################################\n# ITK-SnAP Label Description File\n# File format: \n"
            "# IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL\n# Fields: \n#    IDX:   Zero-based index \n"
            "################################################\n    0     0    0    0        0  0  0    \"Clear Label\"\n"
            "    3   255    0    0        1  1  1    \"Liver\"\n    7     0  255    0        1  1  1    \"Spleen\"\n")
    slicer = "# Color table file /tmp/a.ctbl\n# 8 values\n0 Background 0 0 0 0\n3 liver 221 130 101 255\n7 spleen 157 108 162 255\n"
    surfer = "#No. Label Name:                            R   G   B   A\n\n0   Unknown 0 0 0 0\n3   Liver 1 2 3 0\n7   Spleen 4 5 6 0\n"
    csv = ("LabelValue,Name,Color_R,Color_G,Color_B,Color_A,Category_CodingScheme,Category_CodeValue,Type_CodingScheme,"
           "Type_CodeValue\n3,one,1,2,3,255,SCT,123037004,SCT,10200004\n7,two,1,2,3,255,SCT,123037004,SCT,78961009\n")
    yield of("itk_snap", {"map.txt": snap}, says=["by map.txt"])
    yield of("itk_snap_crlf", {"map.label": snap.replace("\n", "\r\n")}, says=["by map.label"])
    yield of("itk_snap_labels", {"labels.txt": snap}, says=["by labels.txt"])
    yield of("itk_snap_mapping", {"anything.txt": snap}, mapping="anything.txt", says=["by anything.txt"])
    yield of("itk_snap_default_names", {"map.txt": snap.replace("Spleen", "Label 7")}, (3,), says=["Label 7"])
    yield of("itk_snap_broken", {"map.txt": snap.replace('"Spleen"', "")}, (3,), says=["map.txt:10"])
    yield of("slicer_table", {"map_ColorTable.ctbl": slicer}, says=["by map_ColorTable.ctbl"])
    yield of("slicer_table_mapping", {"a.ctbl": slicer}, mapping="a.ctbl")
    yield of("slicer_csv", {"map.csv": csv}, says=["by map.csv"])
    yield of("free_surfer", {"map.lut": surfer}, says=["by map.lut"])
    yield of("free_surfer_mapping", {"FreeSurferColorLUT.txt": surfer}, mapping="FreeSurferColorLUT.txt")
    yield of("list", {"map.txt": "3 liver\n7 spleen\n"})
    yield of("nnu_net", {"dataset.json": json.dumps({"labels": {"background": 0, "liver": 3, "spleen": 7}})})
    yield of("nnu_net_mapping", {"d.json": json.dumps({"labels": {"background": 0, "liver": 3, "spleen": 7}})},
             mapping="d.json")
    yield of("nnu_net_regions", {"dataset.json": json.dumps({"labels": {"background": 0, "organs": [3, 7], "liver": 3}})},
             (3,), says=["'organs' is a region of the values"])
    yield of("bids_mapping", {"x.tsv": "index\tname\n3\tliver\n7\tspleen\n"}, mapping="x.tsv")
    yield of("mapping_of_prose", {"x.txt": "Segmented by A. B. in March.\n"}, (3,), mapping="x.txt", says=["names no values"])
    yield of("note_beside", {"map.txt": "1 case of many\nsee the report\n", "dataset.json": json.dumps(
        {"labels": {"3": "liver", "7": "spleen"}})}, says=["by dataset.json"])
    groups = [{"labels": [{"name": "liver", "value": 3, "color": [1, 0, 0]}, {"name": "spleen", "value": 7}]}]
    fields = f"modality:=org.mitk.multilabel.segmentation\norg.mitk.multilabel.segmentation.labelgroups:={json.dumps(groups)}\n"
    yield of("mitk", {}, ending=".nrrd", make=nrrd, options={"extra": fields})
    yield of("mitk_vector", {}, ending=".nrrd", make=vector_nrrd, options={"extra": fields})
    yield of("mitk_stack", {"map.mitklabel.json": json.dumps({
        "version": 3, "type": "org.mitk.multilabel.segmentation.stack",
        "groups": [{**groups[0], "_file": "./map.nii.gz"}]})}, says=["by map.mitklabel.json"])


def vector_nrrd(path, **options):
    """With a first axis of one value, as MITK writes a segmentation of one group."""
    nrrd(path, **options)
    head, data = path.read_bytes().split(b"\n\n", 1)
    head = head.replace(b"dimension: 3", b"dimension: 4").replace(b"sizes: ", b"sizes: 1 ")
    head = head.replace(b"space directions: ", b"space directions: none ")
    path.write_bytes(head + b"\nkinds: vector domain domain domain\n\n" + data)


def volume_cases(w):
    def of(name, change=None, make=images.good, ending=".nii", writer=nifti, kind="volumes", **options):
        path = w / f"ordinary_{name}{ending}"
        says = options.pop("says", [])
        writer(path, **options)
        if change:
            path.write_bytes(change(path.read_bytes()))
        case = make(kind, "ordinary_" + name, images.SEGMENT.format(path))
        return {**case, "says": says}
    nan = [float("nan") if v <= -1000 else v for v in voxels()]
    yield of("nan_outside", make=images.either, code="f", data=nan)
    yield of("padding_of_3024", code="h", data=[-3024 if v <= -1000 else v for v in voxels()])
    yield of("int64", code="q", make=images.either)
    yield of("five_dimensions", dims=[5, *SIZE, 1, 1, 1, 1])
    yield of("slope_of_nan", lambda b: b[:112] + struct.pack("<2f", math.nan, math.nan) + b[120:], make=images.either)
    yield of("rgb", lambda b: b[:70] + struct.pack("<2h", 128, 24) + b[74:] + bytes(2 * len(voxels())), images.refused)
    yield of("spaces_of_talairach", lambda b: b[:252] + struct.pack("<2h", 0, 3) + b[256:], make=images.either)
    line = lambda old, new: lambda b: b.replace(old, new, 1)
    yield of("nrrd_int16", line(b"type: short", b"type: int16"), ending=".nrrd", writer=nrrd)
    yield of("nrrd_signed_short_int", line(b"type: short", b"type: signed short int"), ending=".nrrd", writer=nrrd)
    yield of("nrrd_crlf", lambda b: b.split(b"\n\n", 1)[0].replace(b"\n", b"\r\n") + b"\r\n\r\n" + b.split(b"\n\n", 1)[1],
             make=images.either, ending=".nrrd", writer=nrrd)
    yield of("nrrd_fields_of_slicer", ending=".nrrd", writer=nrrd, encoding="gzip",
             extra="centerings: cell cell cell\nmeasurement frame: (1,0,0) (0,1,0) (0,0,1)\n")
    yield of("nrrd_byte_skip", make=images.either, ending=".nrrd", writer=nrrd, extra="byte skip: -1\n")
    yield of("nrrd_fourth_axis_of_one", lambda b: b.replace(b"dimension: 3", b"dimension: 4").replace(
        b"sizes: 32 28 10", b"sizes: 32 28 10 1").replace(b"\nspace origin", b" none\nspace origin"),
        make=images.either, ending=".nrrd", writer=nrrd)
    yield of("nrrd_gz", gzip.compress, images.either, ending=".nrrd.gz", writer=nrrd)
    yield of("mha_position", line(b"Offset", b"Position"), ending=".mha", writer=meta)
    yield of("mha_orientation", line(b"TransformMatrix", b"Orientation"), ending=".mha", writer=meta,
             axes=images.FLIPS["ras"])
    yield of("mha_compressed", ending=".mha", writer=meta, compressed=True, axes=images.FLIPS["las"])
    yield of("mha_no_matrix", lambda b: b"\n".join(x for x in b.split(b"\n", 12) if not x.startswith(b"TransformMatrix")),
             make=images.either, ending=".mha", writer=meta)
    yield of("zip", make=images.refused, ending=".zip", writer=zipped)
    yield of("xz", make=images.refused, ending=".nii.xz")


def zipped(path):
    nifti(path.with_suffix(".nii"))
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(path.with_suffix(".nii"), "ct.nii")


def dicom_cases(w):
    def case(variant, make, *says, **options):
        folder = w / ("ordinary_dicom_" + variant)
        ct_series(folder, **options)
        return {**make("dicom", "ordinary_dicom_" + variant, images.SEGMENT.format(folder)), "says": list(says)}
    yield case("no_instance_numbers", images.good, of_slice=lambda k: {"number": ""})
    yield case("feet_first", images.good, extra=((0x18, 0x5100, "CS", "FFS"),))
    yield case("file_per_folder", images.good, name="s{0}_{0}.dcm")
    yield case("padding_of_2000", images.either, signed=1, inter=0.0, stored=16, of_slice=lambda k: {
        "values": [-2000 if v <= -1000 else v for v in slice_values(IDENTITY, k)]})
    yield case("no_rescale", images.either, inter=0.0, of_slice=lambda k: {
        "values": [v + 1024 for v in slice_values(IDENTITY, k)]})
    yield case("localizer_in_series", images.either, of_slice=lambda k: {} if k else {
        "image_type": "ORIGINAL\\PRIMARY\\LOCALIZER"})
    folder = w / "ordinary_dicom_slice_file"
    ct_series(folder)
    yield {**images.refused("dicom", "ordinary_dicom_slice_file", images.SEGMENT.format(folder / "000.dcm")),
           "says": ["folder"]}


def other_cases(w):
    rows = tables.curve()
    s_mm_n = ("Time (s)", "Displacement (mm)", "Force (N)")
    yield from tables.cases_of(w, "ordinary", [
        ("fortran_exponents", tables.table(names=s_mm_n, form="{:.6E}").replace("E+", "D+").replace("E-", "D-"), [3]),
        ("windows_1252", tables.table(names=("Time [s]", "Depth [mm]", "Force [N]"),
                                      before="Pr\u00fcfk\u00f6rper;1\n").encode("cp1252"), [0, 3]),
        ("utf16_no_crlf", tables.table(names=s_mm_n, separator="\t", end="\r\n").encode("utf-16"), [0]),
        ("depth_of_retraction", tables.table([(t, 20 - d, f) for t, d, f in rows]), [0, 3, 4], {"values": []}),
        ("force_of_two_axes", tables.table([(*r, 0.1 * r[2]) for r in rows], names=(*s_mm_n, "Force Y (N)"),
                                           order=(0, 1, 2, 3), factors=(1, 1, 1, 1)), [0, 3]),
        ("trailing_blanks", tables.table(names=s_mm_n, end="  \n"), [0]),
        ("semicolon_at_end", tables.table(names=s_mm_n, separator=";", tail=";"), [0, 3]),
    ])
    source = w / "ordinary_from.csv"
    source.write_text(frames.csv(frames.POINTS))

    def points(name, text, exits, ending, **more):
        path = w / f"ordinary_{name}{ending}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return {"kind": "landmarks", "name": "ordinary_" + name, "exit": exits, "values": frames.VALUES,
                "command": f"acus-register --from {source} --to '{path}' -o out",
                "measure": ("transform", "out/ct_from_reference.tfm"), **more}
    yield points("elastix_points", "point\n4\n" + "".join(f"{x} {y} {z}\n" for _, x, y, z in frames.TO), [3], ".txt")
    yield points("mni_tag", "MNI Tag Point File\nVolumes = 1;\nPoints =\n 1 2 3 \"a\";\n", [3], ".tag")
    swapped = [(x, y, z, n) for n, x, y, z in frames.TO]
    yield points("name_last", "x_mm,y_mm,z_mm,name\n" + "".join(f"{x},{y},{z},{n}\n" for x, y, z, n in swapped), [0], ".csv")
    yield points("table_of_tabs", frames.csv(frames.TO, separator="\t"), [0], ".tsv")
    yield points("table_of_blanks", frames.csv(frames.TO, separator=" "), [0], ".txt")
    document = json.loads(frames.markups(frames.TO, "RAS"))
    document["markups"][0]["coordinateSystem"] = "0"
    yield points("markups_system_as_number", json.dumps(document), [0, 3], ".mrk.json")

    def surface(name, data, ending, exits=(0,), **more):
        path = w / f"ordinary_{name}{ending}"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return {**shapes.case("surfaces", name, path, list(exits), **more), "name": "ordinary_" + name}
    nodes, _ = indexed(shapes.BOX)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    corners = [tuple((20, 15, 10)[d] * (1 if n >> d & 1 else -1) for d in range(3)) for n in range(8)]
    vertices = "".join("v %g %g %g\n" % c for c in corners)
    yield surface("obj_quads", vertices + "".join("f " + " ".join(str(n + 1) for n in q) + "\n" for q in quads), ".obj")
    yield surface("obj_colours", "".join("v %g %g %g 0.5 0.5 0.5\n" % c for c in corners) + "".join(
        "f " + " ".join(f"{n + 1}//1" for n in q) + "\n" for q in quads), ".obj")
    yield surface("obj_continued_line", vertices + "".join(
        "f %d %d \\\n%d %d\n" % tuple(n + 1 for n in q) for q in quads), ".obj", (0, 3))
    text = f"ply\nformat ascii 1.0\nelement vertex 8\n" + "".join(f"property double {c}\n" for c in "xyz")
    yield surface("ply_doubles_and_quads", text + "element face 6\nproperty list uchar uint vertex_index\nend_header\n" + "".join(
        "%g %g %g\n" % c for c in corners) + "".join("4 %d %d %d %d\n" % q for q in quads), ".ply")
    yield surface("stl_tabs", shapes.ascii_stl(shapes.BOX).replace("      vertex", "\t\tvertex"), ".stl")
    yield surface("off", "OFF\n8 6 0\n" + "".join("%g %g %g\n" % c for c in corners), ".off", (3,), says=["must be .stl"])
    offsets = "".join(f"{4 * n} " for n in range(7))
    yield surface("vtk_5_1", "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n" + "".join(
        "%g %g %g\n" % c for c in corners) + f"POLYGONS 7 24\nOFFSETS vtktypeint64\n{offsets}\nCONNECTIVITY vtktypeint64\n" +
        " ".join(str(n) for q in quads for n in q) + "\n", ".vtk")


# Each of another kind that was once taken for something else; the others differ little from these.
ALWAYS = ("other_frame", "roi_of_mr", "seg_other_frame", "itk_snap", "itk_snap_broken", "slicer_csv", "nnu_net_regions",
          "nnu_net_mapping", "mitk_vector")


def cases(w):
    for make in (frame_cases, name_cases, volume_cases, dicom_cases, other_cases):
        for case in make(w):
            yield {**case, "always": case["name"].removeprefix("ordinary_") in ALWAYS}
