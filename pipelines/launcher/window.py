"""The window: trainees on the left; exercises, sessions and what to do with them on the right."""
import datetime
import subprocess
import tkinter as tk
import traceback
from tkinter import font, ttk

import questions
import sessions
from files import UserError
from sessions import State

POLL_MS = 200
ROW_PX = 28
REASONS = ["reason_device", "reason_interrupted", "reason_trainee", "reason_exercise"]


class Window(tk.Tk):
    def __init__(self, workplace, jobs, texts):
        super().__init__(className="AcusTrainingDay")
        self.workplace, self.jobs, self.texts = workplace, jobs, texts
        self.found, self.steps, self.shown, self.running = [], {}, [], None
        self.filled_for = None, None  # Trainee and next exercise that the right side was filled for.
        self.title(texts("title", workplace=workplace.folder.name))
        self.geometry("1280x720+0+0")
        self.minsize(1000, 600)
        self._style()
        self._build()
        self.protocol("WM_DELETE_WINDOW", self.close)
        self.reload()
        left = sessions.to_finish(self.found)
        self.say(texts("found_left", count=len(left)) if left else texts("ready"))
        self.check_devices()
        self.after(POLL_MS, self._poll)

    def _style(self):
        for name in ("TkDefaultFont", "TkTextFont", "TkHeadingFont"):
            font.nametofont(name).configure(size=-15)
        style = ttk.Style(self)
        style.theme_use("clam")
        style.configure("Treeview", rowheight=ROW_PX)
        style.configure("Start.TButton", font=("TkDefaultFont", -19, "bold"), padding=10)
        style.configure("Title.TLabel", font=("TkDefaultFont", -17, "bold"))
        style.configure("Bad.TLabel", foreground="#a00000")

    def _build(self):
        self.columnconfigure(1, weight=1)
        self.rowconfigure(0, weight=1)
        left = ttk.Frame(self, padding=8)
        left.grid(row=0, column=0, sticky="ns")
        left.rowconfigure(1, weight=1)
        ttk.Label(left, text=self.texts("trainees"), style="Title.TLabel").grid(sticky="w")
        self.trainees = self._table(left, {"code": 90, "next": 240, "counted": 90}, height=12)
        self.trainees.master.grid(row=1, sticky="ns")
        self.trainees.bind("<<TreeviewSelect>>", lambda _: self._show_trainee())
        ttk.Label(left, text=self.texts("ask_code"), wraplength=380).grid(row=2, sticky="w", pady=(8, 0))
        adding = ttk.Frame(left)
        adding.grid(row=3, sticky="ew")
        self.new_code = ttk.Entry(adding, width=18)
        self.new_code.pack(side="left")
        self.new_code.bind("<Return>", lambda _: self.do(self.add_trainee))
        self.left_handed = tk.BooleanVar(self)
        ttk.Button(adding, text=self.texts("add"), command=lambda: self.do(self.add_trainee)).pack(side="left", padx=6)
        ttk.Checkbutton(adding, text=self.texts("left_handed"), variable=self.left_handed).pack(side="left")

        self.right = ttk.Frame(self, padding=8)
        self.right.grid(row=0, column=1, sticky="nsew")
        self.right.columnconfigure(0, weight=1)
        self.right.rowconfigure(1, weight=1)
        self.right.rowconfigure(3, weight=1)
        self.heads = {}
        for row, name in ((0, "exercises"), (2, "sessions")):
            self.heads[name] = ttk.Label(self.right, style="Title.TLabel")
            self.heads[name].grid(row=row, sticky="w")
        self.exercises = self._table(self.right, {"exercise": 320, "state": 110, "trials": 70, "best": 100}, height=5)
        self.exercises.master.grid(row=1, sticky="nsew")
        self.list = self._table(
            self.right, {"time": 170, "exercise": 190, "state": 150, "goals": 100, "reason": 180}, height=7)
        self.list.master.grid(row=3, sticky="nsew")
        self._build_buttons()
        self.asked = None  # A question in place of the right side.

        below = ttk.Frame(self, padding=8)
        below.grid(row=1, column=0, columnspan=2, sticky="ew")
        below.columnconfigure(0, weight=1)
        self.status = ttk.Label(below, wraplength=1100)
        self.status.grid(row=0, column=0, sticky="w")
        self.reports = ttk.Label(below)
        self.reports.grid(row=0, column=1, sticky="e")
        self.devices = ttk.Label(below, wraplength=1000)
        self.devices.grid(row=1, column=0, sticky="w")
        self._button(below, "check", "<F4>", self.check_devices).grid(row=1, column=1, sticky="e")

    def _build_buttons(self):
        bar = ttk.Frame(self.right)
        bar.grid(row=4, sticky="ew", pady=(8, 0))
        start = self._button(bar, "start", "<F5>", self.start)
        start.configure(style="Start.TButton")
        start.pack(side="left", padx=(0, 14))
        for key, shortcut, action in (("repeat", "<F6>", self.repeat), ("discard", "<F7>", self.discard),
                                      ("questionnaire", "<F8>", self.ask_questionnaire),
                                      ("report", "<F9>", self.open_report)):
            self._button(bar, key, shortcut, action).pack(side="left", padx=3)

    def _button(self, parent, key, shortcut, action):
        """Key and button do the same; a question on the right side has to be answered first."""
        def act(_=None):
            if self.asked is None:
                self.do(action)
        self.bind(shortcut, act)
        return ttk.Button(parent, text=self.texts(key), command=act)

    def _table(self, parent, columns, height):
        frame = ttk.Frame(parent)
        frame.rowconfigure(0, weight=1)
        frame.columnconfigure(0, weight=1)
        table = ttk.Treeview(frame, columns=list(columns), show="headings", height=height, selectmode="browse")
        for name, width in columns.items():
            table.heading(name, text=self.texts(f"column_{name}"), anchor="w")
            table.column(name, width=width, minwidth=40)
        bar = ttk.Scrollbar(frame, command=table.yview)
        table.configure(yscrollcommand=bar.set)
        table.grid(row=0, column=0, sticky="nsew")
        bar.grid(row=0, column=1, sticky="ns")
        return table

    # What is shown

    def say(self, text, bad=False):
        self.status.configure(text=text, style="Bad.TLabel" if bad else "TLabel")

    def do(self, action):
        """Runs an action; what the user can mend is said in the window."""
        if self.filled_for[0] != self.trainee():
            self._show_trainee()  # Two fast clicks: Tk tells of the new selection after the second one.
        try:
            action()
        except UserError as error:
            self.say(str(error), bad=True)

    def reload(self):
        """Reads the workplace again; the chosen trainee stays chosen."""
        chosen = self.trainee()
        self.found = sessions.find(self.workplace.folder)
        self.jobs.finish(self.found)
        codes = self.workplace.trainees(self.found)
        try:
            self.steps = self.workplace.steps(codes, self.found)
        except UserError as error:
            self.say(str(error), bad=True)
        self.trainees.delete(*self.trainees.get_children())
        for code in codes:
            counted = sum(s.trainee == code and s.state is not State.DISCARDED for s in self.found)
            self.trainees.insert("", "end", iid=code, values=(code, self._next_of(code), counted or ""))
        if chosen in codes:
            self.trainees.selection_set(chosen)
        self._show_trainee()

    def _next_of(self, code):
        steps, following = self.steps.get(code, ([], None))
        if following is not None:
            return self.workplace.exercises[following]
        if not steps:
            return ""  # The curriculum cannot be read.
        left = any(step.state == "open" and step.exercise is None for step in steps)
        return self.texts("next_not_here" if left else "next_none")

    def _show_trainee(self):
        code = self.trainee()
        kept_exercise = self.exercises.selection()
        kept_session = [self.shown[int(place)].folder for place in self.list.selection()]
        for name, label in self.heads.items():
            label.configure(text=self.texts(name, code=code or "-"))
        for table in (self.exercises, self.list):
            table.delete(*table.get_children())
        if code is None:
            self.filled_for = None, None
            return
        steps, following = self.steps.get(code, ([], None))
        for place, step in enumerate(steps):
            best = f"{step.best_percent:.0f} %" if step.trials and self.workplace.curriculum.exists() else ""
            self.exercises.insert("", "end", iid=str(place), values=(
                step.title, self.texts(f"state_{step.state}"), step.trials or "", best))
            if step.exercise is not None and step.exercise == following:
                self.exercises.selection_set(str(place))
        # What was chosen by hand stays so while only states change.
        if self.filled_for == (code, following) and kept_exercise:
            self.exercises.selection_set(kept_exercise)
        self.filled_for = code, following
        self.shown = [session for session in self.found if session.trainee == code]
        for place in reversed(range(len(self.shown))):
            session = self.shown[place]
            self.list.insert("", "end", iid=str(place), values=(
                f"{session.day} {session.time}", self.workplace.exercises.get(session.exercise, session.exercise),
                self.texts(f"state_{session.state.value}"), session.goals, session.reason))
        chosen = [place for place, session in enumerate(self.shown) if session.folder in kept_session]
        if self.shown:
            self.list.selection_set(str(chosen[0] if chosen else len(self.shown) - 1))

    def trainee(self):
        chosen = self.trainees.selection()
        return chosen[0] if chosen else None

    def _chosen_trainee(self):
        if self.trainee() is None:
            raise UserError(self.texts("none_chosen"))
        return self.trainee()

    def _chosen_session(self):
        code, chosen = self._chosen_trainee(), self.list.selection()
        if not chosen:
            raise UserError(self.texts("no_session_chosen", code=code))
        return self.shown[int(chosen[0])]

    def _title_of(self, exercise):
        return self.workplace.exercises.get(exercise, exercise)

    # What is done

    def add_trainee(self):
        code = self.new_code.get().strip()
        self.workplace.add_trainee(code, self.found, "left" if self.left_handed.get() else "right")
        self.new_code.delete(0, "end")
        self.left_handed.set(False)
        self.reload()
        self.trainees.selection_set(code)
        self.trainees.see(code)
        self.focus_set()
        self.say(self.texts("ready"))

    def start(self):
        code, chosen = self._chosen_trainee(), self.exercises.selection()
        exercise = self.steps[code][0][int(chosen[0])].exercise if chosen else None
        if exercise is None:
            raise UserError(self.texts("not_in_workplace"))
        self._start(code, exercise)

    def _start(self, code, exercise):
        if self.jobs.session is not None:
            raise UserError(self.texts("session_running"))
        if self.workplace.must_ask_consent(code):
            def answer(given):
                self.workplace.record_consent(code, given)
                self._start(code, exercise)
            text = self.texts("ask_consent", code=code, study=self.workplace.study.get("name", ""))
            self._ask(questions.YesNo(self.right, self.texts, text, answer))
            return
        step = next((step for step in self.steps[code][0] if step.exercise == exercise), None)
        done = [session for session in self.found if session.trainee == code and session.exercise == exercise and
                session.state is not State.DISCARDED]
        self.jobs.start_session(code, exercise, len(done) + 1, step and step.limit_s,
                                self.workplace.is_left_handed(code), self._caption_of(step))
        self.running = code
        self.say(self.texts("running", code=code, exercise=self._title_of(exercise)))

    def _caption_of(self, step):
        """Of the session's window: where the trainee is in the curriculum."""
        if step is None or step.place is None:
            return ""
        number, count, row, needed = step.place
        return self.texts("place_in_curriculum", number=number, count=count, row=min(row, needed), needed=needed)

    def repeat(self):
        session = self._chosen_session()
        if self.jobs.session is not None:
            raise UserError(self.texts("session_running"))
        if session.state is State.DISCARDED:
            self._start(session.trainee, session.exercise)
        else:
            self._ask_reason("ask_reason_repeat", session,
                             lambda: self._start(session.trainee, session.exercise))

    def discard(self):
        session = self._chosen_session()
        if session.state is State.DISCARDED:
            raise UserError(self.texts("discarded", time=session.time, reason=session.reason))
        self._ask_reason("ask_reason", session, lambda: None)

    def _ask_reason(self, key, session, afterwards):
        def answer(reason):
            sessions.discard(session, reason)
            self.jobs.remake_progress(session)
            self.reload()
            self.say(self.texts("discarded", time=session.time, reason=reason))
            afterwards()
        text = self.texts(key, code=session.trainee, exercise=self._title_of(session.exercise), time=session.time)
        self._ask(questions.Reason(self.right, self.texts, text, [self.texts(word) for word in REASONS], answer))

    def ask_questionnaire(self):
        code = self._chosen_trainee()
        asked = self.workplace.open_questionnaire(code)
        if asked is None:
            raise UserError(self.texts("no_questionnaire", code=code))

        def answer(answers):
            self.workplace.record_answers(code, asked, answers)
            self.say(self.texts("answers_kept", code=code))
            if len(answers) == len(asked.items) and self.workplace.open_questionnaire(code) is not None:
                self.ask_questionnaire()  # The next one.
        self._ask(questions.Likert(self.right, self.texts, code, asked, answer, self.say))

    def _ask(self, question):
        """Shows a question in place of the right side, until it is answered or cancelled."""
        self.asked = question
        for child in self.right.winfo_children():
            if child is not question:
                child.grid_remove()
        question.grid(row=0, column=0, rowspan=5, sticky="nsew")
        question.on_end = self._asked
        question.begin()

    def _asked(self, action):
        question, self.asked = self.asked, None
        question.destroy()
        for child in self.right.winfo_children():
            child.grid()
        self.focus_set()
        if action is not None:
            self.do(action)

    def open_report(self):
        session = self._chosen_session()
        if not session.report.exists():
            raise UserError(self.texts("report_pending"))
        try:
            subprocess.Popen(["xdg-open", session.report], start_new_session=True, stdin=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.say(self.texts("report_opened", time=session.time))
        except OSError:
            self.say(str(session.report))

    def check_devices(self):
        if self.jobs.session is not None:
            raise UserError(self.texts("session_running"))
        self.jobs.start_check()
        self.devices.configure(text=self.texts("check_running"), style="TLabel")

    def close(self):
        """A session goes on until it is ended in its window; then the launcher may close."""
        if self.jobs.session is not None:
            self.say(self.texts("session_running"), bad=True)
            return
        self.jobs.close()
        self.destroy()

    def _show_check(self, code, said):
        if code != 0:
            self.devices.configure(text=self.texts("check_failed", said=said), style="Bad.TLabel")
            return
        text = self.texts("check_ok", time=datetime.datetime.now().strftime("%H:%M"))
        registration = self.workplace.registration()
        if registration is not None:
            text += " " + self.texts("registration", error=f"{registration[0]:.2f}", markers=registration[1])
        self.devices.configure(text=text, style="TLabel")

    def report_callback_exception(self, exc, val, tb):
        """Of Tk: what nobody foresaw is told, and the window stays."""
        traceback.print_exception(exc, val, tb)
        self.say(f"{exc.__name__}: {val}", bad=True)

    def _poll(self):
        self.after(POLL_MS, self._poll)
        self.do(self._take_what_ended)

    def _take_what_ended(self):
        ended = self.jobs.poll()
        for kind, code, said in ended:
            if kind == "check":
                self._show_check(code, said)
            elif kind == "session" and code == 0:
                self.list.selection_set(())  # The new one will be chosen.
                self.say(self.texts("session_ended", code=self.running))
            elif kind == "session":
                self.say(self.texts("failed_session", code=code, said=said), bad=True)
            elif code != 0:
                self.say(self.texts("failed_report", said=said), bad=True)
        if any(kind != "check" for kind, _, _ in ended):
            self.reload()
        waiting = self.jobs.num_reports
        self.reports.configure(text=self.texts("reports_waiting", count=waiting) if waiting else "")
