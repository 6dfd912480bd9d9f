# $1: file, $2: mode. Standard input: what it is to hold.
LC_ALL=C; export LC_ALL; umask 077;
t="$1.$$"; trap 'rm -f "$t"' EXIT;
e=$( { mkdir -p "${1%/*}" && cat >"$t" && chmod "$2" "$t" && mv -f "$t" "$1"; } 2>&1 ) || { echo "error $e"; exit 1; };
echo done
