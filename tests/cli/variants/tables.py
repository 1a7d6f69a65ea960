"""Variants of tables: force curves, units, landmarks, poses."""
import json
import math

PLATEAU = [["plateau_n ([-0-9.e]+)", 0.3, 0.012], ["contact_depth_mm ([-0-9.e]+)", 2.0, 0.1]]


def curve(offset=0.0, hold=False):
    """A needle at 2 mm/s: air up to 2 mm, a rise to 0.8 N at 6 mm, a plateau of 0.3 N."""
    rows = []
    for i in range(400):
        t = i * 0.025
        d = 2 * t
        force = 0 if d < 2 else 0.05 * (d - 2) ** 2 if d < 6 else 0.3 + 0.02 * (d - 6)
        rows.append((t, d, force + 0.003 * math.sin(37 * i) + offset))
    return rows


def table(rows=None, names=("time_s", "depth_mm", "force_n"), separator=",", comma=False, factors=(1, 1, 1),
          order=(0, 1, 2), before="", units=None, end="\n", form="{:.6f}", quote=False, tail=""):
    rows = rows or curve()

    def cell(value):
        text = form.format(value)
        text = text.replace(".", ",") if comma else text
        return f'"{text}"' if quote else text
    name = (lambda n: f'"{n}"') if quote else (lambda n: n)
    lines = [separator.join(name(names[c]) for c in order)]
    if units:
        lines.append(separator.join(units[c] for c in order))
    lines += [separator.join(cell(row[c] * factors[c]) for c in order) + tail for row in rows]
    return before + end.join(lines) + end


def fit(path, *options):
    return f"acus-fit {path} --models none {' '.join(options)} -o out"


def cases_of(w, kind, variants):
    for name, text, exits, *more in variants:
        path = w / f"{kind}_{name}.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        case = {"kind": kind, "name": f"{kind}_{name}", "command": fit(path, *(more[1:] or ())), "exit": exits,
                "values": PLATEAU, "measure": ("plateau", "out")}
        yield {**case, **(more[0] if more else {})}


def replaced(text, rows, change):
    lines = text.split("\n")
    for n in rows:
        lines[n] = change(lines[n])
    return "\n".join(lines)


def curve_cases(w):
    plain = table()
    yield from cases_of(w, "table", [
        ("plain", plain, [0]), ("bom", b"\xef\xbb\xbf" + plain.encode(), [0]),
        ("utf16", plain.encode("utf-16"), [0]), ("utf16_big", b"\xfe\xff" + plain.encode("utf-16-be"), [0]),
        ("crlf", table(end="\r\n"), [0]), ("cr", table(end="\r"), [0]), ("tabs", table(separator="\t"), [0]),
        ("semicolons", table(separator=";"), [0]), ("semicolons_comma", table(separator=";", comma=True), [0]),
        ("tabs_comma", table(separator="\t", comma=True), [0]), ("bars", table(separator="|"), [0]),
        ("blanks", table(separator="   ", form="{:12.6f}"), [0]), ("quoted", table(quote=True), [0]),
        ("quoted_comma", table(quote=True, comma=True), [0, 3]),
        ("comma_and_comma", table(comma=True), [3]),
        ("comments", replaced(plain, (5, 50, 200), lambda line: line + "\n# stopped here"), [0]),
        ("percent", table(before="% made by a robot\n"), [0]),
        ("preamble", table(before="Sample,12\nDate,2024-03-05\nRate,40\nOperator,A. B.\n\n"), [0]),
        ("units_row", table(names=("Time", "Depth", "Force"), units=("s", "mm", "N")), [0]),
        ("units_row_brackets", table(names=("Time", "Displacement", "Load"), units=("(ms)", "(cm)", "(mN)"),
                                     factors=(1000, 0.1, 1000)), [0]),
        ("trailing_commas", table(tail=","), [0, 3]), ("order", table(order=(2, 0, 1)), [0]),
        ("scientific", table(form="{:.7E}"), [0]), ("plus_signs", table(form="{:+.6f}"), [0]),
        ("no_last_newline", plain.rstrip("\n"), [0]), ("empty_lines", plain.replace("\n", "\n\n"), [0]),
        ("capitals", table(names=("TIME_S", "DEPTH_MM", "FORCE_N")), [0]),
        ("words", table(names=("Time (s)", "Insertion depth (mm)", "Axial force (N)")), [0, 3]),
        ("german", table(names=("Zeit [s]", "Weg [mm]", "Kraft [N]"), separator=";", comma=True), [0, 3]),
        ("no_units", table(names=("time", "depth", "force")), [3]),
        ("two_forces", table(names=("time_s", "depth_mm", "force_n", "load_n"),
                             rows=[(*r, 2 * r[2]) for r in curve()], order=(0, 1, 2, 3),
                             factors=(1, 1, 1, 1)), [0, 3]),
        ("empty_cells", replaced(plain, (7, 90), lambda line: line.rsplit(",", 1)[0] + ","), [0]),
        ("nan_cells", replaced(plain, (7, 90), lambda line: line.rsplit(",", 1)[0] + ",NaN"), [0]),
        ("text_cell", replaced(plain, (90,), lambda line: line.rsplit(",", 1)[0] + ",high"), [3]),
        ("missing_cell", replaced(plain, (90,), lambda line: line.rsplit(",", 1)[0]), [3]),
        ("infinite", replaced(plain, (90,), lambda line: line.rsplit(",", 1)[0] + ",inf"), [3]),
        ("repeated_stamp", replaced(plain, (90,), lambda line: line + "\n" + line), [0]),
        ("time_back", replaced(plain, (90,), lambda line: line + "\n0.1,0.2,0.0"), [3]),
        ("header_twice", plain + plain, [3]), ("only_header", "time_s,depth_mm,force_n\n", [3]),
        ("no_header", "\n".join(plain.split("\n")[1:]), [3]), ("empty", "", [3]),
        ("html", "<html><body>Not found</body></html>\n", [3]), ("binary", bytes(range(256)) * 20, [3]),
        ("thousands", table(names=("time_ms", "depth_mm", "force_n"), factors=(1000, 1, 1), quote=True,
                            form="{:,.3f}"), [0, 3]),
        ("latin1", table(names=("time_s", "depth_mm", "force_n"), before="# Prüfkörper\n").encode("latin-1"), [0]),
    ])


def unit_cases(w):
    def named(unit_names, *factors):
        return table(names=unit_names, factors=factors)
    yield from cases_of(w, "units", [
        ("ms", named(("Time [ms]", "depth_mm", "force_n"), 1000, 1, 1), [0]),
        ("microseconds", named(("time_us", "depth_mm", "force_n"), 1e6, 1, 1), [0]),
        ("minutes", table(names=("time_min", "depth_mm", "force_n"), factors=(1 / 60, 1, 1), form="{:.9f}"), [0]),
        ("cm", named(("time_s", "Depth (cm)", "force_n"), 1, 0.1, 1), [0]),
        ("m", table(names=("time_s", "Depth [m]", "force_n"), factors=(1, 1e-3, 1), form="{:.9f}"), [0]),
        ("um", named(("time_s", "depth_um", "force_n"), 1, 1000, 1), [0]),
        ("mN", named(("time_s", "depth_mm", "Force (mN)"), 1, 1, 1000), [0]),
        ("cN", named(("time_s", "depth_mm", "Force_cN"), 1, 1, 100), [0]),
        ("kN", table(names=("time_s", "depth_mm", "Load_kN"), factors=(1, 1, 1e-3), form="{:.9f}"), [0]),
        ("slash", named(("t / s", "depth / mm", "force / N"), 1, 1, 1), [0, 3]),
        ("words", named(("Time (Seconds)", "Depth (Millimeters)", "Force (Newton)"), 1, 1, 1), [0]),
        ("mN_said_N", named(("time_s", "depth_mm", "force_n"), 1, 1, 1000), [3]),
        ("m_said_mm", table(names=("time_s", "depth_mm", "force_n"), factors=(1, 1e-3, 1), form="{:.9f}"), [3]),
        ("mN_as_it_is", named(("time_s", "depth_mm", "force_n"), 1, 1, 1000), [0],
         {"values": [["plateau_n ([-0-9.e]+)", 300, 12]]}, "--as-it-is"),
        ("grams", named(("time_s", "depth_mm", "force_g"), 1, 1, 102), [3]),
        ("pounds", named(("time_s", "depth_mm", "Force (lbf)"), 1, 1, 0.2248), [0, 3]),
        ("no_length", named(("time_s", "depth_n", "force_n"), 1, 1, 1), [3]),
    ])


def force_cases(w):
    columns = lambda sign, name: json.dumps({
        "format": "acus-force-columns/1", "name": "Machine", "description": "test", "time": {"column": "Time"},
        "depth": {"column": "Extension", "sign": sign}, "force": {"column": "Load", "sign": sign}})
    for sign in (1, -1):
        (w / f"columns_{sign}.json").write_text(columns(sign, "m"))
    names = ("Time (s)", "Extension (mm)", "Load (N)")
    low = [(t, d, f - 0.4) for t, d, f in curve()]
    high = [(t, d, f + 0.4) for t, d, f in curve()]
    rest = [(0.025 * i, 0.0, 0.25 + 0.003 * math.sin(11 * i)) for i in range(80)] + [
        (2.0 + t, d, f + 0.25) for t, d, f in curve()]
    yield from cases_of(w, "forces", [
        ("offset_above", table(high), [0]), ("offset_below", table(low), [0]), ("rest_with_offset", table(rest), [0]),
        ("compression_negative", table([(t, d, -f) for t, d, f in curve()]), [3, 4]),
        ("mapped", table(names=names), [0], {}, f"--columns {w}/columns_1.json"),
        ("mapped_signs", table([(t, -d, -f) for t, d, f in curve()], names=names), [0], {},
         f"--columns {w}/columns_-1.json"),
        ("mapped_wrong_sign", table(names=names), [3, 4], {}, f"--columns {w}/columns_-1.json"),
        ("mapped_kN_row", table(names=("Time", "Extension", "Load"), units=("(s)", "(mm)", "(kN)"),
                                factors=(1, 1, 1e-3), form="{:.9f}", before='"Test","A"\n\n'), [0], {},
         f"--columns {w}/columns_1.json"),
        ("mapped_absent", table(), [3], {"says": ["Extension"]}, f"--columns {w}/columns_1.json"),
        ("machine_preset", table(names=names), [0], {}, "--columns columns/materials_tester.json"),
        ("without_air", table([(t, d, f) for t, d, f in curve() if d > 4]), [4],
         {"says": ["begins inside tissue, or the sensor's zero is off"]}),
        ("in_tissue_with_offset", table([(t, d, f + 0.4) for t, d, f in curve() if d > 3]), [4]),
        ("from_contact_on", table([(t, d, f) for t, d, f in curve() if d >= 2]), [0], {"values": PLATEAU[:1]}),
        ("only_zeros", table([(t, d, 0.0) for t, d, f in curve()]), [3, 4]),
        ("constant_depth", table([(t, 1.0, f) for t, d, f in curve()]), [3, 4]),
        ("five_samples", table(curve()[:5]), [3, 4]),
        ("depth_in_reverse", table([(t, -d, f) for t, d, f in curve()]), [3, 4, 0]),
        ("coarse_clock", table([(round(t, 1), d, f) for t, d, f in curve()], form="{:.4f}"), [0],
         {"values": PLATEAU[:1]}),
        ("coarse_encoder", table([(t, round(d, 1), f) for t, d, f in curve()]), [0], {"values": PLATEAU[:1]}),
        ("stopwatch_of_day", table([(t + 45296.0, d, f) for t, d, f in curve()]), [0]),
        ("unix_time", table([(t + 1714557700.0, d, f) for t, d, f in curve()]), [0]),
    ])
    for n in range(2):
        (w / f"curve{n}.csv").write_text(table(before=f"# specimen {n}\n"))
    yield {"kind": "forces", "name": "forces_several_files", "exit": [0], "values": PLATEAU, "measure": ("plateau", "out"),
           "command": f"acus-fit {w}/curve0.csv {w}/curve1.csv --models none -o out"}
