"""Sheets of images for the pages of the papers: pipelines/paper_pages/sheet.py."""
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.append(str(ROOT / "pipelines" / "paper_pages"))

import sheet  # noqa: E402

WIDTH, HEIGHT = 7, 5


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def encoded(rows, step, filters):
    """A PNG whose row n has filter n, written as the specification has it."""
    data, before = b"", bytes(len(rows[0]))
    for kind, row in zip(filters, rows):
        def left(line, i):
            return line[i - step] if i >= step else 0

        def guess(i):
            a, b, c = left(row, i), before[i], left(before, i)
            estimate = a + b - c
            nearest = min((abs(estimate - a), 0, a), (abs(estimate - b), 1, b), (abs(estimate - c), 2, c))[2]
            return (0, a, b, (a + b) // 2, nearest)[kind]
        data += bytes([kind]) + bytes((row[i] - guess(i)) & 255 for i in range(len(row)))
        before = row
    header = struct.pack(">IIBBBBB", len(rows[0]) // step, len(rows), 8, 2 if step == 3 else 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def rows_of(path):
    """Rows of RGB."""
    image = sheet.open_rgb(path)
    data = image.tobytes()
    return [data[n:n + 3 * image.width] for n in range(0, len(data), 3 * image.width)]


class Sheet(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.random = random.Random(1)

    def image(self, name, step=3, filters=(0, 1, 2, 3, 4)):
        rows = [bytes(self.random.randrange(256) for _ in range(WIDTH * step)) for _ in range(HEIGHT)]
        (self.folder / name).write_bytes(encoded(rows, step, filters))
        return rows

    def run_on(self, *words):
        return subprocess.run([sys.executable, str(ROOT / "pipelines/paper_pages/sheet.py"), "out.png", *words],
                              cwd=self.folder, capture_output=True, text=True, check=False)

    def test_every_filter_is_undone(self):
        for step in (1, 3):
            for filters in ((0, 1, 2, 3, 4), (4, 3, 2, 1, 0), (3, 4, 4, 3, 1)):
                rows = self.image("a.png", step, filters)
                want = rows if step == 3 else [bytes(v for v in row for _ in range(3)) for row in rows]
                self.assertEqual(rows_of(self.folder / "a.png"), want)

    def test_images_lie_in_rows_with_white_between(self):
        a, b, c = (self.image(name) for name in ("a.png", "b.png", "c.png"))
        self.assertEqual(self.run_on("a.png", "b.png", "-", "c.png").returncode, 0)
        out = rows_of(self.folder / "out.png")
        gap = b"\xff" * 3 * sheet.GAP_PX
        self.assertEqual(out[:HEIGHT], [x + gap + y for x, y in zip(a, b)])
        self.assertEqual(set(b"".join(out[HEIGHT:HEIGHT + sheet.GAP_PX])), {255})
        self.assertEqual(out[HEIGHT + sheet.GAP_PX:], [x + gap + b"\xff" * 3 * WIDTH for x in c])

    def test_a_difference_is_absolute_and_four_times(self):
        a, b = self.image("a.png", 1), self.image("b.png", 1)
        self.assertEqual(self.run_on("a.png:b.png").returncode, 0)
        want = [bytes(min(255, 4 * abs(x - y)) for x, y in zip(*rows) for _ in range(3)) for rows in zip(a, b)]
        self.assertEqual(rows_of(self.folder / "out.png"), want)

    def test_a_mean_difference_is_in_grey_levels(self):
        a, b = self.image("a.png", 1), self.image("b.png", 1)
        run = subprocess.run([sys.executable, str(ROOT / "pipelines/paper_pages/sheet.py"), "--difference", "a.png", "b.png"],
                             cwd=self.folder, capture_output=True, text=True, check=True)
        pairs = [abs(x - y) for rows in zip(a, b) for x, y in zip(*rows)]
        self.assertAlmostEqual(float(run.stdout) / (sum(pairs) / len(pairs)), 1.0, delta=1e-3)

    def test_what_cannot_be_read_is_named(self):
        (self.folder / "text.png").write_text("no image", encoding="utf-8")
        run = self.run_on("text.png")
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("text.png is not a PNG file", run.stderr)
        self.image("a.png")
        (self.folder / "wide.png").write_bytes(encoded([bytes(3)], 3, (0,)))
        run = self.run_on("a.png", "wide.png")
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("wide.png", run.stderr)


if __name__ == "__main__":
    unittest.main()
