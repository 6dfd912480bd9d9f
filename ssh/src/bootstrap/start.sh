# $1: home, $2: file of the log, then the command. It goes on when the session ends.
LC_ALL=C; export LC_ALL; umask 077;
RTSCTL_HOME="$1"; export RTSCTL_HOME; l="$2"; shift 2;
e=$( { mkdir -p "${l%/*}" && : >>"$l"; } 2>&1 ) || { echo "error $e"; exit 1; };
cd /;
if command -v setsid >/dev/null 2>&1; then s=setsid; else s=nohup; fi;
$s "$@" </dev/null >>"$l" 2>&1 &
echo done
