"""PNG of an Xvfb that keeps its screen in a file: Xvfb -fbdir FOLDER. Usage: screenshot.py FOLDER FILE.png"""
import pathlib
import struct
import sys
import zlib


def read_xwd(path):
    """Width, height and RGB rows of the X window dump that Xvfb writes: 32 bits a pixel, BGRX."""
    data = pathlib.Path(path).read_bytes()
    header = struct.unpack(">25I", data[:100])
    size, width, height, bits, line, colors = header[0], header[4], header[5], header[11], header[12], header[19]
    if bits != 32:
        sys.exit(f"{path}: {bits} bits a pixel; start Xvfb with 24 planes")
    begin = size + 12 * colors
    rows = []
    for row in range(height):
        pixels = data[begin + row * line:begin + row * line + 4 * width]
        rgb = bytearray(3 * width)
        for channel in range(3):
            rgb[channel::3] = pixels[2 - channel::4]
        rows.append(bytes(rgb))
    return width, height, rows


def png_of(width, height, rows):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    packed = zlib.compress(b"".join(b"\0" + row for row in rows), 6)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", packed) + chunk(b"IEND", b""))


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_bytes(png_of(*read_xwd(pathlib.Path(sys.argv[1]) / "Xvfb_screen0")))
