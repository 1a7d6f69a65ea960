# What Tab offers in zsh, by the file that is installed. Usage: completion.zsh FOLDER_OF_COMPLETIONS
zmodload zsh/zpty
export PATH="$ACUS_BIN:$PATH" TERM=dumb
zpty shell zsh -f -i
# What is offered is caught between marks, whatever the terminal makes of it.
zpty -w shell "PS1= PS2= RPS1=; fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -D"
zpty -w shell "compadd() { local words=(\"\${@[\$@[(i)--]+1,-1]}\"); words=(\${(M)words:#\$PREFIX*}); print -r -- \"<<\$words>>\"; return 0 }"
zpty -w shell "_files() { return 0 }; bindkey '^I' list-choices; print READY"

# offer TITLE LINE: what completes the end of the line.
offer() {
  local seen all= found
  zpty -n -w shell "$2"$'\t'
  repeat 100; do
    zpty -r -t shell seen && all+=$seen || sleep 0.1
    [[ $all == *'<<'*'>>'* ]] && break
  done
  found=${${all##*'<<'}%%'>>'*}
  print -r -- "$1: $found"
  zpty -w shell $'\x15'
  repeat 5; do zpty -r -t shell seen || sleep 0.05; done
}
repeat 100; do zpty -r -t shell seen && [[ $seen == READY* ]] && break || sleep 0.1; done
offer subcommands "acus-camera "
offer options "acus-replay --overw"
offer commands "acus rep"
offer presets "acus-replay needles/sp"
offer choices "acus-breathing --model "
offer "through acus" "acus replay --overw"
offer kinds "acus list need"
zpty -d shell
