# $1: home, $2: node, $3: file that starts the service. What is there of a service: a word and its value a line.
LC_ALL=C; export LC_ALL;
h="$1"; n="$2";
number() { sed -n "s/.*\"pid\": *\([0-9][0-9]*\).*/\1/p" "$1" 2>/dev/null | head -n 1; };
has() { tr "\0" "\n" 2>/dev/null <"/proc/$1/cmdline" | grep -Fxq -e "$2"; };
if [ -f "$h/services/$n.json" ]; then printf "record "; head -c 65536 "$h/services/$n.json" | tr -d "\n"; echo; fi;
for f in "$h"/services/*.json; do
if [ -f "$f" ] && [ "$f" != "$h/services/$n.json" ]; then echo "other yes"; fi;
done;
if [ -f "$3" ]; then head -c 65536 "$3" | sed "s/^/file /"; fi;
p=$(number "$h/run/$n/agent.json");
if [ -n "$p" ] && has "$p" "$h"; then
echo "agent $p $(readlink "/proc/$p/exe")";
if [ -S "$h/run/$n/agent.sock" ]; then echo "serves yes"; fi;
fi;
for f in "$h/run/$n"/*/manager.json; do
d=${f%/manager.json}; p=$(number "$f");
if [ -n "$p" ] && has "$p" "$d"; then echo "manager $p"; fi;
done;
echo "end yes"
