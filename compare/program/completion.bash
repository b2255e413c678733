# Completion of `concord` in bash, and in zsh after `autoload -U +X bashcompinit && bashcompinit`: commands, options and
# files. What there is comes from the program's own --help, so that it fits the program that is found.
_concord() {
  local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} words=""
  if ((COMP_CWORD == 1)); then
    words=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z]*\) .*/\1/p')
    words+=" --help --version"
  elif [[ $word == -* ]]; then
    words=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null | sed -n '/^Examples:/q; s/^  \(-[-a-zA-Z,]*\).*/\1/p' | tr ',' '\n')
  fi
  # shellcheck disable=SC2207
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _concord concord
