"""What a program made, as text."""
import gzip
import json
import pathlib
import re


def volume(path):
    """Sizes, vectors, origin, header and bytes of an NRRD as the programs write it."""
    head, data = pathlib.Path(path).read_bytes().split(b"\n\n", 1)
    head = head.decode()
    field = lambda key: re.search(rf"^{key}: ?(.*)$", head, re.M).group(1)
    vectors = [[float(c) for c in v.split(",")] for v in re.findall(r"\(([^)]*)\)", field("space directions"))]
    origin = [float(c) for c in field("space origin").strip("()").split(",")]
    return ([int(n) for n in field("sizes").split()], vectors, origin, head,
            gzip.decompress(data) if "gz" in field("encoding") else data)


def centre_text(name, size, v, origin, places):
    mean = [0, 0, 0]
    for at in places:
        mean[0] += at % size[0]
        mean[1] += at // size[0] % size[1]
        mean[2] += at // (size[0] * size[1])
    mean = [m / max(1, len(places)) for m in mean]
    centre = [origin[d] + sum(v[a][d] * mean[a] for a in range(3)) for d in range(3)]
    voxel = abs(v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) - v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]))
    return (f"{name}: {len(places) * voxel / 1000:.2f} ml at x {centre[0]:.2f} y {centre[1]:.2f} z {centre[2]:.2f}")


def body(folder):
    """Volume and centre of all labels."""
    size, vectors, origin, _, data = volume(pathlib.Path(folder) / "labels.seg.nrrd")
    return centre_text("body", size, vectors, origin, [n for n, v in enumerate(data) if v])


def label(folder, name):
    """Volume and centre of one label."""
    size, vectors, origin, head, data = volume(pathlib.Path(folder) / "labels.seg.nrrd")
    number = re.search(rf"^Segment(\d+)_Name:={name}\s*$", head, re.M)
    value = int(re.search(rf"^Segment{number.group(1)}_LabelValue:=(\d+)", head, re.M).group(1)) if number else -1
    return centre_text(name, size, vectors, origin, [n for n, v in enumerate(data) if v == value])


def mesh(folder):
    """Volume of all tetrahedra."""
    quality = json.loads((pathlib.Path(folder) / "quality.json").read_text())
    return f"mesh_ml {sum(t['mesh_ml'] for t in quality['tissues'])}"


def plateau(folder):
    """Force on the plateau and where the needle met the tissue."""
    parameters = json.loads((pathlib.Path(folder) / "fit.json").read_text())["curves"][0]["parameters"]
    return "\n".join(f"{name} {parameters[name]['value']}" for name in ("plateau_n", "contact_depth_mm"))


def transform(path):
    """Translation of an ITK transform file."""
    text = pathlib.Path(path).read_text()
    return "translation " + " ".join(re.search(r"^Parameters: (.*)$", text, re.M).group(1).split()[9:])


def poses(path):
    """First row of a table of poses."""
    return "first " + pathlib.Path(path).read_text().splitlines()[1]


def camera(folder, truth):
    """The largest distance of a tool from where it was in the images."""
    far = 0.0
    for tool in ("Reference", "Probe", "Needle"):
        rows = [[float(c) for c in (pathlib.Path(place) / f"{tool}.csv").read_text().splitlines()[1].split(",")[1:4]]
                for place in (folder, truth)]
        far = max(far, sum((a - b) ** 2 for a, b in zip(*rows)) ** 0.5)
    return f"off_mm {far}"
