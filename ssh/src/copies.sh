# $1: home, $2: name of a lease, $3: `keep`, `end` or nothing to be done with it, $4: node whose service and ledger count no more, or nothing.
# Standard input: digests that the caller needs, which its lease names. What nobody needs any more is removed.
LC_ALL=C; export LC_ALL; umask 077;
h="$1"; l="$h/leases"; n="$2"; x="$4"; t="$l/.$n.$$"; late=; own=$(cat);
lease() { e=$( { mkdir -p "$l" && echo "$own" >"$t" && mv -f "$t" "$l/$n"; } 2>&1 ) || { rm -f "$t"; return 1; }; };
case "$3" in keep) lease || late=yes;; end) rm -f "$l/$n";; esac;
find "$l" -type f -mtime +30 -exec rm -f {} + 2>/dev/null;
rmdir "$l" 2>/dev/null;
# All digests that the caller, a lease, a service or a ledger names, and what of these cannot be read.
named() {
echo "$own";
for f in "$h" "$l" "$h/services" "$h/state" "$h"/state/*; do
if [ -d "$f" ]; then [ -r "$f" ] && [ -x "$f" ] || echo "unread $f"; fi;
done;
for f in "$l"/* "$h"/services/*.json "$h"/state/*/node-spec*.json; do
case "$f" in "$h/services/$x.json"|"$h/state/$x/"*) continue;; esac;
if [ -e "$f" ]; then cat "$f" || if [ -e "$f" ]; then echo; echo "unread $f"; fi; echo; fi;
done;
};
digests() { grep -oE "[0-9a-f]{64}|^unread .*" | sort -u; };
mark=0000000000000000000000000000000000000000000000000000000000000000;
# A process needs what it was made of, and what its command names: an agent the program of managers that it has not started yet.
needed=$( { echo "$mark"; named; grep -h "/[pm][a-z]*/" /proc/[0-9]*/maps; cat /proc/[0-9]*/cmdline | tr "\0" "\n"; } 2>/dev/null | digests );
# Without this tool nobody knows.
case "$needed" in
*"unread "*) why="${needed##*unread } cannot be read, and may need anything";;
*"$mark"*) why=;;
*) why="grep finds nothing there";;
esac;
if [ -n "$why" ]; then echo "told $why: no copy was removed"; else
# What clean-ups have left that were killed.
for g in "$h"/programs/*.gone.* "$h"/modules/*.gone.*; do
q=${g##*.};
case "$q" in ""|*[!0-9]*) ;; *) kill -0 "$q" 2>/dev/null || rm -rf "$g";; esac;
done;
for d in "$h"/programs/* "$h"/modules/*; do
b=${d##*/};
[ -d "$d" ] && [ "${#b}" -eq 64 ] || continue;
case "$b" in *[!0-9a-f]*) continue;; esac;
case "$needed" in *"$b"*) continue;; esac;
# What was used lately may be wanted in a moment, by whoever else has a lease.
if [ -d "$l" ]; then case "$d" in */modules/*) a="-mtime +7";; *) a="-mmin +10";; esac; else a=; fi;
[ -n "$(find "$d" -prune $a -print 2>/dev/null)" ] || continue;
# Out of sight first: who has named it meanwhile, and looked before, gets it back; who looks now sends it again.
g="$d.gone.$$";
mv "$d" "$g" 2>/dev/null || continue;
case "$(named 2>/dev/null | digests)" in *"$b"*|*"unread "*) [ -e "$d" ] || mv "$g" "$d"; rm -rf "$g"; continue;; esac;
rm -rf "$g" 2>/dev/null && echo "gone $b";
done;
fi;
rmdir "$h/programs" "$h/modules" 2>/dev/null;
# There may be space for it now.
if [ -n "$late" ]; then lease || echo "told the lease of what is used there cannot be written: $e"; fi;
echo done
