# $1: folder, $2: digest, $3: name, $4: size, $5: mode. Standard input: the file. It has its name only when all of it is there.
LC_ALL=C; export LC_ALL; umask 077;
d="$1/$2"; t="$d/.$3.$$.part";
e=$(mkdir -p "$d" 2>&1) || { echo "error $e"; exit 1; };
# Halves whose writers have ended.
for p in "$d"/.*.part; do
q=${p%.part}; q=${q##*.};
case "$q" in ""|*[!0-9]*) ;; *) kill -0 "$q" 2>/dev/null || rm -f "$p";; esac;
done;
trap 'rm -f "$t"' EXIT; trap 'exit 1' HUP INT TERM PIPE;
e=$( { cat >"$t"; } 2>&1 ) || { echo "error $e"; exit 1; };
s=$(wc -c <"$t");
if [ "$s" -eq "$4" ]; then :; else echo "short $s"; exit 1; fi;
if command -v sha256sum >/dev/null 2>&1; then
set -- "$@" $(sha256sum <"$t");
if [ "$6" = "$2" ]; then :; else echo "damaged $6"; exit 1; fi;
fi;
e=$( { chmod "$5" "$t" && { sync "$t" 2>/dev/null || sync; } && mv -f "$t" "$d/$3"; } 2>&1 ) || { echo "error $e"; exit 1; };
echo stored
