#!/bin/bash
# Tries the packages that scripts/package makes, as a user of a bare Debian: installs what they depend on and nothing else, runs the
# README's commands, builds the C++ example, and removes the packages without a trace. It changes the system: use a container or a chroot.
#   tests/installed/try_package.sh FOLDER      as root; FOLDER has both packages for this Debian
set -euo pipefail
say() { echo "try_package: $*"; }
fail() { say "$*" >&2; exit 1; }
[[ $# -eq 1 && $EUID -eq 0 ]] || fail "expected to be root, and one folder with both packages, such as build/package"
[[ -z $(dpkg-query -W -f='${db:Status-Status}' tactile 2>/dev/null || true) ]] || fail "tactile is installed; expected a bare Debian"
folder=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export DEBIAN_FRONTEND=noninteractive HOME=$work

# runs a command; shows the end of what it prints if it fails
run() { "$@" </dev/null >log 2>&1 || { tail -15 log >&2; fail "'$*' failed"; }; }
install() { run apt-get install -y -qq --no-install-recommends "$@"; }
files() { find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /tmp -o -path "$folder" \) -prune -o ! -type d -print | sort; }

run apt-get update -qq
files >before
SECONDS=0
install "$folder"/tactile_*.deb
say "installed with $(grep -c '^Setting up' log) packages in $SECONDS s"
dpkg -L tactile >installed
tactile --version

commands=$(tactile --help | sed -n '/^Commands:/,/^Options:/s/^  \([a-z]\+\) .*/\1/p')
[[ $(wc -w <<<"$commands") -ge 20 ]] || fail "tactile --help lists fewer than 20 commands: $commands"
for command in $commands; do
  [[ -s /usr/share/man/man1/tactile-$command.1.gz ]] || fail "$command has no man page"
done
for file in bash-completion/completions/tactile zsh/vendor-completions/_tactile fish/vendor_completions.d/tactile.fish; do
  [[ -s /usr/share/$file ]] || fail "/usr/share/$file is missing"
done

mkdir readme && cd readme
awk '/^empty folder:$/ { found = 1 } found && /^```/ { if (inside) exit; inside = 1; next } inside' /usr/share/doc/tactile/README.md >commands
[[ $(wc -l <commands) -ge 8 ]] || fail "the README of the package has no commands"
while read -r command; do
  say "$command"
  run bash -c "$command"
done <commands
[[ -s report/report.html ]] || fail "there is no report"
cd ..

install "$folder"/tactile-dev_*.deb cmake g++ make
dpkg -L tactile-dev >>installed
run cmake -S /usr/share/doc/tactile-dev/examples/predict -B predict
run cmake --build predict
./predict/predict readme/data/fan/02/events.aedat4 readme/models/th40-single-1 >predictions
[[ $(wc -l <predictions) -gt 1000 ]] || fail "the C++ example predicted $(wc -l <predictions) lines; expected thousands"
say "the C++ example predicted $(($(wc -l <predictions) - 1)) ticks"

run apt-get remove -y -qq tactile tactile-dev
files >after
left=$(comm -13 before after | grep -i -e tactile -f <(sed 's/.*/^&$/' installed) || true)
[[ -z $left ]] || fail "these files are left after the removal: $left"
say "removed without a trace"
