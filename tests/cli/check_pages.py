"""Pages of one style. Usage: check_pages.py STYLE_SHEET PAGE...

Each page contains the style sheet, is a whole document that needs no network, begins with its title, has warnings
before its sections, and, if chromium is there, opens without a message of an error and is not empty."""
import html.parser
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

VOID = {"meta", "img", "br", "hr", "link", "input", "source", "wbr", "rect", "line", "circle", "path", "polyline",
        "polygon", "use", "stop"}


class Document(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.faults, self.headings, self.external, self.warnings_at = [], [], [], [], None

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag in ("h1", "h2"):
            self.headings.append(tag)
        if "warnings" in (given.get("class") or ""):
            self.warnings_at = len(self.headings)
        for name in ("src", "href"):
            if tag != "a" and re.match(r"(https?:)?//", given.get(name) or ""):
                self.external.append(given[name])
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> closes nothing")


def faults_of(text, style):
    page = Document()
    page.feed(text)
    yield from page.faults[:3]
    if page.open:
        yield f"not closed: {page.open}"
    if not text.startswith("<!DOCTYPE html>") or 'lang="en"' not in text or 'name="viewport"' not in text:
        yield "no doctype, language or viewport"
    if style not in text:
        yield "another style sheet"
    if page.headings[:1] != ["h1"] or page.headings.count("h1") != 1:
        yield f"headings: {page.headings}"
    if page.warnings_at not in (None, 1):
        yield "warnings are not on top"
    yield from (f"needs {address}" for address in page.external)


def faults_in_browser(browser, page):
    """Nothing where the browser itself cannot run, as in a container without its sandbox or memory."""
    with tempfile.TemporaryDirectory() as folder:
        shot = pathlib.Path(folder) / "page.png"
        try:
            done = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                                   "--enable-logging=stderr", f"--user-data-dir={folder}/user",
                                   "--window-size=1000,1400", f"--screenshot={shot}", page.resolve().as_uri()],
                                  capture_output=True, text=True, check=True, timeout=60)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
            print(f"{page}: not opened: {browser} does not run here: {error}")
            return
        for line in done.stderr.splitlines():
            if ":CONSOLE" in line and "Error" in line:
                yield f"console: {line}"
        if not shot.exists() or shot.stat().st_size < 5000:
            yield "the browser shows nothing"


def main(style, pages):
    text = pathlib.Path(style).read_text(encoding="utf-8").strip()
    browser = shutil.which("chromium")
    faults = 0
    for page in map(pathlib.Path, pages):
        found = list(faults_of(page.read_text(encoding="utf-8"), text))
        if browser:
            found += faults_in_browser(browser, page)
        faults += len(found)
        print("\n".join(f"{page}: {fault}" for fault in found) or f"{page}: good")
    print("opened in chromium" if browser else "chromium is not there: pages were not opened")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
