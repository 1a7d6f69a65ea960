#!/usr/bin/env python3
"""Every second voxel of a NIfTI volume along each axis, so that tests on a real CT are fast.

Usage: coarse_nifti.py IN.nii.gz OUT.nii.gz
"""
import array
import gzip
import struct
import sys

TYPES = {2: "B", 4: "h", 8: "i", 16: "f", 256: "b", 512: "H"}  # NIfTI-1 data types.


def coarse(data):
    header = bytearray(data[:352])
    size = struct.unpack_from("<3h", header, 42)
    voxels = array.array(TYPES[struct.unpack_from("<h", header, 70)[0]])
    offset = int(struct.unpack_from("<f", header, 108)[0])
    voxels.frombytes(data[offset:offset + size[0] * size[1] * size[2] * voxels.itemsize])
    out = array.array(voxels.typecode)
    for z in range(0, size[2], 2):
        for y in range(0, size[1], 2):
            begin = (z * size[1] + y) * size[0]
            out.extend(voxels[begin:begin + size[0]:2])
    struct.pack_into("<3h", header, 42, *((n + 1) // 2 for n in size))
    spacing = struct.unpack_from("<3f", header, 80)
    struct.pack_into("<3f", header, 80, *(2 * mm for mm in spacing))
    for row in (280, 296, 312):  # srow_x, srow_y, srow_z: three columns and an origin that stays.
        struct.pack_into("<3f", header, row, *(2 * v for v in struct.unpack_from("<3f", header, row)))
    struct.pack_into("<f", header, 108, 352.0)
    header[348:352] = bytes(4)  # No extensions.
    return bytes(header) + out.tobytes()


with gzip.open(sys.argv[1]) as stream:
    whole = stream.read()
with gzip.open(sys.argv[2], "wb", compresslevel=1) as stream:
    stream.write(coarse(whole))
