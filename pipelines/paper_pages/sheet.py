#!/usr/bin/env python3
"""Puts PNG images of a replay on one sheet, in rows; - between rows.

Usage: sheet.py OUT.png IMAGE... [- IMAGE...]...

IMAGE: the path of a PNG file (8 bits, grey or RGB, all of one size), or A:B, which shows the absolute
difference of the greys of A and B times four.
"""
import pathlib
import struct
import sys
import zlib

GAP_PX = 4
DIFFERENCE_FACTOR = 4
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunks(data):
    at = len(SIGNATURE)
    while at < len(data):
        size = struct.unpack(">I", data[at:at + 4])[0]
        yield data[at + 4:at + 8], data[at + 8:at + 8 + size]
        at += size + 12


def paeth(left, above, corner):
    off = [(abs(above - corner), left), (abs(left - corner), above), (abs(left + above - 2 * corner), corner)]
    return min(off, key=lambda pair: pair[0])[1]


def unfiltered(data, rows, row_bytes, step):
    """The filters of the PNG specification, section 9."""
    before = bytes(row_bytes)
    for n in range(rows):
        kind = data[n * (row_bytes + 1)]
        row = bytearray(data[n * (row_bytes + 1) + 1:(n + 1) * (row_bytes + 1)])
        for i in range(row_bytes if kind else 0):
            left = row[i - step] if i >= step else 0
            corner = before[i - step] if i >= step else 0
            guess = (left, before[i], (left + before[i]) // 2, paeth(left, before[i], corner))[kind - 1]
            row[i] = (row[i] + guess) & 255
        yield bytes(row)
        before = row


def read(path):
    """Rows of RGB."""
    try:
        data = pathlib.Path(path).read_bytes()
    except OSError as error:
        sys.exit(f"sheet.py: {path}: {error.strerror}; give a PNG file that acus-replay wrote")
    if not data.startswith(SIGNATURE):
        sys.exit(f"sheet.py: {path} is not a PNG file; give one that acus-replay wrote")
    parts = list(chunks(data))
    width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", parts[0][1])
    if bits != 8 or colour not in (0, 2) or interlaced:
        sys.exit(f"sheet.py: {path}: allowed are 8 bits, grey or RGB, not interlaced")
    step = 3 if colour == 2 else 1
    packed = b"".join(body for kind, body in parts if kind == b"IDAT")
    rows = unfiltered(zlib.decompress(packed), height, width * step, step)
    return [row if step == 3 else bytes(value for value in row for _ in range(3)) for row in rows]


def need_same_size(name, rows, others):
    if (len(rows), len(rows[0])) != (len(others), len(others[0])):
        sys.exit(f"sheet.py: {name} has {len(rows[0]) // 3} x {len(rows)} pixels, the first image "
                 f"{len(others[0]) // 3} x {len(others)}; all must be of one size")


def image(name):
    if ":" not in name:
        return read(name)
    first, second = map(read, name.split(":"))
    need_same_size(name, second, first)
    return [bytes(min(255, DIFFERENCE_FACTOR * abs(a - b)) for a, b in zip(*rows)) for rows in zip(first, second)]


def sheet(rows_of_images):
    """Rows of RGB, white between the images."""
    columns = max(map(len, rows_of_images))
    size = len(rows_of_images[0][0][0])
    out = []
    for images in rows_of_images:
        images = images + [[b"\xff" * size] * len(images[0])] * (columns - len(images))
        if out:
            out += [b"\xff" * len(out[0])] * GAP_PX
        out += [(b"\xff" * 3 * GAP_PX).join(rows) for rows in zip(*images)]
    return out


def filtered(row, before, step):
    """The row by the filter none, sub or up that leaves the smallest bytes."""
    left = bytes(step) + row[:-step]
    tries = [row] + [bytes((a - b) & 255 for a, b in zip(row, other)) for other in (left, before)]
    sums = [sum(min(value, 256 - value) for value in one) for one in tries]
    kind = sums.index(min(sums))
    return bytes([kind]) + tries[kind]


def png(rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    grey = all(row[0::3] == row[1::3] == row[2::3] for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 0 if grey else 2, 0, 0, 0)
    rows = [row[0::3] if grey else row for row in rows]
    data = b"".join(filtered(row, before, 1 if grey else 3) for before, row in zip([bytes(len(rows[0]))] + rows, rows))
    return SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b"")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    rows = [[]]
    for word in sys.argv[2:]:
        if word == "-":
            rows.append([])
        else:
            rows[-1].append(image(word))
            need_same_size(word, rows[-1][-1], rows[0][0])
    pathlib.Path(sys.argv[1]).write_bytes(png(sheet(rows)))


if __name__ == "__main__":
    main()
