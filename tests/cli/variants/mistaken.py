"""Variants that were once read wrongly, refused, or blamed for something else. All are run, also with --every."""
import json
import struct

from formats import *
import frames
import images
import labels
import tables


def always(cases):
    return ({**case, "always": True} for case in cases)


def patched(path, offset, form, *values):
    whole = bytearray(path.read_bytes())
    struct.pack_into(form, whole, offset, *values)
    path.write_bytes(whole)


def volume_cases(w):
    def of(name, make, *says, patch=None, sidecar=None, **options):
        path = w / f"mistaken_{name}.nii"
        nifti(path, **options)
        if patch:
            patched(path, *patch)
        if sidecar:
            path.with_suffix(".json").write_text(json.dumps(sidecar))
        case = make("volumes", "mistaken_" + name, images.SEGMENT.format(path))
        return {**case, "says": list(says)}
    lengths = [*SPACING]
    origin = [-ORIGIN[0], -ORIGIN[1], ORIGIN[2]]
    for name, units, factor in (("metres", 1, 1e-3), ("micrometres", 3, 1e3)):
        rows = [-factor * SPACING[0], 0, 0, factor * origin[0], 0, -factor * SPACING[1], 0, factor * origin[1],
                0, 0, factor * SPACING[2], factor * origin[2]]
        case = of(name, images.good, f"lengths are in {'m' if units == 1 else 'um'}", units=units,
                  patch=(80, "<3f", *(factor * c for c in lengths)))
        patched(w / f"mistaken_{name}.nii", 280, "<12f", *rows)
        yield case
    yield of("lone_intercept", images.good, "does not count", patch=(112, "<2f", 0.0, -1024.0))
    yield of("negative_pixdim", images.good, patch=(80, "<3f", *(-c for c in lengths)))
    yield of("other_pixdim", images.refused, "pixdim has voxels of", patch=(80, "<3f", 1.0, 1.0, 1.0))
    yield of("normalised", images.refused, "not in Hounsfield units", code="f", data=[(v + 1000) / 2000 for v in voxels()])
    yield of("attenuation", images.refused, "not in Hounsfield units", code="f",
             data=[0.02 * (v + 1000) / 1000 for v in voxels()])
    yield of("sidecar_of_ct", images.good, sidecar={"Modality": "CT", "Units": "HU", "SeriesNumber": 3})
    yield of("sidecar_of_mr", images.refused, "Modality in mistaken_sidecar_of_mr.json is MR", sidecar={"Modality": "MR"})
    yield of("sidecar_with_other_units", images.refused, "'1/cm'", sidecar={"Units": "1/cm"})
    yield of("sidecar_that_is_none", images.good, sidecar=["no", "object"])


def dicom_cases(w):
    folder = w / "mistaken_enhanced"
    images.enhanced(folder / "ct.dcm")
    yield images.good("dicom", "mistaken_enhanced_file", images.SEGMENT.format(folder / "ct.dcm"))
    path = w / "mistaken_dose.dcm"
    write_dicom(path, Dicom().add(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.481.2").add(8, 0x60, "CS", "RTDOSE"))
    yield images.refused("dicom", "mistaken_dose_file", images.SEGMENT.format(path), "of the kind RTDOSE")
    folder = w / "mistaken_high_bit"
    ct_series(folder)
    for file in folder.iterdir():  # 12 bits in the upper bits of 16.
        whole = file.read_bytes()
        at = whole.index(struct.pack("<HH", 0x7FE0, 0x10)) + 12
        count = (len(whole) - at) // 2
        pixels = packed([v << 4 & 0xFFFF for v in struct.unpack(f"<{count}H", whole[at:])], "H")
        high = struct.pack("<HH2sHH", 0x28, 0x102, b"US", 2, 11)
        file.write_bytes(whole[:at].replace(high, high[:-2] + struct.pack("<H", 15)) + pixels)
    yield images.good("dicom", "mistaken_high_bit", images.SEGMENT.format(folder))
    breathe = "acus-breathing {} --resolution 16 --spacing-mm 10 --no-sliding -o out"

    def phases(name, of_part, *says, exits=(0,), descriptions=None):
        folder = w / f"mistaken_{name}"
        for part in range(5):
            value = hu_at if part == 0 else images.LOWERED[part - 1]
            count = SIZE[0] * SIZE[1]
            ct_series(folder, name=f"p{part}_{{}}.dcm",
                      series=f"1.2.826.{part}" if descriptions else "1.2.826.1",
                      of_slice=lambda k: {"extra": of_part(part), "number": part + 1,
                                          "values": voxels(IDENTITY, value)[k * count:(k + 1) * count]})
        if descriptions and len(descriptions) > 5:
            ct_series(folder, name="other_{}.dcm", series="1.2.826.9", extra=((8, 0x103E, "LO", descriptions[5]),))
        return {"kind": "dicom", "name": "mistaken_" + name, "exit": list(exits), "says": list(says),
                "command": breathe.format(folder)}
    yield phases("split_by_trigger", lambda p: ((0x18, 0x1060, "DS", str(800 * p)),), "split by trigger time")
    yield phases("split_by_acquisition_time", lambda p: ((8, 0x32, "TM", f"1200{p:02d}.500"),), "split by acquisition time")
    yield phases("split_by_percentage", lambda p: ((0x20, 0x9241, "FL", struct.pack("<f", 20.0 * p)),),
                 "split by percentage")
    named = [f"{20 * p},0 %" for p in range(5)]
    yield phases("decimal_comma", lambda p: ((8, 0x103E, "LO", named[p]),), "^surrogate ", descriptions=named)
    yield phases("planning_ct", lambda p: ((8, 0x103E, "LO", named[p]),), "omitted: Planning CT 3 mm",
                 descriptions=[*named, "Planning CT 3 mm"])


def label_cases(w):
    def of(name, exits=(0,), value=labels.liver_value, tsv=None, folder=None, **more):
        path = (folder or w) / f"{name}.nii.gz"
        nifti(path, code="B", value=value)
        if tsv:
            path.with_name(name + ".tsv").write_text(tsv)
        return labels.imported("labels", "mistaken_" + name, path, exits, **more)
    yield of("liver_kidney_left", (3,), says=["Which structure is it"])
    yield of("LiverMask")
    three = lambda x, y, z: 3 * labels.in_liver(x, y, z)
    yield of("sub-01_dseg", value=three, tsv="index\tname\tcolor\n0\tBackground\t#000000\n3\tLiver\t#ff0000\n",
             says=["by sub-01_dseg.tsv"])
    yield of("sub-02_dseg", (3,), value=three, tsv="index\tname\n3\tliver\n3\tspleen\n", says=["one name"])
    folder = w / "mistaken_bids"
    folder.mkdir()
    (folder / "dseg.tsv").write_text("index\tname\n3\tliver\n")
    yield of("sub-03_dseg", value=three, folder=folder, says=["by dseg.tsv"])
    folder = w / "mistaken_masks"
    folder.mkdir()
    nifti(folder / "liver.nii.gz", code="B", value=labels.liver_value)
    (folder / "._liver.nii.gz").write_bytes(b"\0\5\x16\7")  # macOS leaves such files in archives.
    yield labels.imported("labels", "mistaken_hidden_file", folder)

    def rois(name, roi, exits=(0,), change=None, values=labels.LIVER, **more):
        path = w / f"mistaken_{name}.dcm"
        labels.structure_set(path, roi)
        if change:
            path.write_bytes(change(path.read_bytes()))
        return labels.imported("structures", "mistaken_" + name, path, exits, values, **more)
    loops = [labels.ellipse(z) for z in labels.PLANES]
    for name in ("Kidney_L", "Lt Kidney", "KidneyLeft"):
        yield {**rois(name.replace(" ", "_"), [(name, "ORGAN", loops)]), "measure": ("label", "out", "kidney"),
               "values": [[pattern.replace("liver", "kidney"), *rest] for pattern, *rest in labels.LIVER]}
    yield rois("Liver_L", [("Liver_L", "ORGAN", loops)], (3,), says=["no structures"])
    yield rois("missing_planes", [("Liver", "ORGAN", [loops[0], loops[1], loops[4]])],
               values=[["liver: ([0-9.]+) ml", labels.LIVER[0][1] * 3 / 5, 0.03 * labels.LIVER[0][1]]])
    count = struct.pack("<HH2sH", 0x3006, 0x46, b"IS", 2)
    yield rois("other_number_of_points", [("Liver", "ORGAN", loops)], (3,),
               lambda whole: whole.replace(count + b"90", count + b"70", 1), says=["states 70 points and holds 90"])


def table_cases(w):
    plain = tables.table()
    blanks = plain.replace(",", " ")
    slow = tables.table(names=("time_s", "depth_mm", "force_n"), factors=(1000, 1, 1))
    push = [(t, d, -f) for t, d, f in tables.curve()]
    gram = 1000 / 9.80665
    yield from tables.cases_of(w, "mistaken", [
        ("names_in_comment", "# needle 18 G\n# " + blanks, [0]),
        ("names_in_comment_with_commas", "# " + plain.split("\n", 1)[0] + "\n" + blanks.split("\n", 1)[1], [0]),
        ("no_names", plain.split("\n", 1)[1], [3], {"says": ["begins with numbers"]}),
        ("ms_said_s", slow, [3], {"says": ["probably in ms"]}),
        ("ms_as_it_is", slow, [0], {}, "--as-it-is"),
        ("compression_negative", tables.table(rows=push), [4], {"says": ["sign"]}),
        ("gram_force", tables.table(names=("time_s", "depth_mm", "Force (gf)"), factors=(1, 1, gram)), [0]),
        ("pound_force", tables.table(names=("time_s", "depth_mm", "Force [lbf]"), factors=(1, 1, 1 / 4.4482216),
                                     form="{:.9f}"), [0]),
    ])


def frame_cases(w):
    source = w / "mistaken_from.csv"
    source.write_text(frames.csv(frames.POINTS))

    def points(name, text, ending=".csv", exits=(0,), **more):
        path = w / f"mistaken_{name}{ending}"
        path.write_text(text)
        return {"kind": "landmarks", "name": "mistaken_" + name, "exit": list(exits), "values": frames.VALUES,
                "command": f"acus-register --from {source} --to '{path}' -o out",
                "measure": ("transform", "out/ct_from_reference.tfm"), **more}
    yield points("names_in_lower_case", frames.csv([(n.lower(), *p) for n, *p in frames.TO[::-1]]))
    yield points("names_of_columns_in_comment", "# " + frames.csv(frames.TO))
    ras = [(n, -x, -y, z) for n, x, y, z in frames.TO]
    rows = frames.fcsv(ras).split("\n")
    yield points("fcsv_without_system", "\n".join(rows[:1] + rows[2:]), ".fcsv", says=["no CoordinateSystem"])
    document = json.loads(frames.markups(frames.TO))
    document["markups"][0].pop("coordinateSystem")
    yield points("markups_without_system", json.dumps(document), ".mrk.json", says=["no coordinateSystem"])
    yield points("fcsv_of_old_columns", "# Fiducial List file\n# columns = label,x,y,z,sel,vis\n" + "".join(
        f"{n},{x},{y},{z},1,1\n" for n, x, y, z in ras), ".fcsv", (3,), says=["label,x,y,z,sel,vis"])

    def transform(name, text, ending, exits, *says):
        path = w / f"mistaken_{name}{ending}"
        path.write_text(text)
        return {"kind": "transforms", "name": "mistaken_" + name, "exit": exits, "says": list(says),
                "command": "acus-replay $SCENARIO $SESSION --ct $PATIENT/ct.nrrd --labels $PATIENT/labels.seg.nrrd "
                           f"--transform '{path}' --check"}
    matrix = "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"
    yield transform("matrix_with_comment", "# ct_from_reference\n" + matrix, ".txt", [0])
    yield transform("matrix_with_decimal_commas", matrix.replace(" 1\n", "\t1,5\n").replace(" ", "\t"), ".txt", [3],
                    "decimal commas")
    yield transform("elastix", '(Transform "EulerTransform")\n(TransformParameters 0 0 0.1 1 2 3)\n', ".txt", [3],
                    "no transform that is read")
    path = w / "mistaken_one_time.csv"
    path.write_text(frames.poses(step=0.0))
    mapping = frames.columns(w, "mistaken_mm.json", "mm")
    yield {"kind": "trackers", "name": "mistaken_one_time", "exit": [3], "says": ["all rows have one time"],
           "command": f"acus-import '{path}' --columns {mapping} -o out"}


def cases(w):
    for make in (volume_cases, dicom_cases, label_cases, table_cases, frame_cases):
        yield from always(make(w))
