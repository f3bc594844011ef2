# Completes palp's programs: options as --help lists them, names of scenes, hands and profiles, files.
_palp() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} folder='' data words=''
  data=${PALP_DATA_DIR:-$(dirname "$(command -v "$1" 2>/dev/null)")/../share/palp}
  case $before in
    --hand) folder=hands ;;
    --profile) folder=devices ;;
    palp-sim-server | palp-run | --scene) folder=scenes ;;
  esac
  if [[ $word == -* ]]; then
    words=$("$1" --help 2>/dev/null | grep -oE -- '(^|[ ,])--[a-z][a-z0-9-]*' | tr -d ' ,' | sort -u)
  elif [ -n "$folder" ]; then
    words=$(find "$data/$folder" -name '*.toml' -printf '%f\n' 2>/dev/null | sed 's/\.toml$//')
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  compopt -o default
}
complete -F _palp "${BASH_SOURCE[0]##*/}"
