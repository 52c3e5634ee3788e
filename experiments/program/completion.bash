# SPDX-License-Identifier: BSD-3-Clause
# Completes the commands and options of s2nnds in bash; they come from its own help.
_s2nnds() {
  local -r word=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]}
  local help words
  if [[ $COMP_CWORD -eq 1 ]]; then
    help=$("$program" --help 2>/dev/null) || return
    words=$(sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help")
    [[ $word != -* ]] || words="--help --version"
  elif [[ $word == -* ]]; then
    help=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null) || return
    words=$(grep -oE -- '--[a-z][a-z-]*' <<<"$help" | sort -u)
  else
    return  # a file's name
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
complete -o default -F _s2nnds s2nnds
