# $1: the script that starts the process, which goes on when the session ends.
cd /;
if command -v setsid >/dev/null 2>&1; then s=setsid; else s=nohup; fi;
$s "$1" </dev/null >/dev/null 2>&1 &
echo done
