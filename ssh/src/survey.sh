# What kind of machine this is: one `key=value` a line.
LC_ALL=C; export LC_ALL;
PATH="$PATH:/usr/bin:/bin:/usr/sbin:/sbin";
say() { printf "%s=%s\n" "$1" "$2"; };
say kernel "$(uname -s)";
say release "$(uname -r)";
say machine "$(uname -m)";
say node "$(uname -n)";
say bits "$(getconf LONG_BIT 2>/dev/null)";
say libc "$(getconf GNU_LIBC_VERSION 2>/dev/null || ldd --version 2>&1 | head -n 1)";
say home "$HOME";
say state "$XDG_STATE_HOME";
say config "$XDG_CONFIG_HOME";
u=$(id -u);
say uid "$u";
say user "$(id -un)";
if [ -d /run/systemd/system ] && command -v systemctl >/dev/null 2>&1; then
say systemd system;
r=${XDG_RUNTIME_DIR:-/run/user/$u};
if [ -S "$r/systemd/private" ] || [ -S "$r/bus" ]; then say services user; fi;
fi;
if [ -e "/var/lib/systemd/linger/$(id -un)" ]; then say linger yes; fi;
if command -v sha256sum >/dev/null 2>&1; then say sha256sum yes; fi;
d=${XDG_STATE_HOME:-$HOME/.local/state};
case "$d" in /*) ;; *) d=/;; esac;
until [ -d "$d" ]; do d=${d%/*}; if [ -z "$d" ]; then d=/; fi; done;
set -- $(df -Pk "$d" 2>/dev/null | tail -n 1);
say free "$4";
say end yes
