# $1: folder, $2: `make` to make it, else nothing is touched, $3: file of a lease or nothing, then the digests that it names.
# Standard input: digest, size and name of a file a line; says of each whether it is there.
LC_ALL=C; export LC_ALL; umask 077;
r="$1"; m="$2"; l="$3"; shift 3;
if [ "$m" = make ]; then
e=$(mkdir -p "$r" 2>&1) || { echo "error $e"; exit 1; };
if [ -w "$r" ] && [ -x "$r" ]; then :; else echo "error $r: Permission denied"; exit 1; fi;
# Before anybody looks: a clean-up by somebody else leaves what a lease names. On a full disk it goes without.
if [ -n "$l" ]; then
t="${l%/*}/.${l##*/}.$$";
{ mkdir -p "${l%/*}" && echo "$@" >"$t" && mv -f "$t" "$l"; } 2>/dev/null || rm -f "$t";
fi;
fi;
while read -r d s n; do
f="$r/$d/$n";
if [ "$m" = make ]; then touch -c "$r/$d" 2>/dev/null; fi;
if [ -f "$f" ] && [ "$(wc -c <"$f")" -eq "$s" ]; then echo have; else echo need; fi;
done;
d="$r"; until [ -d "$d" ]; do d=${d%/*}; if [ -z "$d" ]; then d=/; fi; done;
set -- $(df -Pk "$d" 2>/dev/null | tail -n 1);
echo "free $4"
