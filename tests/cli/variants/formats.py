"""Writers of the file formats that the variants are made of, after their descriptions alone."""
import gzip
import math
import struct
import zlib

# The patient of all volumes: a trunk of soft tissue with a rod of bone, off the middle of the grid and
# narrower towards the head, so that a wrong axis or sign moves its centre. LPS, mm.
SIZE = (32, 28, 10)
SPACING = (9.0, 9.0, 12.0)
ORIGIN = (-139.5, -121.5, 40.0)
BODY = (20.0, -14.0)      # Centre of the trunk, x and y.


def hu_at(x, y, z):
    narrow = 1.0 if z < 100 else 0.7
    if ((x - BODY[0]) / (110 * narrow)) ** 2 + ((y - BODY[1]) / (95 * narrow)) ** 2 > 1:
        return -1000
    if (x - BODY[0]) ** 2 + (y - BODY[1]) ** 2 < 24 ** 2:
        return 900
    return 40 + (round(x) + round(y)) % 7


def place(index, axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)), size=SIZE, spacing=SPACING, centre=None):
    """LPS of a voxel of a grid about the patient's middle, with axes along those given."""
    centre = centre or tuple(o + s * (n - 1) / 2 for o, s, n in zip(ORIGIN, SPACING, SIZE))
    return tuple(centre[d] + sum(axes[a][d] * spacing[a] * (index[a] - (size[a] - 1) / 2)
                                 for a in range(3)) for d in range(3))


IDENTITY = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def grid_of(axes):
    """Size and spacing along each axis, so that the same box is covered."""
    which = [max(range(3), key=lambda d: abs(axis[d])) for axis in axes]
    return tuple(SIZE[w] for w in which), tuple(SPACING[w] for w in which)


_voxels = {}


def voxels(axes=IDENTITY, value=hu_at):
    """Values in the order of the file, the first axis fastest."""
    key = (axes, value)
    if key not in _voxels:
        size, spacing = grid_of(axes)
        _voxels[key] = [value(*place((i, j, k), axes, size, spacing))
                        for k in range(size[2]) for j in range(size[1]) for i in range(size[0])]
    return _voxels[key]


def liver_at(x, y, z):
    return 1 if (x + 40) ** 2 + (y - 10) ** 2 < 45 ** 2 else 0


def packed(values, code, endian="<"):
    return struct.pack(f"{endian}{len(values)}{code}", *values)


NIFTI_TYPES = {"h": (4, 16), "f": (16, 32), "d": (64, 64), "B": (2, 8), "i": (8, 32), "H": (512, 16),
               "b": (256, 8), "q": (1024, 64)}


def quaternion(axes):
    """Of the right-handed rotation with these columns, and the factor of the third axis."""
    r = [list(a) for a in axes]
    cross = [r[0][1] * r[1][2] - r[0][2] * r[1][1], r[0][2] * r[1][0] - r[0][0] * r[1][2],
             r[0][0] * r[1][1] - r[0][1] * r[1][0]]
    factor = 1.0 if sum(c * t for c, t in zip(cross, r[2])) > 0 else -1.0
    r[2] = [factor * t for t in r[2]]
    m = [[r[c][row] for c in range(3)] for row in range(3)]
    candidates = [math.sqrt(max(0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2,
                  math.sqrt(max(0, 1 + m[0][0] - m[1][1] - m[2][2])) / 2,
                  math.sqrt(max(0, 1 - m[0][0] + m[1][1] - m[2][2])) / 2,
                  math.sqrt(max(0, 1 - m[0][0] - m[1][1] + m[2][2])) / 2]
    best = max(range(4), key=lambda i: candidates[i])
    f = 4 * candidates[best]
    q = {0: [f / 4, (m[2][1] - m[1][2]) / f, (m[0][2] - m[2][0]) / f, (m[1][0] - m[0][1]) / f],
         1: [(m[2][1] - m[1][2]) / f, f / 4, (m[0][1] + m[1][0]) / f, (m[0][2] + m[2][0]) / f],
         2: [(m[0][2] - m[2][0]) / f, (m[0][1] + m[1][0]) / f, f / 4, (m[1][2] + m[2][1]) / f],
         3: [(m[1][0] - m[0][1]) / f, (m[0][2] + m[2][0]) / f, (m[1][2] + m[2][1]) / f, f / 4]}[best]
    if q[0] < 0:
        q = [-v for v in q]
    return q, factor


def nifti(path, axes=IDENTITY, code="h", endian="<", version=1, sform=1, qform=0, slope=1.0, inter=0.0,
          extension=b"", volumes=(), data=None, value=hu_at, shear=0.0, q_axes=None, units=2, dims=None,
          offset_mm=(0, 0, 0), q_spacing=None):
    """NIfTI-1 or -2. Axes are LPS; the file says RAS."""
    size, spacing = grid_of(axes)
    origin = place((0, 0, 0), axes, size, spacing)
    ras = lambda v: (-v[0], -v[1], v[2])
    columns = [ras(a) for a in axes]
    columns = [tuple(c + (shear * columns[0][d] if n == 1 else 0) for d, c in enumerate(col))
               for n, col in enumerate(columns)]
    corner = [o + d for o, d in zip(ras(origin), offset_mm)]
    srow = [[columns[c][r] * spacing[c] for c in range(3)] + [corner[r]] for r in range(3)]
    q, factor = quaternion(tuple(ras(a) for a in (q_axes or axes)))
    values = data if data is not None else [round((v - inter) / slope) if code not in "fd" else
                                            (v - inter) / slope for v in voxels(axes, value)]
    body = packed(values, code, endian)
    for extra in volumes:
        body += packed(extra, code, endian)
    dim = dims or ([4, *size, 1 + len(volumes), 1, 1, 1] if volumes else [3, *size, 1, 1, 1, 1])
    pix = [factor, *(q_spacing or spacing), 1, 1, 1, 1]
    kind, bits = NIFTI_TYPES[code]
    begin = (352 if version == 1 else 544) + len(extension)
    if version == 1:
        head = struct.pack(endian + "i36x8h", 348, *dim)
        head += struct.pack(endian + "fffhhhh8ff", 0, 0, 0, 0, kind, bits, 0, *pix, begin)
        head += struct.pack(endian + "ffhBB", slope, inter, 0, 0, units)
        head += b"\0" * (252 - len(head))
        head += struct.pack(endian + "hh6f12f", qform, sform, *q[1:], *corner, *srow[0], *srow[1], *srow[2])
        head += b"\0" * (344 - len(head)) + b"n+1\0"
    else:
        head = struct.pack(endian + "i", 540) + b"n+2\0\r\n\x1a\n"
        head += struct.pack(endian + "hh8q3d8dq", kind, bits, *dim, 0, 0, 0, *pix, begin)
        head += struct.pack(endian + "dd4dqq", slope, inter, 0, 0, 0, 0, 0, 0)
        head += b"\0" * (344 - len(head))
        head += struct.pack(endian + "ii3d3d12d", qform, sform, *q[1:], *corner, *srow[0], *srow[1], *srow[2])
        head += struct.pack(endian + "iii", 0, units, 0)
        head += b"\0" * (540 - len(head))
    head += (b"\1\0\0\0" if extension else b"\0\0\0\0") + extension
    whole = head + body
    path.write_bytes(gzip.compress(whole, 1) if path.name.endswith(".gz") else whole)


NRRD_TYPES = {"h": "short", "f": "float", "d": "double", "B": "uchar", "i": "int", "H": "unsigned short"}


def nrrd(path, axes=IDENTITY, code="h", endian="<", encoding="raw", space="left-posterior-superior",
         extra="", value=hu_at, data=None, scale=1.0, detached=False, spacings_only=False):
    size, spacing = grid_of(axes)
    sign = {"left-posterior-superior": (1, 1, 1), "LPS": (1, 1, 1), "right-anterior-superior": (-1, -1, 1),
            "RAS": (-1, -1, 1), "left-anterior-superior": (1, -1, 1), "LAS": (1, -1, 1)}[space]
    origin = place((0, 0, 0), axes, size, spacing)
    text = lambda v: "(" + ",".join(repr(scale * s * c) for s, c in zip(sign, v)) + ")"
    raw = packed(data if data is not None else voxels(axes, value), code, endian)
    head = f"NRRD0005\n# a comment\ntype: {NRRD_TYPES[code]}\ndimension: 3\nsizes: {size[0]} {size[1]} {size[2]}\n"
    if spacings_only:
        head += "spacings: " + " ".join(repr(s) for s in spacing) + "\n"
    else:
        head += f"space: {space}\nspace directions: " + " ".join(
            text([c * s for c in a]) for a, s in zip(axes, spacing)) + "\nspace origin: " + text(origin) + "\n"
    head += f"endian: {'little' if endian == '<' else 'big'}\nencoding: {encoding}\n" + extra
    if encoding in ("gzip", "gz"):
        raw = gzip.compress(raw, 1)
    elif encoding in ("ascii", "text"):
        raw = " ".join(str(v) for v in voxels(axes, value)).encode()
    elif encoding == "hex":
        raw = raw.hex().encode()
    elif encoding == "bzip2":
        import bz2
        raw = bz2.compress(raw)
    if detached:
        path.write_text(head + "data file: " + path.stem + ".raw\n")
        (path.parent / (path.stem + ".raw")).write_bytes(raw)
    else:
        path.write_bytes(head.encode() + b"\n" + raw)


META_TYPES = {"h": "MET_SHORT", "f": "MET_FLOAT", "d": "MET_DOUBLE", "B": "MET_UCHAR", "i": "MET_INT",
              "H": "MET_USHORT"}


def meta(path, axes=IDENTITY, code="h", endian="<", compressed=False, extra="", value=hu_at):
    size, spacing = grid_of(axes)
    raw = packed(voxels(axes, value), code, endian)
    if compressed:
        raw = zlib.compress(raw)
    local = path.suffix == ".mha"
    head = ("ObjectType = Image\nNDims = 3\nBinaryData = True\n"
            f"BinaryDataByteOrderMSB = {endian == '>'}\nCompressedData = {compressed}\n")
    if compressed:
        head += f"CompressedDataSize = {len(raw)}\n"
    head += "TransformMatrix = " + " ".join(repr(float(c)) for a in axes for c in a) + "\n"
    head += "Offset = " + " ".join(repr(c) for c in place((0, 0, 0), axes, size, spacing)) + "\n" + extra
    head += "ElementSpacing = " + " ".join(map(repr, spacing)) + "\nDimSize = " + " ".join(map(str, size))
    data = "LOCAL" if local else path.stem + ".raw"
    head += f"\nElementType = {META_TYPES[code]}\nElementDataFile = {data}\n"
    path.write_bytes(head.encode() + (raw if local else b""))
    if not local:
        (path.parent / data).write_bytes(raw)


LONG = ("OB", "OW", "SQ", "UN", "UT", "OF", "UC")


class Dicom:
    """A data set; explicit or implicit little endian."""

    def __init__(self, implicit=False):
        self.implicit = implicit
        self.bytes = b""

    def add(self, group, element, vr, value):
        if isinstance(value, str):
            value = value.encode("latin-1")
        if isinstance(value, int):
            value = struct.pack("<H" if vr == "US" else "<i", value)
        if len(value) % 2:
            value += b"\0" if vr in ("UI", "OB", "OW") else b" "
        head = struct.pack("<HH", group, element)
        if self.implicit:
            head += struct.pack("<I", len(value))
        elif vr in LONG:
            head += vr.encode() + struct.pack("<HI", 0, len(value))
        else:
            head += vr.encode() + struct.pack("<H", len(value))
        self.bytes += head + value
        return self

    def sequence(self, group, element, items, undefined=False):
        body = b""
        for item in items:
            length = 0xFFFFFFFF if undefined else len(item.bytes)
            body += struct.pack("<HHI", 0xFFFE, 0xE000, length) + item.bytes
            if undefined:
                body += struct.pack("<HHI", 0xFFFE, 0xE00D, 0)
        if undefined:
            body += struct.pack("<HHI", 0xFFFE, 0xE0DD, 0)
        head = struct.pack("<HH", group, element)
        if not self.implicit:
            head += b"SQ\0\0"
        self.bytes += head + struct.pack("<I", 0xFFFFFFFF if undefined else len(body)) + body
        return self

    def encapsulated(self, frames):
        self.bytes += struct.pack("<HH", 0x7FE0, 0x10) + b"OB\0\0" + struct.pack("<I", 0xFFFFFFFF)
        self.bytes += struct.pack("<HHI", 0xFFFE, 0xE000, 0)
        for frame in frames:
            frame += b"\0" * (len(frame) % 2)
            self.bytes += struct.pack("<HHI", 0xFFFE, 0xE000, len(frame)) + frame
        self.bytes += struct.pack("<HHI", 0xFFFE, 0xE0DD, 0)
        return self


def write_dicom(path, data, syntax="1.2.840.10008.1.2.1", meta_header=True):
    body = data.bytes
    if syntax.endswith(".99"):
        deflate = zlib.compressobj(6, zlib.DEFLATED, -15)
        body = deflate.compress(body) + deflate.flush()
    if not meta_header:
        path.write_bytes(body)
        return
    head = Dicom().add(2, 1, "OB", b"\0\1").add(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2")
    head.add(2, 3, "UI", "1.2.3.4").add(2, 0x10, "UI", syntax)
    head = Dicom().add(2, 0, "UL", struct.pack("<I", len(head.bytes))).bytes + head.bytes
    path.write_bytes(b"\0" * 128 + b"DICM" + head + body)


def rle(values):
    """PS3.5 annex G: 16-bit samples in two segments, high bytes first; literal runs."""
    segments = []
    for shift in (8, 0):
        raw = bytes(v >> shift & 0xFF for v in values)
        out = b""
        for at in range(0, len(raw), 128):
            part = raw[at:at + 128]
            out += bytes([len(part) - 1]) + part
        segments.append(out + b"\0" * (len(out) % 2))
    return struct.pack("<16I", 2, 64, 64 + len(segments[0]), *([0] * 13)) + segments[0] + segments[1]


def ds(numbers):
    return "\\".join(f"{n:.10g}" for n in numbers)


def slice_values(axes, k):
    size, _ = grid_of(axes)
    all_values = voxels(axes)
    count = size[0] * size[1]
    return all_values[k * count:(k + 1) * count]


def ct_slice(k, axes=IDENTITY, implicit=False, series="1.2.826.1", number=None, position=None, spacing=None,
             orientation=None, slope=1.0, inter=-1024.0, bits=16, stored=12, signed=0, modality="CT",
             photometric="MONOCHROME2", high_bits=0, extra=(), pixels=True, image_type="ORIGINAL\\PRIMARY\\AXIAL",
             values=None, compress=None, thickness="8", samples=1):
    size, steps = grid_of(axes)
    position = position or place((0, 0, k), axes, size, steps)
    values = values or slice_values(axes, k)
    data = Dicom(implicit)
    data.add(8, 8, "CS", image_type).add(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2")
    data.add(8, 0x18, "UI", f"{series}.{k + 1}.{number or 0}").add(8, 0x60, "CS", modality)
    for group, element, vr, value in sorted(e for e in extra if e[0] < 0x20):
        data.add(group, element, vr, value)
    data.add(0x18, 0x50, "DS", thickness)
    data.add(0x20, 0xE, "UI", series)
    late = sorted(e for e in extra if e[0] == 0x20)
    for group, element, vr, value in (e for e in late if e[1] < 0x13):
        data.add(group, element, vr, value)
    data.add(0x20, 0x13, "IS", str(k + 1 if number is None else number))
    data.add(0x20, 0x32, "DS", ds(position))
    data.add(0x20, 0x37, "DS", orientation or ds([*axes[0], *axes[1]]))
    for group, element, vr, value in (e for e in late if e[1] > 0x37):
        data.add(group, element, vr, value)
    data.add(0x28, 2, "US", samples).add(0x28, 4, "CS", photometric)
    data.add(0x28, 0x10, "US", size[1]).add(0x28, 0x11, "US", size[0])
    if spacing != "":
        data.add(0x28, 0x30, "DS", spacing or ds([steps[1], steps[0]]))
    data.add(0x28, 0x100, "US", bits).add(0x28, 0x101, "US", stored).add(0x28, 0x102, "US", stored - 1)
    data.add(0x28, 0x103, "US", signed)
    data.add(0x28, 0x1052, "DS", f"{inter:g}").add(0x28, 0x1053, "DS", f"{slope:g}")
    if pixels:
        raw = [round((v - inter) / slope) for v in values]
        if photometric == "MONOCHROME1":
            raw = [4095 - v for v in raw]
        words = [(v & (1 << stored) - 1 | high_bits) & 0xFFFF for v in raw]
        if compress:
            data.encapsulated([compress(words)])
        else:
            data.add(0x7FE0, 0x10, "OW", packed(words, "H"))
    return data


def ct_series(folder, count=None, name="{:03d}.dcm", syntax="1.2.840.10008.1.2.1", meta_header=True, skip=(),
              of_slice=lambda k: {}, **options):
    folder.mkdir(parents=True, exist_ok=True)
    size, _ = grid_of(options.get("axes", IDENTITY))
    for k in range(count or size[2]):
        if k not in skip:
            write_dicom(folder / name.format(k), ct_slice(k, **{**options, **of_slice(k)}), syntax, meta_header)


def mesh_volume(triangles):
    return sum(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]) for a, b, c in triangles) / 6


def box(low, high):
    c = [tuple(high[d] if n >> d & 1 else low[d] for d in range(3)) for n in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return [(c[a], c[b], c[d]) for q in faces for a, b, d in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]


def stl(path, triangles, name=b"surface"):
    path.write_bytes(name.ljust(80, b" ")[:80] + struct.pack("<I", len(triangles)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0) for a, b, c in triangles))


def indexed(triangles):
    nodes, faces = {}, []
    for triangle in triangles:
        faces.append(tuple(nodes.setdefault(p, len(nodes)) for p in triangle))
    return list(nodes), faces


def centre_of(inside, axes=IDENTITY):
    """Volume in ml and centre in LPS of the voxels for whose value inside() is true."""
    size, spacing = grid_of(axes)
    found = [place((n % size[0], n // size[0] % size[1], n // (size[0] * size[1])))
             for n, v in enumerate(voxels()) if inside(v)]
    return (len(found) * SPACING[0] * SPACING[1] * SPACING[2] / 1000,
            tuple(sum(p[d] for p in found) / len(found) for d in range(3)))


BODY_ML, BODY_CENTRE = centre_of(lambda hu: hu > -500)
