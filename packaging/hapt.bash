# bash completion of hapt and its fellows; it asks the programs what they understand

# the sub-commands of a help text; the options and what may stand for its positional words
_hapt_commands() { sed -nE '/^Subcommands:/,$ s/^  ([a-z][a-z0-9-]*) .*/\1/p'; }
_hapt_options() { sed -nE 's/^  (-[a-zA-Z],)?(--[a-z0-9-]+).*/\2/p'; }
_hapt_positionals() { sed -nE '/^Positionals:/,/^$/ s/.*[{]([^}]*)[}].*/\1/p' | tr , ' '; }

_hapt() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} word help line
  local -a command=("${COMP_WORDS[0]}")
  COMPREPLY=()
  help=$("${command[@]}" --help 2>/dev/null) || return
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if _hapt_commands <<<"$help" | grep -qxF -- "$word"; then
      command+=("$word")
      help=$("${command[@]}" --help 2>/dev/null) || return
    fi
  done
  if [[ $previous == -* ]]; then
    line=$(grep -E -m 1 -- "^  (-.,)?${previous}[ ,]" <<<"$help")
    # a set of words; any other value is completed as a file name
    if [[ $line =~ \{([^}]*)\} ]]; then
      mapfile -t COMPREPLY < <(compgen -W "${BASH_REMATCH[1]//,/ }" -- "$current")
      return
    fi
    [[ $line =~ ^\ +-[^\ ]*\ [A-Z] ]] && return
  fi
  word="$(_hapt_commands <<<"$help") $(_hapt_positionals <<<"$help")"
  if [[ $current == -* || -z ${word// /} ]]; then word+=" $(_hapt_options <<<"$help")"; fi
  mapfile -t COMPREPLY < <(compgen -W "$word" -- "$current")
}
complete -o default -F _hapt hapt hapticd haptic-emulator
