// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// cpp-httplib, to be included by this name only.
#include <httplib.h>
// It includes <resolv.h>, whose macro of this name replaces a parameter in Eigen's headers.
#undef _res
