"""Questions that take the place of the window's right side: yes or no, a reason, a questionnaire."""
import tkinter as tk
from tkinter import ttk

WRAP_PX = 640


class Question(ttk.Frame):
    """Ends with on_end(action): None if it was cancelled."""

    def __init__(self, parent, texts, text):
        super().__init__(parent, padding=12)
        self.texts = texts
        self.on_end = None
        self.columnconfigure(0, weight=1)
        ttk.Label(self, text=text, wraplength=WRAP_PX, style="Title.TLabel").grid(row=0, sticky="w", pady=(0, 12))
        self.body = ttk.Frame(self)
        self.body.grid(row=1, sticky="nsew")
        self.buttons = ttk.Frame(self)
        self.buttons.grid(row=2, sticky="w", pady=(14, 0))

    def begin(self):
        self.focus_set()

    def end(self, action):
        self.on_end(action)

    def add_button(self, key, shortcut, action):
        ttk.Button(self.buttons, text=self.texts(key), command=action).pack(side="left", padx=(0, 8))
        self.bind_all_within(shortcut, action)

    def bind_all_within(self, shortcut, action):
        """For the question and all that is in it."""
        tag = f"question{id(self)}"
        self.bind_class(tag, shortcut, lambda _: action())

        def mark(widget):
            if tag not in widget.bindtags():
                widget.bindtags((tag, *widget.bindtags()))
            for child in widget.winfo_children():
                mark(child)
        mark(self)


class YesNo(Question):
    def __init__(self, parent, texts, text, answer):
        super().__init__(parent, texts, text)
        self.add_button("consent_yes", "<F2>", lambda: self.end(lambda: answer(True)))
        self.add_button("consent_no", "<F3>", lambda: self.end(lambda: answer(False)))
        self.add_button("cancel", "<Escape>", lambda: self.end(None))


class Reason(Question):
    def __init__(self, parent, texts, text, examples, answer):
        super().__init__(parent, texts, text)
        self.entry = ttk.Entry(self.body, width=50)
        self.entry.pack(anchor="w")
        ttk.Label(self.body, text=texts("reasons")).pack(anchor="w", pady=6)
        for words in examples:
            ttk.Button(self.body, text=words, width=30, command=lambda w=words: self._take(w)).pack(anchor="w", pady=2)
        self.answer = answer
        self.add_button("ok", "<Return>", self._finish)
        self.add_button("cancel", "<Escape>", lambda: self.end(None))

    def begin(self):
        self.entry.focus_set()

    def _take(self, words):
        self.entry.delete(0, "end")
        self.entry.insert(0, words)
        self.entry.focus_set()

    def _finish(self):
        reason = self.entry.get().strip()
        if reason:
            self.end(lambda: self.answer(reason))


class Likert(Question):
    """A statement a row, a column for each word of the scale. Digits answer the marked row and go to the next."""

    def __init__(self, parent, texts, code, asked, answer, say):
        super().__init__(parent, texts, texts("questionnaire_of", code=code, title=asked.title))
        self.asked, self.answer, self.say = asked, answer, say
        self.values = [tk.IntVar(self, 0) for _ in asked.items]
        self.at, self.warned = 0, False
        for place, word in enumerate(asked.scale):
            ttk.Label(self.body, text=f"{place + 1}\n{word}", wraplength=80, justify="center").grid(
                row=0, column=place + 1, padx=4)
        self.labels = []
        for row, (_, text) in enumerate(asked.items):
            label = ttk.Label(self.body, text=text, wraplength=290)
            label.grid(row=row + 1, column=0, sticky="w", pady=6)
            self.labels.append(label)
            for place in range(len(asked.scale)):
                ttk.Radiobutton(self.body, variable=self.values[row], value=place + 1,
                                command=lambda r=row: self._go(r + 1)).grid(row=row + 1, column=place + 1)
        self.add_button("record", "<Return>", self._finish)
        self.add_button("cancel", "<Escape>", lambda: self.end(None))
        for digit in range(1, min(9, len(asked.scale)) + 1):
            for key in (f"<Key-{digit}>", f"<KP_{digit}>"):
                self.bind_all_within(key, lambda d=digit: self._digit(d))
        self._go(0)

    def _go(self, row):
        self.at = row
        for place, label in enumerate(self.labels):
            label.configure(font=("TkDefaultFont", -15, "bold" if place == row else "normal"))
        self.focus_set()

    def _digit(self, digit):
        if self.at < len(self.values):
            self.values[self.at].set(digit)
            self._go(self.at + 1)

    def _finish(self):
        answers = {key: value.get() for (key, _), value in zip(self.asked.items, self.values) if value.get()}
        left = len(self.values) - len(answers)
        if left and not self.warned:
            self.warned = True
            self.say(self.texts("answers_missing", left=left), bad=True)
        elif answers:
            self.end(lambda: self.answer(answers))
        else:
            self.end(None)
