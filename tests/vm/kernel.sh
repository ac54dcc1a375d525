# SPDX-License-Identifier: GPL-3.0-or-later
# shellcheck shell=bash
# For the scripts that boot a machine, which set `here` to the folder of this file: a Debian kernel, and the stand-in card
# built against it.
#   EHA_VM_CACHE    where the kernel is kept (default: ehad/vm in the user's cache)
cache=${EHA_VM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/ehad/vm}

die() { echo "vm: error: $*" >&2; exit 1; }

# What the machines load, by path under the kernel's modules, and what depmod wants to know.
kernel_modules=(kernel/drivers/comedi kernel/drivers/block/loop.ko kernel/fs/ext4 kernel/fs/jbd2 kernel/fs/mbcache.ko
  kernel/lib/crc16.ko kernel/lib/libcrc32c.ko kernel/crypto/crc32c_generic.ko kernel/arch/x86/crypto
  modules.order modules.builtin modules.builtin.modinfo)

# The kernel, its modules and the headers that match: unpacked, not installed, and kept.
fetch_kernel() {
  local packages package t=$cache/new
  version=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -nE 's/.*Depends: linux-image-([0-9][^ ]*)/\1/p' | head -1)
  [ -n "$version" ] || die "apt knows no linux-image-amd64; as root: apt-get update"
  packages=("linux-image-$version" "linux-headers-$version" "linux-headers-${version%-*}-common" "linux-kbuild-${version%%.0-*}")
  echo "vm: fetching the kernel $version and its headers"
  rm -rf "$t"
  mkdir -p "$t/deb"
  (cd "$t/deb" && apt-get download -qq "${packages[@]}" >apt.log 2>&1) || die "apt-get could not download ${packages[*]}; see $t/deb/apt.log"
  dpkg-deb --fsys-tarfile "$t"/deb/linux-image-*.deb |
    tar -C "$t" -x "./boot/vmlinuz-$version" "${kernel_modules[@]/#/./lib/modules/$version/}"
  for package in "$t"/deb/linux-{headers,kbuild}-*.deb; do dpkg-deb -x "$package" "$t"; done
  # Debian's header tree names its other half by absolute path
  sed -i "s#include /usr/src#include $cache/$version/usr/src#" "$t/usr/src/linux-headers-$version/Makefile"
  rm -rf "$t/deb" "${cache:?}/$version"
  mv "$t" "$cache/$version"
  echo "$version" >"$cache/version"
}

# get_kernel: sets `version` and `kernel`, the folder it is unpacked in.
get_kernel() {
  mkdir -p "$cache"
  cache=$(realpath "$cache")
  # the machines are made side by side, and one of them fetches it
  exec {kernel_lock}>"$cache/lock"
  flock "$kernel_lock"
  version=$(cat "$cache/version" 2>/dev/null || true)
  local module
  for module in "${kernel_modules[@]}"; do
    # a cache from before this module was wanted
    if [ -z "$version" ] || [ ! -e "$cache/$version/lib/modules/$version/$module" ]; then fetch_kernel; break; fi
  done
  kernel=$cache/$version
  exec {kernel_lock}>&-
}

# build_card FOLDER: the stand-in card, FOLDER/pci1716_card.ko
build_card() {
  rm -rf "$1"
  cp -r "${here:?}/card" "$1"
  make -s -C "$kernel/usr/src/linux-headers-$version" M="$1" modules >"$1/build.log" 2>&1 ||
    { cat "$1/build.log" >&2; die "the stand-in card does not build against the kernel's headers"; }
}
