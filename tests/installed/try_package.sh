#!/bin/bash
# Tries the packages that scripts/package makes, as a user of a bare Debian: installs them with what they depend on, runs the README's
# commands, builds the C++ example, and removes them without a trace. Changes the system that it runs on: use a container or a chroot.
#   tests/installed/try_package.sh FOLDER      as root; FOLDER has both packages for this Debian
set -euo pipefail
folder=$(realpath "${1:?which folder has the packages? Expected build/package}")
source=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export DEBIAN_FRONTEND=noninteractive

files() { find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /tmp -o -path /root -o -path "$source" -o -path "$folder" \) -prune -o -print | sort; }
say() { echo "try_package: $*"; }

apt-get update -qq
files >before
SECONDS=0
apt-get install -y -qq "$folder"/tactile_*.deb >install.log 2>&1 || { tail -5 install.log >&2; exit 1; }
say "installed with $(grep -c '^Setting up' install.log) packages in $SECONDS s"
dpkg -L tactile | sort >installed

tactile --version
for page in /usr/share/man/man1/tactile{,-label,-reproduce}.1.gz /usr/share/bash-completion/completions/tactile \
            /usr/share/zsh/vendor-completions/_tactile /usr/share/fish/vendor_completions.d/tactile.fish; do
  [[ -s $page ]] || { say "$page is missing" >&2; exit 1; }
done
mkdir readme && cd readme
awk '/empty folder:$/ { found = 1 } found && /^```/ { if (inside) exit; inside = 1; next } inside' /usr/share/doc/tactile/README.md >commands
[[ $(wc -l <commands) -ge 8 ]] || { say "the README of the package has no commands" >&2; exit 1; }
while read -r command; do
  say "$command"
  bash -c "$command" </dev/null >log 2>&1 || { tail -5 log >&2; exit 1; }
done <commands
cd ..

apt-get install -y -qq "$folder"/tactile-dev_*.deb cmake g++ >install.log 2>&1 || { tail -5 install.log >&2; exit 1; }
cmake -S "$source/examples/predict" -B predict >log 2>&1 && cmake --build predict >>log 2>&1 || { tail -20 log >&2; exit 1; }
./predict/predict readme/data/fan/02/events.aedat4 readme/models/th40-single-1 >predictions
say "the C++ example built, $(wc -l <predictions) ticks predicted"
[[ -s predictions ]]

apt-get remove -y -qq tactile tactile-dev >/dev/null 2>&1
left=$(comm -23 <(comm -12 installed <(files)) before)
left+=$(files | grep -i tactile || true)
[[ -z $left ]] || { say "left after removal: $left" >&2; exit 1; }
say "removed without a trace"
