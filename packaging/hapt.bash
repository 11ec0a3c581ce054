# bash completion of hapt and its fellows; it asks the programs what they understand

# the sub-commands and the options of a help text
_hapt_commands() { sed -nE '/^Commands:/,/^$/ s/^  ([a-z][a-z0-9-]*)( .*|$)/\1/p'; }
_hapt_options() { sed -nE 's/^  (-[a-zA-Z], )?(--[a-z0-9-]+).*/\2/p'; }
# renderers and scenes, as the programs list them
_hapt_renderers() {
  tr -s ' \n' ' ' | sed -nE 's/.*--renderer NAME[^:]*: ([a-z0-9, -]*) \(.*/\1/p' | tr -d ,
}
_hapt_scenes() { "$1" demo --list 2>/dev/null | sed -nE 's/^hapt demo ([a-z][a-z-]*) .*/\1/p'; }

_hapt() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} word help
  local -a command=("${COMP_WORDS[0]}")
  COMPREPLY=()
  help=$("${command[@]}" --help 2>/dev/null) || return
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if _hapt_commands <<<"$help" | grep -qxF -- "$word"; then
      command+=("$word")
      help=$("${command[@]}" --help 2>/dev/null) || return
    fi
  done
  word=$(_hapt_commands <<<"$help")
  if [[ $previous == --renderer ]]; then
    word=$(_hapt_renderers <<<"$help")
  elif [[ $previous == -* ]] && grep -qE -- "^  (-., )?${previous} [A-Z]" <<<"$help"; then
    return # a value: completed as a file name
  elif [[ ${command[*]} == *hapt\ demo && $current != -* ]]; then
    word=$(_hapt_scenes "${command[0]}")
  elif [[ $current == -* || -z $word ]]; then
    word+=" $(_hapt_options <<<"$help")"
  fi
  mapfile -t COMPREPLY < <(compgen -W "$word" -- "$current")
}
complete -o default -F _hapt hapt hapticd haptic-emulator
