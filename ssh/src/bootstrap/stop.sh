# $1: folder of programs of ours, $2: `all` to end what the processes started as well, then process numbers.
# Each ends: by itself within 5 s, else by force.
LC_ALL=C; export LC_ALL;
r="$1"; a="$2"; shift 2;
ours() { case "$(readlink "/proc/$1/exe")" in "$r"/*) return 0;; *) return 1;; esac; };
groups() { sed -n "s/^[0-9]*:\([^:]*\):\(.*\/rtsctl-[^:]*\)$/\1\2/p" "/proc/$1/cgroup" 2>/dev/null; };
for p in "$@"; do
ours "$p" || continue;
g=$(groups "$p");
kill -TERM "$p" 2>/dev/null;
i=0;
while ours "$p" && [ "$i" -lt 50 ]; do sleep 0.1 2>/dev/null || sleep 1; i=$((i+1)); done;
if ours "$p"; then kill -KILL "$p" 2>/dev/null; sleep 1; fi;
if ours "$p"; then echo "error process $p does not end"; exit 1; fi;
if [ "$a" = all ]; then
kill -KILL "-$p" 2>/dev/null;
for c in $g; do for b in /sys/fs/cgroup /sys/fs/cgroup/unified; do
d=$(echo "$b/$c" | tr -s /);
[ -d "$d" ] || continue;
for k in $(cat "$d/cgroup.procs" 2>/dev/null); do kill -KILL "$k" 2>/dev/null; done;
rmdir "$d" 2>/dev/null || { sleep 1; rmdir "$d" 2>/dev/null; };
rmdir "${d%/*}" 2>/dev/null;
done; done;
fi;
done;
echo done
