"""What the window says: English words in texts/en.json, translated by the catalogues of gettext (lib/po/)."""
import gettext
import json
import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]


def program_folder():
    in_sources = (ROOT / "CMakeLists.txt").exists()
    beside = ROOT / "build/bin" if in_sources else ROOT.parent.parent / "bin"
    return pathlib.Path(os.environ.get("ACUS_BIN", beside)).resolve()


def locale_folder():
    return program_folder().parent / "share" / "locale"


def english():
    with open(pathlib.Path(__file__).resolve().parent / "texts/en.json", encoding="utf-8") as stream:
        return json.load(stream)


class Texts:
    def __init__(self, language=None):
        """language: that of a catalogue, such as de; default: that of the environment. Without a catalogue: English."""
        chosen = gettext.translation("acus", locale_folder(), [language] if language else None, fallback=True)
        self.words = {key: chosen.gettext(text) for key, text in english().items()}

    def __call__(self, key, **values):
        return self.words[key].format(**values)


def languages():
    return sorted({"en", *(file.parents[1].name for file in locale_folder().glob("*/LC_MESSAGES/acus.mo"))})
