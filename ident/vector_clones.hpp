// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// EHA_VECTOR_CLONES before a function with hot loops: one build serves old and new processors. The loader picks the
/// clone by the processor's features (AVX2 and FMA), so results may differ between processors by rounding. Sanitizers
/// cannot instrument the dispatch, and Clang has no such level in this attribute.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define EHA_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define EHA_VECTOR_CLONES
#endif
