#!/bin/bash
# Stands in for every program that tools/demo starts: runs until SIGTERM, then writes what the real one would leave.
# FAKE_DIES=NAME: that one ends at once with status 3. FAKE_SICK=NAME: that one says that it was not healthy.
# FAKE_STAYS=NAME: that one sums up and does not end.
# FAKE_HAS_NO_CURVE=NAME: that one ends with status 2 when it is to choose numerics for a budget.
# FAKE_LEAVES=NAME: that one ends well by itself, as a viewer does whose window is closed.
name=$(basename "$0")
echo "$$" >>"$FAKE_PIDS"
echo "$name $*" >>"$FAKE_CALLS"
if [ "${FAKE_HAS_NO_CURVE:-}" = "$name" ] && [[ " $* " == *" --budget "* ]]; then
  echo "there is no curve"
  exit 2
fi
summary='' png='' out='' log='' healthy=true
while [ $# -gt 0 ]; do
  case $1 in
    --summary) summary=$2 ;;
    --png) png=$2 ;;
    --out) out=$2 ;;
    --log) log=$2 ;;
  esac
  shift
done
[ "${FAKE_SICK:-}" = "$name" ] && healthy=false
[ "${FAKE_DIES:-}" = "$name" ] && { echo "no such scene"; exit 3; }
leave() {
  echo "{\"healthy\": $healthy, \"rate_hz\": 1000.0, \"messages\": 12, \"steps\": 3000, \"peak_force_n\": 2.5}" >"$summary"
  [ -n "$png" ] && echo picture >"$png"
  [ -n "$out" ] && echo recording >"$out"
  [ -n "$log" ] && {
    echo "t_ns,state,age_us,lateness_us,force_x,force_y,force_z,torque_x,torque_y,torque_z"
    for i in 1 2 3 4; do echo "${i}000000,engaged,500,20,$i,0,0,0,0,0.1"; done
  } >"$log/bridge_log.csv"
  [ "${FAKE_STAYS:-}" = "$name" ] && return
  exit 0
}
trap leave TERM
echo "serving 'scene'"
[ "${FAKE_LEAVES:-}" = "$name" ] && { sleep 0.5; leave; }
while :; do sleep 0.05; done
