# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the checks share.
set -uo pipefail
export DEBIAN_FRONTEND=noninteractive NO_COLOR=1
failures=0

check() {
  local sentence=$1 output
  shift
  if output=$("$@" 2>&1); then
    echo "ok - $sentence ($SECONDS s)"
  else
    failures=$((failures + 1))
    echo "not ok - $sentence ($SECONDS s)"
    printf '%s\n' "$output" | tail -n 20 | sed 's/^/  # /'
  fi
}
within() {
  local seconds=$1 end=$((SECONDS + $1))
  shift
  until "$@" >/dev/null 2>&1; do
    if [ $SECONDS -ge "$end" ]; then echo "not within $seconds s: $*"; "$@"; return 1; fi
    sleep 0.1
  done
}
not() { ! "$@"; }
# finish LOG...: ends the checks; shows the logs if one failed
finish() {
  [ $failures -gt 0 ] || exit 0
  tail -n 30 "$@"
  exit 1
}
