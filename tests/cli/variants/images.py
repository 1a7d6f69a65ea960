"""Variants of volumes, DICOM series, label maps and structure sets."""
import math
import struct

from formats import *

FLIPS = {"ras": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)), "lps": IDENTITY, "las": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
         "rai": ((-1, 0, 0), (0, 1, 0), (0, 0, -1)), "sagittal": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
         "coronal": ((1, 0, 0), (0, 0, -1), (0, 1, 0)), "mirrored": ((-1, 0, 0), (0, 1, 0), (0, 0, 1))}
SEGMENT = "acus-segment '{}' -o out"
RIGHT = [["^Body ([0-9]+) ml", BODY_ML, 0.002 * BODY_ML]] + [
    [f" {d} (-?[0-9.]+)", c, 0.3] for d, c in zip("xyz", BODY_CENTRE)]


# Phases of a breath: the trunk below the shoulders moves forwards.
LOWERED = [lambda x, y, z, d=d: hu_at(x, y + (d if z < 100 else 0), z) for d in (2.0, 6.0, 6.0, 2.0)]


def good(kind, name, command, **more):
    return {"kind": kind, "name": name, "command": command, "exit": [0], "values": RIGHT,
            "measure": ("body", "out"), **more}


def refused(kind, name, command, *says, **more):
    return {"kind": kind, "name": name, "command": command, "exit": [3], "says": list(says), **more}


def either(kind, name, command, **more):
    """Read rightly or refused: nothing else."""
    return {**good(kind, name, command, **more), "exit": [0, 3]}


def nifti_cases(w):
    def case(name, make, ending=".nii", **options):
        path = w / (name + ending)
        nifti(path, **options)
        return make("volumes", "nifti_" + name, SEGMENT.format(path))
    for name, axes in FLIPS.items():
        yield case(name, good, axes=axes)
    yield case("gz", good, ".nii.gz")
    yield case("big_endian", good, endian=">", axes=FLIPS["las"])
    yield case("float", good, code="f")
    yield case("double_gz", good, ".nii.gz", code="d")
    yield case("int32", good, code="i")
    yield case("unsigned_with_intercept", good, code="H", inter=-1024.0)
    yield case("slope_of_two", good, slope=2.0, inter=-1000.0)
    yield case("slope_of_zero", good, slope=1.0, data=[int(v) for v in voxels()])
    yield case("qform_only", good, sform=0, qform=1, axes=FLIPS["ras"])
    yield case("qform_only_mirrored", good, sform=0, qform=1, axes=FLIPS["las"])
    yield case("both_forms", good, sform=1, qform=1, axes=FLIPS["rai"])
    yield case("extension", good, extension=struct.pack("<ii", 32, 6) + b"a comment".ljust(24, b"\0"))
    yield case("four_d_of_one", good, dims=[4, *SIZE, 1, 1, 1, 1])
    yield case("version_2", good, version=2)
    yield case("version_2_gz", good, ".nii.gz", version=2, axes=FLIPS["ras"])
    yield case("version_2_big_endian", good, version=2, endian=">")
    yield case("sheared_by_a_quarter_degree", good, shear=0.004)
    yield case("sheared_by_three_degrees", refused, shear=0.05)
    yield case("spacings_differ", refused, sform=1, qform=1, q_spacing=(6.0, 6.0, 4.0))
    yield case("upper_case", good, ".NII")
    yield case("name with blanks", good)
    path = w / "phases.nii.gz"
    nifti(path, volumes=[[v // 2 for v in voxels()], voxels()], code="h")
    yield refused("volumes", "nifti_4d", SEGMENT.format(path), "3 volumes over time")
    yield good("volumes", "nifti_4d_chosen", SEGMENT.format(path).replace(" -o", " --series 3 -o"))
    breathe = "acus-breathing {} --resolution 16 --spacing-mm 10 --no-sliding -o out"
    yield refused("volumes", "nifti_4d_of_three_phases", breathe.format(path), "at least 4")
    path = w / "five_phases.nii"
    nifti(path, volumes=[voxels(IDENTITY, lower) for lower in LOWERED], data=voxels())
    yield {"kind": "volumes", "name": "nifti_4d_phases", "exit": [0], "command": breathe.format(path),
           "says": ["^surrogate "]}
    path = w / "cut.nii"
    nifti(path)
    path.write_bytes(path.read_bytes()[:-1000])
    yield refused("volumes", "nifti_cut_off", SEGMENT.format(path), may_be_cut=True)
    path = w / "not_hu.nii"
    nifti(path, code="H", data=[v + 1024 for v in voxels()])
    yield refused("volumes", "nifti_not_hounsfield", SEGMENT.format(path), "1024")
    path = w / "metres.nii"
    nifti(path, units=1)
    yield either("units", "nifti_says_metres", SEGMENT.format(path))


def nrrd_cases(w):
    def case(name, make, ending=".nrrd", **options):
        path = w / (name + ending)
        nrrd(path, **options)
        return make("volumes" if "units" not in name else "units", "nrrd_" + name, SEGMENT.format(path))
    for name in ("ras", "sagittal", "coronal", "mirrored"):
        yield case(name, good, axes=FLIPS[name])
    for space in ("RAS", "right-anterior-superior", "LAS", "LPS"):
        yield case("space_" + space, good, space=space)
    for encoding in ("gzip", "ascii", "hex"):
        yield case(encoding, good, encoding=encoding)
    yield case("bzip2", either, encoding="bzip2")
    yield case("big_endian", good, endian=">")
    yield case("float", good, code="f")
    yield case("detached", good, ".nhdr", detached=True)
    yield case("kinds", good, extra="kinds: domain domain domain\nmodality:=CT\n")
    yield case("units_mm", good, extra='space units: "mm" "mm" "mm"\n')
    for unit, scale in (("m", 1e-3), ("cm", 0.1), ("um", 1e3)):
        yield case("units_" + unit, good, extra=f'space units: "{unit}" "{unit}" "{unit}"\n', scale=scale)
    yield case("units_none_in_metres", refused, scale=1e-3)
    yield case("units_mixed", refused, extra='space units: "mm" "mm" "m"\n')
    yield case("spacings_only", lambda *a: {**good(*a), "values": RIGHT[:1], "says": ["how the patient lies"]},
               spacings_only=True)


def meta_cases(w):
    def case(name, make, ending=".mha", **options):
        path = w / ("meta_" + name + ending)
        meta(path, **options)
        return make("volumes", "meta_" + name, SEGMENT.format(path))
    for name in ("ras", "sagittal", "mirrored"):
        yield case(name, good, axes=FLIPS[name])
    yield case("compressed", good, compressed=True)
    yield case("big_endian", good, endian=">")
    yield case("double", good, code="d")
    yield case("detached", good, ".mhd")
    yield case("orientation_word", good, extra="AnatomicalOrientation = RAI\nCenterOfRotation = 0 0 0\n")


def dicom_cases(w):
    def case(variant, make, *says, command=SEGMENT, **options):
        folder = w / ("dicom_" + variant)
        ct_series(folder, **options)
        return make("dicom", "dicom_" + variant, command.format(folder), *says)
    yield case("plain", good)
    yield case("implicit", good, implicit=True, syntax="1.2.840.10008.1.2")
    yield case("without_meta_header", good, meta_header=False)
    yield case("implicit_without_meta_header", good, implicit=True, meta_header=False)
    yield case("deflated", good, syntax="1.2.840.10008.1.2.1.99")
    yield case("without_ending", good, name="IM{}")
    yield case("big_endian_syntax", refused, "big-endian", syntax="1.2.840.10008.1.2.2")
    for name in ("sagittal", "coronal", "ras"):
        yield case("axes_" + name, good, axes=FLIPS[name])
    yield case("names_in_reverse", good, of_slice=lambda k: {"number": 100 - k})
    yield case("rescale_slope", good, slope=2.0, inter=-1000.0)
    yield case("signed", good, signed=1, inter=0.0, stored=16)
    yield case("signed_12_bits", good, signed=1, inter=0.0, stored=12)
    yield case("overlay_bits", good, high_bits=0xF000)
    yield case("rle", good, syntax="1.2.840.10008.1.2.5", compress=rle)
    yield case("monochrome1", either, photometric="MONOCHROME1")
    yield case("missing_slice", refused, skip=(6,))
    yield case("missing_three_slices", refused, skip=(6, 7, 8))
    yield case("missing_first_slice_only", lambda *a: {**good(*a), "values": [], "measure": None}, skip=(0,))
    yield case("without_spacing", refused, spacing="")
    yield case("mr", refused, "MR", modality="MR")
    yield case("two_slices", refused, count=2)
    yield case("rgb", refused, samples=3)
    yield case("32_bits", refused, bits=32)
    yield case("spacing_rounded", good,
               of_slice=lambda k: {"spacing": "9\\9" if k % 2 else "8.9999998\\9.0000001"})
    yield case("positions_rounded", good, of_slice=lambda k: {
        "position": tuple(round(c, 1) for c in place((0, 0, k)))})
    yield case("orientation_jitter", good, of_slice=lambda k: {
        "orientation": ds([1, 5e-4 * math.sin(k), 0, -5e-4 * math.sin(k), 1, 0])})
    yield case("thickness_differs_from_step", good, thickness="5")
    yield case("private_elements", good, extra=((9, 0x10, "LO", "VENDOR"), (9, 0x1001, "UN", b"\0" * 7)))
    yield case("padding_value", good, extra=((0x20, 0x4000, "LT", "comment of the image"),))
    folder = w / "dicom_copies"
    ct_series(folder)
    ct_series(folder / "again")
    yield good("dicom", "dicom_copies_in_subfolder", SEGMENT.format(folder))
    folder = w / "dicom_scout"
    ct_series(folder)
    ct_series(folder, count=1, name="scout.dcm", series="1.2.826.9", image_type="ORIGINAL\\PRIMARY\\LOCALIZER")
    (folder / "README.txt").write_text("exported\n")
    (folder / "DICOMDIR").write_bytes(b"\0" * 128 + b"DICM")
    yield good("dicom", "dicom_scout_and_other_files", SEGMENT.format(folder))
    folder = w / "dicom_two"
    ct_series(folder / "a", series="1.2.826.5")
    ct_series(folder / "b", series="1.2.826.6")
    yield refused("dicom", "dicom_two_series", SEGMENT.format(folder), "--series")
    yield good("dicom", "dicom_two_series_chosen", SEGMENT.format(folder).replace(" -o", " --series 826.6 -o"))
    yield {**good("dicom", "dicom_list", f"acus-segment {folder} --list-series"), "values": [], "measure": None,
           "says": [r"1\.2\.826\.5", r"1\.2\.826\.6"]}
    folder = w / "dicom_two_in_one"
    for part, scale in ((0, 1), (1, 1)):
        ct_series(folder, name=f"p{part}_{{}}.dcm", extra=((0x20, 0x12, "IS", str(part + 1)),),
                  of_slice=lambda k: {"number": 100 * part + k + 1})
    yield refused("dicom", "dicom_two_acquisitions_in_one_series", SEGMENT.format(folder), "--series")
    folder = w / "dicom_by_order"
    for part in range(2):
        ct_series(folder, name=f"p{part}_{{}}.dcm", of_slice=lambda k: {"number": 2 * k + part})
    yield refused("dicom", "dicom_two_volumes_by_order", SEGMENT.format(folder), "--series")
    folder = w / "dicom_cut"
    ct_series(folder)
    path = folder / "005.dcm"
    path.write_bytes(path.read_bytes()[:-300])
    yield refused("dicom", "dicom_cut_off", SEGMENT.format(folder), "005.dcm", may_be_cut=True)
    folder = w / "dicom_tilt"
    tilt = math.radians(12)
    ct_series(folder, of_slice=lambda k: {
        "orientation": ds([1, 0, 0, 0, math.cos(tilt), -math.sin(tilt)]), "position": place((0, 0, k))})
    yield {**good("dicom", "dicom_tilted", SEGMENT.format(folder)), "values": [], "measure": None, "says": ["tilted by 12"]}
    folder = w / "dicom_blocks"
    ct_series(folder, of_slice=lambda k: {"position": (ORIGIN[0], ORIGIN[1], 40.0 + (6 * k if k < 5 else 12 * k - 30))})
    yield refused("dicom", "dicom_blocks_of_two_steps", SEGMENT.format(folder), "--series", "block 2 of 2")
    yield {**good("dicom", "dicom_block_chosen", SEGMENT.format(folder).replace(" -o", " --series 'block 2' -o")),
           "values": [[" z (-?[0-9.]+)", 100, 19]]}
    folder = w / "empty"
    folder.mkdir()
    yield refused("dicom", "dicom_empty_folder", SEGMENT.format(folder), "no DICOM")
    yield from enhanced_cases(w)


def enhanced(path, order=None, shared_orientation=True, implicit=False, undefined=False):
    data = Dicom(implicit)
    order = order or list(range(SIZE[2]))
    data.add(8, 8, "CS", "ORIGINAL\\PRIMARY\\VOLUME\\NONE").add(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2.1")
    data.add(8, 0x18, "UI", "1.2.9").add(8, 0x60, "CS", "CT").add(0x20, 0xE, "UI", "1.2.8")
    data.add(0x28, 2, "US", 1).add(0x28, 4, "CS", "MONOCHROME2").add(0x28, 8, "IS", str(len(order)))
    data.add(0x28, 0x10, "US", SIZE[1]).add(0x28, 0x11, "US", SIZE[0])
    data.add(0x28, 0x100, "US", 16).add(0x28, 0x101, "US", 16).add(0x28, 0x102, "US", 15).add(0x28, 0x103, "US", 0)
    new = lambda: Dicom(implicit)
    orientation = lambda: new().sequence(0x20, 0x9116, [new().add(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")], undefined)
    group = new()
    if shared_orientation:
        group.bytes += orientation().bytes
    group.sequence(0x28, 0x9110, [new().add(0x18, 0x50, "DS", "12").add(0x28, 0x30, "DS", "9\\9")], undefined)
    group.sequence(0x28, 0x9145, [new().add(0x28, 0x1052, "DS", "-1024").add(0x28, 0x1053, "DS", "1")], undefined)
    data.sequence(0x5200, 0x9229, [group], undefined)
    frames = []
    for k in order:
        frame = new().sequence(0x20, 0x9113, [new().add(0x20, 0x32, "DS", ds(place((0, 0, k))))], undefined)
        if not shared_orientation:
            frame.bytes += orientation().bytes
        frames.append(frame)
    data.sequence(0x5200, 0x9230, frames, undefined)
    data.add(0x7FE0, 0x10, "OW", b"".join(packed([v + 1024 for v in slice_values(IDENTITY, k)], "H") for k in order))
    path.parent.mkdir()
    write_dicom(path, data, "1.2.840.10008.1.2" if implicit else "1.2.840.10008.1.2.1")


def enhanced_cases(w):
    for name, options in (("plain", {}), ("implicit", {"implicit": True}), ("undefined_lengths", {"undefined": True}),
                          ("frames_in_reverse", {"order": list(range(SIZE[2]))[::-1]}),
                          ("frames_shuffled", {"order": [(3 * k) % SIZE[2] for k in range(SIZE[2])]}),
                          ("orientation_per_frame", {"shared_orientation": False})):
        path = w / ("enhanced_" + name) / "ct.dcm"
        enhanced(path, **options)
        yield good("dicom", "enhanced_" + name, SEGMENT.format(path.parent))
