#!/usr/bin/env python3
"""The documentation as a web site that opens from disk: docs/, README.md, CONTRIBUTING.md, CHANGELOG.md.

Usage: site.py SOURCES WORK OUTPUT

WORK holds the pages as they go into mkdocs: links lead within the site, links to sources become text.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

KATEX = pathlib.Path("/usr/share/javascript/katex")
# Folders of docs/ that are no part of the site.
SOURCES_OF_PAGES = ("templates", "data")
PROJECT_PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")
FOLDERS = (("Concepts", "concepts"), ("Models", "models"), ("The four papers", "papers"), ("Reference", "reference"))
FIRST = ("tutorial.md", "clinician_tutorial.md", "cohorts.md")

# Equations are set when a page is shown; the search index comes as a script, and its worker as a frame,
# since a page from disk may neither fetch a file nor start a worker.
EQUATIONS = """document.addEventListener("DOMContentLoaded", () => renderMathInElement(document.body, {
  delimiters: [{left: "\\\\[", right: "\\\\]", display: true}, {left: "\\\\(", right: "\\\\)", display: false}],
  throwOnError: false}));
"""
SEARCH = """if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      this.waiting = [];
      const frame = document.createElement("iframe");
      frame.hidden = true;
      frame.srcdoc = `<script>
        self.window.importScripts = (...urls) => Promise.all(urls.map(url => new Promise(done => {
          const script = document.createElement("script");
          script.src = url;
          script.onload = done;
          document.head.append(script);
        })));
        self.postMessage = data => parent.dispatchEvent(new CustomEvent("acus-search", {detail: data}));
      <\\/script><script src="${url}"><\\/script>`;
      window.addEventListener("acus-search", message => {
        const event = new MessageEvent("message", {data: message.detail});
        this.dispatchEvent(event);
        this.onmessage?.(event);
      });
      frame.onload = () => {
        this.frame = frame.contentWindow;
        this.waiting.splice(0).forEach(data => this.postMessage(data));
      };
      document.body.append(frame);
    }
    postMessage(data) {
      if (!this.frame) return void this.waiting.push(data);
      this.frame.dispatchEvent(new MessageEvent("message", {data}));
    }
    terminate() {}
  };
}
"""


def title_of(page):
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            return line[2:].strip()
    return page.stem


def place_of(path, sources):
    """Where a file of the sources is in the site, or None."""
    inside = path.relative_to(sources) if path.is_relative_to(sources) else None
    if inside is None:
        return None
    if str(inside) in PROJECT_PAGES:
        return pathlib.PurePosixPath(PROJECT_PAGES[str(inside)])
    if inside.parts[0] != "docs" or inside.parts[1] in SOURCES_OF_PAGES:
        return None
    return pathlib.PurePosixPath(*inside.parts[1:])


def with_links(text, page, place, sources):
    def replaced(match):
        label, target, anchor = match.group(1), match.group(2), match.group(3) or ""
        if re.match(r"[a-z]+:", target):
            return match.group(0)
        goal = place_of((page.parent / target).resolve(), sources)
        if goal is None or (page.parent / target).is_dir():
            return label
        return f"[{label}]({os.path.relpath(goal, place.parent)}{anchor})"
    text = LINK.sub(replaced, text)
    return re.sub(r"\]\(docs/figures/", "](figures/", text)


def stage(sources, pages):
    """All pages, with their links changed, and all figures."""
    shutil.rmtree(pages, ignore_errors=True)
    shutil.copytree(sources / "docs", pages, ignore=shutil.ignore_patterns("*.md", "*.sh", *SOURCES_OF_PAGES))
    found = [sources / name for name in PROJECT_PAGES] + sorted((sources / "docs").rglob("*.md"))
    for page in found:
        place = place_of(page, sources)
        target = pages / place
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(with_links(page.read_text(encoding="utf-8"), page, place, sources), encoding="utf-8")


def navigation(pages):
    nav = [{"Acus": "index.md"}]
    nav += [{title_of(pages / name): name} for name in FIRST]
    listed = {"index.md", *FIRST}
    for heading, folder in FOLDERS:
        inside = sorted((pages / folder).rglob("*.md"), key=lambda p: (p.name != "README.md", str(p)))
        nav.append({heading: [{title_of(page): str(page.relative_to(pages))} for page in inside]})
        listed |= {str(page.relative_to(pages)) for page in inside}
    rest = [page for page in sorted(pages.glob("*.md")) if page.name not in listed]
    nav.append({"The project": [{title_of(page): page.name} for page in rest]})
    return nav


def configuration(pages, output, has_api):
    nav = navigation(pages)
    if has_api:
        nav.append({"Library reference": "api/index.html"})
    return {
        "site_name": "Acus", "docs_dir": str(pages), "site_dir": str(output), "nav": nav, "use_directory_urls": False,
        "theme": {"name": "material", "font": False, "features": ["navigation.tabs", "navigation.top", "search.suggest"],
                  "palette": {"primary": "blue grey"}},
        "plugins": ["search"],
        "markdown_extensions": ["tables", "toc", "pymdownx.superfences", {"pymdownx.arithmatex": {"generic": True}}],
        "extra_css": ["katex/katex.min.css"],
        "extra_javascript": ["katex/katex.min.js", "katex/contrib/auto-render.js", "equations.js"],
    }


def add_search(output):
    """The index as a script, ahead of the theme's own."""
    index = (output / "search/search_index.json").read_text(encoding="utf-8")
    (output / "search/index.js").write_text(f"{SEARCH}var __search = {{index: Promise.resolve({index})}};\n",
                                            encoding="utf-8")
    for page in output.rglob("*.html"):
        if (output / "api") in page.parents:
            continue
        text = page.read_text(encoding="utf-8")
        up = "../" * (len(page.relative_to(output).parts) - 1)
        tag = f'<script src="{up}search/index.js"></script>'
        page.write_text(re.sub(r'(<script id="__config")', tag + r"\1", text, count=1), encoding="utf-8")


def main(sources, work, output):
    sources, work, output = (pathlib.Path(each).resolve() for each in (sources, work, output))
    pages = work / "pages"
    stage(sources, pages)
    for name in ("katex.min.css", "katex.min.js", "contrib/auto-render.js", "fonts"):
        target = pages / "katex" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (KATEX / name).is_dir() else shutil.copy
        copy(KATEX / name, target)
    (pages / "equations.js").write_text(EQUATIONS, encoding="utf-8")
    api = work / "api/html"
    if api.is_dir():
        shutil.copytree(api, pages / "api", dirs_exist_ok=True)
    config = work / "mkdocs.json"  # YAML holds JSON.
    config.write_text(json.dumps(configuration(pages, output, api.is_dir()), indent=2), encoding="utf-8")
    # An interpreter of another installation may come first on the PATH.
    run = subprocess.run(["/usr/bin/mkdocs", "build", "--strict", "--config-file", str(config)], text=True,
                         stderr=subprocess.PIPE, check=False)
    if run.returncode != 0:
        sys.exit(f"pipelines/site: mkdocs: {run.stderr.strip()}")
    add_search(output)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
