# killed_process.sh, sourced by tests of programs that go on after a process was killed. Of its caller it takes $mpiexec, $program
# and $folder, which it empties and enters.
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
fail() {
  echo "FAILED: $1" >&2
  exit 1
}
# More processes than cores, and as root where that is how tests run; other MPIs than Open MPI do not listen to these.
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

# kill_one OUTPUT LAUNCHER: kills the last of our own processes with this output folder on the command line; the mpiexec that
# launched them, which writes to killed.log, has to notice.
kill_one() {
  local output=$1 launcher=$2 victim='' process
  for process in /proc/[0-9]*; do
    if [ "$process/exe" -ef "$program" ] && grep -qzFx "$output" "$process/cmdline"; then
      victim=${process#/proc/}
    fi
  done 2>/dev/null
  [ -n "$victim" ] || fail "no process to kill; did the run end too early? $(cat killed.log)"
  kill -KILL "$victim"
  if wait "$launcher"; then fail "mpiexec did not notice that process $victim was killed"; fi
}
