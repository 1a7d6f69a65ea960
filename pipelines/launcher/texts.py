"""What the window says: a file of words for each language in texts/, English for what another one lacks."""
import json
import os
import pathlib

FOLDER = pathlib.Path(__file__).resolve().parent / "texts"


class Texts:
    def __init__(self, language=None):
        """language: a name of a file in texts/, such as de; default: that of the environment, if it is there."""
        self.words = load("en")
        language = language or (os.environ.get("LC_ALL") or os.environ.get("LC_MESSAGES") or
                                os.environ.get("LANG") or "en")[:2]
        if language != "en" and (FOLDER / f"{language}.json").exists():
            self.words.update(load(language))

    def __call__(self, key, **values):
        return self.words[key].format(**values)


def load(language):
    with open(FOLDER / f"{language}.json", encoding="utf-8") as stream:
        return json.load(stream)


def languages():
    return sorted(file.stem for file in FOLDER.glob("*.json"))
