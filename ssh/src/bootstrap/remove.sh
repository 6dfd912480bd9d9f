# $1: home, $2: node, $3: file that starts the service. Folders below the account's go when they are empty.
LC_ALL=C; export LC_ALL;
h="$1"; n="$2"; u="$3";
e=$( {
rm -f "$u";
rm -rf "$h/run/$n" "$h/state/$n" "$h/logs/$n" "$h/services/$n.json" "$h/services/$n.log";
for f in run state logs; do
if [ "$(ls -A "$h/$f" 2>/dev/null)" = .rtsctl ]; then rm -f "$h/$f/.rtsctl"; fi;
rmdir "$h/$f" 2>/dev/null;
done;
rmdir "$h/programs" "$h/modules" "$h/services" 2>/dev/null;
rmdir "$h" 2>/dev/null;
for d in "${h%/*}" "${u%/*}"; do
while case "$d" in "$HOME"/*) rmdir "$d" 2>/dev/null;; *) false;; esac; do d=${d%/*}; done;
done;
:;
} 2>&1 );
if [ -n "$e" ]; then echo "error $e"; exit 1; fi;
if [ -d "$h" ]; then echo "left $(ls -A "$h" | head -n 5 | tr "\n" " ")"; fi;
echo done
