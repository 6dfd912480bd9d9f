# $1: `--user` or nothing, then what `systemctl` is told, each in one word.
LC_ALL=C; export LC_ALL;
XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/run/user/$(id -u)}; export XDG_RUNTIME_DIR;
s="$1"; shift;
for c in "$@"; do
e=$(systemctl $s $c 2>&1) || { echo "error systemctl $s $c: $e"; exit 1; };
done;
echo done
