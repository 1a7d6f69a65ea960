"""Variants of label maps, DICOM segmentations and structure sets (RTSTRUCT), on the patient of formats.py."""
import math
import struct

from formats import *

# A liver of 40 x 50 mm in the plane, seen in the slices at z of 64 to 112.
CENTRE, RADII, PLANES = (50.0, -20.0), (40.0, 50.0), [64.0, 76.0, 88.0, 100.0, 112.0]


def in_liver(x, y, z, hole=0.0):
    share = ((x - CENTRE[0]) / RADII[0]) ** 2 + ((y - CENTRE[1]) / RADII[1]) ** 2
    return 1 if hole ** 2 < share <= 1 and PLANES[0] - 6 < z < PLANES[-1] + 6 else 0


def liver_value(x, y, z):
    return in_liver(x, y, z)


def ring_value(x, y, z):
    return in_liver(x, y, z, 0.5)


def right(value):
    places = [place((n % SIZE[0], n // SIZE[0] % SIZE[1], n // (SIZE[0] * SIZE[1])))
              for n, v in enumerate(voxels(IDENTITY, value)) if v]
    ml = len(places) * SPACING[0] * SPACING[1] * SPACING[2] / 1000
    return [["liver: ([0-9.]+) ml", ml, 0.03 * ml]] + [
        [f"ml at .*{d} (-?[0-9.]+)", sum(p[n] for p in places) / len(places), 1.5] for n, d in enumerate("xyz")]


LIVER, RING = right(liver_value), right(ring_value)


def imported(kind, name, path, exits=(0,), values=LIVER, **more):
    return {"kind": kind, "name": name, "exit": list(exits), "values": values, "measure": ("label", "out", "liver"),
            "command": f"acus-segment $CT --import '{path}' --accept-implausible -o out", **more}


def ellipse(z, share=1.0, points=90, reverse=False):
    angles = [2 * math.pi * n / points for n in range(points)]
    return [(CENTRE[0] + share * RADII[0] * math.cos(a), CENTRE[1] + share * RADII[1] * math.sin(a), z)
            for a in (angles[::-1] if reverse else angles)]


def keyhole(z):
    outer, inner = ellipse(z), ellipse(z, 0.5, reverse=True)
    return outer + outer[:1] + inner + inner[:1]


def structure_set(path, rois, implicit=False, undefined=False, observations=True, syntax=None, frame=None, series=None,
                  roi_frames=()):
    """@param frame, series  What it was drawn on (Referenced Frame of Reference Sequence)."""
    new = lambda: Dicom(implicit)
    names, contours, seen = [], [], []
    for n, (name, kind, loops) in enumerate(rois):
        names.append(new().add(0x3006, 0x22, "IS", str(n + 3)))
        if n < len(roi_frames):
            names[-1].add(0x3006, 0x24, "UI", roi_frames[n])
        names[-1].add(0x3006, 0x26, "LO", name)
        items = []
        for loop in loops:
            geometry = "POINT" if len(loop) == 1 else "CLOSED_PLANAR"
            items.append(new().add(0x3006, 0x42, "CS", geometry).add(0x3006, 0x46, "IS", str(len(loop)))
                         .add(0x3006, 0x50, "DS", "\\".join(f"{c:.2f}" for p in loop for c in p)))
        contours.append(new().sequence(0x3006, 0x40, items, undefined).add(0x3006, 0x84, "IS", str(n + 3)))
        seen.append(new().add(0x3006, 0x82, "IS", "1").add(0x3006, 0x84, "IS", str(n + 3)).add(0x3006, 0xA4, "CS", kind))
    data = new().add(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.481.3").add(8, 0x60, "CS", "RTSTRUCT")
    if frame:
        of_series = new().add(0x20, 0xE, "UI", series or "")
        study = new().sequence(0x3006, 0x14, [of_series], undefined)
        data.sequence(0x3006, 0x10, [new().add(0x20, 0x52, "UI", frame).sequence(0x3006, 0x12, [study], undefined)], undefined)
    data.sequence(0x3006, 0x20, names, undefined).sequence(0x3006, 0x39, contours, undefined)
    if observations:
        data.sequence(0x3006, 0x80, seen, undefined)
    write_dicom(path, data, syntax or ("1.2.840.10008.1.2" if implicit else "1.2.840.10008.1.2.1"))


def structure_cases(w):
    def of(name, rois, exits=(0,), values=LIVER, options=None, **more):
        path = w / f"rs_{name}.dcm"
        structure_set(path, rois, **(options or {}))
        return imported("structures", "rtstruct_" + name, path, exits, values, **more)
    loops = [ellipse(z) for z in PLANES]
    holes = [ellipse(z, 0.5) for z in PLANES]
    liver = [("Liver", "ORGAN", loops)]
    yield of("plain", liver)
    yield of("implicit", liver, options={"implicit": True})
    yield of("undefined_lengths", liver, options={"undefined": True})
    yield of("implicit_undefined", liver, options={"implicit": True, "undefined": True})
    yield of("deflated", liver, options={"syntax": "1.2.840.10008.1.2.1.99"})
    yield of("without_observations", liver, options={"observations": False})
    yield of("lower_case", [("liver", "ORGAN", loops)])
    yield of("from_below", [("Liver", "ORGAN", loops[::-1])])
    yield of("clockwise", [("Liver", "ORGAN", [loop[::-1] for loop in loops])])
    yield of("closed_twice", [("Liver", "ORGAN", [loop + loop[:1] for loop in loops])])
    yield of("hole", [("Liver", "ORGAN", loops + holes)], values=RING)
    yield of("hole_first", [("Liver", "ORGAN", holes + loops)], values=RING)
    yield of("keyhole", [("Liver", "ORGAN", [keyhole(z) for z in PLANES])], values=RING)
    yield of("copies", [("Liver", "ORGAN", loops + loops)])
    yield of("every_second_plane", [("Liver", "ORGAN", loops[::2])], values=[
        ["liver: ([0-9.]+) ml", LIVER[0][1] * 6 / 5, 0.05 * LIVER[0][1]]])
    yield of("targets_beside", liver + [("PTV 60", "PTV", loops), ("Couch", "SUPPORT", loops), ("Iso", "ISOCENTER", [
        [(0, 0, 88)]])], says=["PTV 60", "Couch"])
    yield of("unknown_name", [("LiverJD2", "ORGAN", loops)], (3,), says=["LiverJD2"])
    yield of("only_points", [("Liver", "ORGAN", [[(0, 0, 88)]])], (3,))
    yield of("no_contours", [("Liver", "ORGAN", [])], (3,))
    yield of("elsewhere", [("Liver", "ORGAN", [[(x + 900, y, z) for x, y, z in loop] for loop in loops])], (3,))
    yield of("slanted", [("Liver", "ORGAN", [[(x, y, z + 0.2 * x) for x, y, z in loop] for loop in loops])], (3,))
    yield of("partly_outside", [("Liver", "ORGAN", loops + [ellipse(500.0)])])
    path = w / "rs_odd.dcm"
    structure_set(path, [("Liver", "ORGAN", [loops[0][:-1] + [(1.0, 2.0, 64.0)], loops[1]])])
    path.write_bytes(path.read_bytes().replace(b"\\64.00\\", b"\\ab.cd\\", 1))
    yield imported("structures", "rtstruct_text_in_points", path, (3,))
    path = w / "rs_cut.dcm"
    structure_set(path, liver)
    path.write_bytes(path.read_bytes()[:-900])
    yield imported("structures", "rtstruct_cut_off", path, (3,), may_be_cut=True)


def code(value, scheme="SCT", meaning="x", implicit=False):
    return Dicom(implicit).add(8, 0x100, "SH", value).add(8, 0x102, "SH", scheme).add(8, 0x104, "LO", meaning)


def segmentation(path, frames, kind="BINARY", bits=1, label="Liver", sct="10200004", compress=None, syntax=None,
                 undefined=False, largest=255, value=liver_value, frame=None, series=None):
    data = Dicom().add(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.4").add(8, 0x60, "CS", "SEG")
    if series:
        data.sequence(8, 0x1115, [Dicom().add(0x20, 0xE, "UI", series)], undefined)
    if frame:
        data.add(0x20, 0x52, "UI", frame)
    data.add(0x28, 2, "US", 1).add(0x28, 4, "CS", "MONOCHROME2").add(0x28, 8, "IS", str(len(frames)))
    data.add(0x28, 0x10, "US", SIZE[1]).add(0x28, 0x11, "US", SIZE[0]).add(0x28, 0x100, "US", bits)
    data.add(0x28, 0x101, "US", bits).add(0x28, 0x102, "US", bits - 1).add(0x28, 0x103, "US", 0)
    data.add(0x62, 1, "CS", kind)
    item = Dicom().sequence(0x62, 3, [code("123037004")], undefined).add(0x62, 4, "US", 1).add(0x62, 5, "LO", label)
    item.sequence(0x62, 0xF, [code(sct)], undefined)
    data.sequence(0x62, 2, [item], undefined)
    if kind == "FRACTIONAL":
        data.add(0x62, 0xE, "US", largest)
    shared = Dicom().sequence(0x20, 0x9116, [Dicom().add(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")], undefined)
    shared.sequence(0x28, 0x9110, [Dicom().add(0x18, 0x50, "DS", "12").add(0x28, 0x30, "DS", "9\\9")], undefined)
    data.sequence(0x5200, 0x9229, [shared], undefined)
    per = [Dicom().sequence(0x20, 0x9113, [Dicom().add(0x20, 0x32, "DS", ds(place((0, 0, k))))], undefined)
           .sequence(0x62, 0xA, [Dicom().add(0x62, 0xB, "US", 1)], undefined) for k in frames]
    data.sequence(0x5200, 0x9230, per, undefined)
    count = SIZE[0] * SIZE[1]
    planes = [voxels(IDENTITY, value)[k * count:(k + 1) * count] for k in frames]
    if bits == 1:
        whole = [v for plane in planes for v in plane]
        whole += [0] * (-len(whole) % 8)
        pixels = bytes(sum(whole[at + b] << b for b in range(8)) for at in range(0, len(whole), 8))
        data.add(0x7FE0, 0x10, "OB", pixels)
    else:
        full = largest if kind == "FRACTIONAL" else 1
        raw = [bytes(full * v for v in plane) for plane in planes]
        data.encapsulated([compress(r) for r in raw]) if compress else data.add(0x7FE0, 0x10, "OB", b"".join(raw))
    write_dicom(path, data, syntax or "1.2.840.10008.1.2.1")


def rle8(raw):
    out = b""
    for at in range(0, len(raw), 100):
        part = raw[at:at + 100]
        out += bytes([257 - len(part), part[0]]) if len(set(part)) == 1 and len(part) > 1 else \
            bytes([len(part) - 1]) + part
    return struct.pack("<16I", 1, 64, *([0] * 14)) + out


def segmentation_cases(w):
    def of(name, frames=range(2, 7), exits=(0,), **options):
        path = w / f"seg_{name}.dcm"
        segmentation(path, list(frames), **options)
        return imported("structures", "seg_" + name, path, exits)
    yield of("plain")
    yield of("all_planes", range(SIZE[2]))
    yield of("from_above", range(6, 1, -1))
    yield of("shuffled", (4, 2, 6, 3, 5))
    yield of("undefined_lengths", undefined=True)
    yield of("deflated", syntax="1.2.840.10008.1.2.1.99")
    yield of("fractional", kind="FRACTIONAL", bits=8)
    yield of("fractional_of_100", kind="FRACTIONAL", bits=8, largest=100)
    yield of("fractional_rle", kind="FRACTIONAL", bits=8, compress=rle8, syntax="1.2.840.10008.1.2.5")
    yield of("label_map", kind="LABELMAP", bits=8)
    yield of("label_map_rle", kind="LABELMAP", bits=8, compress=rle8, syntax="1.2.840.10008.1.2.5")
    yield of("named_by_code_alone", label="Segment 1")
    yield of("named_by_text_alone", sct="000000")


def map_cases(w):
    def of(name, exits=(0,), ending=".nii.gz", values=LIVER, value=liver_value, **options):
        path = w / (name + ending)
        (nrrd if "nrrd" in ending else nifti)(path, value=value, **options)
        return imported("labels", "labels_" + name, path, exits, values)
    twice = lambda factor: lambda x, y, z: factor * in_liver(x, y, z)
    yield of("liver", code="B")
    yield of("Liver-label", code="B", ending=".nrrd")
    yield of("case12_liver_mask", code="B")
    yield of("liver_255", code="B", value=twice(255))
    yield of("mask", (3,), code="B")
    yield of("heart_or_liver", (3, 0), code="B")
    yield of("liver_of_seven", (3,), code="B", value=twice(7))
    yield of("liver_float", code="f")
    yield of("liver_double", code="d", value=twice(1.0))
    yield of("liver_float_rounded", code="f", value=twice(1.0004))
    yield of("liver_of_halves", (3,), code="f", value=twice(0.5))
    yield of("liver_negative", (3,), code="h", value=twice(-1))
    yield of("liver_ras", code="B", axes=((-1, 0, 0), (0, -1, 0), (0, 0, 1)))
    yield of("liver_sagittal", code="B", axes=((0, 1, 0), (0, 0, 1), (1, 0, 0)))
    yield of("liver_empty", (3,), code="B", value=lambda x, y, z: 0)
    yield of("liver_elsewhere", (3,), code="B", offset_mm=(900, 0, 0))
    yield of("total", (3,), code="B", value=twice(5))
    yield of("liver_scaled", code="B", slope=0.5)
    yield of("liver_of_version_2", code="B", version=2)
    yield of("liver_big_endian", code="h", endian=">")
    folder = w / "masks"
    folder.mkdir()
    nifti(folder / "liver.nii.gz", code="B", value=liver_value)
    nifti(folder / "spleen.nii.gz", code="B", value=lambda x, y, z: 1 if (x + 60) ** 2 + y ** 2 + (z - 90) ** 2 < 400 else 0)
    yield imported("labels", "labels_folder", folder)
