#!/usr/bin/python3
"""Puts PNG images of a replay on one sheet, in rows; - between rows.

Usage: sheet.py OUT.png IMAGE... [- IMAGE...]...

IMAGE: the path of a PNG file (8 bits, grey or RGB, all of one size), or A:B, which shows the absolute
difference of the greys of A and B times four.

       sheet.py --difference A B: the mean of that difference of two images, in grey levels.
"""
import sys

from PIL import Image, ImageChops, ImageStat, UnidentifiedImageError

GAP_PX = 4
DIFFERENCE_FACTOR = 4


def open_rgb(path):
    try:
        with Image.open(path, formats=["PNG"]) as image:
            if image.mode not in ("L", "RGB"):
                sys.exit(f"sheet.py: {path}: allowed are 8 bits, grey or RGB")
            return image.convert("RGB")
    except UnidentifiedImageError:
        sys.exit(f"sheet.py: {path} is not a PNG file; give one that acus-replay wrote")
    except OSError as error:
        sys.exit(f"sheet.py: {path}: {error.strerror or error}; give a PNG file that acus-replay wrote")


def need_same_size(name, image, other):
    if image.size != other.size:
        sys.exit(f"sheet.py: {name} has {image.width} x {image.height} pixels, the first image "
                 f"{other.width} x {other.height}; all must be of one size")


def load(name):
    if ":" not in name:
        return open_rgb(name)
    first, second = map(open_rgb, name.split(":"))
    need_same_size(name, second, first)
    return ImageChops.difference(first, second).point(lambda value: min(255, DIFFERENCE_FACTOR * value))


def sheet(rows):
    """All images on white, with a gap between them; grey if they are."""
    width, height = (size + GAP_PX for size in rows[0][0].size)
    out = Image.new("RGB", (max(map(len, rows)) * width - GAP_PX, len(rows) * height - GAP_PX), "white")
    for row, images in enumerate(rows):
        for column, image in enumerate(images):
            out.paste(image, (column * width, row * height))
    red, green, blue = out.split()
    is_grey = red.tobytes() == green.tobytes() == blue.tobytes()
    return red if is_grey else out


def mean_difference(first, second):
    a, b = (open_rgb(name).convert("L") for name in (first, second))
    need_same_size(second, b, a)
    return ImageStat.Stat(ImageChops.difference(a, b)).mean[0]


def main():
    if sys.argv[1:2] == ["--difference"] and len(sys.argv) == 4:
        print(f"{mean_difference(*sys.argv[2:]):.4g}")
        return
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    rows = [[]]
    for word in sys.argv[2:]:
        if word == "-":
            rows.append([])
        else:
            rows[-1].append(load(word))
            need_same_size(word, rows[-1][-1], rows[0][0])
    sheet(rows).save(sys.argv[1], optimize=True)


if __name__ == "__main__":
    main()
