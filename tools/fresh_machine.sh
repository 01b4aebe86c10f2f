#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Proves that ./dev works on a bare machine. It makes a bare Debian 12 root with mmdebstrap and
# copies it for each step. It clones this repository's HEAD into the copy and runs the step there.
# Needs root and this host's network.
#
#   run      ./dev run until the studio prints its address and answers there
#   bench    ./dev bench all --quick
#   package  ./dev package
#   test     ./dev test
#
# Usage: fresh_machine.sh [--root DIR] [--steps run,bench,package,test] [--again] [--keep]
# [--command COMMAND]
#   --root DIR     roots, logs and stamps (default /var/tmp/kibori-fresh)
#   --steps LIST   these steps only
#   --again        repeat steps that passed for this commit; otherwise they are skipped
#   --keep         keep the root of a step that passed (some GB each)
#   --command C    run the shell command C in a fresh root instead of the steps
# Settings of apt, npm, certificates and proxies come from the host. Exit status 1: a step failed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

folder=/var/tmp/kibori-fresh steps=run,bench,package,test again= keep= command=
while [ $# -gt 0 ]; do
  case "$1" in
    --root) folder=$2; shift ;;
    --steps) steps=$2; shift ;;
    --again) again=1 ;;
    --keep) keep=1 ;;
    --command) command=$2 steps=command again=1; shift ;;
    *) sed -n '3,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" >&2; exit 2 ;;
  esac
  shift
done
say() { printf '\033[1m==> %s\033[0m\n' "$*" >&2; }
die() { printf 'fresh_machine.sh: %s\n' "$*" >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || die "run it as root, because it uses chroot"
for step in ${steps//,/ }; do
  case "$step" in run | bench | package | test | command) ;; *) die "no step '$step'; there are run, bench, package, test" ;; esac
done

# Variables from which programs read their proxies and certificates.
settings=(http_proxy https_proxy no_proxy all_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY ALL_PROXY SSL_CERT_FILE SSL_CERT_DIR
  CURL_CA_BUNDLE REQUESTS_CA_BUNDLE NODE_EXTRA_CA_CERTS PIP_CERT PIP_INDEX_URL npm_config_registry npm_config_cafile)

copy_into() { # root path ...: copies existing paths to the same place
  local root=$1 path
  shift
  for path in "$@"; do
    [ -e "$path" ] || continue
    mkdir -p "$root$(dirname "$path")"
    cp -aL --remove-destination "$path" "$root$(dirname "$path")/"
  done
}

host_settings() { # root
  local root=$1 name npmrc file
  copy_into "$root" /etc/resolv.conf /etc/hosts /etc/npmrc /usr/local/share/ca-certificates "$HOME/.npmrc"
  [ "$HOME" = /root ] || [ ! -e "$HOME/.npmrc" ] || cp "$HOME/.npmrc" "$root/root/.npmrc"
  for npmrc in /etc/npmrc "$HOME/.npmrc"; do
    [ ! -r "$npmrc" ] || copy_into "$root" "$(sed -nE 's/^cafile *= *"?([^"]*)"?$/\1/p' "$npmrc" | head -n 1)"
  done
  for name in "${settings[@]}"; do
    [ ! -f "${!name:-}" ] || copy_into "$root" "${!name}"  # a certificate file
  done
  for file in /etc/apt/auth.conf /etc/apt/auth.conf.d/*; do copy_into "$root" "$file"; done
}

# Runs a command in a root, in its own namespaces of mounts and processes. Mounts and processes that
# remain are removed when the command ends.
inside() { # root command
  local environment=(HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 TERM=dumb) name
  for name in "${settings[@]}"; do
    [ -z "${!name:-}" ] || environment+=("$name=${!name}")
  done
  unshare --mount --pid --fork --kill-child --propagation private bash -c '
    set -e
    root=$1 command=$2
    shift 2
    mount -t proc proc "$root/proc"
    mount -t sysfs -o ro sysfs "$root/sys" 2>/dev/null || true
    mount --rbind /dev "$root/dev"
    mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
    exec chroot "$root" /usr/bin/env -i "$@" /bin/bash -c "$command"' inside "$1" "$2" "${environment[@]}"
}

# Makes the bare root, unless it exists: apt with its sources, certificates, and no build tools.
base() {
  [ ! -e "$folder/base.done" ] || return 0
  command -v mmdebstrap >/dev/null || {
    say "installing mmdebstrap"
    apt-get update -q >/dev/null
    DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends mmdebstrap >/dev/null
  }
  say "a bare Debian 12 in $folder/base"
  rm -rf "$folder/base"
  local sources=() options=() file
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do
    [ ! -s "$file" ] || sources+=("$file")
  done
  for file in /etc/apt/apt.conf.d/*; do
    ! grep -q '^ *Acquire::' "$file" || options+=("--aptopt=$file")
  done
  mmdebstrap --quiet --variant=minbase --include=ca-certificates "${options[@]}" bookworm "$folder/base" "${sources[@]}" >"$folder/base.log" 2>&1 ||
    { tail -n 20 "$folder/base.log" >&2; die "mmdebstrap failed; $folder/base.log says why"; }
  host_settings "$folder/base"
  inside "$folder/base" update-ca-certificates >>"$folder/base.log" 2>&1
  touch "$folder/base.done"
}

# Runs the studio until it prints its address and sends its page from there. Then stops it. Without
# curl on the host, the address is enough.
until_address() { # root
  inside "$1" 'cd /root/kibori && exec ./dev run' &
  local studio=$! address status=1
  while kill -0 $studio 2>/dev/null; do
    address=$(grep -oE 'http://(127\.0\.0\.1|localhost):[0-9]+/\?token=[0-9a-f]+' "$folder/run.log" | tail -n 1 || true)
    if [ -n "$address" ]; then
      status=0
      ! command -v curl >/dev/null || curl --noproxy '*' -fsS --max-time 20 -o "$folder/run.html" "$address" || status=1
      break
    fi
    sleep 1
  done
  kill $studio 2>/dev/null || true
  wait $studio 2>/dev/null || true
  return $status
}

step() { # name
  local name=$1 root=$folder/$1.root
  base
  say "$name: a fresh root"
  rm -rf "$root"
  cp -a "$folder/base" "$root"
  git clone -q --no-hardlinks . "$root/root/kibori"
  say "$name: $folder/$name.log"
  local begin=$SECONDS status=0
  case "$name" in
    run) until_address "$root" >"$folder/run.log" 2>&1 || status=1 ;;
    bench) inside "$root" 'cd /root/kibori && ./dev bench all --quick' >"$folder/bench.log" 2>&1 || status=1 ;;
    package | test) inside "$root" "cd /root/kibori && ./dev $name" >"$folder/$name.log" 2>&1 || status=1 ;;
    command) inside "$root" "cd /root/kibori && $command" 2>&1 | tee "$folder/command.log" || status=1 ;;
  esac
  local seconds=$((SECONDS - begin))
  if [ $status -eq 0 ]; then
    printf '%s %d\n' "$commit" "$seconds" >"$folder/$name.passed"
    [ -n "$keep" ] || rm -rf "$root"
  else
    rm -f "$folder/$name.passed"
    tail -n 20 "$folder/$name.log" >&2
  fi
  return $status
}

mkdir -p "$folder"
commit=$(git rev-parse HEAD)
results=() failed=0
for name in ${steps//,/ }; do
  if [ -z "$again" ] && read -r passed seconds <"$folder/$name.passed" && [ "$passed" = "$commit" ]; then
    results+=("$(printf '%-8s passed before  %3d min %02d s' "$name" $((seconds / 60)) $((seconds % 60)))")
    continue
  fi 2>/dev/null
  begin=$SECONDS outcome=passed
  step "$name" || { outcome=FAILED; failed=$((failed + 1)); }
  seconds=$((SECONDS - begin))
  [ $outcome = FAILED ] || read -r _ seconds <"$folder/$name.passed"
  results+=("$(printf '%-8s %-13s  %3d min %02d s' "$name" $outcome $((seconds / 60)) $((seconds % 60)))")
done
printf '%s\n' "${results[@]}"
[ $failed -eq 0 ]
