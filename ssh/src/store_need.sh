# $1: folder, $2: `make` to make it. Standard input: digest, size and name of a file a line; says of each whether it is there.
LC_ALL=C; export LC_ALL; umask 077;
if [ "$2" = make ]; then
e=$(mkdir -p "$1" 2>&1) || { echo "error $e"; exit 1; };
if [ -w "$1" ] && [ -x "$1" ]; then :; else echo "error $1: Permission denied"; exit 1; fi;
fi;
while read -r d s n; do
f="$1/$d/$n";
if [ -f "$f" ] && [ "$(wc -c <"$f")" -eq "$s" ]; then touch -c "$1/$d" 2>/dev/null; echo have; else echo need; fi;
done;
d="$1"; until [ -d "$d" ]; do d=${d%/*}; if [ -z "$d" ]; then d=/; fi; done;
set -- $(df -Pk "$d" 2>/dev/null | tail -n 1);
echo "free $4"
