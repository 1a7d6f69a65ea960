"""Each mutant behind its switch does what the same change of the source does; each reason why none
notices a change names a line of the source.
mutants.py SOURCE WORK"""
import os
import pathlib
import shutil
import subprocess
import sys

source, work = map(pathlib.Path, sys.argv[1:])
sys.dont_write_bytecode = True
sys.path.insert(0, str(source / "developer"))
from mutation import mutants, reasons  # noqa: E402

SAMPLE = """#include <algorithm>
#include <cmath>
#include <cstdio>
constexpr double kFactor = 0.5;
bool Asks(int& count) { count += 1; return true; }
int main() {
  int count = 0;
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    if (i >= 2 && Asks(count) || i == 1) sum += kFactor * i - 0.25 / 2.0;
    sum -= std::max(0.125 * i, std::sin(i * 1.0));
  }
  const bool done = sum != 0.0 && true;
  std::printf("%.6f %d %d\\n", sum, count, done);
}
"""


def output(text, name, number=None):
    file = work / f"{name}.cpp"
    file.write_text(text, encoding="utf-8")
    if number is None:
        subprocess.run(["c++", "-std=c++20", "-w", "-O0", file, "-o", work / name], check=True)
    environment = {**os.environ, "MUTANT": str(number)} if number else os.environ
    return subprocess.run([work / name], check=True, capture_output=True, text=True, env=environment,
                          timeout=10).stdout


shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
sample = work / "sample.cpp"
sample.write_text(SAMPLE, encoding="utf-8")
numbered = list(enumerate(mutants.candidates(sample), start=1))
together, taken = mutants.with_mutants(SAMPLE, numbered, source / "developer/mutation/mutant.h")
unchanged = output(SAMPLE, "plain")
assert output(together, "together") == unchanged
seen = set()
for number, mutant in numbered:
    if number not in taken:
        continue
    changed = SAMPLE[:mutant.offset] + mutant.after + SAMPLE[mutant.offset + len(mutant.before):]
    expected = output(changed, "alone")
    found = output(together, "together", number)
    assert found == expected, f"{mutant}: {found} for {expected}"
    seen.add(mutant.before)
print(f"{len(taken)} of {len(numbered)} changes, {len(seen)} tokens")
assert len(taken) >= 30 and len(seen) >= 18

for file, text, before, after in reasons.read():
    lines = {line.strip() for line in (source / file).read_text(encoding="utf-8").splitlines()}
    assert text in lines, f"{reasons.TABLE.name}: {file} has no line '{text}'; remove the row or correct it"
    assert before in text and before != after
