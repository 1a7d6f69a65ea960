#!/usr/bin/env python3
"""Completion of options, choices, subcommands and presets for bash and zsh, from --help.

Usage: completions.py PROGRAMS_FOLDER WORKFLOWS_FOLDER OUTPUT_FOLDER
"""
import pathlib
import shlex
import sys

sys.dont_write_bytecode = True
import commands  # noqa: E402

# Looked up by "PROGRAM" or "PROGRAM SUBCOMMAND"; presets are asked of `acus list` when they are wanted.
BASH = r"""# Completion of Acus' commands. Made from their --help.
declare -gA _acus_options=({options})
declare -gA _acus_choices=({choices})
declare -gA _acus_subcommands=({subcommands})

_acus_presets() {{
  local kind=${{1%%/*}}
  [[ $1 == */* ]] && acus list "$kind" --names 2>/dev/null
}}

_acus() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
  local program=${{COMP_WORDS[0]##*/}} first=1 command
  if [[ $program == acus && $COMP_CWORD -gt 1 ]]; then
    if [[ -v _acus_options[acus-${{COMP_WORDS[1]}}] ]]; then
      program=acus-${{COMP_WORDS[1]}} first=2
    elif [[ -v _acus_options["acus ${{COMP_WORDS[1]}}"] ]]; then
      program="acus ${{COMP_WORDS[1]}}" first=2
    fi
  fi
  command=$program
  local word
  for word in "${{COMP_WORDS[@]:first:COMP_CWORD-first}}"; do
    [[ " ${{_acus_subcommands[$program]-}} " != *" $word "* ]] || command="$program $word"
  done
  COMPREPLY=()
  if [[ -v _acus_choices["$command $previous"] ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${{_acus_choices["$command $previous"]}}" -- "$current")
  elif [[ $current == -* ]]; then
    local options=${{_acus_options[$command]}}
    [[ $command == "$program" ]] || options+=" ${{_acus_options[$program]}}"
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  elif [[ $command == "acus list" && $COMP_CWORD -eq 2 ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(acus list --names 2>/dev/null)" -- "$current")
  elif [[ -n ${{_acus_subcommands[$program]-}} && $command == "$program" ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${{_acus_subcommands[$program]}}" -- "$current")
  fi
  if [[ ${{#COMPREPLY[@]}} -eq 0 ]]; then
    compopt -o filenames
    mapfile -t COMPREPLY < <(compgen -f -- "$current" || true; compgen -W "$(_acus_presets "$current")" -- "$current")
  fi
}}
complete -F _acus {programs}
"""

ZSH = r"""#compdef {programs}
# Completion of Acus' commands. Made from their --help.
typeset -gA _acus_options _acus_choices _acus_subcommands
_acus_options=({options})
_acus_choices=({choices})
_acus_subcommands=({subcommands})

_acus() {{
  local program=${{words[1]:t}} first=2 command word
  if [[ $program == acus && $CURRENT -gt 2 ]]; then
    if (( $+_acus_options[acus-${{words[2]}}] )); then
      program=acus-${{words[2]}} first=3
    elif (( $+_acus_options[acus ${{words[2]}}] )); then
      program="acus ${{words[2]}}" first=3
    fi
  fi
  command=$program
  for word in ${{words[first,CURRENT-1]}}; do
    [[ " ${{_acus_subcommands[$program]}} " == *" $word "* ]] && command="$program $word"
  done
  local choices=${{_acus_choices[$command ${{words[CURRENT-1]}}]}}
  if [[ -n $choices ]]; then
    compadd -- ${{=choices}}
  elif [[ $PREFIX == -* ]]; then
    local options=${{_acus_options[$command]}}
    [[ $command == $program ]] || options+=" ${{_acus_options[$program]}}"
    compadd -- ${{=options}}
  elif [[ $command == "acus list" && $CURRENT -eq 3 ]]; then
    compadd -- $(acus list --names 2>/dev/null)
  elif [[ $command == $program && -n ${{_acus_subcommands[$program]}} ]]; then
    compadd -- ${{=_acus_subcommands[$program]}}
  else
    [[ $PREFIX != */* ]] || compadd -- $(acus list "${{PREFIX%%/*}}" --names 2>/dev/null)
    _files
  fi
}}
_acus "$@"
"""


def table(rows, line):
    return "\n" + "".join(line.format(shlex.quote(key), shlex.quote(" ".join(words))) for key, words in rows)


def main(programs, workflows, output):
    found = list(commands.all_commands(pathlib.Path(programs), pathlib.Path(workflows)))
    known = [each for command in found for each in (command, *command.subcommands)]
    options = [(c.name, [o for item in c.items() for o in item.options()]) for c in known]
    choices = [(f"{c.name} {option}", item.choices())
               for c in known for item in c.items() if item.choices() for option in item.options()]
    subcommands = [(c.name, [s.name.split()[-1] for s in c.subcommands]) for c in found if c.subcommands]
    workflow_names = [c.name.split()[1] for c in found if " " in c.name]
    program_names = [c.name for c in found if " " not in c.name]
    everything = ["list", *(name.removeprefix("acus-") for name in program_names if name != "acus"), *workflow_names]
    subcommands = [(name, words) for name, words in subcommands if name != "acus"] + [("acus", everything)]

    def script(template, line):
        return template.format(options=table(options, line), choices=table(choices, line),
                               subcommands=table(subcommands, line), programs=" ".join(program_names))

    bash = pathlib.Path(output) / "bash-completion/completions"
    bash.mkdir(parents=True, exist_ok=True)
    (bash / "acus").write_text(script(BASH, "  [{}]={}\n"), encoding="utf-8")
    for name in program_names:
        if name != "acus":
            link = bash / name
            link.unlink(missing_ok=True)
            link.symlink_to("acus")
    zsh = pathlib.Path(output) / "zsh/vendor-completions"
    zsh.mkdir(parents=True, exist_ok=True)
    (zsh / "_acus").write_text(script(ZSH, "  {} {}\n"), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
